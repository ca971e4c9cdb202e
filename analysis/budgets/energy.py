# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy of the discs, frame by frame, from positions and velocities (thesis 4.28)."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import nan

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.forces.impulse import window_lengths
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, described, percent
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.dump import ForceHistory, Frame
from lammps_jump.units import known, number


@dataclass(frozen=True)
class EnergyHistory:
    """Energy against time, J per metre of width.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    kinetic, rotational, potential : ndarray, shape (frames,)
        Kinetic energy is NaN in a frame with a disc whose velocity is not known. Potential energy is
        -m (gx x + gy y): zero at the origin.
    elastic : ndarray, shape (frames,)
        Pairs and walls; NaN where the stiffness is not known.
    discs : ndarray of int, shape (frames,)
    same_discs : bool
        Every frame holds the same ids.
    work_of_walls : ndarray, shape (frames,), or None
        Work of moving walls on the discs since the first frame; None where no wall moves, or one is not probed.
    """

    time: np.ndarray
    kinetic: np.ndarray
    rotational: np.ndarray
    potential: np.ndarray
    elastic: np.ndarray
    discs: np.ndarray
    same_discs: bool
    work_of_walls: np.ndarray | None = None

    @property
    def total(self) -> np.ndarray:
        """Sum of all parts, J/m (without elastic energy where that is not known)."""
        return self.kinetic + self.rotational + self.potential + np.nan_to_num(self.elastic)


class EnergyLedger:
    """Collects the energy of one frame after the other; ask for `result` at the end."""

    def __init__(self, flow: Flow, contacts: ContactCollector | None = None, *, elastic: bool = True):
        """`contacts` saw the same frame just before: its elastic energy is used instead of a second pair search.

        Without `elastic` no pairs are looked for.
        """
        self.flow, self.contacts = flow, contacts
        self._own = ContactCollector(flow, None) if elastic and contacts is None and flow.knows_contacts else None
        self._rows: list[tuple[float, ...]] = []
        self._ids: np.ndarray | None = None
        self._same = True

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        flow = self.flow
        mass, (gx, gy) = flow.scene.mass, flow.scene.gravity
        x, y, vx, vy = (flow.by_mass(values, frame) for values in (frame.x, frame.y, frame.vx, frame.vy))
        kinetic = 0.5 * mass * float(np.dot(frame.vx, vx) + np.dot(frame.vy, vy))
        rotational = 0.0
        if "omegaz" in frame.columns:
            spin = frame.column("omegaz")
            moment = flow.by_mass(flow.by_mass(spin, frame), frame)  # m R^2 goes with the square of the mass
            rotational = 0.25 * mass * flow.scene.radius**2 * float(np.dot(spin, moment))
        potential = 0.0 - mass * float(gx * x.sum() + gy * y.sum())  # no disc has 0, not -0
        if self._own:
            self._own.add(frame, time)
        source = self.contacts or self._own
        elastic = source.latest if source else nan
        ids, before = np.sort(frame.ids), self._ids
        self._same = self._same and (before is None or np.array_equal(ids, before))
        self._ids = ids
        self._rows.append((time, kinetic, rotational, potential, elastic, frame.n))

    def result(self) -> EnergyHistory:
        """The history of all frames added."""
        rows = np.array(self._rows, float).reshape(-1, 6)
        time, kinetic, rotational, potential, elastic, discs = rows.T
        return EnergyHistory(time, kinetic, rotational, potential, elastic, discs.astype(int), self._same)


@dataclass(frozen=True)
class Energy:
    """Energy of the discs at the start and the end, and how far it strayed.

    Deviations are errors of the engine only where nothing dissipates and no disc enters or leaves (`conservative`).
    """

    initial: float = number("J/m", "energy at the start", default=nan, label="at the start")
    final: float = number("J/m", "energy at the end", default=nan)
    max_deviation: float = number("", "largest |E − E₀|/|E₀|", default=nan, label="largest deviation")
    lowest_deviation: float = number("", "lowest (E − E₀)/|E₀|", default=nan)
    highest_deviation: float = number("", "highest (E − E₀)/|E₀|", default=nan)
    drift: float = number("", "straight-line change over the record, relative to E₀", default=nan, label="drift")
    kinetic: float = number("J/m", "kinetic energy at the end", default=nan)
    rotational: float = number("J/m", "energy of spin at the end", default=nan)
    potential: float = number("J/m", "potential energy at the end", default=nan)
    elastic: float = number("J/m", "elastic energy at the end", default=nan)
    work_of_walls: float = number("J/m", "work of moving walls on the discs", default=nan)
    closed: bool | None = None
    conservative: bool | None = None
    reason: str | None = None
    history: EnergyHistory | None = field(default=None, metadata={"summary": False})


def drift(time: np.ndarray, energy: np.ndarray) -> float:
    """Straight-line change of the energy over the record relative to its first value, without dimension."""
    if len(time) < 2 or energy[0] == 0 or time[-1] == time[0]:
        return nan
    slope = np.polyfit(time - time[0], energy, 1)[0]
    return float(slope * (time[-1] - time[0]) / energy[0])


