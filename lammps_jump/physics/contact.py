# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact coefficients: from what a case says of a collision to spring, dashpot, friction and time step.

Pure functions, one equation each, cited as "thesis (3.20)" for T-4359, Colorado School of Mines, and as a named
derivation where the thesis is silent. Symbols: m_eff effective mass (m/2 of a pair, m at a wall), omega =
sqrt(k/m_eff), xi damping ratio, h = omega dt, f = dt / (2/omega of a pair).
"""

# ruff: noqa: RUF001  (Greek letters are meant for readers)
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import nan, pi, sqrt
from typing import NamedTuple

from lammps_jump.units import number

from .elementary import acos, asin, atan2, exp, log


def disc_mass(density: float, diameter: float) -> float:
    """Mass of a disc per metre of width, kg: m = rho d^2 (thesis 3.3; the energy box's 5760 J confirms it)."""
    return density * (diameter * diameter)


def stiffness(density: float, largest_overlap: float, impact_speed: float) -> float:
    """Normal stiffness, N/m: k = rho n^2 v0^2, 1/n the largest overlap at the speed v0 over d (thesis 3.20)."""
    n = 1.0 / largest_overlap
    return density * (n * n) * (impact_speed * impact_speed)


def material_stiffness(young: float, poisson: float) -> float:
    """Normal stiffness, N/m, of equal elastic cylinders along a line of 1 m: k = pi E* / 4, E* = E / (2 (1 - nu^2)).

    A line contact of half-width a carries P = pi E* a^2 / (4 R) (Johnson, Contact Mechanics, 1985, 4.2c). With a^2/R
    for its depth that is P = pi E* depth / 4, whatever the radius (docs/theory.md).

    Parameters
    ----------
    young : float
        E, Pa.
    poisson : float
    """
    return pi * young / (8.0 * (1.0 - poisson * poisson))


def damping_ratio(restitution: float) -> float:
    """Share of critical damping xi = ln(1/e) / sqrt(pi^2 + ln^2(1/e)) (thesis 3.21)."""
    loss = log(1.0 / restitution)
    return loss / sqrt(pi * pi + loss * loss)


def restitution_of(ratio: float) -> float:
    """Restitution coefficient of a damping ratio xi < 1: e = exp(-pi xi / sqrt(1 - xi^2)) (thesis 3.21, inverted)."""
    return exp(-pi * ratio / sqrt(1.0 - ratio * ratio))


def damping(restitution: float, stiffness: float, effective_mass: float) -> float:
    """Dashpot, N s/m: c = 2 ln(1/e) sqrt(k m_eff / (pi^2 + ln^2(1/e))) (thesis 3.21-3.23)."""
    return 2.0 * damping_ratio(restitution) * sqrt(stiffness * effective_mass)


def angular_frequency(stiffness: float, effective_mass: float) -> float:
    """Undamped contact frequency omega = sqrt(k / m_eff), rad/s (thesis 3.24)."""
    return sqrt(stiffness / effective_mass)


def critical_time_step(stiffness: float, mass: float) -> float:
    """Largest stable step of an undamped contact of two discs, s: 2/omega with m_eff = m/2 (thesis 3.24)."""
    return 2.0 / angular_frequency(stiffness, mass / 2.0)


def contact_duration(restitution: float, omega: float) -> float:
    """Time from touch to parting, s: t_c = pi / (omega sqrt(1 - xi^2)) (linear spring and dashpot, exact)."""
    return pi / (omega * sqrt(1.0 - damping_ratio(restitution) ** 2))


def largest_overlap(speed: float, restitution: float, omega: float) -> float:
    """Largest overlap of one collision, m: (v/omega) exp(-(xi/s) atan2(s, xi)), s = sqrt(1 - xi^2) (exact)."""
    xi = damping_ratio(restitution)
    s = sqrt(1.0 - xi * xi)
    return speed / omega * exp(-xi / s * atan2(s, xi))


def peak_force(speed: float, xi: float, omega: float, effective_mass: float) -> float:
    """Largest force of one collision, N/m: max over the contact of k delta + c delta_dot.

    With alpha = asin(xi) the force is ``m_eff omega v exp(-xi omega t) sin(omega s t + 2 alpha) / s``: its maximum
    ``m_eff omega v exp(-(xi/s)(pi/2 - 3 alpha))`` lies inside the contact for xi < 1/2, else at first touch, where
    the dashpot alone gives ``2 xi m_eff omega v`` (linear spring and dashpot, exact).

    Parameters
    ----------
    speed : float
        Approach speed, m/s.
    xi : float
        Damping ratio, 0 <= xi < 1.
    omega : float
        Undamped contact frequency, rad/s.
    effective_mass : float
        m/2 of a pair, m at a wall, kg.
    """
    if xi >= 0.5:
        return 2.0 * xi * effective_mass * omega * speed
    s = sqrt(1.0 - xi * xi)
    return effective_mass * omega * speed * exp(-xi / s * (pi / 2 - 3.0 * asin(xi)))


def lagged_restitution(xi: float, h: float) -> float:
    """Mean restitution of velocity Verlet with the dashpot fed by the half-step velocity (LAMMPS).

    One step inside the contact multiplies the state by a complex pair of modulus sqrt(1 - 2 xi h) and angle
    theta = acos((2 - h^2 - 2 xi h) / (2 sqrt(1 - 2 xi h))); half a turn ends the contact:
    e = exp[(pi / (2 theta)) ln(1 - 2 xi h)]. Derived; the wheel reproduces it to the scatter of the entry phase.

    Parameters
    ----------
    xi : float
        Damping ratio, 0 <= xi < 1.
    h : float
        omega dt.
    """
    if xi == 0.0:
        return 1.0
    decay = 1.0 - 2.0 * xi * h
    cosine = (2.0 - h * h - 2.0 * xi * h) / (2.0 * sqrt(decay)) if decay > 0 else -1.0
    if decay <= 0 or abs(cosine) >= 1.0:
        return 0.0  # over-damped in discrete time: the disc does not leave
    return exp(pi / (2.0 * acos(cosine)) * log(decay))


def extrapolated_restitution(xi: float, h: float) -> float:
    """Mean restitution of the thesis' leap-frog, whose dashpot sees v_n = 1.5 v_(n-1/2) - 0.5 v_(n-3/2) (3.7-3.9).

    One step inside the contact has the characteristic equation ``l^3 + (h^2 - 2 + 3 xi h) l^2 + (1 - 4 xi h) l +
    xi h = 0``: a small real root r (the memory of the extrapolation) and a complex pair of modulus^2 ``-xi h / r``
    and angle theta; half a turn ends the contact: e = exp[(pi / (2 theta)) ln(modulus^2)] (derived).

    Parameters
    ----------
    xi : float
        Damping ratio, 0 <= xi < 1.
    h : float
        omega dt, below `extrapolated_stable_h`.
    """
    if xi == 0.0:
        return 1.0
    a, b, c = h * h - 2.0 + 3.0 * xi * h, 1.0 - 4.0 * xi * h, xi * h
    low, high = -1.0, 0.0  # the cubic is below 0 at -1 where the step is stable, and above 0 at 0
    while low < (middle := 0.5 * (low + high)) < high:
        if ((middle + a) * middle + b) * middle + c < 0.0:
            low = middle
        else:
            high = middle
    square = -c / high  # of the pair's modulus
    cosine = -0.5 * (a + high) / sqrt(square)
    if abs(cosine) >= 1.0:
        return 0.0  # over-damped in discrete time: the disc does not leave
    return exp(pi / (2.0 * acos(cosine)) * log(square))


@lru_cache(maxsize=1024)  # cases have the same few again and again, and 80 rounded exponentials take a millisecond
def lagged_correction(restitution: float, h: float) -> float:
    """Factor on the dashpot that makes `lagged_restitution` equal the wanted one; 1 for e = 1.

    Bisection on the monotone closed form; at e = 0.2 and f = 0.05 it is 0.9775.
    """
    xi = damping_ratio(restitution)
    if xi == 0.0:
        return 1.0
    low, high = 0.0, 1.5
    for _ in range(80):
        middle = 0.5 * (low + high)
        if lagged_restitution(middle * xi, h) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def lagged_stable_h(xi: float) -> float:
    """Largest stable omega dt with the lagged dashpot: h_c = 2 (sqrt(1 + xi^2) - xi) (Belytschko's estimate)."""
    return 2.0 * (sqrt(1.0 + xi * xi) - xi)


def extrapolated_stable_h(xi: float) -> float:
    """Largest stable omega dt of the thesis' scheme (3.7-3.9): h_c = 2 (sqrt(1 + 4 xi^2) - 2 xi) (derived)."""
    return 2.0 * (sqrt(1.0 + 4.0 * xi * xi) - 2.0 * xi)


PACKING_FREQUENCY = {"pair": 1.0, "square": sqrt(2.0), "hexagonal": sqrt(3.0)}
"""Highest lattice frequency over that of a pair: square 2 sqrt(k/m), hexagonal sqrt(6 k/m) (derived)."""


def stable_fraction(xi: float, integrator: str, packing: str = "hexagonal") -> float:
    """Largest stable step as a fraction f of 2/omega of the pair, in a dense packing.

    Damping acts through the same network as the springs, so a mode r times stiffer in frequency is r times more
    damped: r h = h_c(r xi).

    Parameters
    ----------
    xi : float
        Damping ratio of a pair.
    integrator : {'velocity_verlet', 'leapfrog_extrapolated'}
    packing : {'pair', 'square', 'hexagonal'}
    """
    ratio = PACKING_FREQUENCY[packing]
    limit = lagged_stable_h if integrator == "velocity_verlet" else extrapolated_stable_h
    return limit(xi * ratio) / ratio / 2.0


def wall_stable_fraction(
    stiffness: float, stiffness_wall: float, mass: float, damping: float, damping_wall: float, integrator: str
) -> float:
    """Stable step, as a fraction f of 2/omega of the pair, of a hexagonal bed's lowest row on a stiffer wall.

    Bound (Gershgorin): a disc on the wall carries k_wall + 1.5 k against vertical motion and is tied to its upper
    neighbours by as much as 1.5 k more, dashpots likewise, so omega^2 <= (k_wall + 3 k)/m. It rules for k_wall > 3 k
    only, where it is up to 10 % below the exact limit (derived; eigenvalues in the tests).

    Parameters
    ----------
    stiffness, stiffness_wall : float
        N/m.
    mass : float
        kg.
    damping, damping_wall : float
        Dashpots, N s/m.
    integrator : {'velocity_verlet', 'leapfrog_extrapolated'}
    """
    omega = sqrt((stiffness_wall + 3.0 * stiffness) / mass)
    xi = (damping_wall + 3.0 * damping) / (2.0 * mass * omega)
    limit = lagged_stable_h if integrator == "velocity_verlet" else extrapolated_stable_h
    return limit(xi) / omega / critical_time_step(stiffness, mass)


class WallLaw(NamedTuple):
    """Contact of a nominal disc with a wall: stiffness (N/m), gamma_n and gamma_t (1/s), friction coefficients.

    `rolling` is None where it is that of the scene.
    """

    stiffness: float
    gamma_normal: float
    gamma_tangential: float
    friction: float
    rolling: float | None = None


@dataclass(frozen=True)
class Coefficients:
    """Everything the engines need of a contact, in SI; made once by `derive`.

    ``damping*`` are the nominal dashpots of thesis (3.21); ``gamma_*`` (1/s) are what the engines use: force =
    m_eff gamma v, the correction of the integrator's restitution included. ``slip_speed`` is where the viscous ramp
    m_eff gamma_t v_t of a pair reaches Coulomb's μ F_n under the `peak_force` of a collision at v0; lighter loads
    slip at proportionally lower speeds. ``stable_fraction`` is the lesser of a hexagonal bed's and its lowest row's.
    """

    mass: float = number("kg/m", "disc mass m = ρd²", label="mass m = rho d^2")
    restitution: float = number("", "restitution coefficient e", label="restitution e")
    friction: float = number("", "friction coefficient μ", label="friction μ")
    stiffness: float = number("N/m", "stiffness k, disc-disc", label="stiffness k")
    stiffness_wall: float = number("N/m", "stiffness k, disc-wall", label="stiffness at walls")
    damping_ratio: float = number("", "damping ratio ξ", label="damping ratio xi")
    damping: float = number("N s/m", "dashpot c, disc-disc", label="damping c, pair (3.21)")
    damping_wall: float = number("N s/m", "dashpot c, disc-wall", label="damping c, wall")
    correction: float = number("", "dashpot correction, disc-disc", label="restitution correction, pair")
    correction_wall: float = number("", "dashpot correction, disc-wall", label="restitution correction, wall")
    gamma_normal: float = number("1/s", "γn, disc-disc", label="gamma_n pair = c/(m/2), corrected")
    gamma_normal_wall: float = number("1/s", "γn, disc-wall", label="gamma_n wall = c/m, corrected")
    gamma_tangential: float = number("1/s", "γt, disc-disc", label="gamma_t pair")
    gamma_tangential_wall: float = number("1/s", "γt, disc-wall", label="gamma_t wall")
    omega: float = number("rad/s", "contact frequency ω, disc-disc")
    omega_wall: float = number("rad/s", "contact frequency ω, disc-wall")
    time_step: float = number("s", "time step")
    critical_time_step: float = number("s", "critical time step 2/ω", label="critical time step 2/omega (3.24)")
    time_step_fraction: float = number("", "time step over 2/ω")
    stable_fraction: float = number("", "largest stable fraction, densest packing")
    contact_duration: float = number("s", "contact duration")
    contact_steps: float = number("", "steps per contact", label="contact duration in steps")
    slip_speed: float = number(
        "m/s",
        "slip speed where Coulomb friction takes over",
        label="slip speed where Coulomb takes over (at the peak load of v0)",
    )
    largest_overlap: float = number("m", "largest overlap at the reference speed", label="largest overlap at v0, pair")

    @property
    def tangential_ratio(self) -> float:
        """Tangential dashpot over the normal one, gamma_t/gamma_n of a pair; NaN without a normal one."""
        return self.gamma_tangential / self.gamma_normal if self.gamma_normal else nan

    @property
    def tangential_ratio_wall(self) -> float:
        """The same at walls."""
        return self.gamma_tangential_wall / self.gamma_normal_wall if self.gamma_normal_wall else nan

    @property
    def pair_law(self) -> WallLaw:
        """Contact of two nominal discs, as of one with a wall."""
        return WallLaw(self.stiffness, self.gamma_normal, self.gamma_tangential, self.friction)

    @cached_property
    def wall_law(self) -> WallLaw:
        """Contact with a wall that has no numbers of its own."""
        return WallLaw(self.stiffness_wall, self.gamma_normal_wall, self.gamma_tangential_wall, self.friction)

    def restitution_of_pair(self, ratio: float, integrator: str) -> float:
        """Mean restitution, in steps, of two discs whose diameter is `ratio` times the nominal one (sharp touch).

        All pairs have the same damping ratio. Small discs have fewer steps in a contact, so a larger bias of the step.
        """
        mean = lagged_restitution if integrator == "velocity_verlet" else extrapolated_restitution
        return mean(self.damping_ratio * self.correction, self.omega / ratio * self.time_step)

    @property
    def inertia(self) -> float:
        """Moment of inertia of a uniform disc over R^2, kg: I / R^2 = m/2."""
        return 0.5 * self.mass


TANGENTIAL_RATE = 3.0
"""gamma_t = 3 omega (1 omega with spin): the viscous ramp dies out in a third of a contact's time constant, and
the densest packing (three times the rate of a pair) still decays without ringing at f = 0.05."""

SMOOTH_SHARE = 0.5
"""Share of `lagged_correction` for a smooth touch: a contact that starts soft is better resolved, and lags less.

The factor with the least largest error over impact speeds of 0.05 … 2 v0, widths of 1 … 4 steps, e = 0.1 … 0.6 and
f = 0.05 … 0.2 takes 0.33 … 0.71 of it, most of them near a half (docs/kernels.md)."""


@dataclass(frozen=True)
class ContactNumbers:
    """Contact numbers of a case, of nominal discs.

    Attributes
    ----------
    density, diameter : float
        kg/m^3, m.
    restitution, friction : float
        e in (0, 1], μ >= 0.
    stiffness, stiffness_wall : float
        N/m.
    impact_speed : float
        v0, m/s: the speed at which the slip speed and the largest overlap are quoted.
    time_step_fraction : float
        f of 2/omega.
    integrator : {'velocity_verlet', 'leapfrog_extrapolated'}
    correct_restitution : bool
        Scale the dashpot so that velocity Verlet's lagged damping gives the wanted restitution.
    rotation : bool
    tangential_damping : float, optional
        gamma_t in 1/s; default `TANGENTIAL_RATE` omega.
    tangential_damping_ratio : float, optional
        gamma_t over gamma_n of contacts with a tangential spring; it goes before the field above.
    touch : {'sharp', 'smooth'}
        A smooth touch gets `SMOOTH_SHARE` of the correction.
    smallest : float, optional
        Smallest diameter, m, where discs are not equal: its pairs set the time step and the limits of stability. The
        correction of the dashpot is that of nominal pairs for all, so that one damping ratio holds for every contact.
    """

    density: float
    diameter: float
    restitution: float
    friction: float
    stiffness: float
    stiffness_wall: float
    impact_speed: float
    time_step_fraction: float
    integrator: str
    correct_restitution: bool
    rotation: bool
    tangential_damping: float | None = None
    tangential_damping_ratio: float | None = None
    touch: str = "sharp"
    smallest: float | None = None


def _side(
    given: ContactNumbers, time_step: float, k: float, effective_mass: float, restitution: float, friction: float
) -> dict[str, float]:
    """Coefficients of a pair or at a wall."""
    frequency, factor, dashpot = angular_frequency(k, effective_mass), 1.0, damping(restitution, k, effective_mass)
    if given.correct_restitution and given.integrator == "velocity_verlet":
        share = SMOOTH_SHARE if given.touch == "smooth" else 1.0
        factor -= share * (1.0 - lagged_correction(restitution, frequency * time_step))
    gamma = given.tangential_damping
    if given.tangential_damping_ratio is not None:
        gamma = given.tangential_damping_ratio * factor * dashpot / effective_mass
    elif gamma is None:
        gamma = TANGENTIAL_RATE / (3.0 if given.rotation else 1.0) * frequency
    return {
        "stiffness": k,
        "damping": dashpot,
        "correction": factor,
        "gamma_normal": factor * dashpot / effective_mass,
        "gamma_tangential": gamma if friction else 0.0,
        "omega": frequency,
    }


def own_wall_law(
    coefficients: Coefficients,
    own: tuple[float | None, float | None, float | None, float | None],
    given: ContactNumbers,
) -> WallLaw:
    """Contact with a wall that has numbers of its own.

    Parameters
    ----------
    coefficients : Coefficients
        Of the scene: what the wall takes where it has none of its own.
    own : (float or None, float or None, float or None, float or None)
        Stiffness (N/m), restitution, friction coefficient and coefficient of rolling friction of the wall.
    given : ContactNumbers
        What the coefficients were derived from.
    """
    c = coefficients
    defaults = c.stiffness_wall, c.restitution, c.friction
    stiffness, restitution, friction = (b if a is None else a for a, b in zip(own[:3], defaults, strict=True))
    side = _side(given, c.time_step, stiffness, c.mass, restitution, friction)
    return WallLaw(stiffness, side["gamma_normal"], side["gamma_tangential"], friction, own[3])


def own_stable_fraction(coefficients: Coefficients, law: WallLaw, smallest: float, integrator: str) -> float:
    """`wall_stable_fraction` of a wall with a contact of its own.

    Parameters
    ----------
    coefficients : Coefficients
        Of the scene.
    law : WallLaw
        Of the wall.
    smallest : float
        Smallest diameter over the nominal one.
    integrator : {'velocity_verlet', 'leapfrog_extrapolated'}
    """
    c = coefficients  # dashpots grow with the root of the mass, which grows with the square of the diameter
    return wall_stable_fraction(
        c.stiffness,
        law.stiffness,
        c.mass * smallest * smallest,
        c.correction * c.damping * smallest,
        law.gamma_normal * c.mass * smallest,
        integrator,
    )


def derive(given: ContactNumbers) -> Coefficients:
    """All contact coefficients of a case, of nominal discs."""
    restitution, friction, integrator = given.restitution, given.friction, given.integrator
    mass = disc_mass(given.density, given.diameter)
    least = disc_mass(given.density, given.smallest or given.diameter)
    critical = critical_time_step(given.stiffness, least)
    time_step = given.time_step_fraction * critical
    pair = _side(given, time_step, given.stiffness, mass / 2, restitution, friction)
    wall = _side(given, time_step, given.stiffness_wall, mass, restitution, friction)
    xi, omega = damping_ratio(restitution), pair["omega"]
    load = peak_force(given.impact_speed, xi, omega, mass / 2)
    return Coefficients(
        mass=mass,
        restitution=restitution,
        friction=friction,
        **pair,
        **{f"{name}_wall": value for name, value in wall.items()},
        damping_ratio=xi,
        time_step=time_step,
        critical_time_step=critical,
        time_step_fraction=given.time_step_fraction,
        stable_fraction=min(
            stable_fraction(xi * pair["correction"], integrator),
            wall_stable_fraction(
                given.stiffness,
                given.stiffness_wall,
                least,
                pair["correction"] * damping(restitution, given.stiffness, least / 2),
                wall["correction"] * damping(restitution, given.stiffness_wall, least),
                integrator,
            ),
        ),
        contact_duration=contact_duration(restitution, omega),
        contact_steps=contact_duration(restitution, omega) / time_step,
        slip_speed=friction * load / (mass / 2 * pair["gamma_tangential"]) if pair["gamma_tangential"] else 0.0,
        largest_overlap=largest_overlap(given.impact_speed, restitution, omega),
    )
