# SPDX-License-Identifier: GPL-2.0-or-later
"""One scene, step by step, on the native engine: what the run, the tests and the cross-validation drive.

Order of operations of a step, LAMMPS' own: half kick, drift, [outlets, arrivals, gates, neighbour list], forces with
the velocities of the half step, half kick. The last half kick of one step and the first of the next are done as one,
so that between steps the arrays hold v_(n-1/2) (see `loops`); what this class hands out is v_n.

Start: forces at step 0 see v_0, and v_(-1/2) = v_0 - dt F_0 / (2 m), so that the thesis' extrapolation
1.5 v_(n-1/2) - 0.5 v_(n-3/2) has its older value from the first step on. A disc that enters at step n has
v_(n-1/2) = v_(n-3/2) = its entry velocity, feels the forces of that step, and gets its last half kick. Where discs are
not equal it enters with the largest diameter, and gets its own behind a step (`Scene.size_steps`): the first half of
that step's kick is that of the largest disc, the second half has the same force on the new mass (LAMMPS' `fix set`).
"""

from __future__ import annotations

from math import inf
from time import perf_counter

import numpy as np

from lammps_jump.errors import CaseError, RunError
from lammps_jump.physics.slip import SIGN_RAMP
from lammps_jump.scene.scene import Scene

from . import ledger as energies
from . import lists as neighbours
from . import loops as kernels
from .constants import law_of, motion_of
from .discs import Discs
from .inlets import OpenBoundaries
from .ledger import Energy
from .walls import Walls

DEFAULT_SKIN = 0.3
"""Skin of the neighbour list over the diameter where the scene gives none."""

