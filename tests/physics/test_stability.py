# SPDX-License-Identifier: GPL-2.0-or-later
"""Stability limits of contact.py against the eigenvalues of whole packings, stepped by either scheme."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from lammps_jump.case.packing import piled
from lammps_jump.physics import contact
from lammps_jump.scene import Sizes

K, M = 1.0, 1.0
CRITICAL = contact.critical_time_step(K, M)
SCHEMES = ("velocity_verlet", "leapfrog_extrapolated")


def packing(xi: float, *, square: bool = False, wall: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping matrices over the mass of 4 x 4 discs, periodic in x, and in y unless on a wall."""
    rows = columns = 4
    n = rows * columns
    springs, dashpots = np.zeros((2, 2 * n, 2 * n))
    c_pair = 2 * xi * np.sqrt(K * M / 2)

    def bond(i: int, j: int, nx: float, ny: float) -> None:
        normal = np.outer((nx, ny), (nx, ny))
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            springs[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += sign * K * normal
            dashpots[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += sign * c_pair * normal

    def index(row: int, column: int) -> int:
        return (row % rows) * columns + column % columns

    for row in range(rows):
        for column in range(columns):
            bond(index(row, column), index(row, column + 1), 1.0, 0.0)
            if row == rows - 1 and wall is not None:
                continue
            if square:
                bond(index(row, column), index(row + 1, column), 0.0, 1.0)
            else:
                shift = row % 2
                bond(index(row, column), index(row + 1, column + shift - 1), -0.5, np.sqrt(0.75))
                bond(index(row, column), index(row + 1, column + shift), 0.5, np.sqrt(0.75))
    if wall is not None:
        for column in range(columns):
            i = 2 * column + 1
            springs[i, i] += wall
            dashpots[i, i] += 2 * xi * np.sqrt(wall * M)
    return springs / M, dashpots / M


def growth(springs: np.ndarray, dashpots: np.ndarray, dt: float, scheme: str) -> float:
    """Largest modulus by which a step multiplies a mode: 1 and less is stable."""
    one, none = np.eye(len(springs)), np.zeros_like(springs)
    if scheme == "velocity_verlet":
        kick = [-dt * springs, one - dt * dashpots]
        rows = [[one + dt * kick[0], dt * kick[1]], kick]
    else:
        kick = [-dt * springs, one - 1.5 * dt * dashpots, 0.5 * dt * dashpots]
        rows = [[one + dt * kick[0], dt * kick[1], dt * kick[2]], kick, [none, one, none]]
    return np.abs(np.linalg.eigvals(np.block(rows))).max()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_limit_of_packings_is_exact(scheme):
    for e, square in product((1.0, 0.6, 0.2), (False, True)):
        xi = contact.damping_ratio(e)
        limit = contact.stable_fraction(xi, scheme, "square" if square else "hexagonal") * CRITICAL
        matrices = packing(xi, square=square)
        # rigid motion is a double eigenvalue 1, which round-off spreads to about 1e-8
        assert growth(*matrices, 0.999 * limit, scheme) < 1 + 1e-6, (e, square)
        assert growth(*matrices, 1.001 * limit, scheme) > 1 + 1e-4, (e, square)


def derived(scheme: str, e: float, wall: float, smallest: float | None = None) -> contact.Coefficients:
    """Coefficients of discs of density M with stiffness K, on walls of the stiffness `wall`."""
    given = contact.ContactNumbers(
        density=M,
        diameter=1.0,
        restitution=e,
        friction=0.0,
        stiffness=K,
        stiffness_wall=wall,
        impact_speed=1.0,
        time_step_fraction=0.05,
        integrator=scheme,
        correct_restitution=False,
        rotation=False,
        smallest=smallest,
    )
    return contact.derive(given)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_limit_on_a_wall_is_safe_and_not_wasteful(scheme):
    for e, wall in product((1.0, 0.6, 0.2), (1.0, 3.0, 6.0, 30.0)):
        coefficients = derived(scheme, e, wall)
        matrices = packing(contact.damping_ratio(e), wall=wall)
        limit = coefficients.stable_fraction * CRITICAL
        assert growth(*matrices, limit, scheme) < 1 + 1e-6, (e, wall)
        # a bound: 11 % below the exact limit at most, over stiffness 1 … 30 and e = 0.2 … 1
        assert growth(*matrices, 1.12 * limit, scheme) > 1 + 1e-4, (e, wall)


def test_stiff_walls_lower_the_limit():
    xi = contact.damping_ratio(0.2)
    bed = contact.stable_fraction(xi, "velocity_verlet")
    pair, wall = contact.damping(0.2, K, M / 2), contact.damping(0.2, 30 * K, M)
    assert contact.wall_stable_fraction(K, 30 * K, M, pair, wall, "velocity_verlet") < 0.5 * bed
    same = contact.damping(0.2, K, M)
    assert contact.wall_stable_fraction(K, K, M, pair, same, "velocity_verlet") > bed


PILES = {
    "uniform": Sizes((1.0,), (0.8,), (1.2,)),
    "wide": Sizes((1.0,), (0.5,), (1.5,)),
    "two": Sizes((0.8, 0.2), (0.6, 1.4), (0.6, 1.4)),
    "few small": Sizes((0.1, 0.9), (0.7, 1.0), (0.7, 1.0)),
}


def pile(sizes: Sizes, e: float, wall: float, squeezed: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping matrices over the masses of a pile; discs nearer than `squeezed` to touching touch."""
    box = ((0.0, 5.0), (0.0, 5.0))
    d = sizes.diameters(np.arange(1, 201))
    places = piled(tuple(d.tolist()), *box, sizes.largest)
    d = d[: len(places)]
    m = M * d**2
    xi = contact.damping_ratio(e)
    springs, dashpots = np.zeros((2, 2 * len(d), 2 * len(d)))
    for i in range(len(d)):
        for j in range(i):
            apart = places[i] - places[j]
            distance = np.hypot(*apart)
            if distance < (d[i] + d[j]) / 2 + squeezed:
                normal = np.outer(apart, apart) / distance**2
                c = 2 * xi * np.sqrt(K * m[i] * m[j] / (m[i] + m[j]))
                for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    springs[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += sign * K * normal
                    dashpots[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += sign * c * normal
        for axis, (low, high) in enumerate(box):
            reach = d[i] / 2 + squeezed
            touches = (places[i, axis] - low < reach) + (high - places[i, axis] < reach)
            springs[2 * i + axis, 2 * i + axis] += touches * wall
            dashpots[2 * i + axis, 2 * i + axis] += touches * 2 * xi * np.sqrt(wall * m[i])
    masses = np.repeat(m, 2)[:, None]
    return springs / masses, dashpots / masses


@pytest.mark.parametrize("sizes", PILES.values(), ids=PILES)
def test_limit_of_the_smallest_discs_is_safe_in_piles_of_several_sizes(sizes):
    for scheme, e, wall in product(SCHEMES, (1.0, 0.2), (1.0, 10.0)):
        coefficients = derived(scheme, e, wall, sizes.smallest)
        assert coefficients.critical_time_step == pytest.approx(sizes.smallest * CRITICAL, rel=1e-12)
        limit = coefficients.stable_fraction * coefficients.critical_time_step
        # touching as packed, and pressed together until many more touch
        for squeezed in (1e-6, 0.05):
            assert growth(*pile(sizes, e, wall, squeezed), limit, scheme) < 1 + 1e-6, (scheme, e, wall, squeezed)
