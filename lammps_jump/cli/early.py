# SPDX-License-Identifier: GPL-2.0-or-later
"""The engine's process is started before the case is read: it loads its libraries meanwhile."""

from __future__ import annotations

import re
from pathlib import Path

from lammps_jump import engines
from lammps_jump.files import read_file

COMMANDS = ("build-and-run", "run")


def start_engine_early(words: list[str]) -> None:
    """Start the process of the engine that a command line will need; a wrong guess costs a process that is not used.

    Parameters
    ----------
    words : list of str
        Of the command line, the program's name left out.
    """
    if len(words) < 2 or words[0] not in COMMANDS or {"--help", "--members", "--until"} & set(words):
        return
    path = Path(words[1]) / "case.yaml" if words[0] == "run" else Path(words[1])
    try:
        native = "native" in words or re.search(rb"(?m)^ *name: *native", read_file(path, 1_000_000)) is not None
    except (OSError, ValueError):
        return  # the command says what is wrong
    engines.prepare_worker("native" if native else "lammps")
