# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of the settings: run time against error; its runs are kept, and their rows in ``bench.json``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import chain

from lammps_jump import Case
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import CaseError, RunError
from lammps_jump.studies import settings
from lammps_jump.studies.runs import KERNELS, in_turn, middle
from lammps_jump.studies.settings import Setting, listed
from lammps_jump.sweeps import Made, Pool, Start, run_starts
from lammps_jump.sweeps.store import Results, Say, Store

from .errors import EXACT, Value, cheapest, measure, names_of, pareto, setting_errors

TARGETS = (0.01, 0.05)
"""Errors for which the cheapest setting is named."""


@dataclass(frozen=True)
class Axes:
    """What a benchmark varies; an empty tuple or None leaves the default values.

    Attributes
    ----------
    names : tuple of str
        Of `settings.AXES`.
    fractions, diameters : tuple of float
        Time steps over 2/omega; disc diameters, m.
    kernels : tuple of str
    members : int or None
        Starts of each setting; default 5 (2 if quick). The reference gets as many.
    """

    names: tuple[str, ...] = ()
    fractions: tuple[float, ...] = ()
    kernels: tuple[str, ...] = ()
    diameters: tuple[float, ...] = ()
    members: int | None = None


def read_axes(
    names: str | None, fractions: str | None, kernels: str | None, diameters: str | None, members: int | None
) -> Axes:
    """Return what the options of the command line vary; each is a list with commas between.

    Raises
    ------
    CaseError
        An axis or a kernel that does not exist; a value that is no number above 0.
    """
    steps, sizes = _numbers("--fractions", fractions), _numbers("--diameters", diameters)
    return Axes(listed("--axes", names, settings.AXES), steps, listed("--kernels", kernels, KERNELS), sizes, members)


def _numbers(option: str, text: str | None) -> tuple[float, ...]:
    if not text:
        return ()
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise CaseError(f"{option} {text!r}: expected numbers with commas between, such as 0.1,0.2") from None
    if not all(0 < value < float("inf") for value in values):
        raise CaseError(f"{option} {text!r}: every value must be above 0")
    return values


def measure_settings(case: Case, store: Store, *, axes: Axes, quick: bool, fresh: bool, say: Say) -> Results:
    """Run every setting from several starts; returns rows, Pareto fronts and choices.

    With `quick`: three steps, two starts, nothing but step, kernel and touch.

    Raises
    ------
    CaseError
        The case or an axis cannot be used.
    RunError
        No setting came to its end.
    """
    fields = case.fields
    names = axes.names or (("f", "touch", "kernel") if quick else settings.USUAL_AXES)
    usable, notes = usable_kernels()
    usable = [kernel for kernel in usable if kernel in axes.kernels] or usable
    chosen = settings.make_settings(
        names, restitution=fields.contact.restitution, kernels=usable, diameters=axes.diameters,
        fractions=axes.fractions or (settings.QUICK_FRACTIONS if quick else settings.FRACTIONS),
        penetrations=(5.0, 20.0) if quick else settings.PENETRATIONS,
    )  # fmt: skip
    reference = settings.reference_setting(0.02 if quick else min(settings.FRACTIONS), usable)
    chosen = list(dict.fromkeys([reference, *chosen]))
    rounds = axes.members or (2 if quick else 5)
    for note in notes:
        say(f"note: {note}")
    say(f"{case.name}: {len(chosen)} settings x {rounds} starts -> {store.path.parent}")

    changes = [setting.changes(fields.discs.diameter) for setting in chosen]
    starts: list[Start] = []
    in_turn(range(len(chosen)), rounds, lambda n, turn: starts.append(Start(n, changes[n], fields.run.seed + turn)))

    seconds = "{cpu_seconds:.2f} s"

    def said(made: Made) -> None:
        label, member = chosen[made.start.point].label, made.start.seed - fields.run.seed + 1
        say(f"  {label}, start {member} of {rounds}: {made.message or seconds.format_map(made.summary)}")

    with Pool(1) as pool:  # one at a time: they are timed
        made = run_starts(case, starts, store.path.parent, pool, fresh=fresh, said=said)
    if not any(run.summary for run in made):
        raise RunError(f"no setting of {case.name} came to its end; the first one says: {made[0].message}")
    groups = [[run for run in made if run.start.point == point] for point in range(len(chosen))]
    measures = [[measure(run) for run in group if run.summary] for group in groups]
    rows = [
        make_row(setting, group, found, measures[0], setting == reference)
        for setting, group, found in zip(chosen, groups, measures, strict=True)
    ]
    return {
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
    }


def make_row(
    setting: Setting,
    runs: list[Made],
    measures: list[dict[str, Value]],
    reference: list[dict[str, Value]],
    is_reference: bool,
) -> Results:
    """Return what is stored of a setting: medians over its complete runs, messages of the others, errors."""
    complete = [run.summary for run in runs if run.summary]
    errors = setting_errors(measures, reference) if complete else {}
    if is_reference:  # its distance from itself says nothing
        errors = {n: e if n in EXACT else e._replace(error=None, floor=None) for n, e in errors.items()}
    seconds = [found["cpu_seconds"] for found in complete]
    kinds = sorted({kind for found in complete for kind in found["breakdown_seconds"] or {}})
    return {
        "label": setting.label,
        "family": setting.family,
        "setting": asdict(setting),
        "plain": setting.plain,
        "runs": len(complete),
        "failed": [run.message for run in runs if not run.summary],
        "seconds": middle(seconds),
        "seconds_all": seconds,
        "wall_seconds": middle(found["wall_seconds"]["run"] for found in complete),
        "disc_steps_per_second": middle(
            found["disc_steps"] / spent for found, spent in zip(complete, seconds, strict=True) if spent
        ),
        "breakdown": {
            kind: middle((found["breakdown_seconds"] or {}).get(kind) for found in complete) for kind in kinds
        },
        "reference": is_reference,
        "errors": {name: entry._asdict() for name, entry in errors.items()},
    }


def summarise_quantity(rows: list[Results], name: str) -> Results:
    """Return Pareto front (labels), the cheapest setting for each of `TARGETS`, and the median floor of the errors."""
    usable = [row for row in rows if row["seconds"] and (row["errors"].get(name) or {}).get("error") is not None]
    choices = {f"{target:g}": cheapest(usable, name, target) for target in TARGETS}
    front = pareto([(row["seconds"], row["errors"][name]["error"]) for row in usable])
    return {
        "pareto": [usable[i]["label"] for i in front],
        "cheapest": {target: row and row["label"] for target, row in choices.items()},
        "floor": middle(row["errors"][name]["floor"] for row in usable),
    }
