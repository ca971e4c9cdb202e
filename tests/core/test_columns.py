# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns of arrays have the same names and places in Python and in the core."""

import ctypes

import pytest

from lammps_jump.core import columns, require_core
from lammps_jump.errors import SetupError
from lammps_jump.scene.tracks import ANGLE, COLUMNS, PHASE, X


def test_the_core_has_the_columns_that_python_knows(compiled_core):
    tell = require_core("columns")["jump_columns"]
    tell.restype = ctypes.c_char_p
    assert tell().decode().splitlines() == columns.lines()
    columns.require_columns(tell().decode())


def test_a_core_with_other_columns_is_refused():
    there = "\n".join(columns.lines())
    moved = there.replace("Pushed place=0+3 speed=3+3 before=6+3", "Pushed place=0+3 before=3+3 speed=6+3")
    assert moved != there
    with pytest.raises(SetupError, match=r"not the same in the core and in Python: Pushed place=0\+3 before=3\+3"):
        columns.require_columns(moved)
    with pytest.raises(SetupError, match="LOADED=7"):
        columns.require_columns(there.replace("LOADED=2", "LOADED=7"))


def test_columns_know_their_number():
    assert columns.PlacedColumns.width() == 11 and columns.PushedColumns.width() == 13
    assert (X, ANGLE, PHASE, COLUMNS) == (1, 11, 22, 25)
