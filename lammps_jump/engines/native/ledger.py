# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy of the discs at a step (thesis 4.28), and the energy balance of the run with its losses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lammps_jump.scene.scene import Scene


@dataclass(frozen=True)
class Energy:
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
    return scene.coefficients.inertia * scene.radius**2


def shares(scene: Scene, radius: np.ndarray | None) -> float | np.ndarray:
    """Mass over the nominal mass: 1 of equal discs, else of discs of these radii (m); its square is that of inertia."""
    return 1.0 if radius is None else (radius / scene.radius) ** 2


def shares_of(scene: Scene, discs) -> float | np.ndarray:
    """`shares` of the discs in play, shape (n,)."""
    return shares(scene, None if discs.radius is None else discs.radius[: discs.n])


def half_kicks(scene: Scene, discs) -> tuple[float | np.ndarray, float | np.ndarray]:
    """dt / (2 m) and dt / (2 I) of the discs in play: what force and torque add to velocity and spin in half a step."""
    share, half = shares_of(scene, discs), 0.5 * scene.time_step
    return half / scene.mass / share, half / inertia(scene) / share**2


def velocities(scene: Scene, discs) -> tuple[np.ndarray, np.ndarray]:
    """Velocities at the step, v_n = v_(n-1/2) + dt F_n / (2 m): two arrays of shape (n,), m/s."""
    n, (half, _) = discs.n, half_kicks(scene, discs)
    return discs.vx[:n] + half * discs.fx[:n], discs.vy[:n] + half * discs.fy[:n]


def spin(scene: Scene, discs) -> np.ndarray:
    """Angular velocities at the step, shape (n,), rad/s."""
    return discs.omega[: discs.n] + half_kicks(scene, discs)[1] * discs.torque[: discs.n]


def energy_of(scene: Scene, discs, elastic: float) -> Energy:
    """Kinetic and gravitational (-m g . x) energy of the discs at the step, with the elastic energy given (J per m)."""
    n, share = discs.n, shares_of(scene, discs)
    vx, vy = velocities(scene, discs)
    kinetic = 0.5 * scene.mass * float((share * vx) @ vx + (share * vy) @ vy)
    if discs.omega is not None:
        turn = spin(scene, discs)
        kinetic += 0.5 * inertia(scene) * float((share**2 * turn) @ turn)
    gx, gy = scene.gravity
    gravitational = -scene.mass * float(gx * (share * discs.x[:n]).sum() + gy * (share * discs.y[:n]).sum())
    return Energy(kinetic, gravitational, elastic)


def free_energy(scene: Scene, x, y, vx, vy, share=1.0) -> float:
    """Kinetic and gravitational energy at the step (J per m) of free discs with half-step velocity (vx, vy).

    `share` is their mass over the nominal mass (see `shares`).
    """
    gx, gy = scene.gravity
    half = 0.5 * scene.time_step
    wx, wy = vx + half * gx, vy + half * gy
    return scene.mass * float(np.sum(share * (0.5 * (wx * wx + wy * wy) - gx * x - gy * y)))


def energy_of_leaving(scene: Scene, discs, leaving: np.ndarray) -> tuple[float, float]:
    """`free_energy` and energy of rotation (J per m) that discs take with them; `leaving` is a mask of shape (n,)."""
    chosen = np.flatnonzero(leaving)
    share = shares(scene, None if discs.radius is None else discs.radius[chosen])
    free = free_energy(scene, discs.x[chosen], discs.y[chosen], discs.vx[chosen], discs.vy[chosen], share)
    if discs.omega is None:
        return free, 0.0
    return free, 0.5 * inertia(scene) * float((share**2 * discs.omega[chosen] ** 2).sum())


def half_work(scene: Scene, discs) -> np.ndarray:
    """Energy that (dashpots, friction) take in the first half of this step's kick, J per m, shape (2,)."""
    n, (half, half_turn) = discs.n, half_kicks(scene, discs)
    wx, wy = discs.vx[:n] + 0.5 * half * discs.fx[:n], discs.vy[:n] + 0.5 * half * discs.fy[:n]
    lost = float(discs.dash_x[:n] @ wx + discs.dash_y[:n] @ wy)
    slid = 0.0
    if discs.slide_x is not None:
        slid = float(discs.slide_x[:n] @ wx + discs.slide_y[:n] @ wy)
        if discs.omega is not None:
            turn = discs.omega[:n] + 0.5 * half_turn * discs.torque[:n]
            slid += float(discs.torque[:n] @ turn)
    return -0.5 * scene.time_step * np.array([lost, slid])


def close(start: Energy, now: Energy, exchanged: dict[str, float], work: np.ndarray) -> dict[str, float]:
    """The energy ledger, J per m of width.

    Present energy (kinetic, gravitational, elastic), the energy at the start (`initial`), `brought_in`, `carried_out`,
    `released_by_gates` (the elastic energy of their contacts), dissipated by dashpots and by friction. The work of a
    dissipative force over a kick is dt F . v_n, exact for the kick; `residual` = present + carried out + released +
    dissipated - initial - brought in is therefore the error of the time integration of springs and weight alone. It
    is of second order: at first touch the spring overworks by k (v dt)^2 / 12 in the mean over entry phases, at parting
    it gives the same back at the lower speed, h^2 (1 - e^2) / 6 of a collision's energy with h = omega dt.
    `throughput` is what to measure it against: kinetic and elastic energy at the start, the change of the gravitational
    energy, and what came in.
    """
    dashpots, friction = (float(w) for w in work)
    found = {
        "initial": start.total,
        "kinetic": now.kinetic,
        "gravitational": now.gravitational,
        "elastic": now.elastic,
        **exchanged,
        "dissipated_dashpots": dashpots,
        "dissipated_friction": friction,
    }
    gone = found["carried_out"] + found["released_by_gates"] + dashpots + friction
    found["residual"] = now.total + gone - start.total - found["brought_in"]
    moved = abs(start.gravitational - now.gravitational)
    found["throughput"] = start.kinetic + start.elastic + moved + abs(found["brought_in"])
    return found
