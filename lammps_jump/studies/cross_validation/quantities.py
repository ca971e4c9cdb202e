# SPDX-License-Identifier: GPL-2.0-or-later
"""Quantities that two engines must share within their scatter, and the statistics that hold them together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, comb, nan
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from lammps_jump.analysis import Jump
from lammps_jump.dump import ForceHistory, TextTable, read_forces
from lammps_jump.runs.summary import results_in
from lammps_jump.scene import Scene
from lammps_jump.sweeps import Results
from lammps_jump.units import numbers_of

TIME_BLOCKS = 12
"""Series are compared by their means over this many equal parts of the run; neighbouring frames are correlated."""
MOST_BINS = 40
"""Profiles are compared on at most this many bins (neighbours averaged)."""
FORCE_MEAN = 0.1
"""The largest force is that of means over this time, s. The peak of single steps depends on chance contacts."""


class MemberCurve(NamedTuple):
    """Curve of one member over 'x' (m) or 't' (s), at the places `at`; without an axis a number, its one value."""

    unit: str
    values: np.ndarray | Sequence[float | None]
    axis: str = ""
    at: np.ndarray = np.zeros(0)


JUMP_NUMBERS = {
    "speed": "shock speed", "y1": "depth before the jump", "y2": "sequent depth",
    "froude": "Froude number in the shock's frame", "toe": "jump toe at the end", "length": "jump length",
}  # fmt: skip
"""Numbers of a `Jump` that are compared, and their names here."""


@dataclass(frozen=True)
class Quantities:
    """Numbers and curves of one member.

    Attributes
    ----------
    found : dict of str to MemberCurve
    verdict : str
        Of the jump analysis; empty where none was requested.
    run : dict
        Engine, kernel, steps, time (s), discs and energy ledger.
    """

    found: dict[str, MemberCurve]
    verdict: str = ""
    run: Results = field(default_factory=dict)


def measure(folder: Path, summary: Mapping[str, Any], scene: Scene) -> Quantities:
    """Return all numbers and curves that are compared, from what the analysis of a run has left in its folder."""
    results = results_in(folder, summary)
    profiles, energy = results.dataset(), _frame(results.table("energy"))
    energy = energy[energy["time"] >= 0]
    moved, open_ = energy["kinetic"] + energy["rotational"], bool(scene.inlets or scene.pours or scene.outlets)
    coefficients, discs, jump = scene.coefficients, summary["discs"], summary.get("jump") or {}
    curves: dict[str, MemberCurve] = {}
    blocks = -(-profiles.sizes["x"] // max(1, -(-profiles.sizes["x"] // MOST_BINS)))
    for name, unit in (("mass_depth", "m"), ("surface_depth", "m"), ("velocity", "m/s"), ("discharge", "m2/s")):
        at, values = (block_means(profiles[part].values, blocks) for part in ("x", f"{name}_mean"))
        curves[f"{name} profile"] = MemberCurve(unit, values, "x", at)
    depth, discharge = (profiles[name].values for name in ("mass_depth_mean", "discharge_mean"))
    wet = depth > 0.5 * scene.diameter
    closed = coefficients.restitution == 1.0 and not coefficients.friction and not scene.inlets
    histories = (
        ("discs", "1", open_, energy["discs"]),
        ("kinetic", "J/m", True, moved),
        ("gravitational", "J/m", any(scene.gravity), energy["potential"]),
    )
    numbers = (
        ("kinetic energy, mean", "J/m", True, moved.mean),
        ("energy at the end", "J/m", True, lambda: energy["total"].iloc[-1]),
        ("energy, largest deviation", "1", closed, lambda: summary["energy"]["max_deviation"]),
        ("discs in play, mean", "1", open_, energy["discs"].mean),
        ("discs inserted", "1", scene.inlets or scene.pours, lambda: discs["inserted"]),
        ("discs removed", "1", scene.outlets, lambda: discs["removed"]),
        ("depth, mean over wet bins", "m", wet.any(), depth[wet].mean),
        ("discharge, mean over wet bins", "m2/s", wet.any() and open_, discharge[wet].mean),
    )
    curves |= {f"{name} history": _history(energy["time"], v, unit) for name, unit, known, v in histories if known}
    curves |= {name: MemberCurve(unit, [float(value())]) for name, unit, known, value in numbers if known}
    if summary.get("front"):
        curves |= _front(_frame(results.table("front")))
    for name, force in read_forces(folder / "forces.csv").items() if summary.get("force") else ():
        curves |= _force(name, force)
    units = {key: number.unit or "1" for key, number in numbers_of(Jump).items()}
    curves |= {label: MemberCurve(units[key], [jump.get(key)]) for key, label in JUMP_NUMBERS.items() if jump}
    if jump and (folder / "jump_track.csv").is_file():
        track = _frame(results.table("jump_track"))
        if track["found"].sum() >= TIME_BLOCKS:
            curves["jump toe history"] = _history(track["time"], track["toe"], "m")
    kept = {name: summary[name] for name in ("engine", "kernel", "steps", "disc_steps", "ledger")}
    run = {**kept, "seconds": summary["wall_seconds"]["run"], **discs}
    return Quantities(curves, jump.get("verdict", ""), run)


def _frame(table: TextTable) -> pd.DataFrame:
    return pd.DataFrame({name: table.numbers(name) for name in table.heads})


def _history(time: ArrayLike, values: ArrayLike, unit: str) -> MemberCurve:
    """Return means of the known values by parts of the run; NaN for a part in which fewer than half are known."""
    values = np.asarray(values, float)
    at, known, sums = (block_means(v, TIME_BLOCKS) for v in (time, np.isfinite(values), np.nan_to_num(values)))
    return MemberCurve(unit, np.where(known < 0.5, nan, sums / np.maximum(known, 0.5)), "t", at)


def _front(front: pd.DataFrame) -> dict[str, MemberCurve]:
    run, end, curves = front[front["time"] >= 0], front["time"].iloc[-1], {}
    for label, name in (("front", "bulk"), ("99 % front", "quantile")):
        curves[f"{label} history"] = _history(run["time"], run[name], "m")
        for moment in (0.25 * end, 0.5 * end, end):
            curves[f"{label} at t = {moment:z.3g} s"] = MemberCurve(
                "m", [float(np.interp(moment, run["time"], run[name]))]
            )
    return curves


def _force(name: str, force: ForceHistory) -> dict[str, MemberCurve]:
    if len(force.time) < 3:
        return {}
    step, run = float(np.median(np.diff(force.time))), force.time > 0
    fx, fy = force.fx[run], force.fy[run]
    curves = {
        f"impulse on {name}, {axis}": MemberCurve("N s/m", [f.sum() * step]) for axis, f in (("x", fx), ("y", fy))
    }
    width = max(1, round(FORCE_MEAN / step))
    if len(fx) > width:
        smooth = np.convolve(fx, np.full(width, 1.0 / width), mode="valid")
        curves[f"largest force on {name}, x"] = MemberCurve("N/m", [smooth[np.argmax(np.abs(smooth))]])
    return curves | {f"force on {name}, x": _history(force.time[run], fx, "N/m")}


@dataclass(frozen=True)
class Comparison:
    """Comparison of two ensembles, by name.

    Attributes
    ----------
    ensembles : (str, str)
    quantities : list of dict
        A row for each number and curve: name, unit, kind ('scalar' or 'curve'), ``verdict`` ('agree', 'differ', 'not
        decided' or 'not comparable') and its ``text``, ``members_needed`` of each ensemble to decide, ``p_adjusted``
        (Holm over all rows), and a `Difference`: that of the number, or of the curve at its worst point, which
        ``place`` names; its half width then holds for all ``points``, and ``scale`` is the curve's largest mean.
    jump_verdicts : (dict, dict)
        Members of each ensemble by the verdict of the jump analysis.
    bands : dict of str to (MemberCurve, Difference)
        Of the curves, at every point.
    """

    ensembles: tuple[str, str]
    quantities: list[Results]
    jump_verdicts: tuple[dict[str, int], dict[str, int]]
    bands: dict[str, tuple[MemberCurve, Difference[np.ndarray]]]

    @property
    def agrees(self) -> bool:
        """Tells whether no quantity differs."""
        return all(row["verdict"] != "differ" for row in self.quantities)

    def find(self, name: str) -> Results | None:
        """Return the row of that name, None where there is none."""
        return next((row for row in self.quantities if row["name"] == name), None)

    def stored(self) -> Results:
        """Return what goes into ``cross_validation.json``."""
        names = ("ensembles", "jump_verdicts", "agrees", "quantities")
        return {name: getattr(self, name) for name in names}


def relative_size(row: Results) -> float | None:
    """Return the larger mean, of which a difference is a share; None where it is within twice its scatter."""
    size = max(abs(row["mean_1"]), abs(row["mean_2"]))
    spread = max(row["deviation_1"], row["deviation_2"])
    return size if size > 0 and not size < 2.0 * spread else None


def _text(row: Results) -> str:
    """Return the verdict in words."""
    gap, half = row["difference"], row["half_width"]
    if row["verdict"] == "not comparable":
        return "not comparable"
    size = relative_size(row) if gap or half else None
    share = f" ({100 * gap / size:+z.2g} ± {100 * half / size:z.2g} %)" if size else ""
    where = f" at {row['place']}" if row["place"] else ""
    needed = f"; {row['members_needed']} members would decide" if row["members_needed"] else ""
    return f"{row['verdict']}: {gap:+z.3g} ± {half:z.2g}{share}{where}{needed}"


def verdict(row: Results, family_error: float) -> tuple[str, int | None]:
    """Return the verdict on a row, and the members that would decide where nothing is decided.

    The half width of the interval, which goes with the root of the members, must be at most `DECIDES` of the quantity
    to call it agreement. A number whose mean lies within its scatter has no such share, and no number of members.
    """
    size, half = relative_size(row) or row["scale"] or 0.0, row["half_width"]
    if not row["p_adjusted"] >= family_error:
        return "differ" if row["p_adjusted"] < family_error else "not comparable", None
    if half <= DECIDES * size:
        return "agree", None
    return "not decided", ceil(min(row["n_1"], row["n_2"]) * (half / (DECIDES * size)) ** 2) if size else None


def compare(names: tuple[str, str], one: list[Quantities], two: list[Quantities], family_error: float) -> Comparison:
    """Compare each number (Welch), each curve (Welch, Bonferroni over its points), and all together (Holm)."""
    rows: list[Results] = []
    bands: dict[str, tuple[MemberCurve, Difference[np.ndarray]]] = {}
    for name, curve in sorted(one[0].found.items(), key=lambda item: bool(item[1].axis)):
        if len({len(m.found[name].values) if name in m.found else 0 for m in (*one, *two)}) > 1:
            continue
        sides = [np.array([m.found[name].values for m in side], float) for side in (one, two)]
        if not any(np.nan_to_num(side, nan=0.0 if curve.axis else 1.0).any() for side in sides):
            continue  # nothing happened in either: nothing to compare
        row = _number(*sides)
        if curve.axis:
            bands[name] = curve, compare_curves(*sides)
            row = _worst_point(*bands[name], sides)
        rows += [{"name": name, "unit": curve.unit, **row}] if row else []
    adjusted = holm({row["name"]: row["p_adjusted"] for row in rows})
    for row in rows:
        row["p_adjusted"] = adjusted[row["name"]]
        row["verdict"], row["members_needed"] = verdict(row, family_error)
        row["text"] = _text(row)
    first, second = (dict(Counter(member.verdict for member in side if member.verdict)) for side in (one, two))
    return Comparison(names, rows, (first, second), bands)


def _number(one: np.ndarray, two: np.ndarray) -> Results:
    test = welch(one[:, 0], two[:, 0])
    return {"kind": "scalar", "place": None, "points": None, "scale": None, "p_adjusted": test.p, **test._asdict()}


def _worst_point(curve: MemberCurve, band: Difference[np.ndarray], sides: list[np.ndarray]) -> Results:
    """Return the row of a curve, an empty one where no point can be compared."""
    points = int(np.isfinite(band.p).sum())
    if not points:
        return {}
    k = int(np.nanargmin(band.p))
    scale = float(np.nanmax(np.abs(band.mean_1), initial=0.0))
    one, two = sides
    test = welch(one[:, k], two[:, k], scale)
    place = f"{curve.axis} = {curve.at[k]:z.3g} {'m' if curve.axis == 'x' else 's'}, worst of {points}"
    facts = {"kind": "curve", "place": place, "points": points, "scale": scale}
    return {**facts, "p_adjusted": min(1.0, band.p[k] * points), **test._asdict(), "half_width": band.half_width[k]}


# --- differences of small samples with confidence intervals, and tests of many of them with few false alarms ----------


CONFIDENCE = 0.95
"""Of the intervals that are printed."""
FAMILY_ERROR = 0.01
"""Chance that any of all comparisons of a study is called different although none is (Holm over quantities)."""
RESOLUTION = 1e-6
"""Differences below this share of a quantity's size are the rounding of files and formats, not of the engines."""
DECIDES = 0.1
"""Half width of an interval, as a share of the quantity, above which finding no difference decides nothing."""
MOST_PERMUTATIONS = 20_000
Value = TypeVar("Value")


class Difference(NamedTuple, Generic[Value]):
    """Difference of two means: numbers, or arrays with an entry for each point of a curve.

    Attributes
    ----------
    mean_1, mean_2 : float or ndarray
    deviation_1, deviation_2 : float or ndarray
        Standard deviations among members.
    difference, half_width : float or ndarray
        mean_2 - mean_1 and the half width of its `CONFIDENCE` interval (Welch). The intervals of all points of a curve
        hold at once (Bonferroni).
    p : float or ndarray
        Two-sided, Welch.
    p_permutation : float
        Exact permutation test of the difference of means; NaN with too many permutations, and for curves.
    n_1, n_2 : int or ndarray
    """

    mean_1: Value
    mean_2: Value
    deviation_1: Value
    deviation_2: Value
    difference: Value
    half_width: Value
    p: Value
    p_permutation: float
    n_1: Value
    n_2: Value


def welch(one: np.ndarray, two: np.ndarray, scale: float | None = None, points: int = 1) -> Difference[Any]:
    """Return the difference of the means of two samples of unequal variance.

    B. L. Welch, Biometrika 34 (1947) 28: t = (m2 - m1)/sqrt(s1^2/n1 + s2^2/n2) with the Welch-Satterthwaite degrees
    of freedom. The variance of each mean gets a floor of (`RESOLUTION` scale)^2, so that samples that agree to
    rounding (before chaos has set in) are not distinguished by their last digits.

    Parameters
    ----------
    one, two : ndarray, shape (n_1,) and (n_2,), or (n_1, points) and (n_2, points)
        NaN is left out.
    scale : float, optional
        Size of the quantity; default the larger absolute mean.
    points : int
        Number of intervals that are to hold at once.

    Returns
    -------
    Difference
        With NaN half width and p where a sample has fewer than two values.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        (n1, m1, s1), (n2, m2, s2) = _moments(one), _moments(two)
        gap = m2 - m1
        same = (s1 == 0) & (s2 == 0) & (gap == 0)
        size = np.where(same, 0.0, np.fmax(np.abs(m1), np.abs(m2))) if scale is None else scale
        floor = (RESOLUTION * size) ** 2
        v1, v2 = s1**2 / n1 + floor, s2**2 / n2 + floor
        total = np.where(v1 + v2 == 0, 1.0, v1 + v2)
        freedom = total**2 / np.where(v1 + v2 == 0, 1.0, v1**2 / (n1 - 1) + v2**2 / (n2 - 1))
    half = stats.t.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / points, freedom) * np.sqrt(v1 + v2)
    p = 2.0 * stats.t.sf(np.abs(gap) / np.sqrt(total), freedom)
    exact = permutation_p(one[np.isfinite(one)], two[np.isfinite(two)]) if one.ndim == 1 and p == p else nan
    return Difference(m1, m2, s1, s2, gap, half, p, exact, n1, n2)


def _moments(sample: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return number, mean and standard deviation of the values that are not NaN, along the first axis."""
    n = np.isfinite(sample).sum(axis=0)
    mean = np.nansum(sample, axis=0) / n
    return n, mean, np.sqrt(np.nansum((sample - mean) ** 2, axis=0) / np.maximum(n - 1, 0))


def permutation_p(one: np.ndarray, two: np.ndarray) -> float:
    """Return the share of all ways to deal the values into two samples whose means differ by at least as much.

    The test assumes only that the labels could be exchanged. Its least value is 1 / C(n1 + n2, n1), twice that for
    samples of equal size. NaN where there are more than `MOST_PERMUTATIONS` ways.
    """
    if comb(len(one) + len(two), len(one)) > MOST_PERMUTATIONS:
        return nan
    # centred first: rounding of a large common part must not decide ties
    centre = np.concatenate([one, two]).mean()
    exact = {"vectorized": True, "n_resamples": np.inf, "alternative": "greater"}
    return float(stats.permutation_test((one - centre, two - centre), _gap, **exact).pvalue)


def _gap(one: np.ndarray, two: np.ndarray, axis: int) -> np.ndarray:
    return np.abs(one.mean(axis=axis) - two.mean(axis=axis))


def compare_curves(one: np.ndarray, two: np.ndarray) -> Difference[np.ndarray]:
    """Compare point by point (Welch) with Bonferroni over the points.

    Parameters
    ----------
    one, two : ndarray, shape (members, points)
        Points at which any member has no number are left out.
    """
    good = np.isfinite(one).all(axis=0) & np.isfinite(two).all(axis=0)
    one, two = (np.where(good, side, nan) for side in (one, two))
    scale = float(np.nanmax(np.abs([*one, *two]), initial=0.0))
    return welch(one, two, scale, max(1, int(good.sum())))


def holm(ps: dict[str, float]) -> dict[str, float]:
    """Return adjusted p values: below a they reject with family-wise error a (S. Holm, Scand. J. Statist. 6 (1979) 65).

    NaN stays NaN and does not count.
    """
    known = pd.Series(ps, dtype=float).dropna().sort_values()
    adjusted = (known * np.arange(len(known), 0, -1)).clip(upper=1.0).cummax()
    return {name: float(adjusted.get(name, nan)) for name in ps}


def block_means(values: ArrayLike, blocks: int) -> np.ndarray:
    """Return means of `blocks` equal parts of a series (fewer where there are fewer values)."""
    values = np.asarray(values, float)
    cuts = np.linspace(0, len(values), min(blocks, len(values)) + 1).astype(int)
    return np.array([values[a:b].mean() for a, b in pairwise(cuts)])
