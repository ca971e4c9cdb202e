# SPDX-License-Identifier: GPL-2.0-or-later
"""Rating curve of a weir or gate on the page of a study: discharge against head, with that of water.

A study that collects ``head`` and ``discharge`` of ``overtopping.<name>`` has the curve of a weir, one that collects
``below_head`` and ``below`` that of a gate.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GOLD, GREY, drawing
from lammps_jump.analysis.report.page import Section, Table, Text
from lammps_jump.physics.jump import critical_depth, critical_discharge, gate_discharge
from lammps_jump.units import shown

from .study_folder import StudyResults
from .table import flat

FEWEST = 3
"""Points of which a power of the head is taken."""


class RatingLaw(NamedTuple):
    """Numbers of ``overtopping.<name>`` that make a rating curve, and the law of water for it in words."""

    head: str
    discharge: str
    over: str
    water: str


WEIR = RatingLaw("head", "discharge", "over the crest", "critical flow over a broad crest, √g (2 H/3)^1.5")
GATE = RatingLaw("below_head", "below", "over the bed", "water under a gate, C a √(2 g (H − C a))")


@dataclass(frozen=True)
class Rating:
    """Rating curve of one structure.

    Attributes
    ----------
    name : str
    law : RatingLaw
    head, discharge : ndarray, shape (points, 3)
        Mean over starts, and the ends of its interval, m and m^2/s.
    opening : ndarray, shape (points,), m
        Of a gate; NaN of a weir.
    depth : ndarray, shape (points,), m
        On the crest; NaN where the study does not collect it.
    gravity : float
        m/s^2.
    """

    name: str
    law: RatingLaw
    head: np.ndarray
    discharge: np.ndarray
    opening: np.ndarray
    depth: np.ndarray
    gravity: float

    def water(self, head: np.ndarray) -> np.ndarray:
        """Discharge of water at heads above 0 (m), m^2/s; of a gate that of the mean opening."""
        if self.law is WEIR:
            return np.array([critical_discharge(one, self.gravity) for one in head])
        opening = np.nanmean(self.opening)
        return np.array([gate_discharge(opening, one, self.gravity) for one in head])

    @property
    def ratio(self) -> np.ndarray:
        """Discharge of each point over that of water at its head and opening, shape (points,)."""
        if self.law is WEIR:
            water = self.water(self.head[:, 0])
        else:
            pairs = zip(self.opening, self.head[:, 0], strict=True)
            water = np.array([gate_discharge(a, h, self.gravity) if a == a and h == h else nan for a, h in pairs])
        return self.discharge[:, 0] / water

    @property
    def crest_ratio(self) -> np.ndarray:
        """Depth on the crest over the critical depth of the discharge, shape (points,)."""
        return self.depth / np.array([critical_depth(q, self.gravity) if q > 0 else nan for q in self.discharge[:, 0]])

    @property
    def power(self) -> tuple[float, float] | None:
        """Factor k and exponent n of the discharge k H^n, by least squares of logarithms; None of too few points."""
        head, discharge = self.head[:, 0], self.discharge[:, 0]
        good = (head > 0) & (discharge > 0)
        if good.sum() < FEWEST or np.ptp(head[good]) < 0.05 * head[good].max():
            return None
        n, k = np.polyfit(np.log(head[good]), np.log(discharge[good]), 1)
        return float(np.exp(k)), float(n)


def ratings(results: StudyResults) -> list[Rating]:
    """Rating curves of what a study collects, in its order."""
    study, frame = results.study, flat(results.table, results.study)
    paths = [item.path for item in study.collect]
    gravity = float(np.hypot(*study.case.scene().gravity))
    made = []
    for name in dict.fromkeys(path.split(".")[1] for path in paths if path.startswith("overtopping.")):
        for law in (WEIR, GATE):
            head, discharge = (f"overtopping.{name}.{key}" for key in (law.head, law.discharge))
            if head not in paths or discharge not in paths or not gravity > 0:
                continue
            values = [
                np.column_stack([np.asarray(frame[one], float) for one in (path, f"{path}_low", f"{path}_high")])
                for path in (head, discharge)
            ]
            gap, depth = (
                np.asarray(frame[path], float) if path in paths else np.full(len(frame), nan)
                for path in (f"overtopping.{name}.opening", f"overtopping.{name}.depth")
            )
            there = (values[0][:, 0] > 0) & np.isfinite(values[1][:, 0])
            if there.any() and (law is WEIR or np.isfinite(gap[there]).all()):
                made.append(Rating(name, law, values[0][there], values[1][there], gap[there], depth[there], gravity))
    return made


def figures(results: StudyResults) -> Iterator[tuple[str, str, Figure]]:
    """Name, caption and figure of each rating curve of more than one point."""
    for one in ratings(results):
        if len(one.head) > 1:
            caption = f"Rating curve of {one.name}; bars: interval over members; dashed: {one.law.water}"
            yield f"sweep_rating_{one.name}", caption, draw(one)


def draw(rating: Rating) -> Figure:
    """Draw discharge against head, with the curve of water and the fitted power."""
    head, discharge = rating.head, rating.discharge
    across = np.linspace(0.9 * head[:, 0].min(), 1.05 * head[:, 0].max(), 100)
    with drawing(5.6, 4.0, 1, 1) as (figure, panel):
        bars = [np.nan_to_num(np.abs(values[:, 1:] - values[:, :1])).T for values in (head, discharge)]
        panel.errorbar(
            head[:, 0], discharge[:, 0], xerr=bars[0], yerr=bars[1], fmt="o", ms=5, color=BLUE, capsize=2, label="discs"
        )
        panel.plot(across, rating.water(across), "--", color=GREY, label="water")
        if rating.power:
            k, n = rating.power
            panel.plot(across, k * across**n, color=GOLD, label=f"{k:z.3g} H^{n:z.2f}")
        panel.set(xlabel=f"Head {rating.law.over} H [m]", ylabel="Discharge [m²/s]", ylim=(0, None))
        panel.legend()
        return figure


def section(results: StudyResults) -> Section:
    """Rating curves in words and numbers; without blocks where the study has none."""
    blocks: list[Table | Text] = []
    for one in ratings(results):
        ratios = one.ratio[np.isfinite(one.ratio)]
        texts = [f"{end(ratios):z.2f}" for end in (np.min, np.max)] if ratios.size else []
        shares = " to ".join(dict.fromkeys(texts))
        carried = f"the discs carry {shares} of" if shares else "no head is above the jet of"
        power = f" They follow {one.power[0]:z.3g} H^{one.power[1]:z.2f} (m²/s, m)." if one.power else ""
        gap, depths = one.law is GATE, one.law is WEIR and np.isfinite(one.crest_ratio).all()
        if depths:
            ends = one.crest_ratio.min(), one.crest_ratio.max()
            power += f" On the crest they are {ends[0]:z.2f} to {ends[1]:z.2f} times as deep as critical flow is."
        blocks.append(Text(f"{one.name}: {carried} {one.law.water}.{power}"))
        heads = [f"Head {one.law.over} [m]", *(["Opening [m]"] if gap else []), "Discharge [m²/s]", "Over water"]
        heads += ["Depth on the crest over critical"] if depths else []
        rows = [
            [
                interval_of(h),
                *([shown(float(a))] if gap else []),
                interval_of(q),
                shown(float(r), digits=3),
                *([shown(float(c), digits=3)] if depths else []),
            ]
            for h, a, q, r, c in zip(one.head, one.opening, one.discharge, one.ratio, one.crest_ratio, strict=True)
        ]
        blocks.append(Table(rows, heads))
    return Section("Rating curve", blocks)


def interval_of(values: np.ndarray) -> str:
    """A mean with half of its interval, where that is known."""
    mean, _, high = (float(value) for value in values)
    return shown(mean, error=high - mean) if np.isfinite(high) else shown(mean, digits=3)
