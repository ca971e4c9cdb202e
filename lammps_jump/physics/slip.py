# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction laws by name, and those that are too steep below sliding for the step that a case asks for."""

from __future__ import annotations

from typing import NamedTuple

from .contact import Coefficients, peak_force

SLIP_MODES = {False: 3.0, True: 12.0}
"""Fastest decay of slip in a hexagonal packing over gamma_t, without and with spin (a pair: 1 and 3; derived)."""
SIGN_RAMP = 0.01
"""eps / v_max of the sign law (thesis 4.20)."""


class FrictionLaw(NamedTuple):
    """What distinguishes a friction law; `law.friction_force` is its formula.

    Attributes
    ----------
    ramp : float or None
        Slip below which friction falls to 0, over v_max; None: LAMMPS' viscous ramp.
    in_stock : bool
        The styles that come with LAMMPS have it.
    remembers : bool
        Contacts have a tangential spring.
    """

    ramp: float | None
    in_stock: bool
    remembers: bool = False


FRICTION_LAWS = {"hooke": FrictionLaw(None, True), "sign": FrictionLaw(SIGN_RAMP, False)}
"""Friction laws by their names in a case."""


def slip_warnings(c: Coefficients, law: str, spin: bool, smallest: float = 1.0) -> list[str]:
    """A warning where friction turns the slip round every step: rate x step > 2, explicit in time.

    With a ramp eps: rate = ks F / (m_eff eps), with F the peak force of a collision at v_max, three times that with
    spin; at e = 1 and eps = v_max/100 this is 200 f ks a step. With the viscous ramp: gamma_t in the densest packing.
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
    if not c.friction:
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
        f"round every step (noisy, though bounded by ks F_n): {advice}"
    ]
