# SPDX-License-Identifier: GPL-2.0-or-later
"""Events at certain steps: discs come and go, and windows of the probes end; and the tables of them.

By those tables, of inlets, outlets, sizes, gates, tailgates, windows and stations, the core steps a scene alone.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from ctypes import addressof
from math import inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.core.columns import Exchange, PlacedColumns, SumsOnWallColumns, Traffic
from lammps_jump.core.library import require_core
from lammps_jump.dump.walls import Row
from lammps_jump.physics.devices import Holding, gate_areas, gate_sees, gate_speed
from lammps_jump.scene.motion import Pose
from lammps_jump.scene.scene import Pour, Scene

from .bound import WINDOW_WIDTH, address, jump_events, jump_inlet, jump_outlet, jump_tailgate
from .discs import DiscArrays, EnteringDisc
from .walls import Walls


class Event(NamedTuple):
    """Event at some steps; `next_after` gives the first of them after a step, infinite for never."""

    next_after: Callable[[int], float]
    happen: Callable[[], None]


class EventList:
    """Events of one place in a step, in their order."""

    def __init__(self, *events: Event):
        self.events = events

    def next_after(self, step: int) -> float:
        """First step after `step` at which an event happens; infinite for never."""
        return min(event.next_after(step) for event in self.events)

    def happen(self, step: int) -> None:
        """Let the events of a step happen."""
        for event in self.events:
            if event.next_after(step - 1) == step:
                event.happen()


class InsertionSchedule:
    """Steps at which an inlet tries: from `first` on `every` so many, until `limit` discs have entered (None: ever).

    With `steps`, those and no others: of an inflow against time.
    """

    def __init__(self, first: int, every: int, limit: int | None, steps: tuple[int, ...] = ()):
        self.first, self.every, self.limit, self.steps = first, every, limit, steps
        self.entered = 0

    def due(self, step: int) -> bool:
        """Tell whether it tries at this step."""
        return self.next_after(step - 1) == step

    def next_after(self, step: int) -> float:
        """First step after `step` at which it tries; infinite where all discs have entered."""
        if self.limit is not None and self.entered >= self.limit:
            return inf
        if self.steps:
            place = bisect_right(self.steps, step)
            return self.steps[place] if place < len(self.steps) else inf
        if step < self.first:
            return self.first
        return self.first + ((step - self.first) // self.every + 1) * self.every


class PourState(InsertionSchedule):
    """A pour in batches: as many discs as the region holds at its volume fraction, again when they have fallen clear.

    Follows LAMMPS' ``fix pour``: at the steps `Scene.pour_turns`; a disc at height y of the region enters as if it had
    fallen from its top at `speed_down`, v_y = -sqrt(v^2 + 2 g (y_top - y)). Places are drawn uniformly; one that
    another disc (closer than d) or a wall (closer than R) occupies is drawn again, 50 times the batch at most. Discs
    come with the largest diameter d.
    """

    def __init__(self, pour: Pour, scene: Scene, rng: np.random.Generator):
        self.pour = pour
        self.rng = rng
        self.gravity = max(0.0, -scene.gravity[1])
        height = pour.y[1] - pour.y[0]
        area = height * (pour.x[1] - pour.x[0])
        self.batch = max(1, int(pour.volume_fraction * area / (pi * (0.5 * scene.largest) ** 2)))
        turns = scene.pour_turns(pour)
        super().__init__(turns.start, turns.step, pour.count)

    def places(self) -> Iterator[tuple[float, float, float]]:
        """Candidate places and velocities of one batch: yields (x, y, vy) up to 50 times the batch."""
        (x_low, x_high), (y_low, y_high) = self.pour.x, self.pour.y
        for _ in range(50 * self.batch):
            x = x_low + (x_high - x_low) * self.rng.random()
            y = y_low + (y_high - y_low) * self.rng.random()
            yield x, y, -sqrt(self.pour.speed_down**2 + 2 * self.gravity * (y_high - y))


class OpenBoundaries:
    """Inlets, pours and outlets of a scene, and the discs that came and went through them.

    Ids are given in turn, so that the last one is the number of discs `inserted`. Those above `sized` still have the
    largest diameter, with which they came.
    """

    def __init__(self, scene: Scene):
        self.scene = scene
        self.rows = [InsertionSchedule(row.first_step, row.every_steps, row.limit, row.turns) for row in scene.inlets]
        self.rng = np.random.default_rng(scene.seed)
        self.pours = [PourState(pour, scene, self.rng) for pour in scene.pours]
        self.removed = 0
        self.inserted = self.sized = len(scene.positions)

    def next_arrival(self, step: int) -> float:
        """Next step at which discs may enter; infinite for never."""
        return min((state.next_after(step) for state in (*self.rows, *self.pours)), default=inf)

    def next_pour(self, step: int) -> float:
        """Next step at which a pour tries; infinite for never."""
        return min((state.next_after(step) for state in self.pours), default=inf)

    def next_leaving(self, step: int) -> float:
        """Next step at which discs may leave; infinite for never."""
        return min(((step // one.every_steps + 1) * one.every_steps for one in self.scene.outlets), default=inf)

    def next_sizes(self, step: int) -> float:
        """Next step at whose end discs get their own diameters; infinite where all have them."""
        if self.scene.sizes is None or self.sized == self.inserted:
            return inf
        return (step // self.scene.size_steps + 1) * self.scene.size_steps

    def leaving(self, step: int, discs: DiscArrays) -> np.ndarray | None:
        """Mask, shape (n,), of discs that an outlet takes at this step; None where none leaves."""
        mask = None
        for outlet in self.scene.outlets:
            if step % outlet.every_steps:
                continue
            coordinate = (discs.x if outlet.axis == "x" else discs.y)[: discs.n]
            gone = coordinate > outlet.at if outlet.side == "above" else coordinate < outlet.at
            mask = gone if mask is None else mask | gone
        return mask if mask is not None and mask.any() else None

    def arrivals(self, step: int, discs: DiscArrays, loaded: Mapping[str, Pose]) -> Iterator[EnteringDisc]:
        """Discs that enter at this step: yields a `EnteringDisc`; the caller adds each before it takes the next.

        `loaded` are the poses of walls that the discs push.
        """
        for row, state in zip(self.scene.inlets, self.rows, strict=True):
            if state.due(step) and discs.is_free(row.x, row.y, row.clearance):
                state.entered += 1
                yield EnteringDisc(self._new_id(), row.x, row.y, row.speed_at(step), row.vy)
        for state in self.pours:
            if not state.due(step):
                continue
            wanted = min(state.batch, state.pour.count - state.entered)
            for x, y, vy in state.places():
                if not discs.is_free(x, y, self.scene.largest) or self._in_wall(step, loaded, x, y):
                    continue
                state.entered += 1
                wanted -= 1
                yield EnteringDisc(self._new_id(), x, y, 0.0, vy)
                if wanted == 0:
                    break

    def _in_wall(self, step: int, loaded: Mapping[str, Pose], x: float, y: float) -> bool:
        radius = 0.5 * self.scene.largest
        return any(float(wall.distance(x, y)) < radius for wall in self.scene.walls_at(step, loaded))

    def _new_id(self) -> int:
        self.inserted += 1
        return self.inserted


class Tailgates:
    """Gates that hold a depth or a front: the steps at which they look, and their speeds.

    Attributes
    ----------
    areas : dict of name to float
        Area of the discs that each gate saw last, m^2, in an earlier run too; none before its first look.
    """

    def __init__(self, scene: Scene):
        self.scene = scene
        self.holdings = {wall.name: motion.holding for wall, motion in scene.walls if motion.holding}
        went = ((wall.name, motion.went) for wall, motion in scene.walls if motion.holding and motion.went)
        self.areas = {name: one.area for name, one in went if one.area is not None}

    def next_after(self, step: int) -> float:
        """First step after `step` at which a gate looks; infinite without gates."""
        return min((_next_look(one, step) for one in self.holdings.values()), default=inf)

    def move(self, step: int, discs: DiscArrays, walls: Walls) -> None:
        """Let the gates whose turn it is look at the discs that move, and give them their speeds."""
        n, poses, speeds = discs.n, walls.poses(), {}
        area = (
            np.full(n, self.scene.diameter * self.scene.diameter)
            if discs.radius is None
            else 4.0 * discs.radius[:n] ** 2
        )
        if discs.fixed is not None:
            area[discs.fixed[:n] != 0] = 0.0
        for name, holding in self.holdings.items():
            if _next_look(holding, step - 1) != step:
                continue
            interval = holding.every * self.scene.time_step
            seen, total = gate_sees(holding, gate_areas(holding, discs.x[:n], area))
            lost = (self.areas.get(name, total) - total) / interval
            self.areas[name] = total
            speeds[name] = gate_speed(holding, poses[name].y, seen, lost, interval)
        walls.set_speeds(speeds)

    def looked(self, name: str, step: int) -> dict[str, float]:
        """Area that a gate has seen last (m^2), and the time since then (s); nothing of another wall or before."""
        if name not in self.areas:
            return {}
        one = self.holdings[name]
        return {"area": self.areas[name], "since": (step - one.first) % one.every * self.scene.time_step}


def _next_look(holding: Holding, step: int) -> int:
    """First step after `step` at which a gate looks."""
    return max(holding.first, holding.first + ((step - holding.first) // holding.every + 1) * holding.every)


WindowForce = tuple[int, str, *tuple[float, ...]]
"""Step, name of the wall, fx, fy and moment; power where walls move."""


class Windows:
    """Mean forces on the probed walls and on bodies, a window of steps at a time.

    Attributes
    ----------
    begin : int
        Step at which the open window began.
    sums : dict of name to ndarray, shape (4,)
        What the window has collected on walls that have been laid anew since.
    forces : list of WindowForce
        Of the windows that are over.
    bodies : list of (step, name, numbers)
        Rows of ``bodies.csv``.
    pressed : list of (step, ndarray)
        Mean of `PressedSums.sums` over each window, all stretches one after the other.
    """

    def __init__(self, scene: Scene):
        self._bodies = tuple(wall.name for wall, _ in scene.bodies)
        self.bodies: list[Row] = []
        self.probes, self.steps, self._columns = scene.probes, scene.probe_steps, 4 if scene.moves else 3
        self.asked, self.begin = scene.has_windows, 0
        self.sums: dict[str, np.ndarray] = {}
        self.forces: list[WindowForce] = []
        self.pressed: list[tuple[int, np.ndarray]] = []

    def next_after(self, step: int) -> float:
        """Step at which the open window ends; infinite without probes and bodies."""
        return self.begin + self.steps if self.asked else inf

    def take(self, walls: Walls) -> None:
        """Add the sums of walls, which begin anew."""
        for name, row in zip(walls.names, walls.sums, strict=True):
            self.sums[name] = self.sums.get(name, 0.0) + row
        walls.sums[:] = 0.0

    def close(self, step: int, walls: Walls) -> None:
        """End the window with this step, and begin the next one."""
        self.take(walls)
        placed = np.empty(0) if walls.moves is None else walls.moves.now
        self.end(step, step - self.begin, self.sums, walls, placed)
        if walls.pressed is not None:
            self.press(step, step - self.begin, walls.pressed.sums.ravel().copy())
            walls.pressed.sums[:] = 0.0
        self.sums, self.begin = {}, step

    def end(self, step: int, steps: int, sums: Mapping[str, np.ndarray], walls: Walls, placed: np.ndarray) -> None:
        """Add the rows of a window of so many steps; `sums` of it, and `placed` as of `Moves.now` at its end."""
        for name in self.probes:
            mean = sums.get(name, np.zeros(4)) / steps
            self.forces.append((step, name, *(float(v) for v in mean[: self._columns])))
        forces = {name: sums[name][SumsOnWallColumns.FORCE] / steps for name in self._bodies}
        self.see_bodies(step, walls, forces, placed)

    def press(self, step: int, steps: int, sums: np.ndarray) -> None:
        """Adds the means of a window of so many steps over stretches of outlines; none without a request."""
        if sums.size:
            self.pressed.append((step, sums / steps))

    def see_bodies(self, step: int, walls: Walls, forces: Mapping[str, np.ndarray], placed: np.ndarray) -> None:
        """Add a row for each body where it is `placed`, with these forces of the discs."""
        self.bodies += [(step, name, row) for name, row in walls.body_rows(forces, placed)]


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

    def _hold(self, item: Any) -> int | None:
        """Address of an array or of structs, which are held as long as the core may read them."""
        self._held.append(item)
        return address(item) if isinstance(item, np.ndarray) else addressof(item)

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
