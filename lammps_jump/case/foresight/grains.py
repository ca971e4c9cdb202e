# SPDX-License-Identifier: GPL-2.0-or-later
"""Limits of a contact law for grains that are to rest, and of a curve of sizes in so few discs."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, sqrt

from lammps_jump.case.discs import Column
from lammps_jump.case.fields import CaseFields
from lammps_jump.case.parts.grading import GradingCurve, SieveSizes
from lammps_jump.case.parts.inflow import PourInflow
from lammps_jump.physics.devices import creep_speed
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene import Beginning, MovingWall, Scene

STATED_SLOPE = 20.0
"""Slope from which on `check` tells that a heap creeps, degrees."""
FLAT = (
    "discs without contact.rolling roll off each other, so that their heap is flat: 10 degrees in column_collapse, 31 "
    "with rolling friction 0.3 in heap; give contact.rolling for an angle of repose as of grains with corners"
)
"""Of poured discs that only slide."""
LEAST_FRICTION = 0.05
"""Friction below which no heap is meant: discs that flow as water."""


def makes_heap(case: CaseFields, diameter: float, walls: Iterable[MovingWall]) -> bool:
    """Tells whether the discs of a case end as a heap: a column falls, or discs are poured; nothing takes them away.

    Parameters
    ----------
    case : CaseFields
    diameter : float
        Of a nominal disc, m.
    walls : iterable of MovingWall
        Gates that are taken away are not among them.
    """
    walls = list(walls)
    if not case.gravity or case.outflow or any(motion.kind is not None for _, motion in walls):
        return False
    lows, highs = zip(*(wall.room("x") for wall, _ in walls), strict=True) if walls else ((), ())
    columns = (item.x for item in case.initial if isinstance(item, Column))
    falls = any(left - max(lows, default=-inf) > diameter or min(highs, default=inf) - right > diameter
                for left, right in columns)  # fmt: skip
    return (falls and case.inflow is None) or isinstance(case.inflow, PourInflow)


def heap_doubts(case: CaseFields, begun: Beginning, walls: Iterable[MovingWall]) -> list[str]:
    """A sentence on a heap whose contacts have no tangential spring: it creeps; or no rolling spring: it is flat."""
    law, c = FRICTION_LAWS[case.contact.friction_law], begun.coefficients
    if law.remembers:
        poured = isinstance(case.inflow, PourInflow) or case.analysis.hopper
        return [FLAT] if poured and case.contact.rolling is None and makes_heap(case, begun.diameter, walls) else []
    if c.friction < LEAST_FRICTION or not makes_heap(case, begun.diameter, walls):
        return []
    speed = creep_speed(case.gravity, STATED_SLOPE, c.gamma_tangential)
    told = (
        f"at {speed:z.2g} m/s on {STATED_SLOPE:zg} degrees ({speed / sqrt(case.gravity * begun.diameter):z.2g} √(g d))"
    )
    holds = [name for name, one in FRICTION_LAWS.items() if one.remembers]
    return [
        f"friction_law {case.contact.friction_law} has no tangential spring: a heap never rests, it creeps"
        + (f" {told}" if law.ramp is None and speed > 0 else "")
        + (f"; friction_law: {holds[0]} holds it" if holds else "")
    ]


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
