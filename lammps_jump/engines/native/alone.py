# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables with which the core steps a scene alone: its inlets, outlets, sizes, gates, tailgates, windows and stations.

Tables are made once. What changes while steps are done is in the objects of `events` and `ledger`, from where it is put
before the core steps, and where it is taken back.
"""

from __future__ import annotations

from ctypes import addressof
from typing import Any

import numpy as np

from lammps_jump.core.columns import Exchange, PlacedColumns, SumsOnWallColumns, Traffic
from lammps_jump.core.library import require_core

from .bound import WINDOW_WIDTH, address, jump_events, jump_inlet, jump_outlet, jump_tailgate

EXCHANGED = {
    "brought_in": Exchange.BROUGHT_IN,
    "carried_out": Exchange.CARRIED_OUT,
    "released_by_gates": Exchange.RELEASED_BY_GATES,
}
"""Places of what `EnergyBalance.exchanged` holds."""


class SceneEvents:
    """Events of a simulation, as `Core.run` takes them.

    Parameters
    ----------
    simulation : NativeSimulation

    Attributes
    ----------
    bound : jump_events
    """

    def __init__(self, simulation: Any):
        for struct in (jump_inlet, jump_outlet, jump_tailgate):
            struct.check(require_core("stepping"))
        scene = simulation.scene
        self.simulation, self.bound = simulation, jump_events()
        self._held: list[Any] = []
        self._radii = np.empty(0)
        self._entered = np.zeros(len(scene.inlets), np.int64)
        self._traffic, self._exchanged = np.zeros(len(Traffic), np.int64), np.zeros(len(Exchange))
        names = [wall.name for wall, _ in scene.walls]
        self._window_sum = np.zeros((len(names), SumsOnWallColumns.width()))
        self._gates = {name: names.index(name) for name in simulation.gates.holdings}
        self._put_inlets()
        self._put_tables(np.array(list(self._gates.values()), np.int64))
        for name, array in (
            ("entered", self._entered), ("traffic", self._traffic), ("exchanged", self._exchanged),
            ("window_sum", self._window_sum), ("until", simulation.walls.until),
        ):  # fmt: skip
            setattr(self.bound, name, address(array))

    def _hold(self, found: Any) -> int | None:
        """Address of an array or of structs, which are held as long as the core may read them."""
        self._held.append(found)
        return address(found) if isinstance(found, np.ndarray) else addressof(found)

    def _put_inlets(self) -> None:
        rows, bound = self.simulation.scene.inlets, self.bound
        begins = np.cumsum([0, *(len(row.turns) for row in rows)]).tolist()
        inlets = [
            jump_inlet(
                row.x, row.y, row.vx, row.vy, row.clearance, row.first_step, row.every_steps,
                -1 if row.limit is None else row.limit, begin, len(row.turns),
            )
            for row, begin in zip(rows, begins[:-1], strict=True)
        ]  # fmt: skip
        bound.inlets, bound.inlet = len(rows), self._hold((jump_inlet * len(rows))(*inlets))
        bound.turn_step = self._hold(np.array([step for row in rows for step in row.turns], np.int64))
        bound.turn_speed = self._hold(np.array([speed for row in rows for speed in row.speeds], float))

    def _put_tables(self, walls: np.ndarray) -> None:
        """Put what does not change; `walls` are those that are tailgates."""
        simulation, bound = self.simulation, self.bound
        scene, stations = simulation.scene, simulation.stations
        outlets = [
            jump_outlet(one.at, "xy".index(one.axis), one.side == "above", one.every_steps) for one in scene.outlets
        ]
        bound.outlets, bound.outlet = len(outlets), self._hold((jump_outlet * len(outlets))(*outlets))
        bound.size_every = scene.size_steps
        gates = [jump_tailgate(**one._asdict()) for one in simulation.gates.holdings.values()]
        self._tailgates = (jump_tailgate * len(gates))(*gates)
        bound.tailgates, bound.tailgate = len(gates), addressof(self._tailgates)
        bound.tailgate_wall = self._hold(walls)
        bound.window_steps = scene.probe_steps if scene.has_windows else 0
        if stations.stations is not None:
            at = stations.stations
            bound.station_left, bound.station_width, bound.station_speed = at.x[0], at.x[1] - at.x[0], at.speed
            bound.station_first, bound.station_last = at.first_step, at.last_step
            bound.station_sums = address(stations.sums)
        bound.ledger = simulation.ledger_on
        bound.gravity_x, bound.gravity_y = scene.gravity
        bound.weight_x, bound.weight_y = simulation.weight
        bound.overlap_limit = scene.overlap_limit

    def _put_radii(self, target: int, discs: int) -> None:
        """Radii of all discs that can be there at step `target`, `discs` at least, by id, m."""
        scene, boundaries = self.simulation.scene, self.simulation.boundaries
        if scene.sizes is None:
            return
        steps = target - self.simulation.step
        most = boundaries.inserted + sum(len(row.turns) or steps // row.every_steps + 1 for row in scene.inlets)
        most = max(most, discs)
        if most > self._radii.size:
            self._radii = 0.5 * scene.diameters(np.arange(1, max(most, scene.expected_discs) + 1))
            self.bound.own_radius = address(self._radii)

    def put(self, target: int, discs: int = 0) -> jump_events:
        """Put what has changed, for the core to go on from up to step `target`, with radii of `discs` at least."""
        self._put_radii(target, discs)
        simulation, bound = self.simulation, self.bound
        boundaries, windows = simulation.boundaries, simulation.windows
        bound.step, bound.disc_steps, bound.window_begin = simulation.step, 0, windows.begin
        self._entered[:] = [row.entered for row in boundaries.rows]
        self._traffic[:] = boundaries.inserted, boundaries.removed, boundaries.sized
        for name, place in EXCHANGED.items():
            self._exchanged[place] = simulation.books.exchanged[name]
        self._window_sum[:] = 0.0
        for name, row in windows.sums.items():
            self._window_sum[simulation.walls.names.index(name)] = row
        for name, gate in zip(self._gates, self._tailgates, strict=True):
            gate.area = simulation.gates.areas.get(name, np.nan)
        return bound

    def take(self, ended: np.ndarray) -> None:
        """Take back what the core has changed, and the windows that have ended, as of `Core.run`."""
        simulation, bound = self.simulation, self.bound
        boundaries, windows, names = simulation.boundaries, simulation.windows, simulation.walls.names
        simulation.step, simulation.disc_steps = bound.step, simulation.disc_steps + int(bound.disc_steps)
        for row, entered in zip(boundaries.rows, self._entered.tolist(), strict=True):
            row.entered = entered
        boundaries.inserted, boundaries.removed, boundaries.sized = self._traffic.tolist()
        for name, place in EXCHANGED.items():
            simulation.books.exchanged[name] = float(self._exchanged[place])
        for window in ended:
            walls = window[2 : 2 + len(names) * WINDOW_WIDTH].reshape(-1, WINDOW_WIDTH)
            windows.press(int(window[0]), int(window[1]), window[2 + len(names) * WINDOW_WIDTH :])
            felt, placed = walls[:, : -PlacedColumns.width()], walls[:, -PlacedColumns.width() :]
            windows.end(int(window[0]), int(window[1]), dict(zip(names, felt, strict=True)), simulation.walls, placed)
        windows.begin = bound.window_begin
        windows.sums = {name: row.copy() for name, row in zip(names, self._window_sum, strict=True) if row.any()}
        for name, gate in zip(self._gates, self._tailgates, strict=True):
            if not np.isnan(gate.area):
                simulation.gates.areas[name] = gate.area
