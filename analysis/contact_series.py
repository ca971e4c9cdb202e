"""Contact forces by frame and bin: the thrust that discs pass on along the channel, and what the bed gives back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lammps_jump.dump.frame import Frame

from .contact_sums import pair_sums, wall_sums
from .flow import Flow


@dataclass(frozen=True)
class ContactSeries:
    """Sums over contacts, frame by frame.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    elastic : ndarray, shape (frames,)
        Elastic energy of pairs and walls, J per metre of width.
    thrust : ndarray, shape (frames, bins)
        Force through vertical planes, averaged over each bin, N/m, compression positive.
    wall_fx, wall_fy : ndarray, shape (frames, bins)
        Force of all walls on the discs of each bin, N per metre of width.
    """

    time: np.ndarray
    elastic: np.ndarray
    thrust: np.ndarray
    wall_fx: np.ndarray
    wall_fy: np.ndarray


class ContactCollector:
    """Collects a `ContactSeries`; with `edges` None only the elastic energy."""

    def __init__(self, flow: Flow, edges: np.ndarray | None):
        self.flow, self.edges = flow, edges
        self.latest = 0.0
        self._time: list[float] = []
        self._elastic: list[float] = []
        self._bins: list[np.ndarray] = []

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame; its elastic energy stands in ``latest`` until the next one."""
        flow, edges = self.flow, self.edges
        pairs = pair_sums(frame, flow, edges)
        self.latest = pairs.energy
        bins = np.zeros((3, len(pairs.thrust)))
        bins[0] = pairs.thrust
        for wall in flow.walls_at(time):
            sums = wall_sums(frame, wall, flow, velocity=edges is not None)
            self.latest += sums.energy
            if edges is not None and sums.index.size:
                place = np.floor((frame.x[sums.index] - edges[0]) / (edges[1] - edges[0])).astype(int)
                inside = (place >= 0) & (place < bins.shape[1])
                bins[1] += np.bincount(place[inside], sums.fx[inside], bins.shape[1])
                bins[2] += np.bincount(place[inside], sums.fy[inside], bins.shape[1])
        self._time.append(time)
        self._elastic.append(self.latest)
        self._bins.append(bins)

    def result(self) -> ContactSeries:
        """The series of all frames added; the collector is empty afterwards (long records are held once)."""
        bins = np.array(self._bins).reshape(len(self._time), 3, -1)
        self._bins.clear()
        return ContactSeries(np.array(self._time), np.array(self._elastic), bins[:, 0], bins[:, 1], bins[:, 2])
