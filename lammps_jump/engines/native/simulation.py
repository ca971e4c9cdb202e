# SPDX-License-Identifier: GPL-2.0-or-later
"""One scene, step by step, on the native engine: what the run, the tests and the cross-validation drive.

Order of operations of a step, LAMMPS' own: half kick, drift, [neighbour list, outlets, arrivals, gates], forces with
the velocities of the half step, half kick. The last half kick of one step and the first of the next are done as one,
so that between steps the arrays hold v_(n-1/2) (see `loops`); what this class hands out is v_n.

Start: forces at step 0 see v_0, and v_(-1/2) = v_0 - dt F_0 / (2 m), so that the thesis' extrapolation
1.5 v_(n-1/2) - 0.5 v_(n-3/2) has its older value from the first step on. A disc that enters at step n has
v_(n-1/2) = v_(n-3/2) = its entry velocity, feels the forces of that step, and gets its last half kick. Where discs are
not equal it enters with the largest diameter, and gets its own after a step (`Scene.size_steps`): the first half of
that step's kick is that of the largest disc, the second half has the same force on the new mass (LAMMPS' `fix set`).

Constants of the loops come first. `CellSimulation`, last, has the contact search of the thesis.
"""

from __future__ import annotations

from math import ceil, inf
from time import perf_counter
from typing import Any

import numpy as np

from lammps_jump.core.columns import RunEnd, SumsOnWallColumns, WorkColumns
from lammps_jump.errors import CaseError, RunError
from lammps_jump.physics.law import Slots
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene.motion import PUSHED_THERE
from lammps_jump.scene.scene import Scene

from .arrays import CHECK_OVERLAP, LIST_STALE, Constants, Grid, Lists, Loops, Memory, Pairs, State, StepConstants
from .bound import Core, jump_events, jump_state
from .discs import ROUND, DiscArrays, starting
from .events import Event, EventList, OpenBoundaries, SceneEvents, Tailgates, WindowForce, Windows
from .ledger import (
    EnergyBalance,
    EnergyNow,
    StationLedger,
    energy_of,
    energy_of_leaving,
    fallen,
    free_energy,
    half_kicks,
    half_work,
    inertia,
    shares_of,
    spin,
    velocities,
)
from .walls import Walls

DEFAULT_SKIN = 0.3
"""Skin of the neighbour list over the diameter where the scene gives none."""


class Memories:
    """Memory of the contacts of a scene, as the loops take it: one object as long as nothing of it changes."""

    def __init__(self, scene: Scene):
        self._scene = scene
        self._held: Memory | None = None

    def of(self, discs: Any, walls: Any, full: np.ndarray, time_step: float) -> Memory | None:
        """The memory of discs and walls; None where contacts have none.

        `full` takes the id of a disc that has no slot left; springs go on by a time step (s), or stay as they are with
        0.
        """
        if self._scene.springs is None:
            return None
        d, held = discs, self._held
        if held is None or held.chain is not walls.chain or held.slots.partner is not d.partner:
            slots = Slots(d.partner, d.sigma, d.spring, d.roll, d.touched)
            held = Memory(slots, d.ids, walls.chain, walls.around, full, time_step)
        if held.time_step != time_step:
            held = held._replace(time_step=time_step)
        self._held = held
        return held


def constants_of(scene: Scene, skin: float) -> Constants:
    """Constants of a scene, with a neighbour list of this skin (m)."""
    return Constants(scene.largest, scene.law_numbers(), motion_of(scene, skin))


def motion_of(scene: Scene, skin: float) -> StepConstants:
    """Constants of the motion, with a neighbour list of this skin (m)."""
    square = 1.0 if scene.sizes is None else scene.radius * scene.radius
    mass = scene.mass / square
    weight = mass * scene.gravity[0], mass * scene.gravity[1]
    return StepConstants(scene.time_step, mass, inertia(scene) / square**2, *weight, (0.5 * skin) ** 2)


def lists_of(scene: Scene, skin: float, *, inside: bool) -> Lists:
    """Arguments of lists of this skin (m); where `inside` is true, loops make them within `Loops.advance`."""
    domain, ends = (*scene.domain[0], *scene.domain[1]), [wall.extent[0] for wall, _ in scene.walls if scene.period]
    return Lists(
        domain, skin, scene.largest, inside, np.zeros(2), scene.period or 0.0, np.zeros(1), np.reshape(ends, (-1, 2))
    )


