# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction laws by name, and those that are too steep below sliding for the step that a case asks for."""

from __future__ import annotations

from math import pi, sqrt
from typing import NamedTuple

from .contact import Coefficients, lagged_stable_h, peak_force
from .elementary import asin

SLIP_MODES = {False: 3.0, True: 12.0}
"""Fastest decay of slip in a hexagonal packing over gamma_t, without and with spin (a pair: 1 and 3; derived)."""
SIGN_RAMP = 0.01
"""eps / v_max of the sign law (thesis 4.20)."""


class FrictionLaw(NamedTuple):
    """Traits of a friction law; `law.friction_force` is its formula.

    Attributes
    ----------
    ramp : float or None
        Slip below which friction falls to 0, over v_max; None: LAMMPS' viscous ramp.
    in_stock : bool
        The styles that come with LAMMPS have it.
    remembers : bool
        Contacts have a tangential spring (`law.slider`).
    """

    ramp: float | None
    in_stock: bool
    remembers: bool = False


FRICTION_LAWS = {
    "viscous": FrictionLaw(None, True),
    "sign": FrictionLaw(SIGN_RAMP, False),
    "history": FrictionLaw(None, True, True),
}
"""Friction laws by their names in a case."""


class Rolling(NamedTuple):
    """Rolling resistance: a spring against rolling that slides at friction times the normal force.

    Attributes
    ----------
    friction : float
        Coefficient of rolling friction.
    stiffness_ratio, damping : float
        Stiffness and dashpot over those of a contact of nominal discs.
    """

    friction: float
    stiffness_ratio: float
    damping: float


class Springs(NamedTuple):
    """Springs with memory.

    Attributes
    ----------
    tangential_ratio, tangential_damping_ratio : float
        Stiffness and dashpot of the tangential spring over the normal ones of the same contact.
    rolling : Rolling or None
    """

    tangential_ratio: float = 2.0 / 7.0
    tangential_damping_ratio: float = 1.0
    rolling: Rolling | None = None


AT_WALLS = 4
"""Slots for contacts with walls."""


def slots_of(smallest: float, largest: float) -> int:
    """Slots that a disc needs for the neighbours it remembers and for walls.

    Of two discs the one with the larger id remembers, so that a disc may have to remember all its neighbours: as many
    of the smallest as fit around the largest, overlapping by a tenth of the smaller diameter.

    Parameters
    ----------
    smallest, largest : float
        Diameters, m.
    """
    apart = 0.5 * (smallest + largest) - 0.1 * smallest
    return int(pi / asin(min(1.0, 0.45 * smallest / apart))) + AT_WALLS


def springs_stable_fraction(xi: float, springs: Springs, spin: bool) -> float:
    """Largest step at which tangential springs are stable in a hexagonal packing, as a fraction f of 2/omega.

    With spin the fastest mode is that of discs that all turn alike: each of the six contacts slips by 2 R omega, so
    that its frequency is sqrt(12 kt/k) of a pair's and its damping 12 ct/c (derived; the largest over all wave numbers
    for kt/k above a quarter). Without it the fastest is that of rows that pass each other, sqrt(3 + kt/k).

    Parameters
    ----------
    xi : float
        Damping ratio of a pair.
    springs : Springs
    spin : bool
    """
    tangential, damping = springs.tangential_ratio, springs.tangential_damping_ratio
    modes = [(sqrt(3.0 + tangential), 3.0 + damping)]
    if spin:
        modes.append((sqrt(max(12.0 * tangential, 1e-6)), 12.0 * damping))
    return min(lagged_stable_h(xi * rate / ratio) / ratio / 2.0 for ratio, rate in modes)


def spring_warnings(c: Coefficients, springs: Springs | None, spin: bool) -> list[str]:
    """A warning where tangential springs are unstable: they turn round every step, until Coulomb's bound holds them."""
    if springs is None or not c.friction:
        return []
    limit = springs_stable_fraction(c.damping_ratio * c.correction, springs, spin)
    if c.time_step_fraction <= limit:
        return []
    return [
        f"friction_law history: tangential springs are stable up to time_step_fraction {limit:.2g}; above it discs at "
        f"rest tremble, at most by what sliding allows: lower run.time_step_fraction to {limit:.2g}"
        + (" or contact.tangential_damping_ratio" if springs.tangential_damping_ratio else "")
    ]


def slip_warnings(c: Coefficients, law: str, spin: bool, smallest: float = 1.0) -> list[str]:
    """A warning where friction turns the slip round every step: rate x step > 2, explicit in time.

    With a ramp eps: rate = μ F / (m_eff eps), with F the peak force of a collision at v_max, three times that with
    spin; at e = 1 and eps = v_max/100 this is 200 f μ a step. With the viscous ramp: gamma_t in the densest packing.
    Coulomb's bound holds the slip: it chatters, and round-off grows; it does not blow up.

    Parameters
    ----------
    c : Coefficients
    law : str
        Of `FRICTION_LAWS`.
    spin : bool
    smallest : float
        Smallest diameter over the nominal one: dashpots grow as sqrt(m), so rates as 1/sqrt(m), that is 1/d.
    """
    if not c.friction or FRICTION_LAWS[law].remembers:
        return []
    ramp = FRICTION_LAWS[law].ramp
    if ramp is not None:
        load = peak_force(1.0, c.damping_ratio, max(c.omega, c.omega_wall), 1.0)
        rate, where = c.friction * load / ramp * (3.0 if spin else 1.0), "the hardest collisions"
    else:
        rate, where = max(c.gamma_tangential, c.gamma_tangential_wall) * SLIP_MODES[spin], "dense packings"
    size = rate / smallest * c.time_step
    if size <= 2.0:
        return []
    fraction = f"{c.time_step_fraction * 2.0 / size:.2g}"
    advice = f"lower run.time_step_fraction to {fraction}"
    if ramp is None:
        advice += f", or contact.tangential_damping to {c.gamma_tangential * 2.0 / size:.3g} 1/s"
    return [
        f"friction_law {law}: below sliding, friction damps by {size:.2g} a step in {where}; above 2 the slip turns "
        f"round every step (noisy, though bounded by μ F_n): {advice}"
    ]
