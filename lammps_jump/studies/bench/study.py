# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of the settings: run time against error; its runs are kept, and their rows in ``bench.json``.

A setting is run from several slightly moved starts. Its error is the distance between the mean of its ensemble and
that of the reference (the finest step), over the size of the latter. For a curve it is the root mean square along it.
The *floor* is the distance that scatter alone gives two equal ensembles: sqrt(s^2/n + s_ref^2/n_ref). Errors below it
cannot be told from zero. An energy box has an exact answer, no deviation. Its error is the median over the starts of
the largest deviation, and its floor is 0.

The ``bench`` command: the study of the settings of a case.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from itertools import chain
from math import inf
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from pydantic import Field, TypeAdapter, ValidationError

from lammps_jump.analysis.tables.markdown import paragraphs
from lammps_jump.dump import read_forces
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import CaseError, RunError
from lammps_jump.files import plain
from lammps_jump.provenance import machine
from lammps_jump.quoting import echoed, typed
from lammps_jump.runs.run import Case, Run, load_case
from lammps_jump.runs.summary import results_in
from lammps_jump.studies.points import FAILED, Found, Point, PointStudy, run_study
from lammps_jump.studies.runs import KERNELS, middle
from lammps_jump.studies.settings import AXES, QUICK, Axes, StudySetting, listed, make_settings, reference_setting
from lammps_jump.sweeps import Results, Say, Store

from .page import draw_settings, page

EXACT = {"energy deviation": 0.0}
"""Quantities whose true value is known."""

Value = float | list[float] | None
Measures = dict[str, Value]
"""What was measured in one run: numbers and curves by name."""


class QuantityError(NamedTuple):
    """Error of one quantity; None where it cannot be told.

    Attributes
    ----------
    error, floor, scatter : float or None
        Shares of the size of the quantity; `scatter` is that of a single run.
    value : float or None
        Mean, for single numbers.
    """

    error: float | None = None
    floor: float | None = None
    scatter: float | None = None
    value: float | None = None


def quantity_error(name: str, members: Sequence[Value], reference: Sequence[Value] | None) -> QuantityError:
    """Return error, floor and single-run scatter of one quantity, as shares of its size.

    Parameters
    ----------
    name : str
    members, reference : sequence of float or of list of float
        One value or curve a run; None values (nothing measured) are left out.
    """
    curves = [[np.atleast_1d(one) for one in side or () if one is not None] for side in (members, reference)]
    if name in EXACT and curves[0]:
        values = np.abs(np.concatenate(curves[0]) - EXACT[name])
        spread = float(values.std(ddof=1)) if len(values) > 1 else None
        return QuantityError(float(np.median(values)), 0.0, spread, float(np.median(values)))
    points = min((len(curve) for side in curves for curve in side), default=0)
    ours, theirs = (np.array([curve[:points] for curve in side], float) for side in curves)
    mean = theirs.mean(axis=0) if len(theirs) else np.zeros(1)
    size = _root_mean_square(mean)
    if size == 0 or not len(ours):
        return QuantityError()
    floor = scatter = None
    if len(ours) > 1 and len(theirs) > 1:
        one, two = ours.var(axis=0, ddof=1), theirs.var(axis=0, ddof=1)
        floor = float(np.sqrt(np.mean(one / len(ours) + two / len(theirs)))) / size
        scatter = float(np.sqrt(np.mean(one))) / size
    value = float(ours.mean()) if points == 1 else None
    return QuantityError(_root_mean_square(ours.mean(axis=0) - mean) / size, floor, scatter, value)


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


CURVE_POINTS = 20


def measure(run: Run) -> Results:
    """Return what a run took, and the numbers and curves that its case asks for."""
    found = run.summary
    taken = {
        "seconds": found["cpu_seconds"],
        "wall_seconds": found["wall_seconds"]["run"],
        "disc_steps": found["disc_steps"],
        "breakdown": found["breakdown_seconds"] or {},
    }
    return {**taken, "measures": measures_of(found, run.folder)}


