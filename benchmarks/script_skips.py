# SPDX-License-Identifier: GPL-2.0-or-later
"""Time that each thing left out of the stock LAMMPS script saves, measured by putting it back in.

Run as ``python benchmarks/script_skips.py CASE [--set PATH=VALUE] [--quick] [--out DIR]``.
Every row edits one thing into the script that the generator writes, and runs both in turn. Their last frames are
compared: the trajectory must not change. Another skin or other list builds change the order of sums. The comparison is
then made after few steps, before chaos has grown.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from pathlib import Path

import numpy as np
from taking_turns import in_turn, main

from lammps_jump import Case
from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.scene import Scene
from lammps_jump.script import script_text
from lammps_jump.studies.runs import KERNELS, middle, run_frames
from lammps_jump.sweeps import Results, Say, Store, all_versions

FULL_COLUMNS = "id type x y z vx vy vz fx fy fz omegax omegay omegaz radius mass"
PRECISE = ("format float %.10g", "format float %.17g")
"""What the comparison reads must hold every digit; both scripts get it."""
EARLY_STEPS = 400


@dataclass(frozen=True)
class Skip:
    """One thing that a script does without.

    Attributes
    ----------
    name : str
    edits : tuple of (pattern, replacement)
        Put the thing into the script. Lines that match a pattern are replaced; `numbers` fill the replacement.
    exact : bool
        Trajectories are equal bit by bit, else to 1e-12 m after `EARLY_STEPS` steps.
    weightless : bool
        Only for scenes without gravity.
    """

    name: str
    edits: tuple[tuple[str, str], ...]
    exact: bool = True
    weightless: bool = False

    def edit(self, text: str, scene: Scene) -> str:
        """Return the script with the thing in it; the same text where it does not apply to the scene."""
        if self.weightless and any(scene.gravity):
            return text
        for pattern, replacement in self.edits:
            text = re.sub(f"(?m)^{pattern}$", replacement.format(**numbers(scene)), text)
        return text


def numbers(scene: Scene) -> dict[str, str]:
    """Return the numbers of a scene that the edits of `SKIPS` need."""
    c, d = scene.coefficients, scene.diameter
    return {
        "rate": f"{3.0 * c.omega:z.6g}",
        "hooke": f"hooke {c.stiffness!r} NULL {max(c.gamma_normal_wall, 1e-12)!r} 0 0 0",
        "far": repr(scene.domain[1][0] - 100.0),
        "often": str(max(1, scene.output_steps // 10)),
        "thin": repr(0.1 * d),
        "thick": repr(0.6 * d),
    }


MOTION, GUARDS, FRAMES, SKIN = r"(fix +motion .*)", "(# --- guards)", r"(dump +frames .*)", r"neighbor +\S+ bin"
SKIPS = (
    # a coefficient of 0 with a tangential dashpot: computed in every contact without effect
    Skip("friction terms (μ = 0)", ((r"(pair_style +gran/hooke \S+ \S+ \S+) 0 0 0", r"\1 {rate} 0 1"),
                                     (r"(.*wall/gran(?:/region)? hooke \S+ \S+ \S+) 0 0 0(.*)", r"\1 {rate} 0 1\2"))),
    Skip("integration of spin", ((r"(fix +motion all) nve", r"\1 nve/sphere disc"),)),
    Skip("gravity of 0", ((MOTION, r"\1\nfix gravity all gravity 0 vector 0 -1 0"),), weightless=True),
    Skip("a wall out of reach", ((MOTION, r"\1\nfix far all wall/gran {hooke} yplane {far} NULL"),)),
    Skip("constraint to z = 0", ((GUARDS, r"fix flat all enforce2d\n\1"),)),
    Skip("sums over forces at every step", ((GUARDS, r"compute push all reduce sum fx fy\n"
                                             r"fix push all ave/time 1 100 100 c_push[1] c_push[2]\n\1"),)),
    Skip("dump columns that no analysis reads",
         ((r"(dump +frames all \S+ \d+ \S+) id x y vx vy.*", rf"\1 {FULL_COLUMNS}"),)),
    # into a second file, so that the frames that are compared stay the same
    Skip("ten times as many frames", ((FRAMES, r"\1\ndump more all custom {often} more.lammpstrj id x y vx vy"),)),
    Skip("log lines every 10 steps", ((r"thermo +\d+", "thermo 10"),)),
    Skip("neighbour lists every 5 steps, needed or not",
         ((r"neigh_modify.*", "neigh_modify delay 0 every 5 check no"),), exact=False),
    Skip("skin of 0.1 d", ((SKIN, "neighbor {thin} bin"),), exact=False),
    Skip("skin of 0.6 d", ((SKIN, "neighbor {thick} bin"),), exact=False),
)  # fmt: skip


def both_scripts(scene: Scene, skip: Skip) -> tuple[str, str]:
    """Return the stock script of the generator, with every digit in the dump, without and with the thing."""
    plain = script_text(scene, kernel="stock").replace(*PRECISE)
    return plain, skip.edit(plain, scene)


def compare_skip(scene: Scene, skip: Skip) -> float | None:
    """Return the largest change of the last frame with the thing in the script; None where that changes no line.

    It is of positions (m) or velocities (m/s), and infinite where the discs differ.
    """
    if not skip.exact:
        steps = min(scene.steps, EARLY_STEPS)
        scene = replace(scene, steps=steps, settle_steps=0, walls=scene.standing, output_steps=steps, probe_steps=steps)
    plain, edited = both_scripts(scene, skip)
    if edited == plain:
        return None
    one, two = (run_frames(scene, "stock", script=text)[1][-1] for text in (plain, edited))
    if not np.array_equal(one.ids, two.ids):
        return inf
    return max(float(np.abs(one.columns[c] - two.columns[c]).max(initial=0.0)) for c in ("x", "y", "vx", "vy"))


def stock_time(scene: Scene, *, dump_format: str = "text", script: str | None = None) -> float:
    """Return the processor seconds of a stock run; keywords as of `run_frames`."""
    return run_frames(scene, "stock", dump_format=dump_format, script=script)[0].cpu_seconds


def dump_formats(scene: Scene, rounds: int) -> dict[str, float | None]:
    """Return the processor seconds of a stock run by dump format."""
    formats = ["text", "gz", "binary"]
    times = in_turn(formats, rounds, lambda name, _: stock_time(scene, dump_format=name))
    return {name: middle(values) for name, values in times.items()}


def measure_skips(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Measure what each skip saves and that it changes nothing.

    A row holds the time with the thing over the time without it, and the largest change of the trajectory (m or m/s);
    None where it does not apply to the scene.
    """
    case = case.replace(KERNELS["stock"])
    scene, rounds = case.scene(), 1 if quick else 5
    identity = f"{case.hash} {all_versions()} {rounds}"
    rows = []
    for skip in SKIPS:
        rows.append(store.piece(f"{skip.name} {identity}", partial(_row, scene, skip, rounds)))
        say(f"  {skip.name}: {rows[-1]['verdict']}")
    formats = store.piece(f"formats {identity}", lambda: dump_formats(scene, rounds))
    return {"rows": rows, "formats": formats, "rounds": rounds}