KNOWN = {
    "integrator": ("velocity_verlet", "leapfrog_extrapolated"),
    "friction_law": ("hooke", "sign"),
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

    Attributes
    ----------
    step : int
        Steps done.
    disc_steps : int
        Sum over steps of the discs in play.
    forces : list of (step, wall name, fx, fy, moment)
        Window means of the force on each probed wall (N per m of width), moment (N) about its reference point. Where
        walls move, the power of the wall on the discs (W/m) stands behind them.
    rebuilds : int
        Neighbour lists made, in `rebuild_seconds` of wall time.

    Raises
    ------
    CaseError
        Integrator, friction law or touch that this engine does not know.
    RunError
        While running: a position is NaN or outside the domain, or an overlap is beyond ``scene.overlap_limit``.
    """

    _grid: kernels.Grid | None = None

    def __init__(self, scene: Scene, *, ledger: bool = True):
        for name, known in KNOWN.items():
            if getattr(scene, name) not in known:
                raise CaseError(f"{name} {getattr(scene, name)!r}: the native engine knows {' and '.join(known)}")
        self.scene = scene
        self.step = 0
        self.disc_steps = 0
        self.rebuilds = 0
        self.rebuild_seconds = 0.0
        self.forces: list[tuple] = []
        self._friction = scene.coefficients.friction if scene.rubs else None
        self._sign = SIGN_RAMP if self._friction is not None and scene.friction_law == "sign" else None
        self._touch = scene.touch_width if scene.touch == "smooth" and scene.touch_width > 0 else None
        self._law = law_of(scene)
        self.skin = scene.skin if scene.skin > 0 else DEFAULT_SKIN * scene.diameter
        self._share = (scene.largest / scene.diameter) ** 2  # of a disc that enters, in the nominal mass
        self._weight = scene.mass * self._share * scene.gravity[0], scene.mass * self._share * scene.gravity[1]
        self._motion = motion_of(scene, self.skin)
        self._ledger_on = ledger
        self._work = np.zeros(6)
        self._columns = 4 if scene.moves else 3
        self.stations = energies.StationLedger(scene, ledger)
        self._exchanged = {"brought_in": 0.0, "carried_out": 0.0, "released_by_gates": 0.0}
        self.boundaries = OpenBoundaries(scene)
        self._window_start = 0
        self._carried: dict[str, np.ndarray] = {}
        self.discs = Discs(scene, ledger=ledger)
        self._load_walls()
        self._rebuild()
        self._check_overlap()
        self._compute_forces()
        self._start_half_step_back()
        self.walls.sums[:] = 0.0
        self._start_work = self._work[:3] + self._half_work()
        self._start_energy = self.energy()
        self._see_stations()

    # --- set-up -------------------------------------------------------------------------------------------------

    def _load_walls(self) -> None:
        """Walls that are there now; sums of the window go on, also those of one that has just been taken away."""
        if hasattr(self, "walls"):
            self._carry_window_over()
        self.walls = Walls(self.scene, self.step, self.skin)

    def _carry_window_over(self) -> None:
        for name, row in zip(self.walls.names, self.walls.sums, strict=True):
            self._carried[name] = self._carried.get(name, 0.0) + row

    def _start_half_step_back(self) -> None:
        discs, n = self.discs, self.discs.n
        half, half_turn = energies.half_kicks(self.scene, discs)
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
        others = self.boundaries.next_sizes(self.step), self.stations.next(self.step)
        stop = min(target, limit, self._next_window(), *others)
        event = self._next_event()
        self._advance(int(min(event, stop)), hold=event <= stop)
        if self.boundaries.next_sizes(self.step - 1) == self.step:
            self._give_sizes()
        self._see_stations()
        if self.step == self._next_window():
            self._close_window()

    def _see_stations(self) -> None:
        """Sums between the stations at this step; `StationLedger.next` lets no step of theirs pass."""
        law = self._law, self._motion, self._friction, self._sign, self._touch
        self.stations.add(self.step, self.discs, *self._list(), *law)

    def _next_window(self) -> float:
        return self._window_start + self.scene.probe_steps if self.scene.probes else inf

    def _next_event(self) -> float:
        return min(self.boundaries.next_after(self.step), self._next_change(self.step))

    def _next_change(self, step: int) -> float:
        return min((motion.next_change(step) for _, motion in self.scene.walls), default=inf)

    def _advance(self, stop: int, hold: bool) -> None:
        """To step `stop`; where `hold`, with what happens between its drift and its forces."""
        pending = False
        while self.step < stop or pending:
            done, state = self._kernel(stop - self.step, pending, hold)
            self.step += done
            self.disc_steps += done * self.discs.n
            pending = state != kernels.DONE
            old = state == kernels.OLD
            if hold and pending and self.step == stop:
                hold = False
                self._exchange(old)
            elif old:
                self._rebuild()

    def _kernel(self, steps: int, pending: bool, hold: bool) -> tuple[int, int]:
        d = self.discs
        self.walls.place(self.step)
        return kernels.advance(
            steps, pending, hold, d.n, d.x, d.y, d.radius, d.vx, d.vy, d.fx, d.fy, d.x0, d.y0, d.ux, d.uy, d.omega,
            d.torque, d.uomega, *self._list()[1:], self._grid, self.walls.faces, self.walls.near, self._law,
            self._motion, self._friction, self._sign, self._touch, d.dash_x, d.dash_y, d.slide_x, d.slide_y,
            self.walls.moves, self._work, self.walls.sums,
        )  # fmt: skip

    def _list(self) -> tuple:
        """The list that stands, as the loops take it: rows, their owners, start, neighbours."""
        return self.discs.n, None, self.discs.start, self.discs.neighbours

    def _compute_forces(self) -> None:
        """Forces at the start, weight included."""
        d, share = self.discs, energies.shares_of(self.scene, self.discs) / self._share
        d.fx[: d.n], d.fy[: d.n] = np.multiply.outer(self._weight, share)
        self._kernel(0, True, False)

    def _exchange(self, old: bool) -> None:
        """What comes and goes at this step, between drift and forces."""
        discs = self.discs
        leaving = self.boundaries.leaving(self.step, discs)
        if leaving is not None:
            self._remove(leaving, old)
        elif old:
            self._rebuild()
        known, before = self.boundaries.inserted, discs.n
        skin = 1.5 * self.skin  # the others may have moved half a skin since the list was made
        for identity, x, y, vx, vy in self.boundaries.arrivals(self.step, discs):
            discs.append(identity, x, y, vx, vy, self._weight, skin, self.scene.largest)
            self._exchanged["brought_in"] += energies.free_energy(self.scene, x, y, vx, vy, self._share)
        if self.boundaries.inserted > known:
            self._exchanged["brought_in"] += self._elastic_of_newcomers(known, self._list_newcomers(before))
        if self._next_change(self.step - 1) == self.step:
            elastic = self._elastic()
            self._load_walls()
            self._list_walls()
            self._exchanged["released_by_gates"] += elastic - self._elastic()

    def _elastic_of_newcomers(self, known: int, begin: int = 0) -> float:
        """Elastic energy of the contacts of discs with ids above `known`, from row `begin` on; 0 without a ledger."""
        return self._elastic_and_worst(known, begin)[0] if self._ledger_on else 0.0

    def _give_sizes(self) -> None:
        """Give discs of the largest diameter their own; the energy balance counts the difference as inflow."""
        d, boundaries = self.discs, self.boundaries
        known = boundaries.sized
        own = 0.5 * self.scene.diameters(np.arange(known + 1, boundaries.inserted + 1))
        elastic = self._elastic_of_newcomers(known)
        gained = kernels.give_sizes(
            known, own, d.n, d.ids, d.x, d.y, d.radius, d.vx, d.vy, d.fx, d.fy, d.omega, d.torque, self._motion,
            d.dash_x, d.dash_y, d.slide_x, d.slide_y,
        )  # fmt: skip
        self._exchanged["brought_in"] += gained + self._elastic_of_newcomers(known) - elastic
        boundaries.sized = boundaries.inserted

    def _remove(self, leaving: np.ndarray, old: bool) -> None:
        discs = self.discs
        elastic = 0.0
        if self._ledger_on:
            if old:
                # the mask follows the discs through the sort by their ids
                ids = discs.ids[: discs.n][leaving]
                self._rebuild()
                leaving = np.isin(discs.ids[: discs.n], ids)
            elastic = self._elastic()
            for energy in energies.energy_of_leaving(self.scene, discs, leaving):
                self._exchanged["carried_out"] += energy
        self.boundaries.removed += int(leaving.sum())
        discs.keep(leaving ^ True)
        self._rebuild()
        if self._ledger_on:
            self._exchanged["carried_out"] += elastic - self._elastic()

    # --- neighbour lists and guards -----------------------------------------------------------------------------

    def _rebuild(self) -> None:
        started = perf_counter()
        self._require_inside(self.discs.sort_and_list(self.skin, self.scene.largest, self.scene.domain))
        self._list_walls()
        self.rebuilds += 1
        self.rebuild_seconds += perf_counter() - started
        if self.rebuilds % 16 == 0:
            self._check_overlap()

    def _list_walls(self) -> None:
        self.walls.place(self.step)
        self.walls.list_discs(self.discs.n, self.discs.x, self.discs.y)

    def _list_newcomers(self, before: int) -> int:
        """Complete the lists for discs that have rows of their own, from row `before` on; their first row."""
        self._list_walls()
        return before

    def _elastic_and_worst(self, known: int | None = None, begin: int = 0) -> tuple[float, float, int, int]:
        """What `loops.elastic` finds: of all contacts, or of those of discs with ids above `known`."""
        d = self.discs
        ids = (None, 0) if known is None else (d.ids, known)
        return kernels.elastic(
            begin, *self._list(), d.x, d.y, d.radius, self.walls.faces, self.walls.near, self._law, self._touch, *ids,
            self.walls.moves,
        )  # fmt: skip

    def _elastic(self) -> float:
        return self._elastic_and_worst()[0]

    def check(self) -> None:
        """Look for NaN, lost discs and overlaps beyond the limit now; RunError where there are any."""
        self._require_inside()
        self._check_overlap()

    def _check_overlap(self) -> None:
        limit = self.scene.overlap_limit
        if limit <= 0:
            return
        _, worst, i, _ = self._elastic_and_worst()
        if worst > limit:
            raise RunError(
                f"overlap {worst:.4g} m of disc {self._place(i)} is beyond the limit of {limit:.4g} m. "
                "The contact is too soft for this flow or the step too long: raise contact.impact_speed or "
                "contact.penetration_fraction, or lower run.time_step_fraction; look for discs that overlap at "
                "the start."
            )

    def _require_inside(self, lost: int | None = None) -> None:
        """RunError where a disc is outside the domain: that of index `lost` (-1: none), or any where none is given."""
        d = self.discs
        (a, b), (c, e) = self.scene.domain
        i = neighbours.extent(d.n, d.x, d.y, a, b, c, e)[4] if lost is None else lost
        if i < 0:
            return
        if not (np.isfinite(d.x[i]) and np.isfinite(d.y[i])):
            raise RunError(
                f"the position of disc {self._place(i)} is not a number: the run has blown up. Lower "
                "run.time_step_fraction and look for discs that overlap at the start."
            )
        raise RunError(
            f"disc {self._place(i)} has left the domain x {a:g} … {b:g} m, y {c:g} … {e:g} m. Put an outflow "
            "where discs leave, close the gap between the walls, or enlarge the domain; where nothing should leave, "
            "lower run.time_step_fraction."
        )

    def _place(self, i: int) -> str:
        d = self.discs
        return (
            f"{d.ids[i]} at ({d.x[i]:.6g}, {d.y[i]:.6g}) m, time {self.scene.time(self.step):.6g} s (step {self.step}),"
        )

    # --- what it hands out --------------------------------------------------------------------------------------

    def _close_window(self) -> None:
        steps = self.step - self._window_start
        self._carry_window_over()
        for name in self.scene.probes:
            mean = self._carried.get(name, np.zeros(4)) / steps
            self.forces.append((self.step, name, *(float(v) for v in mean[: self._columns])))
        self.walls.sums[:] = 0.0
        self._carried = {}
        self._window_start = self.step

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
        return self._by_id(np.column_stack(energies.velocities(self.scene, self.discs)))

    @property
    def spin(self) -> np.ndarray:
        """Angular velocities at the step (rad/s), sorted by id, shape (n,); zeros where discs do not spin."""
        if self.discs.omega is None:
            return np.zeros(self.discs.n)
        return self._by_id(energies.spin(self.scene, self.discs))

    @property
    def radii(self) -> np.ndarray:
        """Radii (m), sorted by id, shape (n,)."""
        d = self.discs
        return np.full(d.n, self.scene.radius) if d.radius is None else self._by_id(d.radius[: d.n])

    def energy(self) -> Energy:
        """Kinetic (spin included), gravitational (-m g . x) and elastic energy now, with that of loaded walls."""
        self.walls.place(self.step)
        found = energies.energy_of(self.scene, self.discs, self._elastic())
        kinetic, place = self.walls.lid_energy()
        return Energy(found.kinetic + kinetic, found.gravitational + place, found.elastic)

    def _half_work(self) -> np.ndarray:
        return energies.half_work(self.scene, self.discs, self._work) if self._ledger_on else np.zeros(3)

    @property
    def ledger(self) -> dict[str, float] | None:
        """Energy ledger since the start, J per m of width (see `ledger.close`); None where it is not kept."""
        if not self._ledger_on:
            return None
        work, moves = self._work[:3] + self._half_work() - self._start_work, self.walls.moves is not None
        found = energies.close(self._start_energy, self.energy(), self._exchanged, work, walls_move=moves)
        return found | self.stations.heads(self.step)
