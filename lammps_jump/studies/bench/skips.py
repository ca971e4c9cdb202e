"""What each thing left out of a script saves, on the stock LAMMPS script, by putting it back in.

Every row takes the script that the generator writes, edits the one thing in, runs both in turn, and compares the last
frame: the trajectory must not change. Where the order of sums changes (another skin, other list builds) the comparison
is made after few steps, before chaos has had time to grow.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.errors import RunError
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.timing import Store, in_turn, machine, middle, versions

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
    """`line` put behind the first line that matches."""
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


def _skin(share: float) -> Callable[[str, Scene], str]:
    def edit(text: str, scene: Scene) -> str:
        return re.sub(r"(?m)^neighbor +\S+ bin$", f"neighbor {share * scene.diameter!r} bin", text)

    return edit


def _lists(text: str, scene: Scene) -> str:
    return re.sub(r"(?m)^neigh_modify.*$", "neigh_modify delay 0 every 5 check no", text)


SKIPS = (
    Skip("friction terms (ks = 0)", _friction),
    Skip("integration of spin", _spin),
    Skip("gravity of 0", _gravity),
    Skip("a wall out of reach", _wall),
    Skip("constraint to z = 0", _plane_constraint),
    Skip("sums over forces at every step", _probe),
    Skip("dump columns that nobody reads", _columns),
    Skip("ten times as many frames", _frames),
    Skip("log lines every 10 steps", _thermo),
    Skip("neighbour lists every 5 steps, needed or not", _lists, exact=False),
    Skip("skin of 0.1 d", _skin(0.1), exact=False),
    Skip("skin of 0.6 d", _skin(0.6), exact=False),
)


def base_script(scene: Scene, plugin: None = None) -> str:
    """The generator's stock script, every digit in the dump."""
    from lammps_jump.script import script_text

    return script_text(scene, kernel="stock").replace(*PRECISE)


def run_script(scene: Scene, text: str) -> tuple[np.ndarray, float]:
    """Last frame (id, x, y, vx, vy; shape (n, 5)) and processor seconds of a script for a scene.

    Raises
    ------
    RunError
        Where it does not come to its end.
    """
    from lammps_jump.dump.read import open_dump
    from lammps_jump.engines.launch import Setting, run

    with tempfile.TemporaryDirectory() as folder:
        result = run(scene, Path(folder), Setting(script=text))
        if result.status != "complete":
            raise RunError(result.message)
        last = None
        for frame in open_dump(Path(folder) / "dump.lammpstrj"):
            last = frame.sorted()
    return np.column_stack([last.ids, last.x, last.y, last.vx, last.vy]), result.cpu_seconds


def largest_difference(one: np.ndarray, two: np.ndarray) -> float:
    """Largest difference of positions (m) or velocities (m/s); infinite where the discs are not the same."""
    if one.shape != two.shape or not np.array_equal(one[:, 0], two[:, 0]):
        return float("inf")
    return float(np.abs(one[:, 1:] - two[:, 1:]).max(initial=0.0))


def shortened(scene: Scene, steps: int) -> Scene:
    """The same scene for few steps, one frame at the end."""
    return replace(scene, steps=steps, settle_steps=0, gates=(), output_steps=steps, probe_steps=steps)


def compare_skip(scene: Scene, skip: Skip) -> float | None:
    """Largest difference that putting the thing in makes to a trajectory; None where the scene needs it anyway."""
    scene = scene if skip.exact else shortened(scene, min(scene.steps, EARLY_STEPS))
    plain = base_script(scene)
    edited = skip.edit(plain, scene)
    if edited == plain:
        return None
    return largest_difference(run_script(scene, plain)[0], run_script(scene, edited)[0])


def dump_formats(scene: Scene, rounds: int) -> dict[str, float]:
    """Processor seconds of a stock run by dump format."""
    from .runs import execute

    taken: dict[str, list[float]] = {"text": [], "gz": [], "binary": []}
    for _, name in in_turn(list(taken), rounds):
        with tempfile.TemporaryDirectory() as folder:
            taken[name].append(execute(scene, Path(folder), "stock", dump_format=name)[1].cpu)
    return {name: middle(values) for name, values in taken.items()}


def bench_skips(
    case: Path, *, out: Path | None = None, quick: bool = False, assignments: Sequence[str] = (), fresh: bool = False,
    say: Callable[[str], None] = print,
) -> str:  # fmt: skip
    """``lammps-jump bench CASE --skips``: time that each skip saves, and that it changes nothing; a markdown table."""
    from lammps_jump.case import case_hash, load_case
    from lammps_jump.case.to_scene import build_scene

    texts = [*assignments, "engine.name=lammps", "engine.kernel=stock"]
    loaded = load_case(case, texts)
    scene = build_scene(loaded)
    folder = Path(out) if out else Path("runs") / "bench" / loaded.case.name
    store = Store(folder / "skips.json", fresh=fresh)
    rounds = 1 if quick else 5
    identity = f"{case_hash(loaded.case)} {versions()} {rounds}"
    rows: list[dict[str, Any]] = []
    for skip in SKIPS:
        row = store.piece(f"{skip.name} {identity}", lambda s=skip: _skip_row(scene, s, rounds))
        rows.append(row)
        say(f"  {skip.name}: " + (row["verdict"]))
    formats = store.piece(f"formats {identity}", lambda: dump_formats(scene, rounds))
    store.data |= {"case": loaded.case.name, "rows": rows, "formats": formats, "machine": machine(), "rounds": rounds}
    store.save()
    table = skip_table(rows, formats)
    (folder / "skips.md").write_text(table)
    return table


def _skip_row(scene: Scene, skip: Skip, rounds: int) -> dict[str, Any]:
    plain = base_script(scene)
    edited = skip.edit(plain, scene)
    if edited == plain:
        return {"name": skip.name, "ratio": None, "difference": None, "verdict": "the scene needs it"}
    taken: dict[str, list[float]] = {plain: [], edited: []}
    for _, text in in_turn([plain, edited], rounds):
        taken[text].append(run_script(scene, text)[1])
    ratio = middle(with_it / without for with_it, without in zip(taken[edited], taken[plain], strict=True))
    difference = compare_skip(scene, skip)
    verdict = f"{100 * (ratio - 1):+.1f} % time with it, trajectory differs by {difference:.1e}"
    return {"name": skip.name, "ratio": ratio, "difference": difference, "exact": skip.exact, "verdict": verdict}


def skip_table(rows: list[dict[str, Any]], formats: dict[str, float]) -> str:
    """Markdown."""
    lines = ["| put back in | time with it | largest change of the trajectory |", "|---|---:|---:|"]
    for row in rows:
        if row["ratio"] is None:
            lines.append(f"| {row['name']} | - | the scene needs it |")
            continue
        where = "" if row["exact"] else f", after {EARLY_STEPS} steps"
        same = "none, bit by bit" if row["difference"] == 0 else f"{row['difference']:.1e}{where}"
        lines.append(f"| {row['name']} | {100 * (row['ratio'] - 1):+.1f} % | {same} |")
    for name in ("gz", "binary"):
        if formats.get("text") and formats.get(name):
            lines.append(
                f"| dump as {name} instead of text | {100 * (formats[name] / formats['text'] - 1):+.1f} % | - |"
            )
    return "\n".join(lines) + "\n"
