# SPDX-License-Identifier: GPL-2.0-or-later
"""Benchmark: settings of the axes that are stable, each timed and held against a fine reference, and its page."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain, product
from math import inf
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib import axes as picture_axes
from matplotlib.ticker import LogLocator
from pydantic import Field, TypeAdapter, ValidationError

from lammps_jump.analysis.draw.style import RED, drawing, save
from lammps_jump.analysis.tables import Column, markdown, paragraphs, percent
from lammps_jump.case.to_scene import INTEGRATORS, TOUCH_STEPS
from lammps_jump.dump import read_forces
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import CaseError, RunError
from lammps_jump.files import plain
from lammps_jump.physics import contact
from lammps_jump.provenance import machine
from lammps_jump.quoting import echoed, typed
from lammps_jump.runs.run import Case, Run, load_case
from lammps_jump.runs.summary import results_in
from lammps_jump.scene import Scene, handmade_scene
from lammps_jump.sweeps import Results, Say, Store

from .points import FAILED, Found, Point, PointStudy, run_study
from .runs import KERNELS, middle, run_frames

AXES = ("f", "n", "touch", "kernel", "correction", "skin", "diameter", "ranks")
BASE = 0.05
"""Time-step fraction of the settings that vary another axis."""
SKINS = (0.1, 0.2, 0.3, 0.5, 0.7)
FIELDS = {
    "ranks": "engine.ranks", "fraction": "run.time_step_fraction", "touch": "contact.touch",
    "correction": "contact.correct_restitution", "diameter": "discs.diameter",
}  # fmt: skip
"""Fields of a case by what a `StudySetting` calls them; skin, kernel and n are none of them."""
MEASURED_KERNELS = tuple(name for name in KERNELS if name != "twin")


class Axes(NamedTuple):
    """Values that a benchmark varies.

    Attributes
    ----------
    names : tuple of str
        Of `AXES`.
    fractions, diameters : tuple of float
        Time steps over 2/omega; disc diameters, m.
    kernels : tuple of str
    members : int
        Starts of each setting. The reference gets as many.
    penetrations : tuple of float
        n of thesis (3.20).
    finest : float
        Time step of the reference.
    """

    names: tuple[str, ...] = ("f", "touch", "kernel", "correction", "n", "skin")
    fractions: tuple[float, ...] = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
    kernels: tuple[str, ...] = MEASURED_KERNELS  # the twin takes hours: only on request, by name
    diameters: tuple[float, ...] = ()
    members: int = 5
    penetrations: tuple[float, ...] = (5.0, 10.0, 20.0, 40.0)
    finest: float = 0.01


QUICK = Axes(("f", "touch", "kernel"), (0.05, 0.1, 0.2), members=2, penetrations=(5.0, 20.0), finest=0.02)


@dataclass(frozen=True)
class StudySetting:
    """One way to compute a case; None leaves a value as the case has it.

    Attributes
    ----------
    kernel : {'stock', 'compiled', 'native'}
    touch : {'sharp', 'smooth'}
    fraction : float
        Time step over 2/omega.
    penetration : float or None
        n of thesis (3.20): the diameter over the largest overlap.
    correction : bool
        Restitution corrected for the integrator's bias.
    skin : float or None
        Over the disc diameter.
    diameter : float or None
        m.
    ranks : int
    """

    kernel: str
    fraction: float
    touch: str = "sharp"
    penetration: float | None = None
    correction: bool = True
    skin: float | None = None
    diameter: float | None = None
    ranks: int = 1

    @property
    def label(self) -> str:
        """Short and unique among the settings of a case."""
        words = [self.family, f"f={self.fraction:zg}"]
        words += [f"n={self.penetration:zg}"] if self.penetration is not None else []
        words += [] if self.correction else ["uncorrected"]
        words += [f"skin={self.skin:zg}d"] if self.skin is not None else []
        words += [f"d={self.diameter:zg}"] if self.diameter is not None else []
        words += [f"{self.ranks} ranks"] if self.ranks > 1 else []
        return " ".join(words)

    @property
    def family(self) -> str:
        """Kernel and touch; a figure gives each family its mark."""
        return self.kernel + (" smooth" if self.touch == "smooth" else "")

    @property
    def plain(self) -> bool:
        """Tells whether nothing but kernel, touch and step is varied."""
        return self == StudySetting(self.kernel, self.fraction, self.touch)

    def changes(self, diameter: float) -> dict[str, object]:
        """Return the values of a case that this setting changes; `diameter` (m) is that of the case."""
        fields = {path: getattr(self, name) for name, path in FIELDS.items()}
        skin = None if self.skin is None else self.skin * (self.diameter or diameter)
        overlap = None if self.penetration is None else 1 / self.penetration
        changed = {**KERNELS[self.kernel], **fields, "contact.largest_overlap": overlap, "engine.skin": skin}
        return {path: value for path, value in changed.items() if value is not None}


def listed(option: str, text: str | None, allowed: Collection[str]) -> tuple[str, ...]:
    """Return the words of an option, ``f,n,touch``, each once; none where it was not given.

    Raises
    ------
    CaseError
        A word that is not allowed, or an option without a word.
    """
    words = tuple(dict.fromkeys(word.strip() for word in (text or "").split(",") if word.strip()))
    if text is not None and not words:
        raise CaseError(f"{option}: '{text}' names nothing; allowed are {', '.join(allowed)}")
    for word in words:
        if word not in allowed:
            raise CaseError(f"{option}: '{word}' is not known; allowed are {', '.join(allowed)}")
    return words


def stable(setting: StudySetting, restitution: float) -> bool:
    """Return whether the step is below the limit of a dense packing (`contact.stable_fraction`)."""
    integrator = INTEGRATORS[KERNELS[setting.kernel]["engine.name"]]
    return setting.fraction <= contact.stable_fraction(contact.damping_ratio(restitution), integrator)


def make_settings(axes: Axes, restitution: float) -> list[StudySetting]:
    """Return stable settings: step, kernel and touch are crossed, the other axes vary one at a time from `BASE`.

    Parameters
    ----------
    axes : Axes
        With kernels that are usable here.
    restitution : float
        Decides which steps are stable.
    """
    names, kernels, first = axes.names, axes.kernels, axes.kernels[0]
    families = [(kernel, "sharp") for kernel in (kernels if "kernel" in names else [first])]
    quickest = reference_setting(BASE, kernels).kernel
    if "touch" in names and quickest != "stock":
        families.append((quickest, "smooth"))
    steps = list(axes.fractions) if "f" in names else [BASE]
    study_settings = [StudySetting(kernel, step, touch) for kernel, touch in families for step in steps]
    if "correction" in names and restitution < 1:
        study_settings += [StudySetting(first, step, correction=False) for step in steps]
    if "n" in names:
        study_settings += [
            StudySetting(quickest, step, penetration=n) for n in axes.penetrations for step in (BASE, 2 * BASE)
        ]
    if "skin" in names:
        study_settings += [StudySetting(kernel, BASE, skin=skin) for kernel in kernels[:2] for skin in SKINS]
    if "diameter" in names:
        study_settings += [StudySetting(quickest, BASE, diameter=d) for d in axes.diameters]
    if "ranks" in names:
        study_settings += [StudySetting(first, BASE), StudySetting(first, BASE, ranks=2)]
    return list(dict.fromkeys(setting for setting in study_settings if stable(setting, restitution)))


def reference_setting(fraction: float, kernels: Iterable[str]) -> StudySetting:
    """Return the reference of all errors: the finest step with sharp touch on the fastest usable kernel."""
    usable = list(kernels)
    fast = next((kernel for kernel in ("compiled", "native") if kernel in usable), usable[0])
    return StudySetting(fast, fraction)


# --- the benchmark of the settings: run time against error; its runs are kept, and their rows in ``bench.json`` -------


EXACT = {"energy deviation": 0.0}
"""Quantities whose true value is known."""

Value = float | list[float] | None
Measures = dict[str, Value]
"""Measurements of one run: numbers and curves by name."""


class QuantityError(NamedTuple):
    """Error of one quantity; None where it is unknown.

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
    summary = run.summary
    taken = {
        "seconds": summary["cpu_seconds"],
        "wall_seconds": summary["wall_seconds"]["run"],
        "disc_steps": summary["disc_steps"],
        "breakdown": summary["breakdown_seconds"] or {},
    }
    return {**taken, "measures": measures_of(summary, run.folder)}


