# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers and curves of each member, by name and with units, and the comparison of two ensembles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import nan

import numpy as np

from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.jump.result import analyse_jump
from lammps_jump.analysis.jump.summary import summarise_jump
from lammps_jump.scene.scene import Scene

from .ensembles import Binning, Member
from .statistics import Band, Difference, block_means, compare_curves, holm, welch

TIME_BLOCKS = 12
"""Series are compared by their means over this many equal parts of the run; neighbouring frames are correlated."""
MOST_BINS = 40
"""Profiles are compared on at most this many bins (neighbours averaged)."""
FORCE_MEAN = 0.1
"""The largest force is that of means over this time, s. The peak of single steps depends on chance contacts."""


@dataclass(frozen=True)
class Wanted:
    """Which analyses make sense for a case."""

    front: bool
    jump: bool
    conservative: bool


@dataclass(frozen=True)
class Curve:
    """Curve of one member; `axis` is 'x' (m) or 't' (s)."""

    axis: str
    at: np.ndarray
    values: np.ndarray
    unit: str


@dataclass(frozen=True)
class Quantities:
    """Numbers and curves of one member, by name.

    Attributes
    ----------
    scalars : dict of str to (value, unit)
    curves : dict of str to Curve
    verdict : str
        Of the jump analysis; empty where none was asked for.
    """

    scalars: dict[str, tuple[float, str]]
    curves: dict[str, Curve]
    verdict: str = ""


