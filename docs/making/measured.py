# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of the site that were measured: made by ``make measured X=…``, kept in ``docs/measured``, shown by the build.

Each file holds the rows of a study, the command, the minutes, commit, versions, machine, and the keys of what was
measured. ``tests/docs/test_measured.py`` compares these keys with those of today.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import lammps_jump as lj
from lammps_jump.analysis.tables import markdown, paragraphs
from lammps_jump.identity import scene_key
from lammps_jump.provenance import machine, versions
from lammps_jump.studies import bench, sensitivity
from lammps_jump.studies.bench import collision_scene
from lammps_jump.studies.cross_validation.study import micro_scenes
from lammps_jump.studies.points import TREE, load_module

from . import calibrated, crossed, jumps, laws

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "benchmarks"))

import collisions  # noqa: E402
from command_overhead import overhead_page  # noqa: E402
from kernel_speed import speed_page  # noqa: E402

stress = load_module(TREE / "stress", "study")
limits = load_module(TREE / "stress", "limits")

FOLDER = ROOT / "docs" / "measured"
RUNS = ROOT / "runs" / "measured"
Keys = dict[str, str]
Data = Mapping[str, Any]


class Measure(NamedTuple):
    """A table that is measured.

    Attributes
    ----------
    command : str
        What measures it, without ``lammps-jump``, or a program of ``benchmarks/``; ``--out`` is set by `make`.
    keys : callable
        Hash of each case or scene that it measures, as it is today.
    rows : callable
        From the folder of the study to what the table needs.
    table : callable
        Markdown of it.
    figures : callable
        Draws its figures into a folder; returns each file by what it shows.
    """

    command: str
    keys: Callable[[], Keys]
    rows: Callable[[Path], Data]
    table: Callable[[Data], str]
    figures: Callable[[Data, Path], dict[str, Path]] = lambda data, place: {}


def make(name: str) -> None:
    """Measure one table and write its file."""
    measure = MEASURES[name]
    command = [*measure.command.split(), "--out", str(RUNS / name)]
    begin = time.monotonic()
    subprocess.run([sys.executable, *_program(measure.command), *command], cwd=ROOT, check=True)
    minutes = (time.monotonic() - begin) / 60
    write(name, measure.rows(Path(command[-1])), minutes)


def _program(command: str) -> tuple[str, ...]:
    """What Python is told to run before the words of a command: nothing where they begin with a file."""
    return () if command.startswith("benchmarks/") else ("-m", "lammps_jump")


def write(name: str, rows: Data, minutes: float) -> None:
    """Write the file of a table that has just been measured."""
    measure = MEASURES[name]
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    data = {
        "command": f"{'lammps-jump' if _program(measure.command) else 'python'} {measure.command}",
        "minutes": round(minutes, 1),
        "commit": commit.stdout.strip(),
        "versions": versions("lammps"),
        "machine": machine(),
        "keys": measure.keys(),
        **rows,
    }
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.json").write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n")


def fragment(name: str, folder: Path = FOLDER, place: Path | None = None) -> str:
    """The figures, drawn into a `place`, the table of a file, and below it what measured it, Markdown.

    Raises
    ------
    ValueError
        A table of other cases than those of today.
    """
    if old := stale(name, folder):
        raise ValueError(f"{name}.json is of other cases: {', '.join(old)}; make measured X={name} measures them again")
    data = json.loads((folder / f"{name}.json").read_text())
    told = ", ".join(f"{key.replace('_', '-')} {text}" for key, text in data["versions"].items())
    about = f"`{data['command']}` · commit `{data['commit']}` · {told} · {data['machine']['processor']}"
    figures = MEASURES[name].figures(data, place) if place else {}
    shown = "".join(f"![{title}](_made/measured/{path.name})\n\n" for title, path in figures.items())
    return f"{shown}{MEASURES[name].table(data)}\n\n```{{admonition}} Measured\n:class: dropdown\n{about}\n```\n"


def stale(name: str, folder: Path = FOLDER) -> list[str]:
    """Cases of a file that are not those of today."""
    stored, today = json.loads((folder / f"{name}.json").read_text())["keys"], MEASURES[name].keys()
    return sorted(case for case in stored.keys() | today.keys() if stored.get(case) != today.get(case))


def case_keys(*changes: Mapping[str, object], scene: str = "quick_jump") -> Keys:
    """Hash of a scene of ``inputs/`` with each of these changes."""
    case = lj.load_case(ROOT / "inputs" / f"{scene}.yaml")
    return {f"{scene} {json.dumps(one)}" if one else scene: case.replace(one).hash for one in changes}


def _sensitivity(name: str) -> Measure:
    study = sensitivity.STUDIES[name]
    return Measure(
        f"sensitivity --only {name}",
        lambda: case_keys(*study.settings.values()),
        lambda folder: {"rows": json.loads((folder / "sensitivity.json").read_text())["studies"][name]},
        lambda data: markdown(sensitivity.COLUMNS, data["rows"]),
        partial(_draw_sensitivity, name),
    )


