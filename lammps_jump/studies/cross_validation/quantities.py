# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers and curves of each member, by name and with units, and the comparison of two ensembles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from lammps_jump.dump.exports import read_netcdf
from lammps_jump.dump.find import ForceHistory, read_forces
from lammps_jump.scene.scene import Scene
from lammps_jump.sweeps.store import Results

from .statistics import DECIDES, Difference, block_means, compare_curves, holm, welch

TIME_BLOCKS = 12
"""Series are compared by their means over this many equal parts of the run; neighbouring frames are correlated."""
MOST_BINS = 40
"""Profiles are compared on at most this many bins (neighbours averaged)."""
FORCE_MEAN = 0.1
"""The largest force is that of means over this time, s. The peak of single steps depends on chance contacts."""


@dataclass(frozen=True)
class Curve:
    """Curve of one member; `axis` is 'x' (m) or 't' (s)."""

    axis: str
    at: Sequence[float]
    values: Sequence[float]
    unit: str


JUMP_NUMBERS = (
    ("speed", "shock speed", "m/s"),
    ("y1", "depth before the jump", "m"),
    ("y2", "sequent depth", "m"),
    ("sequent_ratio", "sequent depth ratio", "1"),
    ("froude", "Froude number in the shock's frame", "1"),
    ("toe", "jump toe at the end", "m"),
    ("length", "jump length", "m"),
)


@dataclass(frozen=True)
class Quantities:
    """Numbers and curves of one member, by name.

    Attributes
    ----------
    scalars : dict of str to (value, unit)
    curves : dict of str to Curve
    verdict : str
        Of the jump analysis; empty where none was asked for.
    run : dict
        Engine, kernel, steps, time (s), discs and energy ledger.
    """

    scalars: dict[str, tuple[float | None, str]]
    curves: dict[str, Curve]
    verdict: str = ""
    run: dict = field(default_factory=dict)


