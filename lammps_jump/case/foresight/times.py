# SPDX-License-Identifier: GPL-2.0-or-later
"""Times of a case that lie behind its end: what is to begin there never does."""

from __future__ import annotations

from lammps_jump.case.fields import CaseFields
from lammps_jump.case.groups.measures import Probes
from lammps_jump.case.parts.beds import RoughBed
from lammps_jump.case.parts.inflow import RowsInflow

SAME = 1e-3
"""Share by which a time may be longer than the run and still count as its end."""


def behind_the_end(case: CaseFields) -> list[str]:
    """Sentences on what is to begin behind the end of the run, and on intervals that are longer than the run."""
    end = case.run.duration
    held = [(f"bodies[{index}].from", f"body '{one.name}' is held", one.begin) for index, one in enumerate(case.bodies)]
    for index, wall in enumerate(case.walls):
        if not isinstance(wall, RoughBed) and wall.motion is not None:
            held.append((f"walls[{index}].motion.from", f"wall '{wall.name}' stands", wall.motion.begin))
    found = [
        f"{field}: {what} until {begin:zg} s, and the run ends at {end:zg} s: it never moves; let it go earlier, or "
        "run longer"
        for field, what, begin in held
        if begin >= end
    ]
    return found + _no_inflow(case) + _long_intervals(case)


def _no_inflow(case: CaseFields) -> list[str]:
    """A sentence on a table of an inflow that lets no disc in while the run lasts."""
    inflow, end = case.inflow, case.run.duration
    if not isinstance(inflow, RowsInflow) or not inflow.table or inflow.hydrograph.means(0.0, end)[1] > 0:
        return []
    return [
        f"the inflow.table lets no disc in before the run ends at {end:zg} s; begin its flow earlier, or run longer"
    ]


def _long_intervals(case: CaseFields) -> list[str]:
    """Sentences on intervals of frames and of forces that are longer than the run."""
    end, found = case.run.duration, []
    asked = case.run.output_interval
    if asked is not None and asked > end * (1 + SAME):
        found.append(
            f"run.output_interval: {asked:zg} s is longer than the run of {end:zg} s, which has a frame at its start "
            "and one at its end; take a part of it"
        )
    interval, probes = case.probes.interval, case.probes
    used = probes.recorded or case.bodies or interval != Probes().interval
    if used and interval > end * (1 + SAME):
        most = min(case.output_interval, end)
        found.append(
            f"probes.interval: {interval:zg} s is longer than the run of {end:zg} s; forces are means over the time "
            f"between frames then, {most:z.3g} s: take a part of it, for example {0.1 * most:z.2g} s"
        )
    return found
