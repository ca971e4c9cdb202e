"""Moving shocks, dam breaks, column collapse and loads on walls: closed forms that runs are compared with.

Pure functions, one equation each; SI, per metre of width. Functions of position take arrays and import numpy when
called. `lammps_jump.physics.jump` offers all of them under the same names.
"""

from __future__ import annotations

from math import radians, sqrt, tan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_GRAVITY = 9.81


# --- moving shocks ----------------------------------------------------------------------------------------------


def relative_froude(velocity: float, depth: float, shock_speed: float, gravity: float = _GRAVITY) -> float:
    """Froude number in the frame of a shock, (u - c) / sqrt(g s); s the mass depth, c the shock's velocity (m/s)."""
    return (velocity - shock_speed) / sqrt(gravity * depth)


def shock_speed_from_mass(depth_1: float, velocity_1: float, depth_2: float, velocity_2: float) -> float:
    """Velocity of a shock between two states, m/s: c = (s2 u2 - s1 u1) / (s2 - s1) (conservation of mass)."""
    return (depth_2 * velocity_2 - depth_1 * velocity_1) / (depth_2 - depth_1)


def shock_speed(depth_1: float, velocity_1: float, depth_2: float, gravity: float = _GRAVITY) -> float:
    """Velocity of the shock that raises (s1, u1) to s2 facing the stream, m/s: u1 - sqrt(g s2 (s1 + s2) / (2 s1)).

    Mass and momentum over the shock with hydrostatic pressure (Bélanger in the shock's frame); negative upstream.
    """
    return velocity_1 - sqrt(gravity * depth_2 * (depth_1 + depth_2) / (2.0 * depth_1))


def reflected_bore(depth: float, velocity: float, gravity: float = _GRAVITY) -> tuple[float, float]:
    """Bore thrown back by a wall that stops the flow: (depth at the wall in m, bore velocity in m/s, negative).

    Mass ``c = -s1 u1 / (s2 - s1)`` and momentum ``2 s1 s2 u1^2 = g (s1 + s2)(s2 - s1)^2``, solved by bisection.
    """

    def excess(s2: float) -> float:
        return gravity * (depth + s2) * (s2 - depth) ** 2 - 2.0 * depth * s2 * velocity**2

    low, high = depth, 2.0 * depth
    while excess(high) < 0:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    depth_2 = 0.5 * (low + high)
    return depth_2, -depth * velocity / (depth_2 - depth)


def bore_strength(depth_1: float, depth_2: float) -> float:
    """Froude number of the stream relative to a bore with these depths: sqrt(s2 (s1 + s2) / (2 s1^2))."""
    return sqrt(depth_2 * (depth_1 + depth_2) / 2.0) / depth_1


# --- dam break --------------------------------------------------------------------------------------------------


def ritter_depth(x: np.ndarray, t: float, depth_0: float, gravity: float = _GRAVITY) -> np.ndarray:
    """Depth of the dam break on a dry bed, m (Ritter 1892, as in SWASHES, arXiv 1110.0288).

    h = (4/9g) (sqrt(g h0) - x/(2t))^2 for -sqrt(g h0) <= x/t <= 2 sqrt(g h0), h0 upstream, 0 downstream.

    Parameters
    ----------
    x : array_like
        Distance from the dam, m, positive downstream; water of depth h0 stood at x < 0, without end.
    t : float
        Time since the release, s, > 0. A reservoir of length L0 follows it until `ritter_wall_time`.
    depth_0 : float
        h0, m.

    Returns
    -------
    ndarray, shape of x
    """
    import numpy as np

    celerity = sqrt(gravity * depth_0)
    similarity = np.clip(np.asarray(x, float) / t, -celerity, 2.0 * celerity)
    return 4.0 / (9.0 * gravity) * (celerity - 0.5 * similarity) ** 2


def ritter_velocity(x: np.ndarray, t: float, depth_0: float, gravity: float = _GRAVITY) -> np.ndarray:
    """Velocity of the dam break on a dry bed, m/s: (2/3)(x/t + sqrt(g h0)) in the wave, 0 outside it.

    Parameters and source as for `ritter_depth`.
    """
    import numpy as np

    celerity = sqrt(gravity * depth_0)
    similarity = np.asarray(x, float) / t
    inside = (similarity >= -celerity) & (similarity <= 2.0 * celerity)
    return np.where(inside, 2.0 / 3.0 * (similarity + celerity), 0.0)


def ritter_front(t: float, depth_0: float, gravity: float = _GRAVITY) -> float:
    """Front of the dam break on a dry bed, m from the dam: 2 t sqrt(g h0) (Ritter 1892)."""
    return 2.0 * t * sqrt(gravity * depth_0)


def ritter_wall_time(reservoir_length: float, depth_0: float, gravity: float = _GRAVITY) -> float:
    """Time when the rarefaction meets the back wall and Ritter ends to hold there, s: L0 / sqrt(g h0)."""
    return reservoir_length / sqrt(gravity * depth_0)


