# SPDX-License-Identifier: GPL-2.0-or-later
"""Processes that a command will need are started before its case is read: they load their libraries meanwhile."""

from __future__ import annotations

import re
from pathlib import Path

from lammps_jump import engines, sweeps
from lammps_jump.files import read_file

COMMANDS = ("build-and-run", "run", "sweep")
MEMBERS = {"--members", "--until"}
"""Options of a command that runs several members of a case."""
NOTHING = {"--help", "--slurm", "--status", "--table", "--member", "--jobs"}
"""Options of a command that runs nothing in workers, or in as many as it says."""


def start_early(words: list[str]) -> None:
    """Start the engine of a run, or the workers of a study; a wrong guess costs a process that is not used.

    Parameters
    ----------
    words : list of str
        Of the command line, the program's name left out.
    """
    options = {word.partition("=")[0] for word in words}
    if len(words) < 2 or words[0] not in COMMANDS or NOTHING & options:
        return
    if words[0] == "sweep" or MEMBERS & options:
        sweeps.pool.prepare_workers()
        return
    path = Path(words[1]) / "case.yaml" if words[0] == "run" else Path(words[1])
    try:
        named = re.search(rb"(?m)^ *name: *(native|twin)", read_file(path, 1_000_000))
        own = next((name for name in ("native", "twin") if name in words), named and named[1].decode())
    except (OSError, ValueError):
        return  # the command says what is wrong
    engines.prepare_worker(own or "lammps")