def measures_of(summary: Mapping[str, Any], folder: Path) -> Measures:
    """Return the numbers and curves of a run that is complete."""
    found: Measures = {}
    results = results_in(folder, summary)
    if energy := summary.get("energy"):
        found["energy deviation"] = energy["max_deviation"]
    if summary.get("front"):
        table = results.table("front")
        times = np.linspace(0.1, 1.0, CURVE_POINTS) * summary["simulated_time"]
        found["front position"] = np.interp(times, table.numbers("time"), table.numbers("quantile")).tolist()
        found["column height"] = np.interp(times, table.numbers("time"), table.numbers("height")).tolist()
    if jump := summary.get("jump"):
        depth = results.dataset()["mass_depth_mean"].values
        found["depth profile"] = np.nan_to_num(depth, posinf=0.0, neginf=0.0).tolist()
        found |= {"sequent depth": jump["y2"], "shock speed": jump["speed"]}
    for name, force in read_forces(folder / "forces.csv").items() if summary.get("force") else ():
        step = float(np.median(np.diff(force.time)))
        found[f"impulse {name}"] = float(np.hypot(force.fx.sum(), force.fy.sum())) * step
    return found


def names_of(runs: Iterable[Measures]) -> list[str]:
    """Return the quantities that some run measured, in order."""
    return list(dict.fromkeys(name for run in runs for name, value in run.items() if value is not None))


def setting_errors(runs: Sequence[Measures], reference: Sequence[Measures]) -> dict[str, QuantityError]:
    """Return `quantity_error` of every quantity of a setting's runs."""
    return {
        name: quantity_error(name, *([measures.get(name) for measures in side] for side in (runs, reference)))
        for name in names_of([*runs, *reference])
    }


NUMBERS = TypeAdapter(tuple[Annotated[float, Field(gt=0, allow_inf_nan=False)], ...])
TARGETS = (0.01, 0.05)
"""Errors for which the cheapest setting is named."""


def read_axes(quick: bool = False, members: int | None = None, **words: str | None) -> Axes:
    """Return what the options of the command line vary.

    Parameters
    ----------
    quick : bool
        Begin with `QUICK`.
    members : int, optional
    words
        ``axes``, ``kernels``, ``fractions`` and ``diameters``, each a list with commas between.

    Raises
    ------
    CaseError
        An axis or a kernel that does not exist; a value that is no number above 0.
    """
    given: dict[str, Any] = {"names": listed("--axes", words.get("axes"), AXES), "members": members}
    given |= {"kernels": listed("--kernels", words.get("kernels"), KERNELS)}
    given |= {name: _numbers(f"--{name}", words.get(name)) for name in ("fractions", "diameters")}
    return (QUICK if quick else Axes())._replace(**{name: value for name, value in given.items() if value})


def _numbers(option: str, text: str | None) -> tuple[float, ...]:
    try:
        return NUMBERS.validate_python(text.split(",") if text else ())
    except ValidationError:
        raise CaseError(
            f"{option} {echoed(text)}: expected numbers above 0 with commas between, such as 0.1,0.2"
        ) from None


def settings_study(case: Case, folder: Path, axes: Axes | None = None, *, quick: bool = False) -> PointStudy:
    """Return the study of all settings of a case, each from several starts; its results have rows, fronts and choices.

    Raises
    ------
    CaseError
        The case or an axis cannot be used.
    """
    axes, (usable, notes) = axes or read_axes(quick), usable_kernels()
    axes = axes._replace(kernels=tuple(kernel for kernel in usable if kernel in axes.kernels) or tuple(usable))
    fields, rounds = case.fields, axes.members
    reference = reference_setting(axes.finest, axes.kernels)
    chosen = list(dict.fromkeys([reference, *make_settings(axes, fields.contact.restitution)]))
    points = [
        Point(setting.label, measure, case, setting.changes(fields.discs.diameter), rounds,
              seed=fields.run.seed, dump=False, judged=True)
        for setting in chosen
    ]  # fmt: skip

    def told(point: Point, start: int, found: Results) -> str:
        return f"{point.name}, start {start} of {rounds}: {found.get(FAILED) or '{seconds:z.2f} s'.format_map(found)}"

    def results(found: Found, stored: Results) -> Results:
        complete = [[run for run in found[point.name] if FAILED not in run] for point in points]
        if not any(complete):
            reason = found[points[0].name][0][FAILED]
            raise RunError(f"no setting of {case.name} came to its end; the first one says: {reason}")
        measures = [[run["measures"] for run in group] for group in complete]
        rows = [make_row(setting, found[setting.label], measures[0], setting == reference) for setting in chosen]
        return {
            "case": case.name,
            "case_hash": case.hash,
            "restitution": fields.contact.restitution,
            "friction": fields.contact.friction,
            "duration": fields.run.duration,
            "members": rounds,
            "reference": reference.label,
            "notes": notes,
            "time": "median processor seconds of the engine, output included, analysis not",
            "rows": rows,
            "quantities": {name: summarise_quantity(rows, name) for name in names_of(chain.from_iterable(measures))},
            "machine": machine(),
        }

    opening = [f"note: {note}" for note in notes]
    opening += [f"{case.name}: {len(chosen)} settings x {rounds} starts -> {folder}"]
    return PointStudy("bench", points, results, page, draw_settings, told, opening, timed=True)


