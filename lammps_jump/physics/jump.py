# SPDX-License-Identifier: GPL-2.0-or-later
"""Open-channel hydraulics that runs are judged by: jump, inflow, sill, moving shocks, dam breaks, loads on walls.

Pure functions of floats, one equation each. "thesis (4.26)" is equation 4.26 of T-4359, Colorado School of Mines.
Depths are measured normal to a horizontal bed, quantities are per metre of width, SI.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import acos, cos, nan, pi, sqrt

from lammps_jump.units import number

from .measured import USBR_JUMP_CLASSES, USBR_JUMP_LENGTH

# --- the jump ---------------------------------------------------------------------------------------------------

GRAVITY = 9.81
"""m/s^2, where a caller has no case at hand."""
BRINK = 0.715
"""Depth at the brink of a free fall over the critical depth (Rouse 1936, Civil Engineering 6:257)."""
CONTRACTION = 0.61
"""Depth of the jet below a sharp gate over its opening (Henderson 1966, Open Channel Flow, section 6.3)."""


# --- moving shocks ----------------------------------------------------------------------------------------------


def relative_froude(velocity: float, depth: float, shock_speed: float, gravity: float = GRAVITY) -> float:
    """Froude number in the frame of a shock, (u - c) / sqrt(g s); s the mass depth, c the shock's velocity (m/s)."""
    return (velocity - shock_speed) / sqrt(gravity * depth)


def shock_speed_from_mass(depth_1: float, velocity_1: float, depth_2: float, velocity_2: float) -> float:
    """Velocity of a shock between two states, m/s: c = (s2 u2 - s1 u1) / (s2 - s1) (conservation of mass)."""
    return (depth_2 * velocity_2 - depth_1 * velocity_1) / (depth_2 - depth_1)


def reflected_bore(depth: float, velocity: float, gravity: float = GRAVITY) -> tuple[float, float]:
    """Bore thrown back by a wall that stops the flow: (depth at the wall in m, bore velocity in m/s, negative).

    Mass ``c = -s1 u1 / (s2 - s1)`` and momentum ``2 s1 s2 u1^2 = g (s1 + s2)(s2 - s1)^2``, solved by Brent's method.
    """
    from scipy.optimize import brentq  # 0.23 s

    def excess(s2: float) -> float:
        return gravity * (depth + s2) * (s2 - depth) ** 2 - 2.0 * depth * s2 * velocity**2

    high = 2.0 * depth
    while excess(high) < 0:
        high *= 2.0
    depth_2 = brentq(excess, depth, high, xtol=1e-300, rtol=1e-15)
    return depth_2, -depth * velocity / (depth_2 - depth)


# --- dam break --------------------------------------------------------------------------------------------------


def ritter_front(t: float, depth_0: float, gravity: float = GRAVITY) -> float:
    """Front of the dam break on a dry bed, m from the dam: 2 t sqrt(g h0) (Ritter 1892)."""
    return 2.0 * t * sqrt(gravity * depth_0)


def ritter_wall_time(reservoir_length: float, depth_0: float, gravity: float = GRAVITY) -> float:
    """Time when the rarefaction meets the back wall and Ritter ends to hold there, s: L0 / sqrt(g h0)."""
    return reservoir_length / sqrt(gravity * depth_0)


# --- loads on walls ---------------------------------------------------------------------------------------------


def hydrostatic_force(depth: float, density: float, gravity: float = GRAVITY, above: float = 0.0) -> float:
    """Force of water at rest on a vertical wall, N/m: rho g (H^2 - a^2) / 2; a is the depth of the wall's top, m."""
    return 0.5 * density * gravity * (depth**2 - above**2)


def froude(velocity: float, depth: float, gravity: float = GRAVITY) -> float:
    """Froude number u / sqrt(g y), without dimension; velocity in m/s, depth in m (> 0)."""
    return velocity / sqrt(gravity * depth)


