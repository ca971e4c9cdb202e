# SPDX-License-Identifier: GPL-2.0-or-later
"""The commands load little before they do something."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest


def test_commands_are_known_without_scene_and_engine():
    """`--help` takes 0.11 s, of which each of these would be a third or more."""
    code = (
        "import sys, lammps_jump.cli.app; "
        "print([name for name in ('lammps_jump.scene.scene', 'lammps_jump.physics', 'yaml', 'numba', 'matplotlib') "
        "if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("given", [{}, {"OPENBLAS_NUM_THREADS": "3"}])
def test_numpy_is_loaded_with_one_thread_of_its_own_unless_the_user_asks_for_more(given):
    code = (
        "import os, sys, lammps_jump.cli; assert 'numpy' not in sys.modules, 'too late'; "
        "print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    environment = {name: text for name, text in os.environ.items() if name != "OPENBLAS_NUM_THREADS"} | given
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == given.get("OPENBLAS_NUM_THREADS", "1")
