"""``lammps-jump calibrate``: contact coefficients that make discs behave most like water.

Distance of a candidate (e, ks, n, sill height): the root mean square of three relative distances, each printed:

- sequent depths y2/y1 against Bélanger at the same Froude number in the front's frame,
- length of the jump over y2 against the USBR curve,
- front of a collapsing column (n^2 = 2) against Martin & Moyce's table (RMS for T > 0.8).

The search walks along one coordinate at a time on fixed grids, from the case's own values, until a whole round changes
nothing. A candidate without a jump counts as 100 % off in the first two. Resumable: ``calibrate.json``.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from pathlib import Path
from typing import Any

from lammps_jump.studies.bench.runs import run_setting

from .sensitivity import QUICK_TEXTS, base_file, fast_setting
from .timing import Store, machine, versions

GRIDS: dict[str, tuple[float, ...]] = {
    "restitution": (0.05, 0.2, 0.5, 0.8, 0.95),
    "friction": (0.0, 0.01, 0.03, 0.1),
    "penetration_fraction": (5.0, 10.0, 20.0),
    "sill": (0.6, 0.9, 1.2, 1.5, 1.8),
}
START = {"restitution": 0.2, "friction": 0.0, "penetration_fraction": 10.0, "sill": 1.2}
QUICK_GRIDS = {"restitution": (0.2, 0.8), "friction": (0.0, 0.03), "penetration_fraction": (10.0,), "sill": (1.2,)}

COLUMN_CASE = """\
name: martin_moyce
description: column of aspect 2, for Martin & Moyce's table
gravity: 9.81
discs: {diameter: 0.1, density: 1000}
contact: {restitution: 0.2, friction: 0, penetration_fraction: 10, impact_speed: 8.86}
domain: {x: [-1, 40], y: [-1, 12]}
walls:
  - {name: back, kind: plane, axis: x, at: 0, side: above}
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
initial:
  - {kind: column, x: [0, 2], y: [0, 4], hydrostatic: true, jitter: 0.001, gate: true}
outflow: [{x_beyond: 35}]
run: {duration: 1.25, time_step_fraction: 0.1, output_interval: 0.02, seed: 1}
analysis: {bin_width: 0.5, front: true}
"""


def texts_of(candidate: dict[str, float]) -> list[str]:
    """``--set`` texts of a candidate for the jump; those of the contact serve the column too."""
    return [f"contact.{name}={candidate[name]!r}" for name in ("restitution", "friction", "penetration_fraction")]


def distances(
    candidate: dict[str, float], jump_case: Path, column_case: Path, store: Store, *, quick: bool, members: int
) -> dict[str, Any]:
    """The three distances of a candidate and their root mean square."""
    contact = texts_of(candidate)
    sill = f"walls.sill.y=[-5, {candidate['sill']!r}]"
    jumps = _runs(jump_case, [*(QUICK_TEXTS if quick else []), *contact, sill], store, members)
    columns = _runs(column_case, [*(["discs.diameter=0.2"] if quick else []), *contact], store, members)
    found = [run["measures"]["jump"] for run in jumps if run["measures"].get("verdict") == "jump"]
    depth = [abs(jump["sequent_ratio"] / jump["belanger_ratio"] - 1) for jump in found]
    length = [abs(jump["length"] / jump["length_usbr"] - 1) for jump in found]
    fronts = [(run["measures"].get("martin_moyce") or {}).get("rms_bulk") for run in columns]
    parts = {
        "depth": _mean([*depth, *[1.0] * (len(jumps) - len(found))]),
        "length": _mean([*length, *[1.0] * (len(jumps) - len(found))]),
        "front": _mean([1.0 if value is None else value for value in fronts]),
    }
    total = sqrt(sum(value**2 for value in parts.values()) / 3)
    return {**candidate, **parts, "distance": total, "jumps": f"{len(found)} of {len(jumps)}"}


def _runs(path: Path, texts: list[str], store: Store, members: int) -> list[dict[str, Any]]:
    setting = fast_setting(texts, path)
    return [
        store.piece(
            f"{path.stem} {member} {texts} {setting.label}",
            lambda m=member: run_setting(path, texts, setting, m),
        )
        for member in range(members)
    ]


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)


def run_calibration(
    out: Path | None = None, *, quick: bool = False, members: int | None = None, fresh: bool = False,
    say: Callable[[str], None] = print,
) -> str:  # fmt: skip
    """Search and return the table of every candidate tried, best first.

    Parameters
    ----------
    out : Path, optional
        Default ``runs/calibrate``.
    quick : bool
        Coarse flows and small grids.
    members : int, optional
        Starts a candidate; default 3 (1 if quick).
    fresh : bool
    say : callable
    """
    folder = Path(out) if out else Path("runs") / "calibrate"
    store = Store(folder / "calibrate.json", fresh=fresh)
    jump_case = base_file(folder)
    column_case = folder / "martin_moyce.yaml"
    column_case.write_text(COLUMN_CASE)
    tried: dict[tuple[float, ...], dict[str, Any]] = {}

    def try_out(candidate: dict[str, float]) -> dict[str, Any]:
        key = tuple(candidate.values())
        if key not in tried:
            count = members or (1 if quick else 3)
            tried[key] = distances(candidate, jump_case, column_case, store, quick=quick, members=count)
            say("  " + describe(tried[key]))
        return tried[key]

    best = search(try_out, START, QUICK_GRIDS if quick else GRIDS)
    rows = sorted(tried.values(), key=lambda row: row["distance"])
    store.data |= {"best": best, "rows": rows, "versions": versions(), "machine": machine()}
    store.save()
    table = calibration_table(rows)
    (folder / "calibrate.md").write_text(table)
    return table


def search(
    try_out: Callable[[dict[str, float]], dict[str, Any]], start: dict[str, float], grids: dict[str, tuple[float, ...]]
) -> dict[str, Any]:
    """Best candidate by walking along one coordinate of the grids at a time until a round changes nothing."""
    best = try_out(dict(start))
    while True:
        before = best["distance"]
        for name, grid in grids.items():
            for value in grid:
                row = try_out({**{key: best[key] for key in start}, name: value})
                best = row if row["distance"] < best["distance"] else best
        if best["distance"] >= before:
            return best


def describe(row: dict[str, Any]) -> str:
    """One line on a candidate."""
    return (
        f"e = {row['restitution']:g}, ks = {row['friction']:g}, n = {row['penetration_fraction']:g}, "
        f"sill {row['sill']:g} m: distance {100 * row['distance']:.1f} % (depth {100 * row['depth']:.1f}, "
        f"length {100 * row['length']:.1f}, front {100 * row['front']:.1f}; {row['jumps']} with a jump)"
    )


def calibration_table(rows: list[dict[str, Any]]) -> str:
    """Markdown, best first."""
    lines = [
        "| e | ks | n | sill (m) | distance | sequent depth | length | Martin & Moyce | jumps |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|---|",
    ]
    for row in rows:
        shares = " | ".join(f"{100 * row[name]:.1f} %" for name in ("distance", "depth", "length", "front"))
        lines.append(
            f"| {row['restitution']:g} | {row['friction']:g} | {row['penetration_fraction']:g} | {row['sill']:g} | "
            f"{shares} | {row['jumps']} |"
        )
    return "\n".join(lines) + "\n"
