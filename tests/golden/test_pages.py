# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a short run of every scene, word by word and number by number: a change must be meant."""

from __future__ import annotations

import difflib
import importlib.util
from itertools import zip_longest
from pathlib import Path

import pytest
from same_results import NUMBER

HERE = Path(__file__).parent
_spec = importlib.util.spec_from_file_location("golden_make", HERE / "make.py")
_make = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_make)
CHEAP = {"quick_jump", "caisson"}
"""A jump with inflow and forces; a body. 1.6 and 0.9 s of processor time; all scenes take 45 s."""


def unit_of(number: str) -> float:
    """One in the last place of a number as it is shown; 0 for a whole number, which may be a count."""
    mantissa, _, power = number.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 10.0 ** (int(power or 0) - decimals) if decimals else 0.0


def differences(old: str, new: str) -> list[str]:
    """Lines of two pages that differ in words, or in a number by more than one in its last place.

    Sines and means by another library may differ in their last bit: a number close to the middle between two that can
    be shown is then rounded to the other one.
    """
    words = [[NUMBER.sub("#", line) for line in text.splitlines()] for text in (old, new)]
    if words[0] != words[1]:
        return [line for line in difflib.unified_diff(old.splitlines(), new.splitlines(), n=0, lineterm="")][2:]
    return [
        f"-{before}\n+{after}"
        for before, after in zip_longest(old.splitlines(), new.splitlines())
        for one, two in zip(NUMBER.findall(before), NUMBER.findall(after), strict=True)
        if one != two and abs(float(one) - float(two)) > 1.001 * max(unit_of(one), unit_of(two))
    ]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in CHEAP else pytest.mark.long) for name in _make.SHORT]
)
def test_page_is_the_golden_one(name, tmp_path):
    golden = (_make.PAGES / f"{name}.txt").read_text()
    found = differences(golden, _make.golden_page(name, tmp_path))
    assert not found, "\n".join([*found, f"meant? then run: python tests/golden/make.py pages {name}"])


def test_every_scene_has_a_golden_page():
    scenes = {path.stem for path in _make.INPUTS.glob("*.yaml")}
    assert scenes == set(_make.SHORT) == {path.stem for path in _make.PAGES.glob("*.txt")}


def test_pages_that_differ_are_told():
    page = "Length [m] 4.10\nDiscs 12 lost, at 9.3e-06\n"
    assert not differences(page, page) and not differences(page, page.replace("4.10", "4.11"))
    others = (("4.10", "4.12"), ("12 lost", "13 lost"), ("lost", "left"), ("9.3e-06", "9.5e-06"), ("at", "at 1"))
    for before, after in others:
        assert differences(page, page.replace(before, after)), after
