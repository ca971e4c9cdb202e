# SPDX-License-Identifier: GPL-2.0-or-later
"""Time that each thing left out of the stock LAMMPS script saves, measured by putting it back in.

Every row edits one thing into the script that the generator writes, and runs both in turn. Their last frames are
compared: the trajectory must not change. Another skin or other list builds change the order of sums. The comparison is
then made after few steps, before chaos has grown.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lammps_jump import Case
from lammps_jump.dump.read import open_dump
from lammps_jump.errors import RunError
from lammps_jump.scene.scene import Scene
from lammps_jump.script import script_text
from lammps_jump.studies.runs import execute, kernel_changes
from lammps_jump.studies.store import Store
from lammps_jump.studies.table import markdown, percent
from lammps_jump.studies.timing import in_turn, middle, versions

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
        """Return the script with the thing in it; the same text where the scene needs it anyway."""
        if self.weightless and any(scene.gravity):
            return text
        for pattern, replacement in self.edits:
            text = re.sub(f"(?m)^{pattern}$", replacement.format(**numbers(scene)), text)
        return text


def numbers(scene: Scene) -> dict[str, str]:
    """Return the numbers of a scene that the edits of `SKIPS` need."""
    c, d = scene.coefficients, scene.diameter
    return {
        "rate": f"{3.0 * c.omega:.6g}",
        "hooke": f"hooke {c.stiffness!r} NULL {max(c.gamma_normal_wall, 1e-12)!r} 0 0 0",
        "far": repr(scene.domain[1][0] - 100.0),
        "often": str(max(1, scene.output_steps // 10)),
        "thin": repr(0.1 * d),
        "thick": repr(0.6 * d),
    }


MOTION, GUARDS, FRAMES, SKIN = r"(fix +motion .*)", "(# --- guards)", r"(dump +frames .*)", r"neighbor +\S+ bin"
SKIPS = (
    # a coefficient of 0 with a tangential dashpot: computed in every contact without effect
    Skip("friction terms (ks = 0)", ((r"(pair_style +gran/hooke \S+ \S+ \S+) 0 0 0", r"\1 {rate} 0 1"),
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


@dataclass(frozen=True)
class Row:
    """What putting one thing back in costs.

    Attributes
    ----------
    name, verdict : str
    ratio : float or None
        Time with it over time without it; None where the scene needs it.
    difference : float or None
        Largest change of the trajectory, m or m/s.
    exact : bool
        See `Skip`.
    """

    name: str
    verdict: str = "the scene needs it"
    ratio: float | None = None
    difference: float | None = None
    exact: bool = True


def base_script(scene: Scene) -> str:
    """Return the stock script of the generator, with every digit in the dump."""
    return script_text(scene, kernel="stock").replace(*PRECISE)


def run_script(scene: Scene, text: str) -> tuple[np.ndarray, float]:
    """Return the last frame (id, x, y, vx, vy; shape (n, 5)) and the processor seconds of a script for a scene.

    Raises
    ------
    RunError
        Where it does not come to its end.
    """
    with tempfile.TemporaryDirectory() as folder:
        result = execute(scene, Path(folder), "stock", script=text)
        if result.status != "complete":
            raise RunError(result.message)
        *_, last = open_dump(Path(folder) / "dump.lammpstrj")
    last = last.sorted()
    return np.column_stack([last.ids, last.x, last.y, last.vx, last.vy]), result.cpu_seconds


def largest_difference(one: np.ndarray, two: np.ndarray) -> float:
    """Return the largest difference of positions (m) or velocities (m/s); infinite where the discs differ."""
    if one.shape != two.shape or not np.array_equal(one[:, 0], two[:, 0]):
        return float("inf")
    return float(np.abs(one[:, 1:] - two[:, 1:]).max(initial=0.0))


def compare_skip(scene: Scene, skip: Skip) -> float | None:
    """Return the largest change of the trajectory with the thing in the script; None where the scene needs it."""
    if not skip.exact:
        steps = min(scene.steps, EARLY_STEPS)
        scene = replace(scene, steps=steps, settle_steps=0, gates=(), output_steps=steps, probe_steps=steps)
    plain = base_script(scene)
    edited = skip.edit(plain, scene)
    if edited == plain:
        return None
    return largest_difference(run_script(scene, plain)[0], run_script(scene, edited)[0])


def dump_formats(scene: Scene, rounds: int) -> dict[str, float]:
    """Return the processor seconds of a stock run by dump format."""
    taken: dict[str, list[float]] = {"text": [], "gz": [], "binary": []}
    for _, name in in_turn(list(taken), rounds):
        with tempfile.TemporaryDirectory() as folder:
            taken[name].append(execute(scene, Path(folder), "stock", dump_format=name).cpu_seconds)
    return {name: middle(values) for name, values in taken.items()}


def bench_skips(case: Case, store: Store, *, quick: bool = False, say: Callable[[str], None] = print) -> str:
    """Measure what each skip saves and that it changes nothing; returns the table (``bench CASE --skips``)."""
    case = case.replace(kernel_changes("stock"))
    scene = case.scene()
    rounds = 1 if quick else 5
    identity = f"{case.hash} {versions()} {rounds}"
    rows: list[Row] = []
    for skip in SKIPS:
        row = store.piece(f"{skip.name} {identity}", lambda s=skip: _skip_row(scene, s, rounds), Row)
        rows.append(row)
        say(f"  {skip.name}: {row.verdict}")
    formats = store.piece(f"formats {identity}", lambda: dump_formats(scene, rounds))
    store.finish(case=case.name, rows=rows, formats=formats, rounds=rounds)
    return store.write_table(skip_table(rows, formats))


def _skip_row(scene: Scene, skip: Skip, rounds: int) -> Row:
    plain = base_script(scene)
    edited = skip.edit(plain, scene)
    if edited == plain:
        return Row(skip.name)
    taken: dict[str, list[float]] = {plain: [], edited: []}
    for _, text in in_turn([plain, edited], rounds):
        taken[text].append(run_script(scene, text)[1])
    ratio = middle(with_it / without for with_it, without in zip(taken[edited], taken[plain], strict=True))
    difference = compare_skip(scene, skip)
    verdict = f"{percent(ratio - 1, 1, '+')} time with it, trajectory differs by {difference:.1e}"
    return Row(skip.name, verdict, ratio, difference, skip.exact)


def skip_table(rows: list[Row], formats: dict[str, float]) -> str:
    """Return the Markdown table."""
    lines = []
    for row in rows:
        if row.ratio is None:
            lines.append([row.name, "-", row.verdict])
            continue
        where = "" if row.exact else f", after {EARLY_STEPS} steps"
        same = "none, bit by bit" if row.difference == 0 else f"{row.difference:.1e}{where}"
        lines.append([row.name, percent(row.ratio - 1, 1, "+"), same])
    for name in ("gz", "binary"):
        if formats.get("text") and formats.get(name):
            change = percent(formats[name] / formats["text"] - 1, 1, "+")
            lines.append([f"dump as {name} instead of text", change, "-"])
    return markdown(["put back in", "time with it", "largest change of the trajectory"], "lrr", lines) + "\n"
