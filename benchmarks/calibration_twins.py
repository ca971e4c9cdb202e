# SPDX-License-Identifier: GPL-2.0-or-later
"""Twins of `calibrate`: data made by runs at known numbers, with noise, and whether the 95 % ranges hold the truth.

Run as ``python benchmarks/calibration_twins.py --out FOLDER [--jobs N] [KIND …]``; it goes on where it stopped. The
twins of a kind, with one and with two varied numbers, share the runs of one Sobol design. The truth of each is drawn.
Its data are those of one run at the truth, with a start of its own and an error of measurement. Twins that measure a
curve are fitted once with the error told, and once without: it is estimated then. ``twins.json`` holds
for each kind how many truths lie in their ranges, and the mean width of the ranges beside the least: that of an
emulator which knows all but the scatter of one experiment. ``ensembles.json`` holds the same runs for other methods
(``calibration_peer.py``).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import replace
from math import ceil, inf
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.calibration.model import Model, model_of
from lammps_jump.calibration.posterior import log_t, sample
from lammps_jump.calibration.search import OVER, PointResults, Search, design
from lammps_jump.calibration.study import Calibration, read_calibration
from lammps_jump.calibration.targets import Target
from lammps_jump.files import plain
from lammps_jump.sweeps import Pool, run_starts
from lammps_jump.sweeps.members import Start

CASES = Path(__file__).parent / "twins"
TWINS, MEMBERS = 10, 2
POINTS = {1: 8, 2: 16}
"""Points of the design, by how many numbers are varied."""
AT = np.round(np.linspace(-0.45, 0.45, 19), 3).tolist()
"""Places of a measured shape of a heap, m."""
FIRST_SEED = 10_000
"""Of the starts of the truths."""


class Kind(NamedTuple):
    """Twins of one kind: case, ranges, targets as (field of a study, error)."""

    case: str
    vary: Mapping[str, tuple[float, float]]
    targets: tuple[Mapping[str, Any], ...]
    twins: int = TWINS


def number(key: str, error: float) -> dict[str, Any]:
    """A measured number; its value is that of the twin."""
    return {"key": key, "value": 1.0, "error": error}


def shape_of_heap(error: float) -> dict[str, Any]:
    """A measured shape of a heap; its values are those of the twin."""
    count = len(AT)
    return {"curve": "heap.depth", "axis": "x", "at": AT, "values": [0.0] * count, "errors": [error] * count}


SHAPE, ROUGH_SHAPE = shape_of_heap(0.004), shape_of_heap(0.02)
"""Below the scatter over starts, and above it."""
FRICTION, ROLLING = "contact.friction", "contact.rolling.friction"
KINDS = {
    "heap shape, 1": Kind("heap", {FRICTION: (0.1, 0.9)}, (SHAPE,), 20),
    "heap shape, 2": Kind("heap", {FRICTION: (0.1, 0.9), ROLLING: (0.0, 0.4)}, (SHAPE,), 20),
    "rough heap shape, 1": Kind("heap", {FRICTION: (0.1, 0.9)}, (ROUGH_SHAPE,), 20),
    "rough heap shape, 2": Kind("heap", {FRICTION: (0.1, 0.9), ROLLING: (0.0, 0.4)}, (ROUGH_SHAPE,), 20),
    "column run-out, 1": Kind("column", {FRICTION: (0.1, 0.9)}, (number("heap.run_out", 0.05),)),
    "column run-out, 2": Kind("column", {FRICTION: (0.1, 0.9), ROLLING: (0.0, 0.4)},
                              (number("heap.run_out", 0.05), number("heap.height", 0.03))),
    "hopper discharge, 1": Kind("hopper", {FRICTION: (0.05, 0.8)}, (number("hopper.discharge", 60.0),)),
    "hopper discharge, 2": Kind("hopper", {FRICTION: (0.05, 0.8), "discs.density": (2000.0, 3000.0)},
                                (number("hopper.discharge", 60.0), number("discs.present", 2.0))),
    "jump depth and length, 1": Kind("jump", {FRICTION: (0.0, 0.06)},
                                     (number("jump.y2", 0.03), number("jump.length", 0.2))),
    "jump depth and length, 2": Kind("jump", {FRICTION: (0.0, 0.06), "inflow.mean_speed": (9.0, 11.0)},
                                     (number("jump.y2", 0.03), number("jump.length", 0.2))),
}  # fmt: skip


def study_of(kind: Kind) -> Calibration:
    """The calibration whose first round is the design."""
    points = POINTS[len(kind.vary)]
    given = {"vary": kind.vary, "targets": [dict(one) for one in kind.targets], "members": MEMBERS}
    return read_calibration({"case": str(CASES / f"{kind.case}.yaml"), **given, "budget": (points + 1) * MEMBERS})


def runs_of_design(study: Calibration, folder: Path, pool: Pool) -> tuple[np.ndarray, PointResults]:
    """Points of the design, and what their runs gave."""
    folder.mkdir(parents=True, exist_ok=True)
    search = Search(study, folder, False, lambda _: None)
    places = design(POINTS[len(study.vary)], len(study.vary), study.seed)
    search.rounds = [{"of": OVER, "points": study.points(places).tolist()}]
    return search.points, search.run(pool)


def truths(study: Calibration, twins: int, folder: Path, pool: Pool) -> list[tuple[list[float], list[Target]]]:
    """Known numbers, and what is measured of a run at them: with scatter, by its own start, and error."""
    rng = np.random.default_rng(study.seed)
    points = study.points(rng.random((3 * twins, len(study.vary)))).tolist()
    found: list[tuple[list[float], list[Target]]] = []
    for first in range(0, len(points), twins):
        some = [dict(zip(study.paths, one, strict=True)) for one in points[first : first + twins]]
        starts = [Start(number, one, FIRST_SEED + first + number) for number, one in enumerate(some)]
        for point, made in zip(points[first:], run_starts(study.case, starts, folder, pool), strict=False):
            values = [target.of_run(made.folder, made.summary) for target in study.targets] if made.summary else []
            if values and all(np.isfinite(one).all() for one in values):
                noisy = [replace(target, measured=one + target.error * rng.normal(size=len(one)))
                         for target, one in zip(study.targets, values, strict=True)]  # fmt: skip
                found.append((point, noisy))
        if len(found) >= twins:
            break
    return found[:twins]


def twin_of(model: Model, targets: list[Target]) -> Model:
    """The model of the design against the data of a twin."""
    pairs = list(zip(model.parts, targets, strict=True))
    kept = [np.isin(target.at, part.target.at) if target.axis else np.array([True]) for part, target in pairs]
    measured = [part.into(target.measured[k]) for (part, target), k in zip(pairs, kept, strict=True)]
    return replace(model, measured=np.concatenate(measured))


def untold(study: Calibration, points: np.ndarray, values: Mapping[str, np.ndarray], targets: list[Target]) -> Model:
    """The model of the design against a twin whose curves tell no error."""
    without = [replace(one, error=np.full(len(one.error), np.nan)) if one.axis else one for one in targets]
    return model_of(study.unit(points), without, values)


Ranges = list[tuple[float, float]]


def ranges_of(model: Model, varied: int) -> Ranges:
    """95 % ranges."""
    found = sample(model.log_likelihood, varied)
    return [found.range_of(k) for k in range(varied)]


def inside(study: Calibration, twins: list[tuple[list[float], list[Target]]], found: list[Ranges]) -> list[int]:
    """How many truths lie in their ranges, of each varied number."""
    held = [
        [low <= one <= high for (low, high), one in zip(ranges, study.unit([truth])[0], strict=True)]
        for (truth, _), ranges in zip(twins, found, strict=True)
    ]
    return np.sum(held, axis=0).tolist()


def widths(found: list[Ranges]) -> np.ndarray:
    """Mean widths of the ranges of each varied number."""
    return np.mean([np.diff(one)[:, 0] for one in found], axis=0)


def widths_of(model: Model, varied: int) -> tuple[Ranges, list[float]]:
    """95 % ranges, and the widths that a perfect emulator and a known scatter would leave."""

    def perfect(places: np.ndarray) -> np.ndarray:
        mean, _ = model.at(places)
        whole = np.broadcast_to(model.errors[0] + model.scatter, (len(places), *model.scatter.shape))
        return log_t(model.measured - mean, whole, np.full(len(places), inf))

    best = sample(perfect, varied)
    return ranges_of(model, varied), [float(np.subtract(*reversed(best.range_of(k)))) for k in range(varied)]


def study_kind(name: str, folder: Path, pool: Pool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Row of a kind, and its runs for other methods."""
    kind = KINDS[name]
    study, place = study_of(kind), folder / name.removeprefix("rough ").replace(", ", "_").replace(" ", "_")
    points, observed = runs_of_design(study, place, pool)
    good = sorted(observed.summaries)
    values = {target: array[good] for target, array in observed.values.items()}
    twins = truths(study, kind.twins, place / "truths", pool)
    model, varied = model_of(study.unit(points[good]), study.targets, values), len(kind.vary)
    told = [widths_of(twin_of(model, targets), varied) for _, targets in twins]
    mean = widths([ranges for ranges, _ in told])
    row = {
        "kind": name, "varied": study.paths, "runs": int(MEMBERS * len(points)), "failed": len(observed.failures),
        "twins": len(twins), "inside": inside(study, twins, [ranges for ranges, _ in told]), "width": mean.tolist(),
        "least": np.mean([best for _, best in told], axis=0),
        "grid": MEMBERS * int(np.prod([ceil(4 / one) for one in mean])),
    }  # fmt: skip
    if any(target.axis for target in study.targets):
        models = [untold(study, points[good], values, targets) for _, targets in twins]
        found = [ranges_of(one, varied) for one in models]
        estimated = [float(one.parts[0].target.error[0]) for one in models]
        row["untold"] = {
            "inside": inside(study, twins, found), "width": widths(found), "error": np.median(estimated),
            "true": float(study.targets[0].error[0]),
        }  # fmt: skip
    runs = {
        "paths": study.paths, "low": study.bounds[:, 0], "high": study.bounds[:, 1], "points": points[good],
        "values": {one: np.nanmean(array, axis=1) for one, array in values.items()},
        "twins": [{"truth": truth, "measured": {one.name: one.measured for one in data}} for truth, data in twins],
    }  # fmt: skip
    return plain(row), plain(runs)


def main() -> None:
    """Run, and write both files after each kind."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    rows, runs = {}, {}
    with Pool(given.jobs) as pool:
        for name in given.kinds:
            rows[name], runs[name] = study_kind(name, given.out, pool)
            print(name, rows[name], flush=True)
            (given.out / "twins.json").write_text(json.dumps({"rows": list(rows.values())}, indent=1))
            (given.out / "ensembles.json").write_text(json.dumps(runs))


if __name__ == "__main__":
    main()