KNOWN = {
    "integrator": ("velocity_verlet", "leapfrog_extrapolated"),
    "friction_law": tuple(FRICTION_LAWS),
    "touch": ("sharp", "smooth"),
}
"""Choices of a scene that this engine obeys."""

WORK_PER_CALL = 4_000_000
"""Disc-steps after which the kernel comes back to look for an interruption: about a tenth of a second."""


class NativeSimulation:
    """A scene on the native engine.

    Parameters
    ----------
    scene : Scene
    ledger : bool
        Keep the energy ledger.
    loops : Loops, optional
        Those of the core where none are given.

    Attributes
    ----------
    loops : Loops
    step : int
        Steps done.
    disc_steps : int
        Sum over steps of the discs in play.
    windows : Windows
        Mean forces on the probed walls.
    books : EnergyBalance
    stations : StationLedger
    rebuilds : int
        Neighbour lists made, in `rebuild_seconds` of wall time.

    Raises
    ------
    CaseError
        Integrator, friction law or touch that this engine does not know.
    RunError
        While running: a position is NaN or outside the domain, or an overlap is beyond ``scene.overlap_limit``.
    """

    _grid: Grid | None = None

    def __init__(self, scene: Scene, *, ledger: bool = True, loops: Loops | None = None):
        for name, known in KNOWN.items():
            if getattr(scene, name) not in known:
                raise CaseError(f"{name} {getattr(scene, name)!r}: the native engine knows {' and '.join(known)}")
        self.scene = scene
        self.loops: Loops = Core() if loops is None else loops
        self.step = 0
        self.disc_steps = 0
        self.rebuilds = 0
        self.rebuild_seconds = 0.0
        self.skin = scene.skin if scene.skin > 0 else DEFAULT_SKIN * scene.diameter
        self._share = (scene.largest / scene.diameter) ** 2  # of a disc that enters, in the nominal mass
        self.weight = scene.mass * self._share * scene.gravity[0], scene.mass * self._share * scene.gravity[1]
        self._constants, self._memories = constants_of(scene, self.skin), Memories(scene)
        self._lists = lists_of(scene, self.skin, inside=self._grid is None)
        self.ledger_on = ledger
        self.boundaries = OpenBoundaries(scene)
        self.windows = Windows(scene)
        self.gates = Tailgates(scene)
        self.books = EnergyBalance(periodic=scene.period is not None)
        self.stations = StationLedger(scene, self.loops, ledger)
        self._between = EventList(  # drift and forces
            Event(self.boundaries.next_leaving, self._let_leave),
            Event(self.boundaries.next_arrival, self._let_enter),
            Event(self._next_change, self._change_walls),
        )
        self._after = EventList(  # forces
            Event(self.boundaries.next_sizes, self._give_sizes),
            Event(self.stations.next_after, self._see_stations),
            Event(self.windows.next_after, self._close_window),
            Event(self.gates.next_after, lambda: self.gates.move(self.step, self.discs, self.walls)),
        )
        self.discs = DiscArrays(scene, self.loops, ledger=ledger)
        self.walls = Walls(scene, self.loops, self.step, self.skin)
        self._full, self._started = np.zeros(1, np.int64), False
        self._events = SceneEvents(self) if self.loops.runs_alone and self._grid is None else None
        if self._grid is None and self.discs.take_lists(scene, self.skin):
            self.walls.list_discs_again(self.discs.n, self.discs.x0, self.discs.y0, self.step)
        else:
            self._rebuild()
        self._check_overlap()
        self._start()
        self._started = True

    # --- set-up -------------------------------------------------------------------------------------------------

    def _start(self) -> None:
        """Forces of the start, weight included, the velocities of half a step before, and the energy.

        Discs of an earlier run feel the forces that its last step would give them here, with springs unchanged.
        Where walls and law are the same too, these are its forces, and the run goes on bit for bit.
        """
        d, share = self.discs, shares_of(self.scene, self.discs) / self._share
        d.fx[: d.n], d.fy[: d.n] = np.multiply.outer(self.weight, share)
        earlier = self.scene.earlier
        if earlier is not None:
            d.see_half_step(self.scene, earlier)
        self._forces()
        if earlier is not None:
            d.set_velocities(starting(self.scene, earlier))
        self._start_half_step_back()
        if earlier is not None:
            d.keep_bits(self.scene, earlier, half_kicks(self.scene, d))
            self.walls.end_start(earlier.walls, ROUND * self.scene.diameter / self.scene.time_step)
        forces = self.walls.sums[:, SumsOnWallColumns.FORCE]
        if self.walls.moves is not None:
            placed = self.walls.moves.now
            self.windows.see_bodies(self.step, self.walls, dict(zip(self.walls.names, forces, strict=True)), placed)
        self.walls.sums[:] = 0.0
        if self.walls.pressed is not None:
            self.walls.pressed.sums[:] = 0.0
        self.books.start, self.books.start_work = self.energy(), self.books.work[WorkColumns.WHOLE] + self._half_work()
        self.books.start_fallen = fallen(self.scene, self.discs)
        self._after.happen(self.step)

    def _start_half_step_back(self) -> None:
        discs, n = self.discs, self.discs.n
        half, half_turn = half_kicks(self.scene, discs)
        discs.vx[:n] -= half * discs.fx[:n]
        discs.vy[:n] -= half * discs.fy[:n]
        if discs.omega is not None:
            discs.omega[:n] -= half_turn * discs.torque[:n]

    # --- stepping -----------------------------------------------------------------------------------------------

    def run(self, steps: int) -> None:
        """Do `steps` steps."""
        target = self.step + steps
        while self.step < target:
            self.run_some(target)

    def run_some(self, target: int) -> None:
        """Go on towards step `target` for at most about a tenth of a second of work."""
        limit = self.step + max(1, WORK_PER_CALL // max(32, self.discs.n))
        alone = min(target, limit, self.boundaries.next_pour(self.step) - 1)
        if self._events is not None and alone > self.step:
            self._run_alone(int(alone))
            return
        stop = int(min(target, limit, self._between.next_after(self.step), self._after.next_after(self.step)))
        if stop > self.step:
            self._drift(stop)
            self._between.happen(stop)
            self._forces()
            self._after.happen(stop)

    def for_host(self, target: int, discs: int = 0) -> tuple[jump_state, jump_events]:
        """State and events as structs of the core, for a host that goes on from here to step `target` by `jump_run`.

        A host that lets more discs in than the scene gives the number of all discs whose radii it needs.

        Their arrays are those of this simulation, which must not step in parallel with that host.
        """
        assert isinstance(self.loops, Core) and self._events is not None
        self.walls.place(self.step)
        return self.loops.struct(self._state(self.scene.time_step)), self._events.put(target, discs)

    def _run_alone(self, target: int) -> None:
        """Let the core step up to `target`, with all that happens at its steps but pours."""
        assert isinstance(self.loops, Core) and self._events is not None
        self.walls.place(self.step)
        end, windows = self.loops.run(self._state(self.scene.time_step), self._events.put(target), target)
        self._events.take(windows)
        self._see_core()
        if end is RunEnd.AT_TARGET:
            return
        if end is RunEnd.NO_LISTS:
            self._rebuild()  # tells what is wrong, and so does the look at overlaps
        self._check_overlap()
        raise RunError(f"step {self.step}: the core went no further ({end.name})")

    def _drift(self, stop: int) -> None:
        """To the drift of step `stop`, its forces excluded; lists that have become too old are made anew."""
        left = 0
        while self.step < stop:
            done, left = self._advance(stop - self.step, left != 0)
            self.step += done
            self.disc_steps += done * self.discs.n
            if left == LIST_STALE:
                self._rebuild()
            elif left == CHECK_OVERLAP:
                self._check_overlap()

    def _forces(self) -> None:
        """The forces after a drift."""
        while self._advance(0, True)[1]:
            self._rebuild()

    def _state(self, time_step: float = 0.0) -> State:
        """Arguments of the loops; springs go on by a time step (s), or stay as they are with 0."""
        memory = self._memories.of(self.discs, self.walls, self._full, time_step)
        bodies = self.walls.body_state(self._constants, memory)
        return State(
            self.discs, self.listed_pairs(), self.walls, self._constants, memory, self.books.work, self._grid, bodies,
            self._lists,
        )  # fmt: skip

    def _advance(self, steps: int, forces_pending: bool) -> tuple[int, int]:
        self.walls.place(self.step)
        ended_at = self.loops.advance(
            self._state(self.scene.time_step if self._started else 0.0), steps, forces_pending
        )
        self._see_core()
        return ended_at

    def _see_core(self) -> None:
        """Count the lists that the core has made, and look for what ends a run."""
        lists, seconds = self._lists.made.tolist()
        self._lists.made[:] = 0.0
        self.rebuilds += int(lists)
        self.rebuild_seconds += seconds
        if self._full[0]:
            raise RunError(
                f"disc {self._full[0]} touches more than the {self.scene.slots} others it can remember: contacts "
                f"are too deep; {self.scene.stiffer}."
            )
        if self.scene.period is not None:
            self.books.exchanged["work_of_slope"] += float(self._lists.slope_work[0])
            self._lists.slope_work[:] = 0.0
        self._require(self.walls.trouble_of_bodies())

    def _require(self, wrong: str) -> None:
        """RunError where something is wrong now."""
        if wrong:
            raise RunError(f"at t = {self.scene.time(self.step):z.4g} s (step {self.step}) {wrong}.")

    def listed_pairs(self) -> Pairs:
        """The present list."""
        return self.discs.pairs

    # --- events -------------------------------------------------------------------------------------------------

    def _see_stations(self) -> None:
        """Sums between the stations at this step; `StationLedger.next_after` lets no step of theirs pass."""
        self.stations.add(self.step, self._state())

    def _next_change(self, step: int) -> float:
        return min((motion.next_change(step) for _, motion in self.scene.walls), default=inf)

    def _let_leave(self) -> None:
        """Take out the discs that an outlet takes at this step."""
        leaving = self.boundaries.leaving(self.step, self.discs)
        if leaving is None:
            return
        if self.ledger_on:
            for energy in (*energy_of_leaving(self.scene, self.discs, leaving), self._elastic_of(leaving)):
                self.books.exchanged["carried_out"] += energy
        self.boundaries.removed += int(leaving.sum())
        self.discs.keep(leaving ^ True)
        self._rebuild()

    def _let_enter(self) -> None:
        """Add the discs that enter at this step."""
        known = self.boundaries.inserted
        skin = 1.5 * self.skin  # the others may have moved half a skin since the list was made
        for new in self.boundaries.arrivals(self.step, self.discs, self.walls.poses()):
            self.discs.append(new, self.weight, skin, self.scene.largest)
            self.books.exchanged["brought_in"] += free_energy(self.scene, (new.x, new.y), (new.vx, new.vy), self._share)
        if self.boundaries.inserted > known:
            self._list_newcomers()
            self.books.exchanged["brought_in"] += self._elastic_of_newcomers(known)

    def _change_walls(self) -> None:
        """Take away the walls that go at this step."""
        elastic = self._elastic()
        self.windows.take(self.walls)
        self.walls.take_away(self.step)
        self._list_walls()
        self.books.exchanged["released_by_gates"] += elastic - self._elastic()

    def _close_window(self) -> None:
        self.windows.close(self.step, self.walls)

    def _elastic_of(self, chosen: np.ndarray) -> float:
        """Elastic energy of the contacts of some discs, a mask of shape (n,); 0 without a ledger."""
        return self.loops.elastic(self._state(), chosen)[0] if self.ledger_on else 0.0

    def _elastic_of_newcomers(self, known: int) -> float:
        """That of the contacts of discs with ids above `known`."""
        return self._elastic_of(self.discs.ids[: self.discs.n] > known)

    def _give_sizes(self) -> None:
        """Give discs of the largest diameter their own; the energy balance counts the difference as inflow."""
        boundaries = self.boundaries
        known = boundaries.sized
        own = 0.5 * self.scene.diameters(np.arange(known + 1, boundaries.inserted + 1))
        elastic = self._elastic_of_newcomers(known)
        gained = self.loops.give_sizes(self._state(), known, own)
        self.books.exchanged["brought_in"] += gained + self._elastic_of_newcomers(known) - elastic
        boundaries.sized = boundaries.inserted

    # --- neighbour lists and guards -----------------------------------------------------------------------------

    def _rebuild(self) -> None:
        started = perf_counter()
        if self.scene.period is not None:
            self._wrap(self.scene.period)
        self._require_inside(self.discs.list_pairs(self._state()))
        self._list_walls()
        wrong = self.walls.trouble_at_seam(self.scene)
        self._require(wrong and f"{wrong}; {PUSHED_THERE}")
        self.rebuilds += 1
        self.rebuild_seconds += perf_counter() - started
        if self.rebuilds % 16 == 0:
            self._check_overlap()

    def _wrap(self, period: float) -> None:
        """Let discs that have left a periodic channel in at its other end; the slope has done work on them."""
        self.books.exchanged["work_of_slope"] += fallen(self.scene, self.discs)
        self.discs.wrap(self.scene.domain[0][0], period)
        self.books.exchanged["work_of_slope"] -= fallen(self.scene, self.discs)

    def _list_walls(self) -> None:
        self.walls.place(self.step)
        self.walls.list_discs(self.discs.n, self.discs.x0, self.discs.y0)

    def _list_newcomers(self) -> None:
        """Completes the lists for discs that have rows of their own after the others."""
        self._list_walls()

    def _elastic(self) -> float:
        return self.loops.elastic(self._state())[0]

    def check(self) -> None:
        """Look for NaN, lost discs and overlaps beyond the limit now; RunError where there are any."""
        self._require_inside()
        self._check_overlap()

    def _check_overlap(self) -> None:
        limit = self.scene.overlap_limit
        if limit <= 0:
            return
        _, worst, i, _ = self.loops.elastic(self._state())
        if worst > limit:
            raise RunError(
                f"overlap {worst:z.4g} m of disc {self.discs.place(i, self.scene, self.step)} is beyond the limit of "
                f"{limit:z.4g} m. The contact is too soft for this flow or the step too long: {self.scene.stiffer}, or "
                "lower run.time_step_fraction; look for discs that overlap at the start."
            )

    def _require_inside(self, lost: int | None = None) -> None:
        """RunError where a disc is outside the domain: that of index `lost` (-1: none), or any where none is given."""
        i = self.discs.outside(self.scene, self.skin) if lost is None else lost
        if i >= 0:
            raise RunError(self.discs.lost(i, self.scene, self.step))

    # --- what it hands out --------------------------------------------------------------------------------------

    def _by_id(self, values: np.ndarray) -> np.ndarray:
        return values[np.argsort(self.discs.ids[: self.discs.n], kind="stable")]

    @property
    def ids(self) -> np.ndarray:
        """Ids of the discs in play, ascending, shape (n,)."""
        return np.sort(self.discs.ids[: self.discs.n])

    @property
    def positions(self) -> np.ndarray:
        """Positions x_n (m), sorted by id, shape (n, 2)."""
        d = self.discs
        return self._by_id(np.column_stack([d.x[: d.n], d.y[: d.n]]))

    @property
    def velocities(self) -> np.ndarray:
        """Velocities at the step, v_n (m/s), sorted by id, shape (n, 2)."""
        return self._by_id(np.column_stack(velocities(self.scene, self.discs)))

    @property
    def spin(self) -> np.ndarray:
        """Angular velocities at the step (rad/s), sorted by id, shape (n,); zeros where discs do not spin."""
        if self.discs.omega is None:
            return np.zeros(self.discs.n)
        return self._by_id(spin(self.scene, self.discs))

    @property
    def radii(self) -> np.ndarray:
        """Radii (m), sorted by id, shape (n,)."""
        d = self.discs
        return np.full(d.n, self.scene.radius) if d.radius is None else self._by_id(d.radius[: d.n])

    @property
    def forces(self) -> list[WindowForce]:
        """(step, wall name, fx, fy, moment) of each window of a probed wall: means, N per m of width.

        The moment (N) is about the reference point of the wall. Where walls move, the power of the wall on the discs
        (W/m) follows them.
        """
        return self.windows.forces

    def contacts(self) -> tuple[np.ndarray, np.ndarray]:
        """Contacts now with the forces of the step, as `Loops.contacts` lists them; wall w is that of the scene."""
        scene, d, room, count = self.scene, self.discs, 3 * self.discs.n + 64, -1
        vx, vy = velocities(scene, d)
        at_step = vx, vy, None if d.omega is None else spin(scene, d)
        seen = (d.vx, d.vy, d.omega) if d.ux is None else (d.ux, d.uy, d.uomega)
        while count < 0:
            who, rows = np.empty((room, 2), np.int64), np.empty((room, 5))
            count = self.loops.contacts(self._state(), at_step, seen if self.step else at_step, who, rows)
            room *= 2
        names = [wall.name for wall, _ in scene.walls]
        numbers = np.array([0, *(-1 - names.index(name) for name in self.walls.names)])
        other = who[:count, 1]
        other[:] = np.where(other < 0, numbers[np.maximum(-other, 0)], other)
        return who[:count], rows[:count]

    def energy(self) -> EnergyNow:
        """Kinetic (spin included), gravitational (-m g . x) and elastic energy now, with that of loaded walls."""
        self.walls.place(self.step)
        energy_now = energy_of(self.scene, self.discs, self._elastic())
        kinetic, place = self.walls.lid_energy()
        return EnergyNow(energy_now.kinetic + kinetic, energy_now.gravitational + place, energy_now.elastic)

    def _half_work(self) -> np.ndarray:
        return half_work(self.scene, self.discs, self.books.work) if self.ledger_on else np.zeros(3)

    @property
    def ledger(self) -> dict[str, float] | None:
        """Energy ledger since the start, J per m of width (see `EnergyBalance`); None if it is not kept."""
        if not self.ledger_on:
            return None
        moves = self.walls.moves is not None
        terms = self.books.balance(self.energy(), self._half_work(), fallen(self.scene, self.discs), walls_move=moves)
        return terms | self.stations.heads(self.step)


class CellSimulation(NativeSimulation):
    """A scene stepped with cell lists made anew every step, and every disc tried against every wall.

    Same forces as `NativeSimulation`; only the order in which they are summed differs.

    Parameters
    ----------
    scene : Scene
    cell_size : float, optional
        Width of the square cells, m; 2 d by default, as the thesis has it.
    ledger : bool
    loops : Loops, optional
        As of `NativeSimulation`.
    """

    def __init__(
        self, scene: Scene, *, cell_size: float | None = None, ledger: bool = True, loops: Loops | None = None
    ):
        self.cell_size = 2.0 * scene.diameter if cell_size is None else float(cell_size)
        if not (0.1 * scene.diameter <= self.cell_size < float("inf")):
            raise CaseError(
                f"cell size {self.cell_size:zg} m: use at least a tenth of the disc diameter "
                f"({0.1 * scene.diameter:zg} m); the thesis used two diameters"
            )
        (x_low, x_high), (y_low, y_high) = scene.domain
        inverse = 1.0 / self.cell_size
        columns = int((x_high - x_low) * inverse) + 1
        rows = int((y_high - y_low) * inverse) + 1
        first = np.zeros(columns * rows + 2, np.int64)
        self._grid = Grid(x_low, y_low, inverse, columns, rows, first, np.zeros(1, np.int64))
        self._slots = (ceil(scene.largest * inverse) + 1) ** 2
        self._owner = np.empty(0, np.int32)
        self._neighbours = np.empty(256, np.int32)
        super().__init__(scene, ledger=ledger, loops=loops)
        motion = self._constants.motion._replace(reach2=float("inf"))
        self._constants = self._constants._replace(motion=motion)

    def listed_pairs(self) -> Pairs:
        """The present list."""
        assert self._grid is not None  # `__init__` has made it
        return Pairs(int(self._grid.used[0]), self._owner, self._first, self._neighbours)

    def _rebuild(self) -> None:
        started = perf_counter()
        d = self.discs
        self._require_inside()
        if self._owner.size < self._slots * d.room:
            self._owner = np.empty(self._slots * d.room, np.int32)
            self._first = np.zeros(self._slots * d.room + 1, np.int64)
        while self.loops.cell_pairs(self._state()) < 0:
            self._neighbours = np.empty(2 * self._neighbours.size, np.int32)
        self._list_walls()
        self.rebuilds += 1
        self.rebuild_seconds += perf_counter() - started

    def _drift(self, stop: int) -> None:
        super()._drift(stop)
        if self._between.next_after(stop - 1) == stop:
            self._rebuild()

    def _list_newcomers(self) -> None:
        self._rebuild()

    def _list_walls(self) -> None:
        self.walls.list_all(self.discs.n)
