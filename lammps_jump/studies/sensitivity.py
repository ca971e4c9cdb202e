"""``lammps-jump sensitivity``: the jump against disc size, restitution, friction, stiffness, Froude number and sill.

The thesis' recommendation 1. Every study changes one thing of a base case, the frictionless ``quick_jump`` (a jet of
0.6 m at 10 m/s against a 1.2 m sill), and measures the jump in the frame of its moving front, from a few slightly moved
starts. Resumable: finished runs are kept in ``sensitivity.json``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.errors import CaseError
from lammps_jump.physics import jump as theory
from lammps_jump.studies.bench.runs import run_setting
from lammps_jump.studies.bench.settings import Setting, usable_kernels

from .timing import Store, in_turn, machine, versions

DEPTH, GRAVITY = 0.6, 9.81
BASE_FROUDE = theory.froude(10.0, DEPTH, GRAVITY)


@dataclass(frozen=True)
class Study:
    """One parameter and its values.

    Attributes
    ----------
    name, label : str
    values, quick : tuple of float
    assign : callable
        value -> ``--set`` texts.
    base : float
        The base case's value.
    dear : float
        From this value on a run takes so long that two starts must do.
    """

    name: str
    label: str
    values: tuple[float, ...]
    quick: tuple[float, ...]
    assign: Callable[[float], list[str]]
    base: float
    dear: float = float("inf")


def _diameter(rows: float) -> list[str]:
    return [f"discs.diameter={DEPTH / rows!r}"]


def _froude(number: float) -> list[str]:
    """Another speed of the same jet; channel, time and sill grow with the jump that is to be expected."""
    speed = number * sqrt(GRAVITY * DEPTH)
    y2 = theory.sequent_depth(speed, DEPTH, GRAVITY)
    reach = max(20.0, 5.0 * y2)  # jumps of discs are about y2 long, water's would not fit
    sill = max(0.3, 1.2 * theory.sill_holding_height(speed, DEPTH, GRAVITY) / _HOLDING)
    end = reach + 0.6
    # the bore travels upstream at about (discharge held back)/(y2 - y1): a third of the channel in this time
    duration = reach / speed + 0.4 * reach * (y2 - DEPTH) / (0.65 * speed * DEPTH)
    return [
        f"inflow.mean_speed={speed!r}", f"contact.impact_speed={speed!r}",
        f"walls.floor.x=[-5, {reach + 0.2!r}]", f"walls.sill.x=[{reach!r}, {end!r}]", f"walls.sill.y=[-5, {sill!r}]",
        f"domain.x=[-1, {reach + 14!r}]", "domain.y=[-8, 40]", f"outflow.0.x_beyond={reach + 9!r}",
        f"run.duration={duration!r}", f"analysis.window=[{0.67 * duration!r}, {duration!r}]",
        f"run.output_interval={duration / 90!r}",
    ]  # fmt: skip


_HOLDING = theory.sill_holding_height(10.0, DEPTH, GRAVITY)

STUDIES = {
    study.name: study
    for study in (
        Study("diameter", "inflow depth over disc diameter", (5.0, 10.0, 20.0), (4.0,), _diameter, 4.0, dear=20.0),
        Study("restitution", "restitution coefficient", (0.05, 0.2, 0.4, 0.6, 0.8, 0.95), (0.2,),
              lambda e: [f"contact.restitution={e!r}"], 0.2),
        Study("friction", "friction coefficient ks", (0.0, 0.01, 0.02, 0.05, 0.1, 0.2), (0.1,),
              lambda ks: [f"contact.friction={ks!r}"], 0.0),
        Study("stiffness", "penetration fraction n", (5.0, 10.0, 20.0, 40.0), (5.0,),
              lambda n: [f"contact.penetration_fraction={n!r}"], 10.0),
        Study("froude", "inflow Froude number", (2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0), (3.0,), _froude, BASE_FROUDE,
              dear=7.0),
        Study("sill", "sill height over inflow depth", (1.0, 1.5, 2.0, 2.5, 3.0), (2.0,),
              lambda s: [f"walls.sill.y=[-5, {s * DEPTH!r}]"], 2.0),
    )
}  # fmt: skip
QUICK_TEXTS = ["discs.diameter=0.2", "run.duration=5", "analysis.window=[3.5, 5]", "run.output_interval=0.1"]


def fast_setting(texts: list[str], path: Path) -> Setting:
    """The quickest kernel at f = 0.1, or less where that is not stable for these coefficients."""
    from lammps_jump.case import load_case
    from lammps_jump.studies.bench.settings import stable

    usable, _ = usable_kernels()
    kernel = "compiled" if "compiled" in usable else "native"
    restitution = load_case(path, texts).fields.contact.restitution
    return next(s for s in (Setting(kernel, f) for f in (0.1, 0.05, 0.02)) if stable(s, restitution))


def base_file(folder: Path, name: str = "quick_jump") -> Path:
    """A scene of the package as a file of the study's folder."""
    from lammps_jump.case.templates import scene_text

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.yaml"
    path.write_text(scene_text(name))
    return path