def belanger(froude_1: float) -> float:
    """Sequent-depth ratio y2/y1 = (sqrt(1 + 8 Fr1^2) - 1) / 2 (thesis 4.26; Bélanger)."""
    return 0.5 * (sqrt(1.0 + 8.0 * froude_1**2) - 1.0)


def sequent_depth(velocity: float, depth: float, gravity: float = GRAVITY) -> float:
    """Sequent depth y2 in m of a flow of `velocity` (m/s) and `depth` (m), by thesis (4.26)."""
    return depth * belanger(froude(velocity, depth, gravity))


def sequent_ratio(
    froude_1: float, density_ratio: float = 1.0, resistance: float = 0.0, beta_1: float = 1.0, beta_2: float = 1.0
) -> float:
    """Ratio of mass depths S = s2/s1 over a jump with a change of density and a resisting bed.

    Largest root of ``2 Fr1^2 (beta_1 - beta_2/S) + 1 - S^2/R = K (1 + S)``: the momentum balance per width of a
    control volume with hydrostatic pressure on both ends (derived; the ingredients are those of Méjean, Faug & Einav
    2017, J. Fluid Mech. 816). The height ratio is ``H = S/R``. R = 1, K = 0, beta = 1 gives `belanger`.

    Parameters
    ----------
    froude_1 : float
        Upstream Froude number on the mass depth s1, in the frame of the jump.
    density_ratio : float
        R = rho2/rho1 of the bulk (hexagonal against square packing: 2/sqrt(3)).
    resistance : float
        K = kappa (mu_e - tan(slope)) L/h1: effective friction mu_e and slope over the length L, with kappa the mean
        weight of the jump over that of a trapezium of the end depths.
    beta_1, beta_2 : float
        Momentum coefficients of the velocity profiles up- and downstream.

    Raises
    ------
    ValueError
        The flow is subcritical (Fr1 < 1), or its momentum is too small against density change and resistance.
    """
    if froude_1 < 1 or density_ratio <= 0:
        raise ValueError(
            f"sequent_ratio: Froude number {froude_1:g} must be at least 1, density ratio {density_ratio:g} above 0"
        )
    # multiplied by S: a falling cubic with one maximum at positive S; the jump is the root beyond the maximum
    linear = 2.0 * froude_1**2 * beta_1 + 1.0 - resistance
    constant = 2.0 * froude_1**2 * beta_2
    discriminant, shift = resistance**2 + 3.0 * linear / density_ratio, -density_ratio * resistance / 3.0
    half = sqrt(max(discriminant, 0.0)) * density_ratio / 3.0
    top = half + shift
    if top <= 0 or ((linear - (top / density_ratio + resistance) * top) * top < (1.0 - 1e-12) * constant):
        raise ValueError(
            f"sequent_ratio: no jump at Froude number {froude_1:g}, density ratio {density_ratio:g}, resistance "
            f"{resistance:g}; the inflow needs more momentum (a larger Froude number)"
        )
    # Viète: the largest of three real roots, by the cosine of a third of an angle
    cosine = 0.5 * density_ratio * (constant - shift * (linear + 2.0 * shift**2 / density_ratio)) / half**3
    return shift - 2.0 * half * cos((acos(min(cosine, 1.0)) + 2.0 * pi) / 3.0)