def analyse_energy(history: EnergyHistory, flow: Flow) -> Energy:
    """Energy at the ends of a record, its deviations and its drift."""
    if not len(history.time):
        return Energy(reason="the dump holds no frame")
    if not np.any(history.discs):
        return Energy(reason="no frame holds a disc", history=history)
    total, c, work = history.total, flow.scene.coefficients, history.work_of_walls
    lossless = c.restitution == 1.0 and not any(law.gamma_normal for law in flow.scene.own_laws.values())
    start = float(total[0])
    several = len(total) > 1
    unknown = "" if np.isfinite(total).all() else "velocities of some discs are not known: the dump has no vx, vy"
    relative = (total - start) / abs(start) if start and several else np.full(len(total), nan)
    return Energy(
        initial=start,
        final=float(total[-1]),
        max_deviation=float(np.max(np.abs(relative))),
        lowest_deviation=float(relative.min()),
        highest_deviation=float(relative.max()),
        drift=nan if unknown else drift(history.time, total),
        **{part: float(getattr(history, part)[-1]) for part in ("kinetic", "rotational", "potential", "elastic")},
        work_of_walls=nan if work is None else float(work[-1]),
        closed=history.same_discs,
        conservative=lossless and not flow.scene.rubs and not flow.scene.moves and history.same_discs,
        reason=unknown or (None if several else "one frame tells no change of the energy"),
        history=history,
    )


def analyse(gathered: Gathered) -> Energy:
    """Energy of a run."""
    history = gathered.histories["energy"]
    assert isinstance(history, EnergyHistory)
    work = work_of_walls(gathered.forces, gathered.flow, history.time)
    return analyse_energy(replace(history, work_of_walls=work), gathered.flow)


def work_of_walls(forces: Mapping[str, ForceHistory], flow: Flow, time: np.ndarray) -> np.ndarray | None:
    """Work of moving walls on the discs from the first of these times (s) on, J/m; None where it is not recorded."""
    moving = [forces.get(wall.name) for wall, motion in flow.scene.walls if motion.kind is not None]
    if not moving or not len(time):
        return None
    total = np.zeros(len(time))
    for record in moving:
        if record is None or record.power is None:
            return None
        done = np.concatenate([[0.0], np.cumsum(record.power * window_lengths(record.time))])
        ends = np.concatenate([[record.time[0] - window_lengths(record.time)[0]], record.time])
        total += np.interp(time, ends, done) - np.interp(time[0], ends, done)
    return total


def tables(energy: Energy) -> Tables:
    """Energy against time, J/m."""
    history = energy.history
    assert history is not None
    parts = ("kinetic", "rotational", "potential", "elastic", "total", "discs")
    columns = {name: getattr(history, name) for name in ("time", *parts)}
    columns |= {} if history.work_of_walls is None else {"work_of_walls": history.work_of_walls}
    return {"energy.csv": {name: column for name, column in columns.items() if np.isfinite(column).any()}}


def figures(energy: Energy, gathered: Gathered) -> Drawings:
    """Figure of the parts of the energy against time."""
    return {"energy": energy_chart(energy)}


def section(energy: Energy) -> Section | None:
    """Energy at the start and the end; deviation and drift of a closed box."""
    if not known(energy.initial):
        return None
    rows = described(energy, "initial", "final")
    if energy.conservative:
        rows += [("Largest deviation", percent(energy.max_deviation, 4)),
                 ("Drift over the record", percent(energy.drift, 4))]  # fmt: skip
    parts = ("kinetic", "potential", "elastic", *(["work_of_walls"] if known(energy.work_of_walls) else []))
    return Section("Energy", [Table([*rows, *described(energy, *parts)])])


def energy_chart(energy: Energy) -> Chart | None:
    """Parts of the energy against time; where nothing dissipates the deviation from the start below."""
    history = energy.history
    if history is None or not len(history.time):
        return None
    time, total = history.time, history.total
    most = float(total[np.isfinite(total)].max(initial=0.0))
    scale, unit = (1e6, "MJ/m") if most > 1e6 else (1e3, "kJ/m") if most > 1e4 else (1.0, "J/m")
    parts: tuple[tuple[str, np.ndarray, str], ...] = (
        ("total", total, "sum"),
        ("kinetic", history.kinetic, "first"),
        ("potential (y = 0)", history.potential, "second"),
        ("spin", history.rotational, "faint"),
        ("elastic", history.elastic, "third"),
    )
    if history.work_of_walls is not None:
        parts += (("work of the walls", history.work_of_walls, "fit"),)
    always = ("total", "kinetic", "elastic")
    kept = [one for one in parts if np.isfinite(one[1]).any() and (one[0] in always or np.any(one[1]))]
    panels = [Panel(f"Energy [{unit}]", [Trace(label, time, part / scale, look) for label, part, look in kept])]
    if energy.conservative and total[0] != 0:
        off = Trace("deviation from the start", time, 100 * (total / total[0] - 1))
        panels.append(Panel("Deviation from\nthe start [%]", [off]))
    return Chart("energy of the discs", TIME, panels)


OF_A_CLOSED_BOX = {"max_deviation", "drift"}
"""Errors of the engine, where nothing dissipates and no disc comes or goes."""

QUANTITY = Quantity(
    name="energy",
    title="Energy",
    result=Energy,
    definitions="""\
kinetic, spin, potential (−m g·r), elastic (k δ²/2) energy of all discs, per metre of width
drift         straight-line change over the record, over the energy at the start
deviation     largest |E − E₀|/|E₀|, exact for this run; it judges the engine only where nothing dissipates
""",
    collector=EnergyLedger,
    needs=frozenset({"contacts"}),
    analyse=analyse,
    files={"energy.csv": "energies against time"},
    captions={"energy": "Energy of the discs"},
    tables=tables,
    figures=figures,
    linked="energy",
    section=section,
    headline=(
        HeadlineNumber("max_deviation", "exact: 0", label="largest change of the energy", scale=0.01, unit="%"),
        HeadlineNumber("drift", "exact: 0", label="drift of the energy", scale=0.01, unit="%"),
        HeadlineNumber("final", "at the start", "initial"),
        HeadlineNumber("kinetic"),
        HeadlineNumber("potential"),
    ),
    rank=120,
    is_shown=lambda _, summary: bool(part(summary, "energy").get("conservative")),
    applies=lambda key, energy: key not in OF_A_CLOSED_BOX or energy.conservative is not False,
)
