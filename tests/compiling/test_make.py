# SPDX-License-Identifier: GPL-2.0-or-later
"""Setting up: what compiles while the environment is installed needs few packages, and runs as the Makefile says."""

import re
import shlex
import sys
import tomllib
from pathlib import Path

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
