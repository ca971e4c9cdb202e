"""Energy of the discs, frame by frame, from positions and velocities (thesis 4.28)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lammps_jump.dump.frame import Frame

from .contact_series import ContactCollector
from .contact_sums import pair_sums, wall_sums
from .flow import Flow


@dataclass(frozen=True)
class EnergyHistory:
    """Energy against time, J per metre of width.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    kinetic, rotational, potential : ndarray, shape (frames,)
        Potential energy is -m (gx x + gy y): zero at the origin.
    elastic : ndarray or None, shape (frames,)
        Pairs and walls; None where the stiffness is not known.
    discs : ndarray of int, shape (frames,)
    same_discs : bool
        Every frame holds the same ids.
    """

    time: np.ndarray
    kinetic: np.ndarray
    rotational: np.ndarray
    potential: np.ndarray
    elastic: np.ndarray | None
    discs: np.ndarray
    same_discs: bool

    @property
    def total(self) -> np.ndarray:
        """Sum of all parts, J/m (without elastic energy where that is not known)."""
        return self.kinetic + self.rotational + self.potential + (0.0 if self.elastic is None else self.elastic)


class EnergyLedger:
    """Collects the energy of one frame after the other; ask for `result` at the end."""

    def __init__(self, flow: Flow, contacts: ContactCollector | None = None):
        """`contacts` saw the same frame just before: its elastic energy is used instead of a second pair search."""
        self.flow, self.contacts = flow, contacts
        self._rows: list[tuple[float, ...]] = []
        self._ids: np.ndarray | None = None
        self._same = True

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        flow = self.flow
        mass, (gx, gy) = flow.scene.mass, flow.scene.gravity
        x, y = frame.x, frame.y
        kinetic = 0.5 * mass * float(np.dot(frame.vx, frame.vx) + np.dot(frame.vy, frame.vy))
        rotational = 0.0
        if "omegaz" in frame.columns:
            spin = frame.column("omegaz")
            rotational = 0.25 * mass * flow.scene.radius**2 * float(np.dot(spin, spin))
        potential = -mass * float(gx * x.sum() + gy * y.sum())
        elastic = np.nan
        if self.contacts is not None:
            elastic = self.contacts.latest
        elif flow.knows_contacts:
            walls = sum(wall_sums(frame, wall, flow, velocity=False).energy for wall in flow.walls_at(time))
            elastic = pair_sums(frame, flow).energy + walls
        ids = np.sort(frame.ids)
        if self._ids is None:
            self._ids = ids
        elif self._same:
            self._same = np.array_equal(ids, self._ids)
        self._rows.append((time, kinetic, rotational, potential, elastic, frame.n))

    def result(self) -> EnergyHistory:
        """The history of all frames added."""
        rows = np.array(self._rows, float).reshape(-1, 6)
        elastic = rows[:, 4] if len(rows) and self.flow.knows_contacts else None
        return EnergyHistory(*rows[:, :4].T, elastic, rows[:, 5].astype(int), self._same)


def drift(time: np.ndarray, energy: np.ndarray) -> float:
    """Straight-line change of the energy over the record relative to its first value, without dimension."""
    if len(time) < 2 or energy[0] == 0 or time[-1] == time[0]:
        return float("nan")
    slope = np.polyfit(time - time[0], energy, 1)[0]
    return float(slope * (time[-1] - time[0]) / energy[0])


def summarise_energy(history: EnergyHistory, flow: Flow) -> dict:
    """Numbers for the summary.

    Parameters
    ----------
    history : EnergyHistory
    flow : Flow

    Returns
    -------
    dict
        initial, final (J/m); max_deviation: largest abs(E - E0)/abs(E0); drift: straight-line change over the record
        relative to E0; lowest and highest deviation; kinetic, potential and elastic energy at the end; closed: no disc
        came or went. Deviations say something about the engine only where nothing dissipates (`conservative`).
    """
    if not len(history.time):
        return {"initial": None, "max_deviation": None, "drift": None, "reason": "the dump holds no frame"}
    total = history.total
    start = float(total[0])
    relative = (total - start) / abs(start) if start else np.full_like(total, np.nan)
    conservative = flow.conservative and history.same_discs
    return {
        "initial": start,
        "final": float(total[-1]),
        "max_deviation": float(np.max(np.abs(relative))) if start else None,
        "lowest_deviation": float(relative.min()) if start else None,
        "highest_deviation": float(relative.max()) if start else None,
        "drift": drift(history.time, total) if start and len(total) > 1 else None,
        "kinetic": float(history.kinetic[-1]),
        "rotational": float(history.rotational[-1]),
        "potential": float(history.potential[-1]),
        "elastic": None if history.elastic is None else float(history.elastic[-1]),
        "closed": bool(history.same_discs),
        "conservative": bool(conservative),
    }
