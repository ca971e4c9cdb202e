# SPDX-License-Identifier: GPL-2.0-or-later
"""Own elementary functions: right to a unit in the last place, and the same bits in C++ and in Python."""

import ctypes
import math
import random
from itertools import product

import mpmath
import numpy as np
import pytest

from lammps_jump.core import core
from lammps_jump.physics import elementary

LARGEST = math.ldexp(1.0 - 2.0**-53, 1024)
EDGES = [
    0.0, -0.0, 5e-324, 2.3e-308, 1e-300, 1e-9, 1e-8, 0.7853981633974483, 0.7853981633974484, 1.5707963267948966,
    3.141592653589793, 6.283185307179586, 5.319372648326541e255, 6.381956970095103e16, LARGEST, math.inf, math.nan,
]  # fmt: skip
"""The two long ones are doubles that lie nearest to a multiple of pi/2 (Muller et al. 2018, 11.4)."""


def angles(count: int) -> list[float]:
    """Angles of all sizes, rad, and as many next to multiples of pi/2."""
    draw = random.Random(1)
    found = []
    for i in range(count // 4):
        found.append(draw.uniform(-4.0, 4.0))
        found.append(draw.uniform(-1e6, 1e6))
        found.append(math.ldexp(draw.uniform(-1.0, 1.0), draw.randint(-40, 1023)))
        found.append(math.nextafter((i + 1) * math.pi / 2, draw.choice([0.0, math.inf])))
    return found


def points(count: int) -> list[tuple[float, float]]:
    """Points (y, x) all round, of like and of unlike coordinates, and near the axes and diagonals."""
    draw = random.Random(2)
    found = []
    for _ in range(count // 3):
        y, x = draw.uniform(-2.0, 2.0), draw.uniform(-2.0, 2.0)
        found.append((y, x))
        found.append((x * draw.choice([1.0, -1.0, 0.125, 0.0625, 0.5, 8.0]) * (1.0 + 1e-15 * y), x))
        found.append((math.ldexp(y, draw.randint(-400, 400)), math.ldexp(x, draw.randint(-400, 400))))
    return found


def off(got: float, right: mpmath.mpf) -> float:
    """Distance in units in the last place of the right number."""
    return float(abs(mpmath.mpf(got) - right) / mpmath.mpf(math.ulp(float(right))))


def worst(count: int) -> dict[str, float]:
    """Largest distance of each function over so many arguments."""
    found = dict.fromkeys(["sin", "cos", "atan2"], 0.0)
    with mpmath.workprec(1300):  # the largest angles need the digits of pi
        turns = [(x, mpmath.cos_sin(mpmath.mpf(x))) for x in angles(count)]
    with mpmath.workprec(120):
        for x, (c, s) in turns:
            found["sin"] = max(found["sin"], off(elementary.sin(x), s))
            found["cos"] = max(found["cos"], off(elementary.cos(x), c))
        for y, x in points(count):
            found["atan2"] = max(found["atan2"], off(elementary.atan2(y, x), mpmath.atan2(y, x)))
    return found


def test_within_a_unit_in_the_last_place():
    assert max(worst(2_000).values()) < 1.0


@pytest.mark.long
def test_within_a_unit_in_the_last_place_for_a_million_arguments():
    assert max(worst(1_000_000).values()) < 1.0


@pytest.mark.parametrize("name", ["asin", "acos"])
def test_inverse_functions(name):
    draw = random.Random(3)
    for _ in range(500):
        x = draw.choice([draw.uniform(-1.0, 1.0), 1.0 - 10.0 ** draw.uniform(-16.0, -1.0)])
        with mpmath.workprec(120):
            assert off(getattr(elementary, name)(x), getattr(mpmath, name)(x)) < 2.0
    with pytest.raises(ValueError):
        getattr(elementary, name)(1.0000001)


def test_logarithm_exponential_and_power_are_rounded_once():
    draw = random.Random(4)
    for _ in range(300):
        x, y = 10.0 ** draw.uniform(-300.0, 300.0), draw.uniform(-700.0, 700.0)
        with mpmath.workprec(160):
            assert elementary.log(x) == float(mpmath.log(x))
            assert elementary.exp(y) == float(mpmath.exp(y))
            assert elementary.power(x, 1.0 / 7.0) == float(mpmath.power(x, mpmath.mpf(1.0 / 7.0)))
    assert [elementary.power(0.0, 0.5), elementary.power(0.0, 0.0), elementary.power(2.5, 0.0)] == [0.0, 1.0, 1.0]
    assert elementary.log(math.inf) == math.inf
    for wrong in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError):
            elementary.log(wrong)
    with pytest.raises(ValueError):
        elementary.power(-1.0, 2.0)


@pytest.mark.parametrize("y, x", list(product([0.0, -0.0, 1.0, -1.0, math.inf, -math.inf], repeat=2)))
def test_angles_of_zeros_and_infinities_are_those_of_c(y, x):
    got = elementary.atan2(y, x)
    assert (got, math.copysign(1.0, got)) == (math.atan2(y, x), math.copysign(1.0, math.atan2(y, x)))


def bits(values) -> list[int]:
    found = np.array(values, dtype=float)
    return np.where(np.isnan(found), np.nan, found).view(np.int64).tolist()


@pytest.mark.skipif(core() is None, reason="needs the core")
def test_core_and_python_give_the_same_bits():
    library = core()
    turns = [*EDGES, *(-x for x in EDGES), *angles(20_000)]
    for name in ("sin", "cos"):
        function = library["jump_" + name]
        function.argtypes, function.restype = [ctypes.c_double], ctypes.c_double
        assert bits([function(x) for x in turns]) == bits([getattr(elementary, name)(x) for x in turns])
    function = library["jump_atan2"]
    function.argtypes, function.restype = [ctypes.c_double] * 2, ctypes.c_double
    some = [*product(EDGES, EDGES), *((y, -x) for y, x in product(EDGES, EDGES)), *points(20_000)]
    assert bits([function(y, x) for y, x in some]) == bits([elementary.atan2(y, x) for y, x in some])