def run_sensitivity(
    out: Path | None = None, *, quick: bool = False, only: str | None = None, members: int | None = None,
    fresh: bool = False, figures: bool = True, say: Callable[[str], None] = print,
) -> str:  # fmt: skip
    """All studies, or those named in `only`; returns their tables as markdown.

    Parameters
    ----------
    out : Path, optional
        Default ``runs/sensitivity``.
    quick : bool
        One value a study, one start, coarse discs.
    only : str, optional
        Names of `STUDIES`, comma-separated.
    members : int, optional
        Starts of every value; default 4 (1 if quick), 2 for the dearest values.
    fresh : bool
    figures : bool
    say : callable

    Raises
    ------
    CaseError
        An unknown study.
    """
    names = [word.strip() for word in only.split(",")] if only else list(STUDIES)
    for name in names:
        if name not in STUDIES:
            raise CaseError(f"--only: there is no study '{name}'; allowed are {', '.join(STUDIES)}")
    folder = Path(out) if out else Path("runs") / "sensitivity"
    store = Store(folder / "sensitivity.json", fresh=fresh)
    path = base_file(folder)
    found = store.data.setdefault("studies", {})
    for name in names:
        study = STUDIES[name]
        found[name] = run_study(study, path, store, quick=quick, members=members, say=say)
        if figures:
            from .sensitivity_figures import draw_study

            draw_study(study, found[name], folder / f"sensitivity_{name}.png")
    store.data |= {"versions": versions(), "machine": machine()}
    store.save()
    text = "\n".join(study_table(STUDIES[name], found[name]) for name in names)
    (folder / "sensitivity.md").write_text(text)
    return text


def run_study(
    study: Study, path: Path, store: Store, *, quick: bool, members: int | None, say: Callable[[str], None]
) -> list[dict[str, Any]]:
    """Rows (one a value) of means and standard errors over the starts."""
    values = study.quick if quick else study.values
    count = members or (1 if quick else 4)
    runs: dict[float, list[dict[str, Any]]] = {value: [] for value in values}
    for member, value in in_turn(values, count):
        if value >= study.dear and member >= 2:
            continue  # minutes each; large numbers of discs scatter less
        texts = [*(QUICK_TEXTS if quick else []), *study.assign(value)]
        setting = fast_setting(texts, path)
        key = f"{study.name} {value} {member} {texts} {setting.label}"
        run = store.piece(key, lambda t=texts, s=setting, m=member: run_setting(path, t, s, m))
        runs[value].append(run)
        say(f"  {study.label} = {value:g}, start {member + 1}: {run['measures'].get('verdict') or run['message']}")
    return [{"value": value, **summarise_runs(runs[value])} for value in values]


NUMBERS = ("froude", "sequent_ratio", "belanger_ratio", "density_ratio", "length_over_y2", "length_usbr", "y2", "speed")


def summarise_runs(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Mean and standard error of the mean of each number, over the runs that found a jump; verdicts counted."""
    verdicts = [run["measures"].get("verdict") or run["status"] for run in runs]
    jumps = [run["measures"]["jump"] for run in runs if run["measures"].get("verdict") == "jump"]
    row: dict[str, Any] = {"verdicts": {word: verdicts.count(word) for word in dict.fromkeys(verdicts)}}
    row["seconds"] = float(np.median([run.get("cpu_seconds") or 0.0 for run in runs])) if runs else None
    for name in NUMBERS:
        values = np.array([jump[name] for jump in jumps if jump.get(name) is not None], float)
        row[name] = float(values.mean()) if len(values) else None
        row[f"{name}_error"] = float(values.std(ddof=1) / sqrt(len(values))) if len(values) > 1 else None
    ratio, expected = row["sequent_ratio"], row["belanger_ratio"]
    row["deviation"] = ratio / expected - 1 if ratio and expected else None
    usbr = [jump["length_usbr"] / jump["y2"] for jump in jumps if jump.get("length_usbr") and jump.get("y2")]
    row["usbr"] = float(np.mean(usbr)) if usbr else None
    return row


def study_table(study: Study, rows: list[dict[str, Any]]) -> str:
    """Markdown of one study."""
    lines = [
        f"### {study.label} (base {study.base:.3g})",
        "",
        "| value | found | Fr, front's frame | y2/y1 | Bélanger | deviation | L/y2 | USBR | front (m/s) | CPU (s) |",
        "|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        found = ", ".join(f"{count} {word}" for word, count in row["verdicts"].items())
        cells = [_number(row, name) for name in ("froude", "sequent_ratio", "belanger_ratio")]
        cells.append("-" if row["deviation"] is None else f"{100 * row['deviation']:+.1f} %")
        cells += [
            _number(row, "length_over_y2"),
            "-" if row["usbr"] is None else f"{row['usbr']:.2f}",
            _number(row, "speed"),
        ]
        lines.append(f"| {row['value']:g} | {found} | " + " | ".join(cells) + f" | {row['seconds']:.1f} |")
    return "\n".join(lines) + "\n"


def _number(row: dict[str, Any], name: str) -> str:
    if row[name] is None:
        return "-"
    error = row.get(f"{name}_error")
    return f"{row[name]:.2f}" + (f" ± {error:.2f}" if error is not None else "")
