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
from functools import partial
from pathlib import Path

import numpy as np

from lammps_jump.dump.read import open_dump
from lammps_jump.errors import RunError
from lammps_jump.scene.scene import Scene
from lammps_jump.script import script_text
from lammps_jump.studies.runs import StudyCase, execute, kernel_changes
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
    edit : callable
        (script, scene) -> script with the thing in it; the same text where the scene needs it anyway.
    exact : bool
        Trajectories are equal bit by bit, else to 1e-12 m after `EARLY_STEPS` steps.
    """

    name: str
    edit: Callable[[str, Scene], str]
    exact: bool = True


def _after(text: str, pattern: str, line: str) -> str:
    """Return the text with `line` behind the first line that matches."""
    return re.sub(f"(?m)^({pattern}.*)$", rf"\1\n{line}", text, count=1)


def _friction(text: str, scene: Scene) -> str:
    # a coefficient of 0 with a tangential dashpot: computed in every contact, and worth nothing
    rate = 3.0 * scene.coefficients.omega
    text = re.sub(r"(?m)^(pair_style +gran/hooke \S+ \S+ \S+) 0 0 0$", rf"\1 {rate:.6g} 0 1", text)
    return re.sub(r"(wall/gran(?:/region)? hooke \S+ \S+ \S+) 0 0 0", rf"\1 {rate:.6g} 0 1", text)


def _spin(text: str, scene: Scene) -> str:
    return re.sub(r"(?m)^(fix +motion all) nve$", r"\1 nve/sphere disc", text)


def _gravity(text: str, scene: Scene) -> str:
    return text if any(scene.gravity) else _after(text, "fix +motion", "fix gravity all gravity 0 vector 0 -1 0")


def _wall(text: str, scene: Scene) -> str:
    c, (low, _) = scene.coefficients, scene.domain[1]
    law = f"hooke {c.stiffness!r} NULL {max(c.gamma_normal_wall, 1e-12)!r} 0 0 0"
    return _after(text, "fix +motion", f"fix far all wall/gran {law} yplane {low - 100.0!r} NULL")


def _plane_constraint(text: str, scene: Scene) -> str:
    return re.sub(r"(?m)^(# --- guards)$", r"fix flat all enforce2d\n\1", text)


def _probe(text: str, scene: Scene) -> str:
    lines = "compute push all reduce sum fx fy\nfix push all ave/time 1 100 100 c_push[1] c_push[2]"
    return re.sub(r"(?m)^(# --- guards)$", lines + r"\n\1", text)


def _columns(text: str, scene: Scene) -> str:
    return re.sub(r"(?m)^(dump +frames all \S+ \d+ \S+) id x y vx vy.*$", rf"\1 {FULL_COLUMNS}", text)


def _thermo(text: str, scene: Scene) -> str:
    return re.sub(r"(?m)^thermo +\d+$", "thermo 10", text)


def _frames(text: str, scene: Scene) -> str:
    # into a second file, so that the frames that are compared stay the same
    every = max(1, scene.output_steps // 10)
    more = rf"\1\ndump more all custom {every} more.lammpstrj id x y vx vy"
    return re.sub(r"(?m)^(dump +frames .*)$", more, text)


def _skin(text: str, scene: Scene, share: float) -> str:
    return re.sub(r"(?m)^neighbor +\S+ bin$", f"neighbor {share * scene.diameter!r} bin", text)


def _lists(text: str, scene: Scene) -> str:
    return re.sub(r"(?m)^neigh_modify.*$", "neigh_modify delay 0 every 5 check no", text)


SKIPS = (
    Skip("friction terms (ks = 0)", _friction),
    Skip("integration of spin", _spin),
    Skip("gravity of 0", _gravity),
    Skip("a wall out of reach", _wall),
    Skip("constraint to z = 0", _plane_constraint),
    Skip("sums over forces at every step", _probe),
    Skip("dump columns that no analysis reads", _columns),
    Skip("ten times as many frames", _frames),
    Skip("log lines every 10 steps", _thermo),
    Skip("neighbour lists every 5 steps, needed or not", _lists, exact=False),
    Skip("skin of 0.1 d", partial(_skin, share=0.1), exact=False),
    Skip("skin of 0.6 d", partial(_skin, share=0.6), exact=False),
)


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
        result, watch = execute(scene, Path(folder), "stock", script=text)
        if result.status != "complete":
            raise RunError(result.message)
        *_, last = open_dump(Path(folder) / "dump.lammpstrj")
    last = last.sorted()
    return np.column_stack([last.ids, last.x, last.y, last.vx, last.vy]), watch.cpu


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
            taken[name].append(execute(scene, Path(folder), "stock", dump_format=name)[1].cpu)
    return {name: middle(values) for name, values in taken.items()}


def bench_skips(case: StudyCase, store: Store, *, quick: bool = False, say: Callable[[str], None] = print) -> str:
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
