# SPDX-License-Identifier: GPL-2.0-or-later
"""Setting up: what compiles while the environment is installed needs few packages, and runs as the Makefile says."""

import os
import re
import shlex
import shutil
import sys
import tomllib
from pathlib import Path

import pytest
from children import run_child

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / "Makefile").read_text()
COMPILING = shlex.split(re.search(r"^COMPILING = (.+)$", MAKEFILE, re.MULTILINE)[1])

IMPORTS = """
import sys
import lammps_jump.engines.plugin.make
for name, module in sorted(sys.modules.items()):
    file = getattr(module, "__file__", None) or ""
    if "site-packages" in file and "." not in name:
        print(name)
"""
WITH_THEM = {"pydantic_core", "typing_extensions"}
"""Modules that pydantic brings."""


def names(requirements):
    return {re.match(r"[\w-]+(\[\w+\])?", one)[0] for one in requirements}


def test_what_is_installed_first_is_among_the_dependencies():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(COMPILING) <= names(project["dependencies"])


def test_compiling_imports_what_is_installed_first():
    status, said = run_child([sys.executable, "-c", IMPORTS])
    own = {"lammps_jump", *sys.builtin_module_names}
    found = {name for name in said.split() if not name.startswith(("_", "sitecustomize"))} - own
    assert status == 0 and found <= {name.partition("[")[0] for name in COMPILING} | WITH_THEM


def test_every_target_of_tests_waits_for_their_packages():
    for target in ("suite", "check", "browser", "faults", "slurm", "docs-test", "lint", "test-repeat"):
        assert f"\n{target}: $(VENV)/.test\n" in MAKEFILE
    assert "\nrun: $(VENV)/.ready\n" in MAKEFILE and "\nunexport PYTHONDONTWRITEBYTECODE\n" in MAKEFILE


STANDS_IN = """#!/bin/sh
# python3, pip and python of an environment: says how it was called, makes what is asked for
echo "$(basename "$0") $*" >> {calls}
case "$*" in *"-m venv "*) mkdir -p {venv}/bin && cp "$0" {venv}/bin/pip && cp "$0" {venv}/bin/python ;; esac
"""


def set_up_without_uv(tmp_path, target):
    """How a target calls pip where uv fails; nothing is installed."""
    venv, calls, path = tmp_path / "venv", tmp_path / "calls", tmp_path / "path"
    path.mkdir()
    (path / "python3").write_text(STANDS_IN.format(calls=calls, venv=venv))
    (path / "uv").write_text("#!/bin/sh\nexit 1\n")
    for program in path.iterdir():
        program.chmod(0o755)
    command = ["make", "-C", ROOT, f"VENV={venv}", f"PYTHON={path / 'python3'}", f"{venv}/{target}"]
    status, said = run_child(command, env={**os.environ, "PATH": f"{path}:{os.environ['PATH']}"})
    assert status == 0, said
    return [line for line in calls.read_text().splitlines() if line.startswith("pip install")]


def test_pip_installs_where_uv_cannot(tmp_path):
    first, rest, tests = set_up_without_uv(tmp_path, ".test")
    assert first == "pip install --quiet " + " ".join(COMPILING)
    assert rest == "pip install --quiet --editable ." and tests == "pip install --quiet --editable .[test]"


@pytest.mark.long
def test_pip_alone_installs_what_runs_a_case(tmp_path):
    """As README.md says it; needs the network. Of a copy: pip leaves its files in the tree."""
    shutil.copytree(ROOT, tmp_path / "tree", ignore=shutil.ignore_patterns(".*", "build", "runs", "_build", "_made"))
    python = tmp_path / "venv" / "bin" / "python"
    plain = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    for command in (
        [sys.executable, "-m", "venv", tmp_path / "venv"],
        [python, "-m", "pip", "install", "--quiet", tmp_path / "tree"],
        [python, "-m", "lammps_jump", "build-and-run", ROOT / "inputs" / "quick_jump.yaml", "--quiet", "--out", "run"],
    ):
        status, said = run_child(command, cwd=tmp_path, env=plain)
        assert status == 0, said
    assert (tmp_path / "run" / "report.html").is_file()
