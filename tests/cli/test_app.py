# SPDX-License-Identifier: GPL-2.0-or-later
"""The commands load little before they do something."""

from __future__ import annotations

import subprocess
import sys


def test_commands_are_known_without_scene_and_engine():
    """`--help` takes 0.11 s, of which each of these would be a third or more."""
    code = (
        "import sys, lammps_jump.cli.app; "
        "print([name for name in ('lammps_jump.scene.scene', 'lammps_jump.physics', 'yaml', 'numba', 'matplotlib') "
        "if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
