# SPDX-License-Identifier: GPL-2.0-or-later
"""The hashes of a run stay as they are: names of run folders, markers and summaries of earlier versions hold them."""

from dataclasses import dataclass

import numpy as np

from lammps_jump import identity

CORE = {"run": {"seed": 1}, "walls": [{"y": 0.5}]}
REST = {"name": "a", "analysis": {"jump": True}}
PROGRAM = {"engine": "native", "kernel": "numba", "lammps_jump": "0"}


@dataclass
class Numbers:
    name: str
    skin: float
    positions: np.ndarray


def test_the_hashes_are_those_of_earlier_versions(monkeypatch):
    monkeypatch.setattr(identity, "__version__", "0")
    assert identity.case_key(CORE) == "e62fedc1bc17"
    assert identity.shown_key(CORE, "numba") == "e62fedc1bc17-numba"
    assert identity.run_key(CORE, PROGRAM) == "4608d21e74b5"
    assert identity.member_key("0123", REST) == "dde52fdd1157"
    assert identity.analysis_key(REST, {"forces.csv": {"size": 1, "sha256": "ab"}}) == "74a2c9290545"
    assert identity.field_keys("name: a\nwalls:\n- {y: 1}\n") == {"name": "1e7e5f3c45fc", "walls": "a64b4243596b"}
    found = identity.scene_key(Numbers("x", 0.5, np.arange(3.0)))
    assert found == "bf23397c4e23f7401f7d3a60b7fd01541a129031115575930855b6bcdebb84dc"


def test_the_version_belongs_to_the_analysis(monkeypatch):
    before = identity.analysis_key(REST, {})
    monkeypatch.setattr(identity, "__version__", "another")
    assert identity.analysis_key(REST, {}) != before