def sloping_ratio(froude_1: float, weight: float) -> float:
    """Ratio of depths S = y2/y1 over a jump on a sloping bed, with the weight of the water between the two sections.

    Largest root of ``2 Fr1^2 (1 - 1/S) + 1 - S^2 + weight = 0``: momentum along the bed, with hydrostatic pressure
    (FHWA 2006, Hydraulic Engineering Circular 14, eq. 6.7, over g cos y1^2/2). Weight 0 gives `belanger`.

    Parameters
    ----------
    froude_1 : float
        u1/sqrt(g cos y1), in the frame of the jump; depths are measured across the bed.
    weight : float
        2 A tan(slope)/y1^2, with A the area of the water between the sections, m^2; positive where the bed falls along
        the stream. NaN where the weight holds back more than the stream brings.
    """
    linear, constant = 2.0 * froude_1**2 + 1.0 + weight, 2.0 * froude_1**2
    # Viète, of S^3 - linear S + constant = 0
    cosine = -1.5 * constant / linear * sqrt(3.0 / linear) if linear > 0 else -2.0
    return 2.0 * sqrt(linear / 3.0) * cos(acos(max(cosine, -1.0)) / 3.0) if cosine >= -1.0 - 1e-12 else nan


def downstream_froude(froude_1: float) -> float:
    """Froude number downstream of the jump, Fr2 = Fr1 / (y2/y1)^1.5 (continuity and thesis 4.26)."""
    return froude_1 / belanger(froude_1) ** 1.5


def specific_energy(depth: float, velocity: float, gravity: float = GRAVITY, alpha: float = 1.0) -> float:
    """Specific energy E = y + alpha u^2 / (2 g), m; upstream of a jump y1 (1 + Fr1^2/2)."""
    return depth + alpha * velocity**2 / (2.0 * gravity)


def energy_loss(depth_1: float, depth_2: float) -> float:
    """Head lost in a jump, m: (y2 - y1)^3 / (4 y1 y2) (continuity, thesis 4.26 and `specific_energy`)."""
    return (depth_2 - depth_1) ** 3 / (4.0 * depth_1 * depth_2)


def critical_depth(discharge: float, gravity: float = GRAVITY) -> float:
    """Critical depth y_c = (q^2/g)^(1/3), m; discharge in m^2/s."""
    return (discharge**2 / gravity) ** (1.0 / 3.0)


def critical_discharge(head: float, gravity: float = GRAVITY) -> float:
    """Discharge over a crest under a head (m) above it without loss, m^2/s: q = sqrt(g) (2 h / 3)^(3/2).

    The flow is critical there: its depth is two thirds of the head (Chow, Open-Channel Hydraulics, 1959, 3-7).
    """
    return sqrt(gravity) * (2.0 * head / 3.0) ** 1.5


def brink_depth(critical: float) -> float:
    """Depth at the brink of a free fall, m, by the critical depth: 0.715 y_c of a level bed (Rouse 1936)."""
    return BRINK * critical


def gate_discharge(opening: float, head: float, gravity: float = GRAVITY) -> float:
    """Discharge of water under a gate, free downstream, m^2/s: C a sqrt(2 g (H - C a)), C = 0.61.

    Opening a and head H over the bed, m; C is the contraction of a sharp edge (Henderson 1966, section 6.3). NaN where
    the head is no higher than the jet.
    """
    jet = CONTRACTION * opening
    return jet * sqrt(2.0 * gravity * (head - jet)) if head > jet else nan


def fast_depth(discharge: float, energy: float, gravity: float = GRAVITY) -> float:
    """Depth of the fast stream of a discharge (m^2/s) and a specific energy (m), m; NaN below that of critical flow.

    Smaller positive root of ``E = y + q^2/(2 g y^2)`` (Henderson 1966, Open Channel Flow, eq. 2-2), by the cosine of a
    third of an angle.
    """
    cosine = 1.0 - 6.75 * discharge**2 / (gravity * energy**3) if energy > 0 else -2.0
    return energy / 3.0 * (1.0 + 2.0 * cos((acos(cosine) + 4.0 * pi) / 3.0)) if cosine >= -1.0 else nan


def jump_class(froude_1: float) -> str:
    """Kind of jump: none, undular, weak, oscillating, steady, strong (USBR Engineering Monograph 25)."""
    return next(name for bound, name in USBR_JUMP_CLASSES if froude_1 <= bound)


# --- length of the jump -----------------------------------------------------------------------------------------


