# SPDX-License-Identifier: GPL-2.0-or-later
"""docs/own_geometry.md: its case is fine, and each change says what the page says."""

import re
from pathlib import Path

import pytest

from lammps_jump.case import load_case
from lammps_jump.errors import CaseError

PAGE = (Path(__file__).parents[2] / "docs" / "own_geometry.md").read_text()
CHANGES = re.findall(r"^\| `([\w.]+)=(.+)` \| (.+) \|$", PAGE, re.MULTILINE)


@pytest.fixture
def case(tmp_path):
    """The files of the page."""
    for kind, name in (("csv", "bed.csv"), ("yaml", "chute.yaml")):
        (tmp_path / name).write_text(re.search(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)[1])
    return tmp_path / "chute.yaml"


def test_the_case_is_fine(case):
    found = load_case(case)
    assert str(found.check()).startswith("this case is fine\n")
    assert f"discs: {len(found.scene().positions)} inserted" in PAGE


@pytest.mark.parametrize(("field", "value", "said"), CHANGES, ids=[f"{row[0]}-{i}" for i, row in enumerate(CHANGES)])
def test_a_change_says_what_the_page_says(case, field, value, said):
    with pytest.raises(CaseError, match=re.escape(said)):
        load_case(case, [f"{field}={value}"]).check()


def test_every_change_is_read():
    assert len(CHANGES) == 8