def measures_of(summary: Mapping[str, Any], folder: Path) -> Measures:
    """Return the numbers and curves of a run that is complete."""
    by_measure: Measures = {}
    results = results_in(folder, summary)
    if energy := summary.get("energy"):
        by_measure["energy deviation"] = energy["max_deviation"]
    if summary.get("front"):
        table = results.table("front")
        times = np.linspace(0.1, 1.0, CURVE_POINTS) * summary["simulated_time"]
        by_measure["front position"] = np.interp(times, table.numbers("time"), table.numbers("quantile")).tolist()
        by_measure["column height"] = np.interp(times, table.numbers("time"), table.numbers("height")).tolist()
    if jump := summary.get("jump"):
        depth = results.dataset()["mass_depth_mean"].values
        by_measure["depth profile"] = np.nan_to_num(depth, posinf=0.0, neginf=0.0).tolist()
        by_measure |= {"sequent depth": jump["y2"], "shock speed": jump["speed"]}
    for name, force in read_forces(folder / "forces.csv").items() if summary.get("force") else ():
        step = float(np.median(np.diff(force.time)))
        by_measure[f"impulse {name}"] = float(np.hypot(force.fx.sum(), force.fy.sum())) * step
    return by_measure


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


# --- pairs of discs that collide, with their closed forms: restitution, duration, largest overlap, over ---------------


