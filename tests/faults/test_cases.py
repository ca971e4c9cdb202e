# SPDX-License-Identifier: GPL-2.0-or-later
"""Case files with a value, key or line changed at random: built, or refused in a sentence; no other file is touched."""

from __future__ import annotations

import random

import pytest
from fault_table import many
from made_up import SCENES, files

import lammps_jump as lj
from lammps_jump.case import parse_case
from lammps_jump.errors import CaseError

pytestmark = pytest.mark.fault("mutants of cases")

VALUES = (
    "0", "-1", "1e300", "-1e300", "nan", ".inf", "1e-300", "99999999999999999999", "null", "true", "''", "[]", "{}",
    "[1, 2]", "{a: 1}", "x", "'20 cm'", "'1e9 km'", "../../etc/passwd", "'a\\nb'", "[nan, nan]", "!!python/none",
    "&a [*a]", "\t", "0x10",
)  # fmt: skip


def mutant(text: str, dice: random.Random) -> str:
    """A case file with one to three changes."""
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        lines = text.splitlines()
        places = [number for number, line in enumerate(lines) if line.strip() and not line.strip().startswith("#")]
        place = dice.choice(places)
        kind = dice.randrange(5)
        if kind == 0:
            del lines[place]
        elif kind == 1:
            lines.insert(dice.choice(places), lines[place])
        elif kind == 2:
            at = dice.randrange(len(lines[place]))
            lines[place] = lines[place][:at] + chr(dice.randrange(32, 127)) + lines[place][at + 1 :]
        else:
            key, colon, _ = lines[place].partition(": ")
            lines[place] = key + (colon or ": ") + dice.choice(VALUES)
        text = "\n".join(lines) + "\n"
    return text


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_mutant_is_built_or_refused(path, tmp_path, tried, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken, times = 0, many(3, 400)
    for seed in range(times):
        text = mutant(path.read_text(encoding="utf-8"), random.Random(f"{path.stem} {seed}"))
        print(f"seed {seed}")
        (tmp_path / "case.yaml").write_text(text, encoding="utf-8")
        try:
            lj.load_case(tmp_path / "case.yaml").scene()
            taken += 1
        except CaseError as error:
            assert "\n" not in str(error) and len(str(error)) < 1000
        assert list(files(tmp_path)) == [str(tmp_path / "case.yaml")]
    assert taken < times
    tried(times)


def test_values_are_counted_before_they_are_read(monkeypatch):
    """A list of 30 MB was read for minutes."""
    monkeypatch.setattr("lammps_jump.case.text.MOST_VALUES", 1000)
    monkeypatch.setattr("yaml.compose", None)
    with pytest.raises(CaseError, match=r"<case>:3: more than 1,000 values and keys"):
        parse_case("name: x\ninitial:\n  [" + 2000 * "1," + "1]\n")