def make_row(
    setting: StudySetting, runs: Sequence[Mapping[str, Any]], reference: list[Measures], is_reference: bool
) -> Results:
    """Return what is stored of a setting: medians over its complete runs, messages of the others, errors."""
    complete = [run for run in runs if FAILED not in run]
    errors = setting_errors([run["measures"] for run in complete], reference) if complete else {}
    if is_reference:  # its distance from itself says nothing
        errors = {n: e if n in EXACT else e._replace(error=None, floor=None) for n, e in errors.items()}
    kinds = sorted({kind for run in complete for kind in run["breakdown"]})
    return {
        "label": setting.label,
        "family": setting.family,
        "setting": asdict(setting),
        "plain": setting.plain,
        "runs": len(complete),
        "failed": [run[FAILED] for run in runs if FAILED in run],
        "seconds": middle(run["seconds"] for run in complete),
        "seconds_all": [run["seconds"] for run in complete],
        "wall_seconds": middle(run["wall_seconds"] for run in complete),
        "disc_steps_per_second": middle(run["disc_steps"] / run["seconds"] for run in complete if run["seconds"]),
        "breakdown": {kind: middle(run["breakdown"].get(kind) for run in complete) for kind in kinds},
        "reference": is_reference,
        "errors": {name: entry._asdict() for name, entry in errors.items()},
    }


def summarise_quantity(rows: Sequence[Results], name: str) -> Results:
    """Return Pareto front (labels), the cheapest setting for each of `TARGETS`, and the median floor of the errors.

    The front holds the settings that no other beats in time and error, from fast to slow. The cheapest is the quickest
    whose error and floor are within the target. Settings with another stiffness or disc size are other flows and are
    not chosen.
    """
    known = [row for row in rows if row["seconds"] and (row["errors"].get(name) or {}).get("error") is not None]
    errors = pd.DataFrame([row["errors"][name] for row in known], columns=QuantityError._fields, dtype=float)
    table = errors.assign(**{key: [row[key] for row in known] for key in ("label", "seconds")})
    table["flow"] = [all(row["setting"].get(key) is None for key in ("penetration", "diameter")) for row in known]
    table = table.sort_values(["seconds", "error"])
    own = table[table.flow.astype(bool)].set_index("label")[["error", "floor"]].fillna(0.0)
    return {
        "pareto": table.label[table.error < table.error.cummin().shift(fill_value=inf)].tolist(),
        "cheapest": {f"{target:zg}": next(iter(own.index[(own <= target).all(axis=1)]), None) for target in TARGETS},
        "floor": plain(table.floor.median()),
    }


FOLDER = Path("runs") / "bench"


def run_bench(
    case: Case,
    *,
    out: Path | None = None,
    axes: Axes | None = None,
    quick: bool = False,
    fresh: bool = False,
    say: Say = print,
) -> str:
    """Run the benchmark of the settings of a case and return its table as Markdown.

    Parameters
    ----------
    case : Case
    out : Path, optional
        Folder; default ``runs/bench/<name>``.
    axes : Axes, optional
        Of the settings.
    quick, fresh : bool
        Few and short runs; measure again what is stored.
    say : callable
        Takes one line of progress.

    Raises
    ------
    CaseError
        No such axis or number.
    """
    folder = out or FOLDER / case.name
    study = settings_study(case, folder, axes, quick=quick)
    return run_study(study, folder, command="bench", fresh=fresh, say=say)[1]


def stored_table(path: Path, out: Path | None = None) -> str:
    """Return the table of a finished benchmark of a case file.

    Raises
    ------
    CaseError
        Where there is none.
    """
    file = (out or FOLDER / load_case(path).name) / "bench.json"
    data = Store(file).data
    if "rows" not in data:
        raise CaseError(f"{file}: no finished benchmark is stored there; run `{typed('bench', path)}` first")
    return paragraphs(*page(data))