def _row(scene: Scene, skip: Skip, rounds: int) -> Results:
    ratio, difference, verdict = None, compare_skip(scene, skip), "does not apply"
    if difference is not None:
        taken = in_turn(both_scripts(scene, skip), rounds, lambda text, _: stock_time(scene, script=text))
        ratio = middle(with_it / without for without, with_it in zip(*taken.values(), strict=True))
        more = "-" if ratio is None else f"{100 * (ratio - 1):+z.1f} %"
        verdict = f"{more} time with it, trajectory differs by {difference:z.1e}"
    return {"name": skip.name, "verdict": verdict, "ratio": ratio, "difference": difference, "exact": skip.exact}


def skip_page(data: Results, folder: Path) -> list[str]:
    """Return the table."""
    formats = data["formats"]
    dumps = (
        {"name": f"dump as {name} instead of text", "ratio": formats[name] / formats["text"], "same": "-"}
        for name in ("gz", "binary")
        if formats.get("text") and formats.get(name)
    )
    columns: dict[str, Column] = {
        "put back in": "{name}",
        "time with it:": lambda row: "-" if row["ratio"] is None else f"{100 * (row['ratio'] - 1):+z.1f} %",
        "largest change of the trajectory:": lambda row: row.get("same") or _change(row),
    }
    return [markdown(columns, [*data["rows"], *dumps])]


def _change(row: Results) -> str:
    difference = inf if row["difference"] is None else row["difference"]
    where = "" if row["exact"] else f", after {EARLY_STEPS} steps"
    same = f"{difference:z.1e}{where}" if difference else "none, bit by bit"
    return row["verdict"] if row["ratio"] is None else same


if __name__ == "__main__":
    raise SystemExit(main(__doc__, "skips", measure_skips, skip_page))