def silvester_jump_length(froude_1: float, depth_1: float) -> float:
    """Length of the jump, m: L_j = 9.75 y1 (Fr1 - 1)^1.01 (thesis 4.27; Silvester 1964); nan below Fr1 = 1."""
    return 9.75 * depth_1 * (froude_1 - 1.0) ** 1.01 if froude_1 >= 1 else nan


def usbr_jump_length(froude_1: float, depth_1: float) -> float:
    """Length of the jump, m: L/y2 read from the USBR curve (straight lines between its points) times y2 of (4.26).

    nan outside the curve's range, Fr1 = 1.6 … 19.2.
    """
    xs, ys = USBR_JUMP_LENGTH.x, USBR_JUMP_LENGTH.y
    if not xs[0] <= froude_1 <= xs[-1]:
        return nan
    i = next(i for i in range(1, len(xs)) if froude_1 <= xs[i])
    share = (froude_1 - xs[i - 1]) / (xs[i] - xs[i - 1])
    return (ys[i - 1] + share * (ys[i] - ys[i - 1])) * belanger(froude_1) * depth_1


def channel_length(froude_1: float, depth_1: float) -> float:
    """Length of the thesis' channel, m: 1.5 L_j with L_j of `silvester_jump_length` (thesis, with 4.27)."""
    return 1.5 * silvester_jump_length(froude_1, depth_1)


# --- inflow -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Inflow:
    """Hydraulics of the inflow."""

    depth: float = number("m", "depth of the inflow")
    velocity: float = number("m/s", "mean velocity of the inflow")
    froude: float = number("", "Froude number of the inflow")
    belanger_y2: float = number("m", "sequent depth of the inflow, Bélanger")
    length: float = number("m", "length of its jump, thesis (4.27)")
    length_usbr: float = number("m", "length of its jump, USBR curve")
    energy_loss: float = number("m", "head lost in its jump")
    sill: float = number("m", "sill that holds its jump by energy, E2 - 1.5 yc")
    jump_class: str = field(default="none", metadata={"key": "class"})


def inflow_theory(depth: float, velocity: float, gravity: float = GRAVITY) -> Inflow:
    """Hydraulics of an inflow of `depth` (m, > 0) and `velocity` (m/s): the jump that it would make."""
    froude_1 = froude(abs(velocity), depth, gravity)
    y2 = depth * belanger(froude_1)
    return Inflow(
        depth=depth,
        velocity=velocity,
        froude=froude_1,
        belanger_y2=y2,
        length=silvester_jump_length(froude_1, depth),
        length_usbr=usbr_jump_length(froude_1, depth),
        energy_loss=energy_loss(depth, y2) if y2 > 0 else nan,
        sill=sill_holding_height(abs(velocity), depth, gravity) if froude_1 > 1 else nan,
        jump_class=jump_class(froude_1),
    )


def velocity_range(depth_1: float, gravity: float = GRAVITY) -> tuple[float, float]:
    """Mean inflow velocities the thesis admits, m/s: 5 and 9 sqrt(g y1), the range of the steady jump."""
    celerity = sqrt(gravity * depth_1)
    return 5.0 * celerity, 9.0 * celerity


# --- sill -------------------------------------------------------------------------------------------------------


def crest_holding_depth(depth: float, discharge: float, gravity: float = GRAVITY) -> float:
    """Height of a broad crest over the bed that holds a depth (m) before it, m: D = E - 1.5 y_c; discharge in m^2/s.

    Critical flow on the crest, no loss up to it.
    """
    return specific_energy(depth, discharge / depth, gravity) - 1.5 * critical_depth(discharge, gravity)


def sill_holding_height(velocity: float, depth: float, gravity: float = GRAVITY) -> float:
    """Height of a broad sill that holds the jump of a stream, m: `crest_holding_depth` of its sequent depth."""
    return crest_holding_depth(sequent_depth(velocity, depth, gravity), velocity * depth, gravity)
