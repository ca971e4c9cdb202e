# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump calibrate``: contact coefficients that make discs behave most like water.

The distance of a candidate (e, μ, largest overlap, sill height) is the root mean square of three relative distances,
each printed:

- sequent depths y2/y1 against Bélanger at the same Froude number in the front's frame,
- length of the jump over y2 against the USBR curve,
- front of a collapsing column (n^2 = 2) against Martin & Moyce's table (RMS for T > 0.8).

The search varies one coordinate at a time on fixed grids, from the values of the case, until a whole round changes
nothing. A candidate without a jump counts as 100 % off in the first two. The runs are kept: an interrupted search
continues. Its result is in ``calibrate.json`` too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from pathlib import Path
from typing import Any

import pandas as pd

from lammps_jump import load_case
from lammps_jump.provenance import usable_cores
from lammps_jump.studies.folder import held_folder
from lammps_jump.sweeps import Pool, Say, Store, run_starts, table

from .sensitivity import JUMP_CASE, QUICK_CHANGES, starts_of
from .table import filled, markdown

Candidate = Mapping[str, float]
GRIDS: dict[str, tuple[float, ...]] = {
    "restitution": (0.05, 0.2, 0.5, 0.8, 0.95),
    "friction": (0.0, 0.01, 0.03, 0.1),
    "largest_overlap": (0.2, 0.1, 0.05),
    "sill": (0.6, 0.8, 1.0, 1.2, 1.4),
}
START = {"restitution": 0.2, "friction": 0.0, "largest_overlap": 0.1, "sill": 1.0}
QUICK_GRIDS = {"restitution": (0.2, 0.8), "friction": (0.0, 0.03), "largest_overlap": (0.1,), "sill": (1.0,)}

COLUMN_CASE = Path(__file__).with_name("column.yaml")
"""The collapsing column of Martin & Moyce."""
Row = dict[str, Any]
"""A candidate that was tried: its values (e, μ, largest overlap and height of the sill, m); ``depth``, ``length`` and
``front``, the relative distances from Bélanger, the USBR curve, and Martin & Moyce; ``distance``, their root mean
square; ``jumps``, the starts that found a jump, "2 of 3"."""


def distances(candidate: Candidate, folder: Path, pool: Pool, *, quick: bool, members: int, fresh: bool = False) -> Row:
    """Return the three distances of a candidate and their root mean square; its runs are kept in a folder."""
    contact = {f"contact.{name}": candidate[name] for name in ("restitution", "friction", "largest_overlap")}
    jump = {**(QUICK_CHANGES if quick else {}), **contact, "walls.sill.y": [-5, candidate["sill"]]}
    column = {**({"discs.diameter": 0.2} if quick else {}), **contact}
    jumps, columns = (
        run_starts(case, starts_of(case, changes, members), folder, pool, fresh=fresh)
        for case, changes in ((load_case(JUMP_CASE), jump), (load_case(COLUMN_CASE), column))
    )
    names = ["belanger_deviation", "length", "length_usbr"]
    found = pd.DataFrame([run.jump for run in jumps], columns=names, dtype=float)
    parts = {
        "depth": found.belanger_deviation,
        "length": found.length / found.length_usbr - 1,
        "front": pd.Series([table.number_at(run.summary, "front.martin_moyce.rms_bulk") for run in columns]),
    }
    means = {name: float(part.abs().fillna(1.0).mean()) for name, part in parts.items()}
    total = sqrt(sum(value**2 for value in means.values()) / 3)
    return {**candidate, **means, "distance": total, "jumps": f"{sum(bool(run.jump) for run in jumps)} of {len(jumps)}"}


def run_calibration(out: Path | None = None, *, quick: bool = False, fresh: bool = False, say: Say = print) -> str:
    """Search and return the table of every candidate tried, best first.

    Parameters
    ----------
    out : Path, optional
        Default ``runs/calibrate``.
    quick : bool
        Coarse flows, small grids, one start a candidate in place of three.
    fresh : bool
        Run again what is stored.
    say : callable
    """
    folder = Path(out) if out else Path("runs") / "calibrate"
    tried: dict[tuple[float, ...], Row] = {}

    def distance(candidate: Candidate) -> float:
        key = tuple(candidate.values())
        if key not in tried:
            options = {"quick": quick, "members": 1 if quick else 3, "fresh": fresh}
            tried[key] = distances(candidate, folder, pool, **options)
            say("  " + filled(SAID, tried[key]))
        return tried[key]["distance"]

    with held_folder(folder, "calibrate"), Pool(usable_cores()) as pool:
        best = search(distance, START, QUICK_GRIDS if quick else GRIDS)
        rows = sorted(tried.values(), key=lambda row: row["distance"])
        store = Store(folder / "calibrate.json", fresh=True)
        return store.finish(markdown(COLUMNS, rows) + "\n", best=tried[tuple(best.values())], rows=rows)


SAID = (
    "e = {restitution:zg}, μ = {friction:zg}, overlap {largest_overlap:zg}, sill {sill:zg} m: distance {distance:z.1%} "
    "(depth {depth:z.1%}, length {length:z.1%}, front {front:z.1%}; {jumps} with a jump)"
)
COLUMNS = {
    "e:": "{restitution:zg}",
    "μ:": "{friction:zg}",
    "largest overlap:": "{largest_overlap:zg}",
    "sill (m):": "{sill:zg}",
    "distance:": "{distance:z.1%}",
    "sequent depth:": "{depth:z.1%}",
    "length:": "{length:z.1%}",
    "Martin & Moyce:": "{front:z.1%}",
    "jumps": "{jumps}",
}


def search(distance: Callable[[Candidate], float], start: Candidate, grids: Mapping[str, Sequence[float]]) -> Candidate:
    """Return the candidate of least distance, found by one coordinate of the grids at a time."""
    best = dict(start)
    while True:
        before = best
        for name, grid in grids.items():
            for value in grid:
                other = {**best, name: value}
                best = other if distance(other) < distance(best) else best
        if best == before:
            return best
