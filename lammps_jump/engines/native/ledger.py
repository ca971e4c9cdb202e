# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy of the discs at a step (thesis 4.28), the energy balance of the run, and that between two moving stations."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from lammps_jump.core.columns import StationSum, WorkColumns
from lammps_jump.scene.scene import Scene

from .arrays import Loops, State, StationStep
from .discs import DiscArrays

Numbers = float | np.ndarray
"""A number of one disc, or of each."""


@dataclass(frozen=True)
class EnergyNow:
    """Energy now, J per m of width; `elastic` of pairs and walls together, `kinetic` with spin."""

    kinetic: float
    gravitational: float
    elastic: float

    @property
    def total(self) -> float:
        """Sum of the three."""
        return self.kinetic + self.gravitational + self.elastic


def inertia(scene: Scene) -> float:
    """Moment of inertia of a nominal disc, kg m^2 per m of width: m R^2 / 2."""
    return scene.coefficients.inertia * (scene.radius * scene.radius)


def shares(scene: Scene, radius: np.ndarray | None) -> Numbers:
    """Mass over the nominal mass: 1 of equal discs, else of discs of these radii (m); its square is that of inertia."""
    return 1.0 if radius is None else (radius / scene.radius) ** 2


def shares_of(scene: Scene, discs: DiscArrays) -> Numbers:
    """`shares` of the discs in play, shape (n,)."""
    return shares(scene, None if discs.radius is None else discs.radius[: discs.n])


def half_kicks(scene: Scene, discs: DiscArrays) -> tuple[Numbers, Numbers]:
    """dt / (2 m) and dt / (2 I) of the discs in play: what force and torque add to velocity and spin in half a step."""
    share, half = shares_of(scene, discs), 0.5 * scene.time_step
    return half / scene.mass / share, half / inertia(scene) / share**2


def velocities(scene: Scene, discs: DiscArrays) -> tuple[np.ndarray, np.ndarray]:
    """Velocities at the step, v_n = v_(n-1/2) + dt F_n / (2 m): two arrays of shape (n,), m/s."""
    n, (half, _) = discs.n, half_kicks(scene, discs)
    return discs.vx[:n] + half * discs.fx[:n], discs.vy[:n] + half * discs.fy[:n]


def spin(scene: Scene, discs: DiscArrays) -> np.ndarray:
    """Angular velocities at the step, shape (n,), rad/s."""
    assert discs.omega is not None  # they spin
    return discs.omega[: discs.n] + half_kicks(scene, discs)[1] * discs.torque[: discs.n]


def energy_of(scene: Scene, discs: DiscArrays, elastic: float) -> EnergyNow:
    """Kinetic and gravitational (-m g . x) energy of the discs at the step, with the elastic energy given (J per m)."""
    n, share = discs.n, shares_of(scene, discs)
    vx, vy = velocities(scene, discs)
    kinetic = 0.5 * scene.mass * float((share * vx) @ vx + (share * vy) @ vy)
    if discs.omega is not None:
        turn = spin(scene, discs)
        kinetic += 0.5 * inertia(scene) * float((share**2 * turn) @ turn)
    gx, gy = scene.gravity
    gravitational = -scene.mass * float(gx * (share * discs.x[:n]).sum() + gy * (share * discs.y[:n]).sum())
    return EnergyNow(kinetic, gravitational, elastic)


def fallen(scene: Scene, discs: DiscArrays) -> float:
    """Work of weight along a periodic channel from x = 0 to where the discs are, J per m; 0 in another channel."""
    if scene.period is None:
        return 0.0
    return scene.mass * scene.gravity[0] * float((shares_of(scene, discs) * discs.x[: discs.n]).sum())


def free_energy(
    scene: Scene, place: tuple[Numbers, Numbers], velocity: tuple[Numbers, Numbers], share: Numbers = 1.0
) -> float:
    """Kinetic and gravitational energy at the step (J per m) of free discs with this half-step velocity.

    `share` is their mass over the nominal mass (see `shares`).
    """
    (x, y), (vx, vy) = place, velocity
    gx, gy = scene.gravity
    half = 0.5 * scene.time_step
    wx, wy = vx + half * gx, vy + half * gy
    return scene.mass * float(np.sum(share * (0.5 * (wx * wx + wy * wy) - gx * x - gy * y)))