def _draw_sensitivity(name: str, data: Data, place: Path) -> dict[str, Path]:
    path = place / f"sensitivity_{name}.png"
    sensitivity.draw_study(sensitivity.STUDIES[name], data["rows"], path)
    return {sensitivity.STUDIES[name].label: path}


def _bench(scene: str, options: str = "") -> Measure:
    return Measure(
        f"bench inputs/{scene}.yaml {options}".strip(),
        lambda: case_keys({}, scene=scene),
        _bench_rows,
        lambda data: paragraphs(*bench.page(dict(data))[1:]).strip(),
        partial(_draw_bench, scene),
    )


DRAWN = ("energy deviation", "front position", "sequent depth", "shock speed")
"""Quantities whose time against error is drawn."""


def _draw_bench(scene: str, data: Data, place: Path) -> dict[str, Path]:
    found = {}
    for name in DRAWN:
        if "pareto" in data["quantities"].get(name, {}):
            path = place / f"bench_{scene}_{name.replace(' ', '_')}.png"
            found[f"{scene}: {name}"] = bench.draw_quantity(dict(data), name, place).replace(path)
    return found


def _cross(scene: str, members: int) -> Measure:
    return Measure(
        f"cross-validate inputs/{scene}.yaml --members {members}",
        lambda: case_keys({}, scene=scene) | {one.name: scene_key(one) for one in micro_scenes()},
        crossed.rows,
        crossed.table,
    )


def _speed(scene: str, more: str = "") -> Measure:
    return Measure(
        f"benchmarks/kernel_speed.py inputs/{scene}.yaml{more}",
        lambda: case_keys({}, scene=scene),
        lambda folder: {name: json.loads((folder / "speed.json").read_text())[name] for name in ("rows", "agreement")},
        lambda data: paragraphs(*speed_page(dict(data), RUNS)),
    )


def _overhead(scene: str) -> Measure:
    names = ("case", "rows", "rounds", "ratios", "cpu_ratios")
    return Measure(
        f"benchmarks/command_overhead.py inputs/{scene}.yaml",
        lambda: case_keys({}, scene=scene),
        lambda folder: {name: json.loads((folder / "overhead.json").read_text())[name] for name in names},
        lambda data: paragraphs(*overhead_page(dict(data), RUNS)),
    )


def _scale_table(data: Data) -> str:
    columns = {
        "discs:": "{discs:,.0f}",
        "1 thread, ns:": lambda row: f"{row['threads']['1']:.1f}",
        "2 threads, ns:": lambda row: f"{row['threads']['2']:.1f}",
        "2 over 1:": lambda row: f"{row['threads']['1'] / row['threads']['2']:.2f}",
        "plain loop, ns:": "{plain:.1f}",
        "peak, MB:": lambda row: f"{row['peak'] / 1e6:,.0f}",
    }
    return markdown(columns, data["rows"])


def _peers_table(data: Data) -> str:
    columns = {
        "discs:": "{discs:,.0f}",
        "law": "{law}",
        "program": "{program}",
        "ns a disc-step:": "{ns:.0f}",
        "least to most": "{least:.0f} to {most:.0f}",
        "centre of mass apart, d:": "{apart:.1e}",
    }
    return markdown(columns, data["rows"])


def _bench_rows(folder: Path) -> Data:
    """What the page of a benchmark shows; the rest of its file is megabytes of single runs."""
    data = json.loads((folder / "bench.json").read_text())
    rows = [
        {
            key: row.get(key)
            for key in ("label", "family", "plain", "failed", "seconds", "disc_steps_per_second", "errors")
        }
        for row in data["rows"]
    ]
    quantities = {
        name: {key: found[key] for key in ("cheapest", "pareto", "floor")} for name, found in data["quantities"].items()
    }
    kept = {key: data[key] for key in ("case", "duration", "members", "reference", "time")}
    return {**kept, "quantities": quantities, "rows": rows}


FEW_STEPS = (0.01, 0.05, 0.1, 0.2)


def _collision_table(data: Data) -> str:
    shown = [row for row in data["rows"] if row["restitution"] == 0.2 and row["fraction"] in FEW_STEPS]

    def error(row: Data, name: str) -> str:
        return f"{100 * row[f'{name}_error']:+.2f} ± {100 * row[f'{name}_scatter']:.2f} %"

    columns = {"way": "", "f:": "{fraction:g}"}
    return markdown(columns | {f"{name}:": partial(error, name=name) for name in collisions.QUANTITIES}, shown)


def _draw_collision(data: Data, place: Path) -> dict[str, Path]:
    collisions.draw_collisions(data["rows"], place / "bench_collision.png")
    return {"errors of restitution": place / "bench_collision.png"}


def _collision_keys() -> Keys:
    return {f"e = 0.2, f = {f:g}": scene_key(collision_scene(f, 0.2)) for f in FEW_STEPS}


PACKED = ("pair", "wall", "square")
"""Arrangements whose scenes cost nothing to make."""
LIMITS_OF = {
    "pair": "pair",
    "wall": "disc on a wall",
    "square": "square packing",
    "hexagonal": "hexagonal packing",
    "column": "deep column",
}


