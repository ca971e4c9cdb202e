# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of the settings: run time against error; resumable, in one ``bench.json``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from lammps_jump import Case
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import CaseError, RunError
from lammps_jump.studies import settings
from lammps_jump.studies.measure import Measured, run_setting
from lammps_jump.studies.runs import KERNELS, in_turn, middle, versions
from lammps_jump.studies.settings import Setting, listed
from lammps_jump.studies.store import Results, Say, Store

from .errors import EXACT, cheapest, names_of, pareto, setting_errors

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
    values = (
        _numbers("--fractions", fractions),
        listed("--kernels", kernels, KERNELS),
        _numbers("--diameters", diameters),
    )
    return Axes(listed("--axes", names, settings.AXES), *values, members)


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


def measure_settings(case: Case, store: Store, *, axes: Axes, quick: bool, say: Say) -> Results:
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

    def run(setting: Setting, member: int) -> Measured:
        key = setting.key(case.hash, versions(), member)
        known = key in store.pieces
        found = store.piece(key, lambda: run_setting(case, setting, member), Measured)
        outcome = f"{found.cpu_seconds:.2f} s" if found.complete else f"{found.status}: {found.message}"
        if not known:
            say(f"  {setting.label}, start {member + 1} of {rounds}: {outcome}")
        return found

    runs = in_turn(chosen, rounds, run)
    every = [found for group in runs.values() for found in group]
    if not any(found.complete for found in every):
        raise RunError(f"no setting of {case.name} came to its end; the first one says: {every[0].message}")
    rows = [make_row(setting, group, runs[reference], setting == reference) for setting, group in runs.items()]
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
        "quantities": {name: summarise_quantity(rows, name) for name in names_of(every)},
    }


def make_row(setting: Setting, runs: list[Measured], reference: list[Measured], is_reference: bool) -> Results:
    """Return what is stored of a setting: medians over its complete runs, messages of the others, errors."""
    complete = [run for run in runs if run.complete]
    errors = setting_errors(runs, reference) if complete else {}
    if is_reference:  # its distance from itself says nothing
        errors = {n: e if n in EXACT else e._replace(error=None, floor=None) for n, e in errors.items()}
    return {
        "label": setting.label,
        "family": setting.family,
        "setting": asdict(setting),
        "plain": setting.plain,
        "runs": len(complete),
        "failed": [run.message for run in runs if not run.complete],
        "seconds": middle(run.cpu_seconds for run in complete),
        "seconds_all": [run.cpu_seconds for run in complete],
        "wall_seconds": middle(run.wall_seconds for run in complete),
        "disc_steps_per_second": middle(run.disc_steps / run.cpu_seconds for run in complete if run.cpu_seconds),
        "breakdown": {
            kind: middle(run.breakdown.get(kind) for run in complete)
            for kind in sorted({kind for run in complete for kind in run.breakdown})
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