def stoker_state(depth_left: float, depth_right: float, gravity: float = _GRAVITY) -> tuple[float, float, float]:
    """Middle depth (m), middle velocity and bore velocity (m/s) of the dam break on a wet bed (Stoker 1957).

    The celerity c_m is the root of ``(c^2 - g hr)^2 (c^2 + g hr) = 8 g hr c^2 (sqrt(g hl) - c)^2`` between
    sqrt(g hr) and sqrt(g hl); h_m = c_m^2/g, u_m = 2 (sqrt(g hl) - c_m), bore = 2 c_m^2 (sqrt(g hl) - c_m) /
    (c_m^2 - g hr) (in the form of SWASHES, arXiv 1110.0288).

    Raises
    ------
    ValueError
        Unless 0 < depth_right < depth_left.
    """
    if not 0 < depth_right < depth_left:
        raise ValueError(
            f"stoker_state: depths {depth_left:g} m (left) and {depth_right:g} m (right) must satisfy "
            "0 < right < left; use the Ritter functions for a dry bed"
        )
    left, right = sqrt(gravity * depth_left), gravity * depth_right

    def balance(c: float) -> float:
        return (c**2 - right) ** 2 * (c**2 + right) - 8.0 * right * c**2 * (left - c) ** 2

    low, high = sqrt(right), left
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if balance(middle) < 0 else (low, middle)
    c = 0.5 * (low + high)
    return c**2 / gravity, 2.0 * (left - c), 2.0 * c**2 * (left - c) / (c**2 - right)


def stoker_profile(
    x: np.ndarray, t: float, depth_left: float, depth_right: float, gravity: float = _GRAVITY
) -> tuple[np.ndarray, np.ndarray]:
    """Depth (m) and velocity (m/s) of the dam break on a wet bed, each of x's shape; see `stoker_state`."""
    import numpy as np

    middle, speed, bore = stoker_state(depth_left, depth_right, gravity)
    celerity = sqrt(gravity * depth_left)
    similarity = np.asarray(x, float) / t
    fan_end = 2.0 * celerity - 3.0 * sqrt(gravity * middle)
    fan_depth = 4.0 / (9.0 * gravity) * (celerity - 0.5 * similarity) ** 2
    fan_speed = 2.0 / 3.0 * (similarity + celerity)
    zones = [similarity <= -celerity, similarity <= fan_end, similarity <= bore]
    return (
        np.select(zones, [depth_left, fan_depth, middle], depth_right),
        np.select(zones, [0.0, fan_speed, speed], 0.0),
    )


# --- columns of discs -------------------------------------------------------------------------------------------


def hydrostatic_overlap_vertical(discs_above: int, mass: float, stiffness: float, gravity: float = _GRAVITY) -> float:
    """Overlap of two discs in a stack, m: (discs above the contact) m g / k (thesis figure 6.2)."""
    return discs_above * mass * gravity / stiffness


def hydrostatic_overlap_horizontal(
    row_from_top: int, density: float, diameter: float, stiffness: float, gravity: float = _GRAVITY
) -> float:
    """Overlap of neighbours in a row, m: rho g ((n - 1) d + d/2) d / k, n = 1 for the top row (thesis figure 6.2)."""
    return density * gravity * ((row_from_top - 1) * diameter + 0.5 * diameter) * diameter / stiffness


def column_runout(aspect: float) -> float:
    """Run-out (L_inf - L)/L of a collapsing frictional column, aspect a = H/L, planar (Lube et al. 2005).

    1.2 a below a = 2.3, 1.9 a^(2/3) above (as quoted by Staron & Hinch, arXiv physics/0501022); the two branches meet
    at a = 3.97 only, so the law jumps up at 2.3.
    """
    return 1.2 * aspect if aspect < 2.3 else 1.9 * aspect ** (2.0 / 3.0)


def column_final_height(aspect: float) -> float:
    """Final height h_inf/L of a collapsed column: a below 1.15, 0.65 a^0.4 above.

    Lube et al. 2005, from memory of the literature.
    """
    return aspect if aspect < 1.15 else 0.65 * aspect**0.4


def column_stop_time(height: float, gravity: float = _GRAVITY) -> float:
    """Time when the column has come to rest, s: 3.3 sqrt(H/g) (Lube; from memory of the literature)."""
    return 3.3 * sqrt(height / gravity)


# --- loads on walls ---------------------------------------------------------------------------------------------


def hydrostatic_force(depth: float, density: float, gravity: float = _GRAVITY) -> float:
    """Force of water at rest on a vertical wall, N/m: rho g H^2 / 2."""
    return 0.5 * density * gravity * depth**2


def hydrostatic_moment(depth: float, density: float, gravity: float = _GRAVITY) -> float:
    """Overturning moment of water at rest about the wall's foot, N m/m: rho g H^3 / 6."""
    return density * gravity * depth**3 / 6.0


def stagnation_force(depth: float, velocity: float, density: float, gravity: float = _GRAVITY) -> float:
    """Force of a stream that a wall turns away, N/m: rho h u^2 + rho g h^2 / 2 (momentum of the oncoming flow)."""
    return density * depth * velocity**2 + hydrostatic_force(depth, density, gravity)


def cross_wall_force(
    depth: float, velocity: float, front_angle: float, density: float, gravity: float = _GRAVITY
) -> float:
    """Surge force on a wall, N/m: rho g h^2/2 + C_F rho h u^2, C_F = 1 + tan(theta)^1.2, theta in degrees.

    theta is the slope of the wave's front (Cross 1967; from memory of the literature).
    """
    coefficient = 1.0 + tan(radians(front_angle)) ** 1.2
    return hydrostatic_force(depth, density, gravity) + coefficient * density * depth * velocity**2
