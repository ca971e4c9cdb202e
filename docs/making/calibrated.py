# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables and figures of calibrations: of the runs that are stored, without running any."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import lammps_jump as lj
from lammps_jump.analysis.tables import markdown
from lammps_jump.calibration import page, read_calibration
from lammps_jump.calibration.model import model_of
from lammps_jump.calibration.posterior import sample
from lammps_jump.calibration.study import Calibration
from lammps_jump.identity import short_hash
from lammps_jump.runs.summary import read_summary

ROOT = Path(__file__).parents[2]
STUDIES = ROOT / "validation" / "calibrate"
TWINS = ROOT / "benchmarks" / "twins"
Data = Mapping[str, Any]
KEPT = ("verdict", "notes", "parameters", "targets", "correlation", "runs", "failed", "rounds", "nearest")


def study_of(name: str) -> Calibration:
    """A study file of ``validation/calibrate``."""
    return read_calibration(STUDIES / f"{name}.yaml")


def keys(name: str) -> dict[str, str]:
    """Hash of the case of a study, and of what is varied and measured."""
    study = study_of(name)
    asked = {"vary": study.vary, "targets": [one.as_field for one in study.targets]}
    return {"case": study.case.hash, "study": short_hash(json.loads(json.dumps(asked)))}


def twin_keys() -> dict[str, str]:
    """Hash of each case of the twins."""
    return {path.stem: lj.load_case(path).hash for path in sorted(TWINS.glob("*.yaml"))}


def rows(folder: Path) -> Data:
    """The answer in a folder, its points, and the values of each target in the runs, rounded to six digits."""
    found, study = lj.Calibrated(folder), read_calibration(folder)
    points = [one for one in found.data["points"] if one["runs"]]
    values = {target.name: [] for target in study.targets}
    for one in points:
        for target in study.targets:
            runs = [target.of_run(folder / run, read_summary(folder / run)) for run in one["runs"]]
            lacking = [np.full(len(target.measured), np.nan)] * (study.members - len(runs))
            values[target.name].append([_short(run) for run in [*runs, *lacking]])
    return {
        "rows": {key: found.data.get(key) for key in KEPT},
        "points": [list(one["values"].values()) for one in points],
        "values": values,
    }


def _short(values: np.ndarray) -> list[float | None]:
    return [float(f"{one:.6g}") if np.isfinite(one) else None for one in values]


def table(name: str, data: Data) -> str:
    """The verdict, the numbers that were looked for, and what was measured beside the best."""
    found, study = data["rows"], study_of(name)
    numbers = [{"path": f"`{path}`", **one, "lowest": one["prior"][0], "highest": one["prior"][1]}
               for path, one in found["parameters"].items()]  # fmt: skip
    columns = {
        "path": "", "best:": "{best:.3g}", "95 % from:": "{low:.3g}", "to:": "{high:.3g}",
        "looked for from:": "{lowest:g}", "to :": "{highest:g}",
        "identified": lambda row: "yes" if row["identified"] else "no",
    }  # fmt: skip
    targets = [{"target": f"`{key}`", **one} for key, one in found["targets"].items() if "at" not in one]
    shown = {
        "target": "", "measured:": "{measured:.3g}", "error:": "{error:.2g}", "at the best:": "{at_best:.3g}",
        "scatter over starts:": "{spread:.2g}",
    }  # fmt: skip
    said = f"{found['verdict']}\n\n{markdown(columns, numbers)}\n\n"
    said += f"{markdown(shown, targets)}\n\n" if targets else ""
    said += "\n".join(f"- {note}" for note in found["notes"])
    return f"{said}\n\n{found['runs']} runs, {found['failed']} left out; {study.members} starts of each point."


def figures(name: str, data: Data, place: Path) -> dict[str, Path]:
    """Runs against the measurements, and the posterior."""
    study, points = study_of(name), np.array(data["points"], float)
    values = {key: np.array(one, float) for key, one in data["values"].items()}
    model = model_of(study.unit(points), study.targets, values)
    posterior = sample(model.log_likelihood, len(study.vary))
    paths = {"What is likely": page.draw_posterior(study, posterior, points, place / f"calibration_{name}_likely.png")}
    if any(target.axis for target in study.targets):
        near = [one[int(np.argmin(model.distances_of_points().max(axis=1)))] for one in model.values]
        drawn = page.draw_curves(model, posterior, near, place / f"calibration_{name}_curve.png")
    else:
        drawn = page.draw_targets(study, model, posterior, place / f"calibration_{name}_targets.png")
    return {"Runs and what was measured": drawn, **paths}


def twin_rows(folder: Path) -> Data:
    """Rows of the twins, with those of the other program where it was run."""
    found = json.loads((folder / "twins.json").read_text())["rows"]
    peer = folder / "peer.json"
    other = json.loads(peer.read_text()) if peer.is_file() else {"version": "", "rows": {}}
    return {"peer": other["version"], "rows": [{**row, "peer": other["rows"].get(row["kind"])} for row in found]}


def _each(values: list[float], text: str = "{:.2f}") -> str:
    return ", ".join(text.format(value) for value in values)


def twin_table(data: Data) -> str:
    """Truths in their ranges, widths beside the least, runs beside a grid, and the other program."""
    columns = {
        "kind, numbers": lambda row: row["kind"],
        "truth inside, of": lambda row: f"{_each(row['inside'], '{:.0f}')} of {row['twins']}",
        "mean width / range": lambda row: _each(row["width"]),
        "least that scatter allows": lambda row: _each(row["least"]),
        "error not told: inside": lambda row: _each(row["untold"]["inside"], "{:.0f}") if "untold" in row else "",
        "width, not told": lambda row: _each(row["untold"]["width"]) if "untold" in row else "",
        "error estimated, of": lambda row: (
            f"{row['untold']['error']:.2g} of {row['untold']['true']:g}" if "untold" in row else ""
        ),
        "runs:": "{runs}",
        "runs of a grid:": "{grid}",
        f"GrainLearning {data['peer']}: inside": lambda row: (
            _each(row["peer"]["inside"], "{:.0f}") if row["peer"] else ""
        ),
        "width": lambda row: _each(row["peer"]["width"]) if row["peer"] else "",
    }
    return markdown(columns, data["rows"])