def energy_of_leaving(scene: Scene, discs: DiscArrays, leaving: np.ndarray) -> tuple[float, float]:
    """`free_energy` and energy of rotation (J per m) that discs take with them; `leaving` is a mask of shape (n,)."""
    chosen = np.flatnonzero(leaving)
    share = shares(scene, None if discs.radius is None else discs.radius[chosen])
    place, velocity = (discs.x[chosen], discs.y[chosen]), (discs.vx[chosen], discs.vy[chosen])
    free = free_energy(scene, place, velocity, share)
    if discs.omega is None:
        return free, 0.0
    return free, 0.5 * inertia(scene) * float((share**2 * discs.omega[chosen] ** 2).sum())


def half_work(scene: Scene, discs: DiscArrays, work: np.ndarray) -> np.ndarray:
    """Work at a step besides the sums `work`, J per m, shape (3,): of dashpots, friction and moving walls.

    That of discs is what they lose in the first half of this step's kick. Of walls, half of this step is too much.
    """
    n, (half, half_turn) = discs.n, half_kicks(scene, discs)
    wx, wy = discs.vx[:n] + 0.5 * half * discs.fx[:n], discs.vy[:n] + 0.5 * half * discs.fy[:n]
    assert discs.dashpot_x is not None  # the ledger is kept
    lost = float(discs.dashpot_x[:n] @ wx + discs.dashpot_y[:n] @ wy)
    slid = 0.0
    if discs.friction_x is not None:
        slid = float(discs.friction_x[:n] @ wx + discs.friction_y[:n] @ wy)
        if discs.omega is not None:
            turn = discs.omega[:n] + 0.5 * half_turn * discs.torque[:n]
            slid += float(discs.torque[:n] @ turn)
    return -0.5 * scene.time_step * np.array([lost, slid, 0.0]) - 0.5 * work[WorkColumns.OF_WALLS]


class EnergyBalance:
    """The energy balance of a run, J per m of width.

    Present energy (kinetic, gravitational, elastic), the energy at the start (`initial`), `brought_in`, `carried_out`,
    `released_by_gates` (the elastic energy of their contacts), dissipated by dashpots and by friction. The work of a
    dissipative force over a kick is dt F . v_n, exact for the kick; `residual` = present + carried out + released +
    dissipated - initial - brought in is therefore the error of the time integration of springs and weight alone. It
    is of second order: at first touch the spring overworks by k (v dt)^2 / 12 in the mean over entry phases, at parting
    it gives the same back at the lower speed, h^2 (1 - e^2) / 6 of a collision's energy with h = omega dt.
    In a periodic channel `work_of_slope` is what weight along it has done since the start, and the gravitational energy
    is that of the height alone. Moving walls add `work_of_walls`, with the velocity centred on the step, to what is
    brought in.
    `throughput` is what to measure it against: kinetic and elastic energy at the start, the change of the gravitational
    energy, and what came in.

    Attributes
    ----------
    start : EnergyNow
    start_work, work : ndarray, shape (3,) and (6,)
        `half_work` at the start; what dashpots and friction have taken in whole kicks since, what moving walls have
        done, and the last step's part that is due to walls (`WorkColumns`).
    exchanged : dict
        Energy that came, went, and was released by gates.
    """

    def __init__(self, *, periodic: bool = False) -> None:
        self.start, self.start_work, self.work = EnergyNow(0.0, 0.0, 0.0), np.zeros(3), np.zeros(WorkColumns.width())
        self.start_fallen = 0.0
        self.exchanged = {"brought_in": 0.0, "carried_out": 0.0, "released_by_gates": 0.0}
        if periodic:
            self.exchanged["work_of_slope"] = 0.0

    def balance(
        self, now: EnergyNow, half: np.ndarray, fallen: float = 0.0, *, walls_move: bool = False
    ) -> dict[str, float]:
        """The balance at a step with this energy and `half_work`.

        `fallen` is the work of weight along a periodic channel (the function of that name); `exchanged` holds that on
        discs which went round.
        """
        start, done = self.start, self.work[WorkColumns.WHOLE] + half - self.start_work
        dashpots, friction, walls = map(float, done)
        fallen -= self.start_fallen
        height = now.gravitational + fallen
        balance_terms = {
            "initial": start.total,
            "kinetic": now.kinetic,
            "gravitational": height,
            "elastic": now.elastic,
            **self.exchanged,
            "dissipated_dashpots": dashpots,
            "dissipated_friction": friction,
        }
        slope = 0.0
        if "work_of_slope" in balance_terms:
            slope = balance_terms["work_of_slope"] = balance_terms["work_of_slope"] + fallen
        gone = balance_terms["carried_out"] + balance_terms["released_by_gates"] + dashpots + friction
        if walls_move:
            balance_terms["work_of_walls"] = walls
        brought = balance_terms["brought_in"] + walls + slope
        balance_terms["residual"] = now.total + fallen + gone - start.total - brought
        moved = abs(start.gravitational - height)
        balance_terms["throughput"] = (
            start.kinetic + start.elastic + moved + abs(balance_terms["brought_in"]) + abs(walls) + abs(slope)
        )
        return balance_terms


