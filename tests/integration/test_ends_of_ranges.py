# SPDX-License-Identifier: GPL-2.0-or-later
"""At the ends of what a case allows every engine runs with every law, and all of them find the same."""

from __future__ import annotations

from itertools import combinations
from math import inf

import numpy as np
import pytest
from ends import ENDS, LAWS, case_at
from features import BASE, ENGINES
from made_up import engine_setting, lacks

from lammps_jump.case import load_case
from lammps_jump.dump.find import read_forces
from lammps_jump.dump.read import open_dump
from lammps_jump.engines.launch import run
from lammps_jump.errors import CaseError

pytestmark = pytest.mark.lammps
NEAR = 1e-7
"""Largest difference of places in diameters: round-off that collisions amplify, to 5e-10 when measured."""
REFUSED = {"no disc", "fixed discs alone", "inflow of no row"}
"""Ends that no law runs."""
CHEAP = {
    ("contact.friction=0", "history"), ("contact.tangential_ratio=0", "history"),
    ("restitution 1, several sizes", "history"), ("a lid, contacts asked for", "history"), ("one disc", "sign"),
}  # fmt: skip
"""What the default run tries: what once went wrong, and each law that needs it."""
PAIRS = [
    pytest.param(end, law, id=f"{end}-{law}", marks=[] if (end, law) in CHEAP else pytest.mark.long)
    for end in ENDS
    for law in LAWS
]


def scene_at(end: str, law: str, engine: str):
    whole, changes = case_at(end, law)
    name = "native" if engine == "native" else "lammps"
    return load_case({**BASE, **whole, "engine": {"name": name}}, changes).scene()


@pytest.mark.parametrize(("end", "law"), PAIRS)
def test_all_engines_run_the_ends_of_ranges_alike(end, law, tmp_path):
    try:
        scenes = {engine: scene_at(end, law, engine) for engine in ENGINES}
    except CaseError:
        with pytest.raises(CaseError):
            scene_at(end, law, "native")
        return
    assert end not in REFUSED
    results = {}
    for engine, scene in scenes.items():
        if not lacks(scene, engine):
            results[engine] = run(scene, tmp_path / engine, engine_setting(engine, checkpoint_interval=inf))
    assert len({result.status for result in results.values()}) == 1, {e: r.message for e, r in results.items()}
    if (end, law) == ("contact.friction=1000", "sign"):  # `check` warns that this ramp is unstable
        assert results["native"].status == "failed"
        return
    assert results["native"].status == "complete", results["native"].message
    for one, two in combinations(results, 2):
        compare(scenes["native"], tmp_path / one, tmp_path / two)


def compare(scene, one, two) -> None:
    """The same discs at the same places; of a pour, which is random, the same frames and windows."""
    frames = [[frame.sorted() for frame in open_dump(next(place.glob("dump.*")))] for place in (one, two)]
    assert [frame.step for frame in frames[0]] == [frame.step for frame in frames[1]]
    for before, after in () if scene.pours else zip(*frames, strict=True):
        assert np.array_equal(before.ids, after.ids)
        away = np.hypot(before.x - after.x, before.y - after.y) / scene.diameter
        assert (away < NEAR).all(), (one.name, two.name, before.step, away.max())
    if scene.probes:
        forces = [read_forces(place / "forces.csv") for place in (one, two)]
        assert {name: len(found.time) for name, found in forces[0].items()} == {
            name: len(found.time) for name, found in forces[1].items()
        }
