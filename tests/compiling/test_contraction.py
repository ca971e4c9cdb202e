# SPDX-License-Identifier: GPL-2.0-or-later
"""What is compiled rounds every product and every sum: results are the same with every compiler and beside any code."""

import platform
import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from made_up import plugin_or_skip

from lammps_jump.compiling.build import library_path
from lammps_jump.core.library import CORE, require_core

CONTRACTED = re.compile(r"\bv?fn?m(?:add|sub)\w*\b")
"""Instructions that round once for a product and a sum."""


def contracted(library: Path) -> Counter:
    """Functions of a library that have such instructions, with their number."""
    told = subprocess.run(
        ["objdump", "-d", "-C", "--no-show-raw-insn", library], capture_output=True, text=True, check=True
    )
    found: Counter = Counter()
    name = ""
    for line in told.stdout.splitlines():
        if line.endswith(">:"):
            name = line
        elif CONTRACTED.search(line.partition(":")[2]):
            found[name] += 1
    return found


@pytest.mark.skipif(
    platform.machine() != "x86_64" or shutil.which("objdump") is None, reason="reads instructions of x86-64 by objdump"
)
@pytest.mark.parametrize("product", ["core", "plugin"])
def test_nothing_compiled_contracts(product):
    if product == "core":
        require_core("this test")
    library = library_path(CORE) if product == "core" else plugin_or_skip()
    assert not contracted(library)