DIAMETER, DENSITY, SPEED, OVERLAP = 0.2, 1000.0, 16.0, 0.1
PHASES = 64


def collision_scene(
    fraction: float, restitution: float, *, correct: bool = True, speed: float = SPEED, phases: int = PHASES, **law: Any
) -> Scene:
    """Return `phases` pairs of discs, 3 d apart from each other, each about to collide head-on at `speed` (m/s).

    It has the corrected dashpot and the width of a smooth touch that a case gets; `law` may hold integrator and touch.
    """
    k = contact.stiffness(DENSITY, OVERLAP, SPEED)
    dt = fraction * contact.critical_time_step(k, contact.disc_mass(DENSITY, DIAMETER))
    gaps = speed * dt * (1.0 + (np.arange(phases) + 0.5) / phases)
    left = np.column_stack([-0.5 * (DIAMETER + gaps), 3 * DIAMETER * np.arange(phases)])
    return handmade_scene(
        np.stack([left, left * [-1, 1]], axis=1), np.tile([[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], (phases, 1)),
        name="collision", description="pairs of discs, head-on", gravity=(0.0, 0.0), diameter=DIAMETER,
        density=DENSITY, largest_overlap=OVERLAP, impact_speed=SPEED, restitution=restitution,
        time_step_fraction=fraction, correct_restitution=correct, skin=0.3 * DIAMETER,
        touch_width=TOUCH_STEPS * SPEED * dt if law.get("touch") == "smooth" else 0.0,
        steps=int(1.6 * expected(restitution)["duration"] / dt) + 8,
        overlap_limit=DIAMETER,  # a single elastic pair may go deeper than a case allows: that is what is measured
        **law,
    )  # fmt: skip


def measure_collisions(scene: Scene, kernel: str) -> dict[str, np.ndarray]:
    """Return restitution, duration (s) and largest overlap (m) of every pair, shape (phases,).

    The overlap is the largest at a step, the duration the number of steps in contact: both are right to a step.
    """
    _, frames = run_frames(scene, kernel)
    x = np.array([frame.x for frame in frames])
    overlap = scene.diameter - (x[:, 1::2] - x[:, 0::2])
    before, after = (frame.vx[1::2] - frame.vx[0::2] for frame in (frames[0], frames[-1]))
    duration = (overlap > 0).sum(axis=0) * scene.time_step
    return {"restitution": -after / before, "duration": duration, "overlap": overlap.max(axis=0)}


def expected(restitution: float, speed: float = SPEED) -> dict[str, float]:
    """Return the closed forms for the same pair (docs/theory.md, one collision, exactly)."""
    k = contact.stiffness(DENSITY, OVERLAP, SPEED)
    omega = contact.angular_frequency(k, 0.5 * contact.disc_mass(DENSITY, DIAMETER))
    return {
        "restitution": restitution,
        "duration": contact.contact_duration(restitution, omega),
        "overlap": contact.largest_overlap(speed, restitution, omega),
    }


# --- the page of a benchmark, in Markdown, and its figures, from what ``bench.json`` holds ----------------------------


MARKS = {
    "stock": ("o", "#33508f"),
    "compiled": ("s", "#7d7c78"),
    "compiled smooth": ("D", "#b5a05a"),
    "native": ("^", "#111111"),
    "native smooth": ("v", "#d9c55b"),
}
COLUMNS = ("label", "family", "plain", "seconds", "error")


def page(data: Mapping[str, Any]) -> list[str]:
    """Return the paragraphs of a benchmark's page: cheapest settings, then every row.

    Parameters
    ----------
    data : dict
        Content of ``bench.json``.
    """
    columns: dict[str, Column] = {
        "setting": lambda row: row["label"] + (f" ({len(row['failed'])} failed)" if row["failed"] else ""),
        "time (s):": "{seconds:z.2f}",
        "M disc-steps/s:": lambda row: f"{rate / 1e6:z.1f}" if (rate := row["disc_steps_per_second"]) else "-",
    }
    columns |= {f"{name} (floor):": partial(_error, name=name) for name in data["quantities"]}
    about = (
        f"{data['duration']:zg} s of flow, {data['members']} starts a setting, reference: {data['reference']}; "
        f"{data['machine']['processor']}, one core. Time: {data['time']}."
    )
    return [f"### {data['case']}", about, short_table(data), markdown(columns, data["rows"])]


def short_table(data: Mapping[str, Any]) -> str:
    """Returns the cheapest setting for 5 % and 1 % of each quantity, next to stock LAMMPS at f = 0.05."""
    rows = {row["label"]: row for row in data["rows"]}
    base, targets = rows.get("stock f=0.05"), {"0.05": "5 %", "0.01": "1 %"}
    lines = []
    for name, summary in data["quantities"].items():
        chosen = {f"cheapest within {word}": rows.get(summary["cheapest"].get(t)) for t, word in targets.items()}
        cells = {title: _cell(row, name, base) for title, row in chosen.items()}
        lines.append({"quantity": name, "stock f = 0.05": _cell(base, name, None), **cells})
    return markdown(dict.fromkeys(lines[0] if lines else (), ""), lines)


def _error(row: Mapping[str, Any], name: str) -> str:
    entry = row["errors"].get(name)
    if not entry or entry["error"] is None:
        return "-"
    return percent(entry["error"]) + (f" ({percent(entry['floor'])})" if entry["floor"] else "")


def _cell(row: Mapping[str, Any] | None, name: str, base: Mapping[str, Any] | None) -> str:
    if row is None or row["seconds"] is None:
        return "none shown"
    text = f"{row['label']}: {row['seconds']:z.2f} s" if base is not None else f"{row['seconds']:z.2f} s"
    if base is not None and base["seconds"] and base is not row:
        text += f", {base['seconds'] / row['seconds']:z.1f}x"
    return f"{text} ({_error(row, name)})"


def draw_settings(data: Mapping[str, Any], folder: Path) -> None:
    """Draw the figure of each quantity."""
    for name in data["quantities"]:
        draw_quantity(data, name, folder)


def draw_quantity(data: Mapping[str, Any], name: str, folder: Path) -> Path:
    """Draw run time (s, log) against error (%, log): families by mark, Pareto front as a line, floor as a band.

    A setting without any error has no place on a logarithmic axis.
    """
    summary = data["quantities"][name]
    rows = [{**row, "error": 100 * (row["errors"].get(name, {}).get("error") or 0.0)} for row in data["rows"]]
    table = pd.DataFrame([row for row in rows if row["seconds"] and row["error"]], columns=COLUMNS).set_index("label")
    with drawing(7.2, 4.4) as (figure, axes):
        for family, plain in product(MARKS, (True, False)):
            some, (mark, colour) = table[(table.family == family) & (table.plain == plain)], MARKS[family]
            if len(some):
                axes.plot(some.seconds, some.error, mark, color=colour, markerfacecolor=colour if plain else "white",
                          markersize=6, label=family if plain else f"{family}, other axes")  # fmt: skip
        front = table.reindex(summary["pareto"]).dropna()
        if len(front):
            axes.step(front.seconds, front.error, where="post", color=RED, linewidth=1.0, label="Pareto front")
        axes.set(xscale="log", yscale="log", xlabel="processor time of the run (s)", ylabel="error (%)")
        if summary["floor"]:
            floor, low = 100 * summary["floor"], min(axes.get_ylim()[0], 50 * summary["floor"])
            axes.set_ylim(bottom=low)
            axes.axhspan(low, floor, color="#eeeeee", zorder=0)
            axes.annotate("scatter of the ensembles: nothing can be told apart below", (0.02, floor),
                          xycoords=("axes fraction", "data"), fontsize=7, va="top", color="#666666")  # fmt: skip
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:zg}")
            axis.set_minor_formatter("")
        _name_choices(axes, summary["cheapest"], table)
        axes.set_title(f"{data['case']}: {name}")
        if len(table):
            axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
        return save(figure, folder / f"bench_{name.replace(' ', '_')}.png")


def _name_choices(axes: picture_axes.Axes, cheapest: dict[str, str | None], table: pd.DataFrame) -> None:
    """Ring and name the cheapest settings; where one serves both targets it is named once."""
    for index, label in enumerate(dict.fromkeys(label for label in cheapest.values() if label in table.index)):
        targets = " and ".join(f"{100 * float(target):zg} %" for target, one in cheapest.items() if one == label)
        point = tuple(table.loc[label, ["seconds", "error"]])
        axes.plot(*point, "o", markersize=12, markerfacecolor="none", color=RED, linewidth=1.2)
        axes.annotate(
            f"{targets}: {label}", point, xytext=(1.02, 0.95 - 0.07 * index), textcoords="axes fraction", fontsize=8,
            color=RED, arrowprops={"arrowstyle": "-", "color": RED, "linewidth": 0.6},
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
        )  # fmt: skip
