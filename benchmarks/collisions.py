# SPDX-License-Identifier: GPL-2.0-or-later
"""Collisions of two discs against their closed forms: restitution, duration, largest overlap, over many entry phases.

Run as ``python benchmarks/collisions.py [--quick] [--out DIR]``. It writes ``collision.json``, ``collision.md`` and
``bench_collision.png``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd
from taking_turns import FOLDER

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.analysis.tables import Column, markdown, paragraphs
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import JumpError
from lammps_jump.physics import contact
from lammps_jump.provenance import machine
from lammps_jump.studies.bench import collision_scene, expected, measure_collisions
from lammps_jump.studies.points import held_folder
from lammps_jump.sweeps import Results, Say, Store

QUANTITIES = ("restitution", "duration", "overlap")
COLOURS = ("#33508f", "#8aa0c8", "#7d7c78", "#b5a05a", "#111111")


def collision_row(way: str, kernel: str, restitution: float, fraction: float, **options: Any) -> Results:
    """Return errors of the mean over all entry phases, and the scatter among them, relative to the closed forms."""
    exact = expected(restitution)
    scene = collision_scene(fraction, restitution, **options)
    row = {"way": way, "restitution": restitution, "fraction": fraction, "steps": scene.coefficients.contact_steps}
    for name, found in measure_collisions(scene, kernel).items():
        row[f"{name}_error"] = float(found.mean() / exact[name] - 1)
        row[f"{name}_scatter"] = float(found.std() / exact[name])
    return row


def collision_rows(kernels: Sequence[str], *, quick: bool) -> Iterator[Results]:
    """Yield `collision_row` for each restitution coefficient, way and stable step."""
    fast = "compiled" if "compiled" in kernels else "native"
    ways: dict[str, tuple[str, dict[str, Any]]] = {
        "stock, corrected": ("stock", {}),
        "stock, uncorrected": ("stock", {"correct": False}),
        "native, thesis scheme": ("native", {"integrator": "leapfrog_extrapolated"}),
        f"{fast}, smooth touch": (fast, {"touch": "smooth"}),
    }
    fractions = (0.05, 0.2) if quick else (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
    for restitution, (way, (kernel, options)) in product((0.2, 1.0) if quick else (0.2, 0.6, 1.0), ways.items()):
        xi, scheme = contact.damping_ratio(restitution), options.get("integrator", "velocity_verlet")
        steps = [f for f in fractions if f <= contact.stable_fraction(xi, scheme, "pair")]
        if kernel in kernels and (restitution < 1 or "correct" not in options):
            yield from (collision_row(way, kernel, restitution, f, **options) for f in steps)


def run_collisions(folder: Path, *, quick: bool = False, say: Say = print) -> str:
    """Write rows, page and figure into a folder, and return the page."""
    kernels, notes = usable_kernels()
    with held_folder(folder, "bench"):
        store, rows = Store(folder / "collision.json", fresh=True), []
        for row in collision_rows(kernels, quick=quick):
            rows.append(row)
            say(f"  {row['way']}, e {row['restitution']:zg}, f {row['fraction']:zg}: {row['restitution_error']:+z.4f}")
        draw_collisions(rows, folder / "bench_collision.png")
        found = {"rows": rows, "notes": notes, "case": "collision", "machine": machine()}
        return store.finish(paragraphs(collision_table(rows)), **found)


def collision_table(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the table: error of the mean and scatter over entry phases, per cent."""

    def error(row: Mapping[str, Any], name: str) -> str:
        return f"{100 * row[f'{name}_error']:+z.2f} ± {100 * row[f'{name}_scatter']:z.2f} %"

    columns: dict[str, Column] = {"e:": "{restitution:zg}", "way": "", "f:": "{fraction:zg}"}
    return markdown(columns | {f"{name}:": partial(error, name=name) for name in QUANTITIES}, rows)


def draw_collisions(rows: Sequence[Results], path: Path) -> None:
    """Draw the error of restitution (mean and scatter) against the step, one panel a restitution coefficient."""
    table = pd.DataFrame(rows)
    looks = dict(zip(table.way.unique(), zip("osD^v", COLOURS, strict=True), strict=False))
    panels = table.groupby("restitution")
    with drawing(3.2 * len(panels) + 1.2, 3.4, 1, len(panels), squeeze=False) as (figure, axes):
        for panel, (e, part) in zip(axes.flat, panels, strict=True):
            for way, group in part.groupby("way", sort=False):
                mark, colour = looks[way]
                error, bars = 100 * group.restitution_error, 100 * group.restitution_scatter
                panel.errorbar(group.fraction, error, yerr=bars, marker=mark, color=colour, label=way, lw=1, capsize=2)
            panel.axhline(0, color="#555555", linewidth=0.8)
            panel.set(xscale="log", xlabel="f, step over 2/omega", title=f"e = {e:zg}")
            panel.legend(fontsize=7)
        axes.flat[0].set_ylabel("error of restitution (%),\nbars: scatter over entry phases")
        save(figure, path)


def main() -> int:
    """Read the command line and print the table; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two restitution coefficients, two steps")
    parser.add_argument("--out", type=Path, default=FOLDER / "collision", help="folder (default: %(default)s)")
    given = parser.parse_args()
    try:
        print(run_collisions(given.out, quick=given.quick))
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
