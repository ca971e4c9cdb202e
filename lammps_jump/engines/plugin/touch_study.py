"""One collision in discrete time: how the smooth touch changes restitution (tables of docs/kernels.md).

``python -m lammps_jump.engines.plugin.touch_study`` prints the tables. Units: m_eff = k = 1, so that omega = 1, times
count in 1/omega and the step is h = omega dt = 2 f. Velocity Verlet with the dashpot fed by the half-step velocity, as
LAMMPS evaluates it (docs/theory.md, one collision in steps).
"""

from __future__ import annotations

from math import sqrt

from lammps_jump.physics.contact import SMOOTH_SHARE, damping_ratio, lagged_correction

SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0)
PHASES = 64
LIMIT = 1_000_000


def spring(overlap: float, width: float) -> float:
    """Elastic force over k: delta^2/(2 s) below delta = s, delta - s/2 beyond; s = 0 is the linear spring delta."""
    if width <= 0.0:
        return overlap
    share = min(1.0, overlap / width)
    return share * (overlap - 0.5 * width * share)


def energy(overlap: float, width: float) -> float:
    """Elastic energy over k, integral of `spring`: delta^3/(6 s) below s, (q^2 + s^2/12)/2 beyond (q = delta - s/2)."""
    if width <= 0.0:
        return 0.5 * overlap**2
    if overlap < width:
        return overlap**3 / (6.0 * width)
    return 0.5 * ((overlap - 0.5 * width) ** 2 + width**2 / 12.0)


def dashpot_share(overlap: float, width: float, dashpot: str) -> float:
    """Factor on the dashpot: 'ramp' min(1, delta/s), 'even' F/sqrt(2 k E), which keeps restitution at every speed.

    Derivation: with z = sqrt(2 E/k) and d tau = (dz/d delta) dt, any potential with the dashpot c dz/d delta is the
    linear spring and dashpot (docs/kernels.md).
    """
    if width <= 0.0:
        return 1.0
    if dashpot == "ramp":
        return min(1.0, overlap / width)
    return spring(overlap, width) / sqrt(2.0 * energy(overlap, width))


def restitution(xi: float, h: float, width: float, speed: float, phase: float, dashpot: str = "even") -> float:
    """Restitution coefficient of one collision.

    Parameters
    ----------
    xi : float
        Damping ratio of the linear law.
    h : float
        omega dt.
    width : float
        s in the units of speed / omega; 0 is the sharp contact.
    speed : float
        Impact speed.
    phase : float
        Share of a step between the last free position and touch, 0 … 1.
    dashpot : {'even', 'ramp'}
    """
    overlap, v, force = -phase * h * speed, speed, 0.0
    for _ in range(LIMIT):
        half = v + 0.5 * h * force
        overlap += h * half
        force = 0.0
        if overlap > 0.0:
            force = -spring(overlap, width) - 2.0 * xi * dashpot_share(overlap, width, dashpot) * half
        v = half + 0.5 * h * force
        if overlap <= 0.0 and v < 0.0:
            return -v / speed
    raise ArithmeticError(f"the contact has not ended after {LIMIT} steps (xi {xi}, h {h}, width {width})")


def mean_restitution(
    xi: float, h: float, width: float, speed: float, dashpot: str = "even", phases: int = PHASES
) -> tuple[float, float]:
    """Mean and standard deviation of `restitution` over evenly spread phases of entry."""
    found = [restitution(xi, h, width, speed, (i + 0.5) / phases, dashpot) for i in range(phases)]
    mean = sum(found) / phases
    return mean, sqrt(max(sum(e * e for e in found) / phases - mean * mean, 0.0))


def fitted_factor(e: float, h: float, width: float, dashpot: str) -> float:
    """Factor on c that gives the wanted restitution at v0 = 1 (bisection: restitution falls with c)."""
    low, high = 0.5, 2.0
    for _ in range(20):
        middle = 0.5 * (low + high)
        if mean_restitution(middle * damping_ratio(e), h, width, 1.0, dashpot, 16)[0] > e:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def table(restitutions=(0.2, 0.6), fractions=(0.05, 0.1, 0.2), widths=(1.0, 2.0)) -> list[str]:
    """Rows of the Markdown table: e, f, w, sharp, ramp and even over `SPEEDS`; w in steps at v0."""
    rows = ["| e | f | w | sharp: e ± scatter | ramp: range | even: range | even: scatter at v0 |", "|---" * 7 + "|"]
    for e in restitutions:
        for f in fractions:
            h = 2.0 * f
            factor = lagged_correction(e, h)
            xi = damping_ratio(e) * factor
            softer = damping_ratio(e) * (1.0 - SMOOTH_SHARE * (1.0 - factor))
            sharp = mean_restitution(xi, h, 0.0, 1.0)
            for w in widths:
                fitted = damping_ratio(e) * fitted_factor(e, h, w * h, "ramp")
                ramp = [mean_restitution(fitted, h, w * h, u, "ramp")[0] for u in SPEEDS]
                even = [mean_restitution(softer, h, w * h, u) for u in SPEEDS]
                means = [mean for mean, _ in even]
                rows.append(
                    f"| {e} | {f} | {w:g} | {sharp[0]:.3f} ± {sharp[1]:.3f} | {min(ramp):.3f} to {max(ramp):.3f} "
                    f"| {min(means):.3f} to {max(means):.3f} | {even[SPEEDS.index(1.0)][1]:.4f} |"
                )
    return rows


if __name__ == "__main__":
    print("\n".join(table()))