def measure(member: Member, scene: Scene, wanted: Wanted, binning: Binning) -> Quantities:
    """Return all numbers and curves of one member that are compared."""
    profiles, series = member.profiles, member.series
    scalars: dict[str, tuple[float, str]] = {}
    curves: dict[str, Curve] = {}
    time = series["time"]
    run = time >= 0
    x = profiles["x"].values
    group = max(1, -(-len(x) // MOST_BINS))
    for name, unit in (("mass_depth", "m"), ("surface_depth", "m"), ("velocity", "m/s"), ("discharge", "m2/s")):
        values = profiles[f"{name}_mean"].values
        blocks = -(-len(x) // group)
        curves[f"{name} profile"] = Curve("x", block_means(x, blocks), block_means(values, blocks), unit)
    for name, unit in (("discs", "1"), ("kinetic", "J/m"), ("gravitational", "J/m")):
        if (name == "gravitational" and not any(scene.gravity)) or (name == "discs" and not _open(scene)):
            continue
        curves[f"{name} history"] = _history(time[run], series[name][run].astype(float), unit)
    total = series["kinetic"] + series["gravitational"] + series["elastic"]
    scalars["kinetic energy, mean"] = float(np.mean(series["kinetic"][run])), "J/m"
    scalars["energy at the end"] = float(total[-1]), "J/m"
    if wanted.conservative:
        scalars["energy, largest deviation"] = float(np.max(np.abs(total - total[0])) / abs(total[0])), "1"
    if _open(scene):
        scalars["discs in play, mean"] = float(series["discs"][run].mean()), "1"
    if scene.inlets or scene.pours:
        scalars["discs inserted"] = float(member.result.inserted), "1"
    if scene.outlets:
        scalars["discs removed"] = float(member.result.removed), "1"
    wet = profiles["mass_depth_mean"].values > 0.5 * scene.diameter
    if wet.any():
        scalars["depth, mean over wet bins"] = float(profiles["mass_depth_mean"].values[wet].mean()), "m"
    if wet.any() and _open(scene):
        scalars["discharge, mean over wet bins"] = float(profiles["discharge_mean"].values[wet].mean()), "m2/s"
    if wanted.front:
        _front(member, time, run, scalars, curves)
    for name, table in member.forces.items():
        _force(name, table, scalars, curves)
    verdict = _jump(member, scene, binning, scalars, curves) if wanted.jump else ""
    return Quantities(scalars, curves, verdict)


def _open(scene: Scene) -> bool:
    return bool(scene.inlets or scene.pours or scene.outlets)


def _history(time: np.ndarray, values: np.ndarray, unit: str) -> Curve:
    return Curve("t", block_means(time, TIME_BLOCKS), block_means(values, TIME_BLOCKS), unit)


def _front(member: Member, time: np.ndarray, run: np.ndarray, scalars: dict, curves: dict) -> None:
    for name, label in (("front", "front"), ("front_99", "99 % front")):
        values = member.series[name]
        curves[f"{label} history"] = _history(time[run], values[run], "m")
        for share in (0.25, 0.5, 1.0):
            moment = share * time[-1]
            scalars[f"{label} at t = {moment:.3g} s"] = float(np.interp(moment, time[run], values[run])), "m"


def _force(name: str, table: np.ndarray, scalars: dict, curves: dict) -> None:
    time, fx, fy, _ = table.T
    if len(time) < 3:
        return
    step = float(np.median(np.diff(time)))
    run = time > 0
    scalars[f"impulse on {name}, x"] = float(fx[run].sum() * step), "N s/m"
    scalars[f"impulse on {name}, y"] = float(fy[run].sum() * step), "N s/m"
    width = max(1, round(FORCE_MEAN / step))
    if run.sum() > width:
        smooth = np.convolve(fx[run], np.full(width, 1.0 / width), mode="valid")
        scalars[f"largest force on {name}, x"] = float(smooth[np.argmax(np.abs(smooth))]), "N/m"
    curves[f"force on {name}, x"] = _history(time[run], fx[run], "N/m")


def _jump(member: Member, scene: Scene, binning: Binning, scalars: dict, curves: dict) -> str:
    found = analyse_jump(member.profiles, from_scene(scene, bin_width=binning.bin_width, window=binning.window))
    numbers = summarise_jump(found)
    names = (
        ("speed", "shock speed", "m/s"),
        ("y1", "depth before the jump", "m"),
        ("y2", "sequent depth", "m"),
        ("sequent_ratio", "sequent depth ratio", "1"),
        ("froude", "Froude number in the shock's frame", "1"),
        ("toe", "jump toe at the end", "m"),
        ("length", "jump length", "m"),
    )
    for key, label, unit in names:
        scalars[label] = float(getattr(numbers, key)), unit
    if found.track is not None:
        sign, track = found.direction, found.track
        if track.found.sum() >= TIME_BLOCKS:
            curves["jump toe history"] = _toe(track.time, sign * track.toe)
    return found.verdict


def _toe(time: np.ndarray, toe: np.ndarray) -> Curve:
    """Return the toe by parts of the run; NaN for a part in which fewer than half of the frames have a jump."""
    cuts = np.linspace(0, len(time), TIME_BLOCKS + 1).astype(int)
    at, values = [], []
    for a, b in pairwise(cuts):
        good = np.isfinite(toe[a:b])
        at.append(time[a:b].mean())
        values.append(toe[a:b][good].mean() if good.sum() >= 0.5 * (b - a) else nan)
    return Curve("t", np.array(at), np.array(values), "m")


@dataclass(frozen=True)
class Verdict:
    """One line of a comparison of ensembles.

    Attributes
    ----------
    name, unit : str
    kind : {'scalar', 'curve'}
    difference : Difference
        Of the scalar, or of the curve at its worst point (its half width then holds for all points at once).
    place : str
        Where that is, for a curve.
    p_adjusted : float
        Holm over the quantities of the comparison.
    word : {'agree', 'differ', 'not comparable'}
    points : int
        Points of the curve.
    """

    name: str
    unit: str
    kind: str
    difference: Difference
    place: str
    p_adjusted: float
    word: str = "not comparable"
    points: int = 0

    @property
    def text(self) -> str:
        """Verdict in words."""
        d = self.difference
        if self.word == "not comparable":
            return "not comparable"
        size = relative_size(d) if d.difference or d.half_width else None
        share = f" ({100 * d.difference / size:+.2g} ± {100 * d.half_width / size:.2g} %)" if size else ""
        where = f" at {self.place}" if self.place else ""
        return f"{self.word}: {d.difference:+.3g} ± {d.half_width:.2g}{share}{where}"


def relative_size(d: Difference) -> float | None:
    """Return the larger mean, of which a difference is a share; None where it is within twice its scatter."""
    size = max(abs(d.mean_1), abs(d.mean_2))
    spread = max(d.deviation_1, d.deviation_2)
    return size if size > 0 and not size < 2.0 * spread else None


@dataclass(frozen=True)
class Comparison:
    """Comparison of two ensembles: one verdict a quantity, and the bands of the curves."""

    name_1: str
    name_2: str
    verdicts: tuple[Verdict, ...]
    bands: dict[str, tuple[Curve, Band]]
    verdicts_of_jump: tuple[dict[str, int], dict[str, int]]

    @property
    def agrees(self) -> bool:
        """Whether no quantity differs."""
        return all(verdict.word != "differ" for verdict in self.verdicts)

    def find(self, name: str) -> Verdict | None:
        """Return the verdict of that name, None where there is none."""
        return next((verdict for verdict in self.verdicts if verdict.name == name), None)


def compare(name_1: str, one: list[Quantities], name_2: str, two: list[Quantities], family_error: float) -> Comparison:
    """Compare each number (Welch), each curve (Welch, Bonferroni over its points), and all together (Holm)."""
    drafts: list[Verdict] = []
    bands: dict[str, tuple[Curve, Band]] = {}
    for name in _common(one, two, "scalars"):
        unit = one[0].scalars[name][1]
        values = [np.array([m.scalars[name][0] for m in side]) for side in (one, two)]
        if not any(np.any(side != 0.0) for side in values):  # nothing happened in either: nothing to compare
            continue
        found = welch(*values)
        drafts.append(Verdict(name, unit, "scalar", found, "", found.p))
    for name in _common(one, two, "curves"):
        curve = one[0].curves[name]
        tables = [np.array([m.curves[name].values for m in side]) for side in (one, two)]
        if len({table.shape[1] for table in tables}) > 1 or not any(np.nan_to_num(table).any() for table in tables):
            continue
        band = compare_curves(*tables)
        bands[name] = (curve, band)
        if band.worst < 0:
            continue
        k = band.worst
        at_worst = welch(tables[0][:, k], tables[1][:, k], float(np.nanmax(np.abs(band.mean_1), initial=0.0)))
        at_worst = replace(at_worst, half_width=float(band.half_width[k]))
        sign = "x" if curve.axis == "x" else "t"
        place = f"{sign} = {curve.at[k]:.3g} {'m' if sign == 'x' else 's'}, worst of {band.points}"
        drafts.append(Verdict(name, curve.unit, "curve", at_worst, place, band.p, points=band.points))
    adjusted = holm({draft.name: draft.p_adjusted for draft in drafts})
    verdicts = []
    for draft in drafts:
        p = adjusted[draft.name]
        word = "not comparable" if p != p else ("differ" if p < family_error else "agree")
        verdicts.append(replace(draft, p_adjusted=p, word=word))
    return Comparison(name_1, name_2, tuple(verdicts), bands, (_count(one), _count(two)))


def _common(one: list[Quantities], two: list[Quantities], kind: str) -> list[str]:
    names = list(getattr(one[0], kind))
    return [name for name in names if all(name in getattr(member, kind) for member in (*one, *two))]


def _count(members: list[Quantities]) -> dict[str, int]:
    words = [member.verdict for member in members if member.verdict]
    return {word: words.count(word) for word in dict.fromkeys(words)}
