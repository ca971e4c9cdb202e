# SPDX-License-Identifier: GPL-2.0-or-later
"""Limits of a curve of sizes in so few discs."""

from __future__ import annotations

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.grading import GradingCurve, SieveSizes
from lammps_jump.scene import Scene

TENTHS = 0.1, 0.9
"""Parts of the mass below which its finest tenth is, and above which its coarsest."""
FEWEST = 10.0
"""Discs of the coarsest tenth below which chance makes the curve there: their number is known to a third."""


def curve_doubts(case: CaseFields, scene: Scene) -> list[str]:
    """Sentences on a curve of sizes: its largest discs are too few, its finest part has no lower end."""
    sizes, curve = scene.sizes, case.discs.sizes
    if sizes is None or not isinstance(curve, GradingCurve):
        return []
    told = [curve.open_end] if isinstance(curve, SieveSizes) and curve.open_end else []
    coarse = sizes.diameter_at(TENTHS[1])
    share = 1.0 - float(sizes.passing(coarse, 0))
    count = scene.drawn_discs
    if count and count * share < FEWEST:
        told.append(
            f"discs.sizes: the coarsest tenth of the mass, above {coarse:z.3g} m, is {count * share:z.2g} of {count} "
            f"discs: too few for the curve to be met there; {FEWEST / share:z.2g} discs hold {FEWEST:zg} of them: take "
            "a larger bed, or a curve that is not so wide"
        )
    return told