def _stability_rows(folder: Path) -> Data:
    data = json.loads((folder / "stress.json").read_text())
    keys = ("arrangement", "restitution", "friction", "rotation", "engine", "predicted", "measured", "deviation")
    rows = [{key: row[key] for key in keys} for row in data["limits"]]
    return {"rows": rows, "growth": data["growth"]}


def _stability_table(data: Data) -> str:
    """Limits without friction, an arrangement and restitution a row, the engines side by side."""
    found: dict[tuple, dict[str, Any]] = {}
    for row in data["rows"]:
        if row["friction"]:
            continue
        line = found.setdefault((row["arrangement"], row["restitution"]), {})
        line |= {"arrangement": LIMITS_OF[row["arrangement"]], "e": row["restitution"], row["engine"]: row["measured"]}
        line[limits.integrator_of(row["engine"])] = row["predicted"]
    columns = {
        "arrangement": "",
        "e:": "{e:g}",
        "Verlet, closed form:": "{velocity_verlet:.4f}",
        "stock:": "{stock:.3f}",
        "compiled:": "{compiled:.3f}",
        "native:": "{native velocity_verlet:.3f}",
        "leap-frog, closed form:": "{leapfrog_extrapolated:.4f}",
        "native leap-frog:": "{native leapfrog_extrapolated:.3f}",
    }
    return markdown(columns, found.values())


def _draw_stability(data: Data, place: Path) -> dict[str, Path]:
    return {"limits of the step against restitution": stress.draw_map(data["rows"], place / "stress_map.png")}


def _stability_keys() -> Keys:
    return {name: scene_key(limits.arrangement_scene(name, 0.2, 0.2, "velocity_verlet")) for name in PACKED}


def _calibration(name: str) -> Measure:
    return Measure(
        f"calibrate validation/calibrate/{name}.yaml",
        partial(calibrated.keys, name),
        calibrated.rows,
        partial(calibrated.table, name),
        partial(calibrated.figures, name),
    )


MEASURES: dict[str, Measure] = {
    **{f"sensitivity_{name}": _sensitivity(name) for name in sensitivity.STUDIES},
    "collision": Measure(
        "benchmarks/collisions.py",
        _collision_keys,
        lambda folder: {"rows": json.loads((folder / "collision.json").read_text())["rows"]},
        _collision_table,
        _draw_collision,
    ),
    "stability": Measure("stress --random 0", _stability_keys, _stability_rows, _stability_table, _draw_stability),
    "bench_energy_box_16": _bench("energy_box_16", "--members 7"),
    "bench_dam_break": _bench("dam_break", "--axes f,touch,kernel --fractions 0.05,0.1,0.2 --members 4"),
    "bench_quick_jump": _bench("quick_jump", "--axes f,touch,kernel --fractions 0.05,0.1,0.2 --members 3"),
    "speed_dam_break": _speed("dam_break"),
    "speed_quick_jump": _speed("quick_jump", " --quick"),
    "overhead_quick_jump": _overhead("quick_jump"),
    "overhead_stable_jump": _overhead("stable_jump"),
    "scale": Measure(
        "benchmarks/scale.py 1e3 1e4 1e5 1e6 1e7",
        lambda: case_keys({}, scene="dam_break"),
        lambda folder: {"rows": json.loads((folder / "scale.json").read_text())},
        _scale_table,
    ),
    "peers": Measure(
        "benchmarks/peers.py 1200 12000 --turns 3",
        lambda: case_keys({}, scene="dam_break"),
        lambda folder: {"rows": json.loads((folder / "peers.json").read_text())},
        _peers_table,
    ),
    "cross_energy_box_16": _cross("energy_box_16", 8),
    "cross_quick_jump": _cross("quick_jump", 6),
    "cross_dam_break": _cross("dam_break", 6),
    "stream": Measure(
        "build-and-run inputs/hydraulic_jump_frictionless.yaml --set run.output_interval=0.05 --force",
        lambda: case_keys({"run.output_interval": 0.05}, scene="hydraulic_jump_frictionless"),
        jumps.stream_rows,
        jumps.stream_table,
    ),
    "starts": Measure(
        f"build-and-run inputs/quick_jump.yaml --members 16 --collect {','.join(jumps.STARTS)}",
        lambda: case_keys({}),
        jumps.starts_rows,
        jumps.starts_table,
    ),
    "calibration_discs": _calibration("discs"),
    "calibration_rods": _calibration("rods"),
    "calibration_water": _calibration("like_water"),
    "calibration_twins": Measure(
        "benchmarks/calibration_twins.py", calibrated.twin_keys, calibrated.twin_rows, calibrated.twin_table
    ),
    "thesis": Measure("validate thesis", partial(laws.keys, "thesis"), partial(laws.rows, page="thesis"), laws.table),
    "others": Measure("validate others", partial(laws.keys, "others"), partial(laws.rows, page="others"), laws.table),
    "validation": Measure("validate", laws.keys, laws.rows, laws.table),
}
"""By the name of the file in ``docs/measured``."""


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in MEASURES:
        sys.exit("make measured X=NAME, NAME one of " + ", ".join(MEASURES))
    make(sys.argv[1])
