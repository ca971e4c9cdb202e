# SPDX-License-Identifier: GPL-2.0-or-later
"""Measured tables that runs are compared with; each record carries its citation and its units.

Numbers here are other people's measurements, digitised or tabulated; equations live in `lammps_jump.physics.jump`.
"""

from __future__ import annotations

from typing import NamedTuple


class MeasuredCurve(NamedTuple):
    """A measured curve: abscissas and ordinates, same length, without dimension; its citation is below it."""

    x: tuple[float, ...]
    y: tuple[float, ...]


USBR_JUMP_LENGTH = MeasuredCurve(
    x=(1.6, 2, 2.25, 2.5, 2.75, 3, 3.25, 3.5, 3.75, 4, 4.5, 5, 5.5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 19.2),
    y=(
        *(3.77, 4.35, 4.56, 4.77, 4.96, 5.13, 5.28, 5.43, 5.5, 5.6, 5.75, 5.87),
        *(5.95, 6.02, 6.09, 6.13, 6.14, 6.13, 6.03, 5.91, 5.75, 5.57, 5.47),
    ),
)
"""Length of the free jump on a horizontal floor over the sequent depth, L/y2, against the upstream Froude number Fr1:
U.S. Bureau of Reclamation, Engineering Monograph 25; digitised curve."""

USBR_JUMP_CLASSES = (
    (1.0, "none"),
    (1.7, "undular"),
    (2.5, "weak"),
    (4.5, "oscillating"),
    (9.0, "steady"),
    (float("inf"), "strong"),
)
"""(upper bound of Fr1, name) of the kinds of jump, USBR Engineering Monograph 25; bounds belong to the lower kind."""

MARTIN_MOYCE_FRONT = MeasuredCurve(
    x=(0.41, 0.84, 1.19, 1.43, 1.63, 1.83, 1.98, 2.20, 2.32, 2.51, 2.65, 2.83, 2.98, 3.11, 3.33),
    y=(1.11, 1.22, 1.44, 1.67, 1.89, 2.11, 2.33, 2.56, 2.78, 3.00, 3.22, 3.44, 3.67, 3.89, 4.11),
)
"""Z = front / a against T = n t sqrt(g/a), for n^2 = 2, a = 2.25 in: Martin & Moyce 1952, Phil. Trans. R. Soc. A 244,
312-324, collapse of a water column of base a and height n^2 a; table 2."""

KOSHIZUKA_OKA_FRONT = MeasuredCurve(
    x=(0.0, 0.381, 0.769, 1.153, 1.537, 1.935, 2.323, 2.719, 3.096),
    y=(1.0, 1.111, 1.252, 1.505, 1.892, 2.241, 2.615, 3.003, 3.624),
)
"""Z = front / L against T = t sqrt(2 g/L) of a water column L x 2 L, the variables of Martin & Moyce for n^2 = 2:
Koshizuka & Oka 1996, Nuclear Science and Engineering 123, 421-434, as tabled in examples/db_exp_data.py of PySPH."""

MARTIN_MOYCE_HEIGHT = MeasuredCurve(
    x=(0.56, 0.77, 0.93, 1.08, 1.28, 1.46, 1.66, 1.84, 2.00, 2.21, 2.45, 2.70, 3.06, 3.44, 4.20, 5.25),
    y=(0.94, 0.89, 0.83, 0.78, 0.72, 0.67, 0.61, 0.56, 0.50, 0.44, 0.39, 0.33, 0.28, 0.22, 0.17, 0.11),
)
"""h / H of the same column at its back wall against tau = t sqrt(g/a); table 6."""

MARTIN_MOYCE_FRONT_SLOPE: dict[float, float] = {1: 1.40, 2: 1.319}
"""dZ/dT of the front over T in [1.43, 3.33] for n^2 = 1 and 2 (straight-line fit of their tables)."""


class DiscHeap(NamedTuple):
    """A column of discs that fell to both sides, at rest; lengths over half its base L0.

    Attributes
    ----------
    aspect : float
        H0/L0.
    run_out : float
        Of the outermost disc, (L - L0)/L0.
    shape : MeasuredCurve
        Height over the distance from the middle.
    """

    aspect: float
    run_out: float
    shape: MeasuredCurve


DISC_HEAPS = (
    DiscHeap(0.49, 0.94, MeasuredCurve((0.0, 0.5, 1.0, 1.5, 2.0), (0.49, 0.37, 0.22, 0.11, 0.0))),
    DiscHeap(1.39, 3.48, MeasuredCurve((0.0, 0.5, 1.0, 1.5, 2.0, 3.0), (0.73, 0.63, 0.51, 0.42, 0.31, 0.16))),
    DiscHeap(6.00, 12.1, MeasuredCurve((0.0, 0.5, 1.0, 1.5, 2.0, 3.0), (1.21, 1.07, 0.97, 0.91, 0.85, 0.72))),
)
"""Columns of discs by contact dynamics (friction, restitution and sizes are not stated): data of the public repository
comphy-lab/basilisk-C, sandbox M1EMN, files ShapeTime.A-01, -03 and -04."""
