# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of results: described once, shown by one formatter, written into the summary."""

from dataclasses import dataclass, field, replace
from math import isnan, nan
from types import SimpleNamespace

import numpy as np
import pytest

from lammps_jump.files import plain
from lammps_jump.units import (
    ABSENT,
    Estimates,
    Number,
    as_summary,
    estimate,
    from_summary,
    number,
    numbers_of,
    shown,
    sure_of,
)


@dataclass(frozen=True)
class Inner:
    share: float = number("", "share of the whole")


@dataclass(frozen=True)
class Result:
    verdict: str
    y2: float = number("m", "sequent depth, by mass", label="y2")
    y2_error: float = number("m", "standard error of y2", default=nan)
    inner: Inner | None = None
    curve: tuple[float, ...] = field(default=(1.0,), metadata={"summary": False})


def test_a_class_and_its_instance_describe_their_numbers():
    expected = {
        "y2": Number("y2", "m", "sequent depth, by mass", "y2"),
        "y2_error": Number("y2_error", "m", "standard error of y2", "standard error of y2"),
    }
    assert numbers_of(Result) == numbers_of(Result("jump", 2.0)) == expected


def test_the_summary_holds_the_fields_by_name():
    result = Result("jump", 2.0, inner=Inner(0.5))
    found = as_summary(result)
    assert list(found) == ["verdict", "y2", "y2_error", "inner"] and found["inner"] == {"share": 0.5}
    assert as_summary(replace(result, inner=None))["inner"] is None


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((None,), ABSENT),
        ((nan, "m"), ABSENT),
        ((True,), "yes"),
        ((3,), "3"),
        ((0.123456,), "0.1235"),
        ((2.0, "m"), "2 m"),
        ((1.23456, "m", 0.0123), "1.235 ± 0.012 m"),
        ((123.456, "", 12.3), "123 ± 12"),
        ((1.5, "m", nan), "1.5 m"),
        (("jump",), "jump"),
    ],
)
def test_one_formatter_shows_every_value(arguments, text):
    assert shown(*arguments) == text


def test_errors_of_every_size_are_told():
    assert shown(3.4, "m", 0.06, bound=True) == "3.400 ± at least 0.060 m"
    assert shown(3.4, error=0.06, bound=True) == "3.400 ± at least 0.060"
    assert shown(3.4, "m", bound=True) == "3.4 m"
    assert shown(506.3, "kN/m", 99.6) == "510 ± 100 kN/m"
    assert shown(6.0, "m", 1e-15) == "6 m"  # arithmetic, no error
    found = SimpleNamespace(y2=3.0, y2_error=0.1, angle=20.0, angle_interval=2.0, lower_bounds=["y2"])
    assert sure_of(found, "y2") == (0.1, True) and sure_of(found, "angle") == (2.0, False)
    assert sure_of(SimpleNamespace(y2_error=nan), "y2") == (None, False)


def test_an_estimate_has_its_error_behind_it():
    @dataclass(frozen=True)
    class Flow(Estimates):
        verdict: str
        y2: float = estimate("m", "sequent depth", label="y2")
        count: int = 0

    assert list(as_summary(Flow("jump", 2.0, y2_error=0.1, count=3)).items()) == [
        ("verdict", "jump"), ("y2", 2.0), ("y2_error", 0.1), ("count", 3),
    ]  # fmt: skip

    class Jump(Flow):
        """A child without fields of its own."""

    assert list(as_summary(Jump("jump"))) == ["verdict", "y2", "y2_error", "count"]
    assert isnan(Flow("none").y2) and isnan(Flow("none").y2_error)
    assert numbers_of(Flow)["y2_error"].unit == "m"
    assert numbers_of(Flow)["y2_error"].meaning == "standard error of sequent depth"


@dataclass(frozen=True)
class Part(Estimates):
    depth: float = estimate("m", "depth")
    name: str = ""


@dataclass(frozen=True)
class Whole:
    first: Part
    parts: tuple[Part, ...]
    by_name: dict[str, Part]
    counts: tuple[int, ...]
    curve: np.ndarray
    absent: Part | None
    kind: str = field(metadata={"key": "class"})
    hidden: list[int] = field(metadata={"summary": False})


def test_a_result_is_read_back_from_its_summary():
    """Null is NaN where a number stands, arrays and inputs are left out, results within it are results again."""

    found = Whole(
        Part(1.5, name="sill"),
        (Part(2.0), Part(nan)),
        {"gate": Part(3.0)},
        (1, 2),
        np.array([0.5, nan]),
        None,
        "weak",
        hidden=[1],
    )
    summary = plain(as_summary(found))
    assert summary["parts"][1] == {"depth": None, "depth_error": None, "name": ""}
    assert summary["class"] == "weak" and "hidden" not in summary
    back = from_summary(Whole, summary)
    assert (back.first.depth, back.by_name.keys(), back.counts, back.absent, back.kind) == (
        1.5,
        {"gate"},
        (1, 2),
        None,
        "weak",
    )
    assert back.hidden is None and isnan(back.parts[1].depth) and back.parts[0].depth == 2.0
    np.testing.assert_array_equal(back.curve, found.curve)
    lacking = from_summary(Part, {})
    assert isnan(lacking.depth) and lacking.name == ""