def measure(folder: Path, summary: Mapping[str, Any], scene: Scene) -> Quantities:
    """Return all numbers and curves that are compared, from what the analysis of a run has left in its folder."""
    profiles, energy = read_netcdf(folder / "profiles.nc"), pd.read_csv(folder / "energy.csv")
    energy = energy[energy["time"] >= 0]
    moved, open_ = energy["kinetic"] + energy["rotational"], bool(scene.inlets or scene.pours or scene.outlets)
    coefficients, discs = scene.coefficients, summary["discs"]
    kept = {name: summary[name] for name in ("engine", "kernel", "steps", "disc_steps", "ledger")}
    found = Quantities({}, {}, run={**kept, "seconds": summary["wall_seconds"]["run"], **discs})
    scalars, curves = found.scalars, found.curves
    blocks = -(-profiles.sizes["x"] // max(1, -(-profiles.sizes["x"] // MOST_BINS)))
    for name, unit in (("mass_depth", "m"), ("surface_depth", "m"), ("velocity", "m/s"), ("discharge", "m2/s")):
        at, values = (block_means(profiles[part].values, blocks) for part in ("x", f"{name}_mean"))
        curves[f"{name} profile"] = Curve("x", at, values, unit)
    histories = {"discs": (energy["discs"], "1")} if open_ else {}
    histories |= {"kinetic": (moved, "J/m")}
    histories |= {"gravitational": (energy["potential"], "J/m")} if any(scene.gravity) else {}
    for name, (values, unit) in histories.items():
        curves[f"{name} history"] = _history(energy["time"], values, unit)
    depth, discharge = (profiles[name].values for name in ("mass_depth_mean", "discharge_mean"))
    wet = depth > 0.5 * scene.diameter
    closed = coefficients.restitution == 1.0 and not coefficients.friction and not scene.inlets
    rows = (
        ("kinetic energy, mean", "J/m", True, moved.mean),
        ("energy at the end", "J/m", True, lambda: energy["total"].iloc[-1]),
        ("energy, largest deviation", "1", closed, lambda: summary["energy"]["max_deviation"]),
        ("discs in play, mean", "1", open_, energy["discs"].mean),
        ("discs inserted", "1", scene.inlets or scene.pours, lambda: discs["inserted"]),
        ("discs removed", "1", scene.outlets, lambda: discs["removed"]),
        ("depth, mean over wet bins", "m", wet.any(), depth[wet].mean),
        ("discharge, mean over wet bins", "m2/s", wet.any() and open_, discharge[wet].mean),
    )
    scalars.update({name: (float(value()), unit) for name, unit, known, value in rows if known})
    if summary.get("front"):
        _front(pd.read_csv(folder / "front.csv"), found)
    for name, force in read_forces(folder / "forces.csv").items() if summary.get("force") else ():
        _force(name, force, found)
    if jump := summary.get("jump"):
        numbers = ((label, jump.get(key), unit) for key, label, unit in JUMP_NUMBERS)
        scalars.update({label: (nan if value is None else value, unit) for label, value, unit in numbers})
        if (folder / "jump_track.csv").is_file():
            track = pd.read_csv(folder / "jump_track.csv")
            if track["found"].sum() >= TIME_BLOCKS:
                curves["jump toe history"] = _toe(track["time"].to_numpy(), track["toe"].to_numpy())
    return replace(found, verdict=jump["verdict"] if jump else "")


def _history(time: pd.Series, values: pd.Series, unit: str) -> Curve:
    parts = (block_means(part.to_numpy(float), TIME_BLOCKS) for part in (time, values))
    return Curve("t", *parts, unit)


def _front(front: pd.DataFrame, found: Quantities) -> None:
    run, end = front[front["time"] >= 0], front["time"].iloc[-1]
    for label, name in (("front", "bulk"), ("99 % front", "quantile")):
        found.curves[f"{label} history"] = _history(run["time"], run[name], "m")
        for moment in (0.25 * end, 0.5 * end, end):
            found.scalars[f"{label} at t = {moment:.3g} s"] = float(np.interp(moment, run["time"], run[name])), "m"


def _force(name: str, force: ForceHistory, found: Quantities) -> None:
    if len(force.time) < 3:
        return
    step, run = float(np.median(np.diff(force.time))), force.time > 0
    time, fx, fy = force.time[run], force.fx[run], force.fy[run]
    found.scalars[f"impulse on {name}, x"] = float(fx.sum() * step), "N s/m"
    found.scalars[f"impulse on {name}, y"] = float(fy.sum() * step), "N s/m"
    width = max(1, round(FORCE_MEAN / step))
    if len(fx) > width:
        smooth = np.convolve(fx, np.full(width, 1.0 / width), mode="valid")
        found.scalars[f"largest force on {name}, x"] = float(smooth[np.argmax(np.abs(smooth))]), "N/m"
    found.curves[f"force on {name}, x"] = _history(pd.Series(time), pd.Series(fx), "N/m")


def _toe(time: np.ndarray, toe: np.ndarray) -> Curve:
    """Return the toe by parts of the run; NaN for a part in which fewer than half of the frames have a jump."""
    cuts = np.linspace(0, len(time), TIME_BLOCKS + 1).astype(int)[1:-1]
    parts = [(part, part[np.isfinite(part)]) for part in np.split(toe, cuts)]
    values = [known.mean() if len(known) >= 0.5 * len(part) else nan for part, known in parts]
    return Curve("t", [part.mean() for part in np.split(time, cuts)], values, "m")


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
    bands : dict of str to (Curve, Difference)
        Of the curves, at every point.
    """

    ensembles: tuple[str, str]
    quantities: list[Results]
    jump_verdicts: tuple[dict[str, int], dict[str, int]]
    bands: dict[str, tuple[Curve, Difference]]

    @property
    def agrees(self) -> bool:
        """Whether no quantity differs."""
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
    share = f" ({100 * gap / size:+.2g} ± {100 * half / size:.2g} %)" if size else ""
    where = f" at {row['place']}" if row["place"] else ""
    needed = f"; {row['members_needed']} members would decide" if row["members_needed"] else ""
    return f"{row['verdict']}: {gap:+.3g} ± {half:.2g}{share}{where}{needed}"


def decided(row: Results) -> tuple[bool, int | None]:
    """Return whether the interval is narrow enough to call it agreement, and else the members that would make it so.

    Its half width, which goes with the root of the members, must be at most `DECIDES` of the quantity. A number whose
    mean lies within its scatter has no such share, and no number of members.
    """
    size = relative_size(row) or row["scale"]
    if row["half_width"] <= DECIDES * (size or 0.0):
        return True, None
    return False, ceil(min(row["n_1"], row["n_2"]) * (row["half_width"] / (DECIDES * size)) ** 2) if size else None


def compare(names: tuple[str, str], one: list[Quantities], two: list[Quantities], family_error: float) -> Comparison:
    """Compare each number (Welch), each curve (Welch, Bonferroni over its points), and all together (Holm)."""
    rows: list[Results] = []
    bands: dict[str, tuple[Curve, Difference]] = {}
    for name in one[0].scalars:
        if not _common(name, "scalars", one, two):
            continue
        values = [np.array([m.scalars[name][0] for m in side], float) for side in (one, two)]
        if any(np.any(side != 0.0) for side in values):  # else nothing happened in either: nothing to compare
            found = welch(*values)
            facts = {"name": name, "unit": one[0].scalars[name][1], "kind": "scalar", "place": None, "points": None}
            facts["scale"] = None
            rows.append({**facts, "p_adjusted": found.p, **found._asdict()})
    for name, curve in one[0].curves.items():
        if not _common(name, "curves", one, two) or len({len(m.curves[name].values) for m in (*one, *two)}) > 1:
            continue
        tables = [np.array([m.curves[name].values for m in side], float) for side in (one, two)]
        if any(np.nan_to_num(table).any() for table in tables):
            band = compare_curves(*tables)
            bands[name] = (curve, band)
            rows += _worst_point(name, curve, band, tables)
    adjusted = holm({row["name"]: row["p_adjusted"] for row in rows})
    for row in rows:
        p = row["p_adjusted"] = adjusted[row["name"]]
        row["verdict"] = "not comparable" if p != p else ("differ" if p < family_error else "agree")
        sure, row["members_needed"] = decided(row) if row["verdict"] == "agree" else (True, None)
        row["verdict"] = row["verdict"] if sure else "not decided"
        row["text"] = _text(row)
    words = (dict(Counter(member.verdict for member in side if member.verdict)) for side in (one, two))
    return Comparison(names, rows, tuple(words), bands)


def _worst_point(name: str, curve: Curve, band: Difference, tables: list[np.ndarray]) -> list[Results]:
    """Return the row of a curve, none where no point can be compared."""
    points = int(np.isfinite(band.p).sum())
    if not points:
        return []
    k = int(np.nanargmin(band.p))
    scale = float(np.nanmax(np.abs(band.mean_1), initial=0.0))
    found = welch(tables[0][:, k], tables[1][:, k], scale)
    place = f"{curve.axis} = {curve.at[k]:.3g} {'m' if curve.axis == 'x' else 's'}, worst of {points}"
    facts = {"name": name, "unit": curve.unit, "kind": "curve", "place": place, "points": points}
    facts["scale"] = scale
    p = min(1.0, band.p[k] * points)
    return [{**facts, "p_adjusted": p, **found._asdict(), "half_width": band.half_width[k]}]


def _common(name: str, kind: str, *sides: list[Quantities]) -> bool:
    return all(name in getattr(member, kind) for side in sides for member in side)
