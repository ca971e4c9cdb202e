# SPDX-License-Identifier: GPL-2.0-or-later
"""The generated script of every scene, line by line: a change must be meant."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path

import pytest

from lammps_jump.case import load_case
from lammps_jump.engines.native import NativeSimulation, WithoutDiscs
from lammps_jump.script import script_text

HERE = Path(__file__).parent
_spec = importlib.util.spec_from_file_location("golden_make", HERE / "make.py")
_make = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_make)
texts = cache(_make.golden_texts)  # not where the module is imported: each worker imports it, one runs it


@pytest.mark.parametrize("name", sorted(path.name for path in HERE.glob("*.lammps")))
def test_script_is_the_golden_one(name):
    assert texts()[name] == (HERE / name).read_text(), "meant? then run: python tests/golden/make.py"


def test_no_golden_file_is_left_over():
    assert {path.name for path in HERE.glob("*.lammps")} == set(texts())


def test_blocks_stand_only_where_needed():
    box = texts()["energy_box_16.stock.lammps"]
    for word in ("gravity", "deposit", "evaporate", "wall/gran/region", "enforce2d", "omegaz", "nve/sphere"):
        assert word not in box, word
    collapse = texts()["column_collapse.stock.lammps"]
    assert "nve/sphere disc" in collapse and "omegaz" in collapse
    jump = texts()["hydraulic_jump_frictionless.stock.lammps"]
    # no friction: dampflag and coefficients are zero in pair and walls
    assert "gran/hooke 25600000 NULL 1008.69" in jump and " 0 0 0\n" in jump
    assert jump.count("fix deposit") == 0 and jump.count(" all deposit ") == 6


def test_skin_of_the_case_reaches_every_neighbour_list():
    scene = load_case(_make.INPUTS / "dam_break.yaml", ["engine.skin=0.05"]).scene()
    stock, compiled = (script_text(scene, kernel=kernel) for kernel in ("stock", "compiled"))
    assert "neighbor        0.05 bin\n" in stock
    # the plugin keeps a list of its own; LAMMPS' skin says no more than when discs must change ranks
    assert "neighbor        0.2 bin\n" in compiled
    assert {WithoutDiscs(scene).lists.skin, NativeSimulation(scene).skin} == {0.05}


def test_traps_of_the_design_are_avoided():
    for name, text in texts().items():
        if ".stock." not in name or "# No run: " in text:
            continue
        assert "hooke/history" not in text
        assert text.index("thermo_style") < text.index("thermo_modify")  # the style resets the other
        if " all deposit " in text:
            lines = [line for line in text.splitlines() if line.startswith("region          inlet_")]
            assert lines and all(line.endswith(" 0 0") for line in lines)  # flat in z
            assert text.count("mol disk id max") == text.count(" all deposit ")
        for line in text.splitlines():
            if line.startswith(("region          solid_", "region          face_")) and " intersect " not in line:
                assert " INF INF side " in line  # a finite face in z would be a contact
            if "wall/gran" in line and " granular " in line:
                assert line.count(" damping coeff_restitution") == 1  # others give unequal discs another restitution
            elif "wall/gran" in line:
                gamma = line.split("hooke ")[1].split()[2]
                assert float(gamma) > 0  # zero is a NaN in this wheel
        assert "format float %.10g" in text
        assert "comm_modify     vel yes" in text
