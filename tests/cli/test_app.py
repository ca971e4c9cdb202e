# SPDX-License-Identifier: GPL-2.0-or-later
"""The commands load little before they do something."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from functools import reduce

import pytest
import typer
from made_up import INPUTS, some_long
from typer.testing import CliRunner

import lammps_jump as lj
from lammps_jump import compiling
from lammps_jump.cli import tools
from lammps_jump.cli.app import app
from lammps_jump.compiling.build import Status, library_path
from lammps_jump.core import CORE
from lammps_jump.errors import JumpError

# fmt: off
HEAVY = {
    "MDAnalysis", "concurrent.futures.thread", "jinja2", "lammps", "matplotlib", "pandas", "pint", "scipy", "xarray",
    "lammps_jump.analysis.flow", "lammps_jump.runs.results",
}
"""What `check` does without."""
FOR_HELP = HEAVY | {
    "lammps_jump.scene.scene", "lammps_jump.physics", "lammps_jump.provenance", "yaml", "importlib.metadata", "email",
    "zipfile",
}
"""What `--help` does without: it takes 0.11 s, of which each of these would be a twentieth or more."""
# fmt: on


@pytest.mark.parametrize(("words", "spared"), [("--help", FOR_HELP), (f"check {INPUTS / 'hopper.yaml'}", HEAVY)])
def test_modules_that_a_command_does_not_load(words, spared):
    with suppress(JumpError):  # without a compiler nothing is compiled
        library_path(CORE)  # `check` compiles in threads where there is no core yet, as in a fresh checkout
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "lammps_jump", *words.split()],
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "lammps_jump.cli.app" in loaded
    assert not loaded & spared


@pytest.mark.parametrize("given", [{}, {"OPENBLAS_NUM_THREADS": "3"}])
def test_numpy_is_loaded_with_one_thread_of_its_own_unless_the_user_asks_for_more(given):
    code = (
        "import os, sys, lammps_jump.cli; assert 'numpy' not in sys.modules, 'too late'; "
        "print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    environment = {name: text for name, text in os.environ.items() if name != "OPENBLAS_NUM_THREADS"} | given
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == given.get("OPENBLAS_NUM_THREADS", "1")


@pytest.mark.parametrize("width", [80, 100])
@pytest.mark.parametrize("words", [(), ("kernels",)])
def test_help_lists_the_whole_sentence_of_every_command(words, width):
    group = reduce(lambda group, name: group.commands[name], words, typer.main.get_command(app))
    listed = CliRunner().invoke(app, [*words, "--help"], terminal_width=width).output
    assert max(map(len, listed.splitlines())) <= width
    cut = [name for name, one in group.commands.items() if one.help.split(". ")[0] not in " ".join(listed.split())]
    assert group.commands
    assert not cut


def test_the_program_ends_at_once_but_what_is_to_be_done_at_its_end_is_done():
    code = (
        "import atexit, sys; atexit.register(print, 'at the end'); sys.argv = ['lammps-jump', '--version']; "
        "from lammps_jump.__main__ import run; run(); print('not reached')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout.splitlines() == [f"lammps-jump {lj.__version__}", "at the end"]


@pytest.mark.parametrize("closed", [some_long(">&-"), some_long("2>&-"), ">&- 2>&-"])
def test_the_status_is_the_program_s_own_where_its_streams_are_closed(closed):
    code = f'exec "$0" -m lammps_jump check nofile.yaml {closed}'
    assert subprocess.run(["sh", "-c", code, sys.executable], capture_output=True).returncode == 2


def test_doctor_says_that_the_first_run_compiles(monkeypatch):
    """A machine where a library would be built on first use is ready, but the first run takes longer."""
    healthy, _ = tools.examine()
    assert "ready" in healthy.splitlines()[-1]
    monkeypatch.setattr(compiling, "availability", lambda product: Status(True, "not built yet"))
    told, good = tools.examine()
    last = told.splitlines()[-1]
    assert good and last.startswith("ready, but not compiled yet: ") and "lammps-jump kernels build" in last