MASS_LEFT, MASS_RIGHT, CARRIED, CONTACTS, WALLS, DASHPOTS, FRICTION, BEGAN, HELD = StationSum
"""Sums of a `StationLedger`: mass through the stations along x (kg/m); energies (J/m), those carried and handed on in
less out."""


class StationLedger:
    """Energy between two stations that move, summed at every step; nothing where the scene has none.

    In the frame of the stations, kinetic energy of the half step v_(n-1/2) and the height half a step back belong
    together: the work of weight then is the change of the gravitational energy, to round-off. What is left over
    is the work of springs: elastic energy, and the error of its integration.

    Attributes
    ----------
    sums : ndarray, shape (9,)
        Since the first step; all that a resumed run needs.
    """

    def __init__(self, scene: Scene, loops: Loops, on: bool):
        self._loops = loops
        self.scene, self.stations, self.sums = scene, scene.stations if on else None, np.zeros(9)

    def next_after(self, step: int) -> float:
        """Step at which `add` sees the discs next, after `step`; infinite for never."""
        stations = self.stations
        if stations is None or step >= stations.last_step:
            return inf
        return max(stations.first_step, step + 1)

    def add(self, step: int, state: State) -> None:
        """Take in the discs at a step of `next_after`, with its forces and the pairs that they were made with."""
        stations = self.stations
        assert stations is not None  # else `next_after` names no step
        left = stations.x[0] + stations.speed * (step - stations.first_step) * self.scene.time_step
        moved, pushed = step > stations.first_step, step < stations.last_step
        at = StationStep(left, stations.x[1] - stations.x[0], stations.speed, moved, pushed)
        self._loops.between(state, at, self.sums)
        if step == stations.first_step:
            self.sums[BEGAN] = self.sums[HELD]

    def heads(self, step: int) -> dict[str, float]:
        """The budget up to a step: discharge (m^2/s) and heads (m), energies over g and the mass that came in.

        With it are the places at its begin (m), the speed (m/s) and the time (s) of the stations. `lost` is what
        dashpots and friction take; `residual` is what came in, less stored, less lost.
        """
        stations = self.stations
        if stations is None or step <= stations.first_step:
            return {}
        seconds = (min(step, stations.last_step) - stations.first_step) * self.scene.time_step
        left, right, *energies = self.sums
        mass = left if left + right > 0 else -right  # through the station upstream
        scale = mass * abs(self.scene.gravity[1])
        heads = [energy / scale if scale > 0 else float("nan") for energy in energies]
        carried, contacts, walls, dashpots, friction, began, held = map(float, heads)
        storage, lost = held - began, dashpots + friction
        return {
            "stations_left": stations.x[0],
            "stations_right": stations.x[1],
            "stations_speed": stations.speed,
            "stations_begin": self.scene.time(stations.first_step),
            "stations_end": self.scene.time(min(step, stations.last_step)),
            "stations_discharge": float(mass) / (self.scene.density * seconds),
            "stations_carried": carried,
            "stations_contacts": contacts,
            "stations_walls": walls,
            "stations_storage": storage,
            "stations_dashpots": dashpots,
            "stations_friction": friction,
            "stations_lost": lost,
            "stations_residual": carried + contacts + walls - storage - lost,
        }
