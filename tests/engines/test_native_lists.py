# SPDX-License-Identifier: GPL-2.0-or-later
"""Lists that the core makes by itself are those of the driver, and sums over chosen discs those of the twin."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.twin import Twin


class Seeing(Core):
    """Loops that keep the state of the last call; `inside` as of `Lists`, else the driver steps."""

    def __init__(self, threads="1", *, inside=True):
        super().__init__(threads)
        self.inside, self.runs_alone, self.state = inside, inside, None

    def advance(self, state, steps, owed):
        self.state = state._replace(lists=state.lists._replace(inside=self.inside))
        return super().advance(self.state, steps, owed)


def jump(loops, steps):
    changes = {"engine.name": "native", "discs.diameter": 0.3}
    simulation = NativeSimulation(load_case(INPUTS / "quick_jump.yaml", changes).scene(), loops=loops)
    simulation.run(steps)
    return simulation


def test_lists_of_the_core_are_those_of_the_driver(compiled_core):
    by_driver, by_core, by_two = (jump(loops, 400) for loops in (Seeing(inside=False), Seeing(), Seeing("2")))
    assert by_core.rebuilds == by_driver.rebuilds > 20
    for other in (by_core, by_two):
        for name in ("ids", "x", "y", "vx", "fx", "x0", "radius"):
            a, b = getattr(by_driver.discs, name), getattr(other.discs, name)
            assert a[: other.discs.n].tobytes() == b[: other.discs.n].tobytes(), name
        for name, array in by_driver.discs.listed(by_driver.listed_pairs()).items():
            assert np.array_equal(array, other.discs.listed(other.listed_pairs())[name]), name
        for name, array in by_driver.walls.listed.items():
            assert np.array_equal(array, other.walls.listed[name]), name


def test_the_elastic_energy_of_chosen_discs_is_that_of_their_contacts(compiled_core):
    loops = Seeing()
    simulation = jump(loops, 300)
    whole = loops.elastic(loops.state)
    touching, rng = 0, np.random.default_rng(3)
    for share in (0.002, 0.3):
        chosen = rng.random(simulation.discs.n) < share
        found, known = loops.elastic(loops.state, chosen), Twin().elastic(loops.state, chosen)
        assert found == pytest.approx(known, rel=1e-12)
        touching += found[0] > 0
    assert touching and loops.elastic(loops.state, np.ones(simulation.discs.n, bool)) == whole


@pytest.mark.parametrize("radii", [None, (0.02, 0.12)], ids=["equal", "sizes"])
def test_rows_across_the_seam_of_a_channel_hold_the_pairs_that_are_near(compiled_core, radii):
    """A pair that is listed some steps too late shows in few runs: here the pairs themselves are compared."""
    rng, n, period, skin = np.random.default_rng(7), 60, 1.0, 0.05
    x, y = rng.uniform(0.0, period, n), rng.uniform(0.0, 0.4, n)
    radius = None if radii is None else rng.uniform(*radii, n)
    sums = np.full((n, n), 0.2) if radius is None else radius[:, None] + radius
    widest = sums.max() + skin
    near = np.hypot(x[:, None] + period - x, y[:, None] - y) < sums + skin
    for loops in (Core(), Twin()):
        owner, shift = np.empty(2 * n, np.int32), np.empty(2 * n)
        start, neighbours = np.zeros(2 * n + 1, np.int64), np.empty(n * n, np.int32)
        discs = SimpleNamespace(n=n, x=x, y=y, radius=radius, period=period, start=start, neighbours=neighbours)
        rows = loops.image_rows(discs, (widest if radius is None else skin, widest, 0.0), owner, shift)
        listed = [(owner[row], j) for row in range(n, rows) for j in neighbours[start[row] : start[row + 1]]]
        assert set(shift[n:rows]) == {period} and len(listed) == len(set(listed)) > 20
        assert set(listed) == set(zip(*np.nonzero(near), strict=True))
