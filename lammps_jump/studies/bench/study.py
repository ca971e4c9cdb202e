# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump bench CASE``: run time against error over the settings of a case; resumable, in one ``bench.json``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from lammps_jump import Case
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import CaseError, RunError
from lammps_jump.studies.measure import Measured, run_setting
from lammps_jump.studies.settings import (
    FRACTIONS,
    QUICK_FRACTIONS,
    Setting,
    make_settings,
    parse_axes,
    reference_setting,
)
from lammps_jump.studies.store import Store
from lammps_jump.studies.timing import in_turn, middle, versions

from .errors import EXACT, Row, cheapest, names_of, pareto, setting_errors
from .figures import draw_all
from .table import page

BENCH_FILE = "bench.json"
MOST_MEMBERS = 100
TARGETS = (0.01, 0.05)
"""Errors for which the cheapest setting is named."""
QUIET_CHANGES = {
    "run.duration": 0.001, "run.output_interval": 0.001, "analysis.energy": False, "analysis.jump": False,
    "analysis.front": False, "probes.forces": [], "analysis.window": None,
}  # fmt: skip
"""A run that only loads an engine."""

Say = Callable[[str], None]


@dataclass(frozen=True)
class Axes:
    """What a benchmark varies; None leaves the default values.

    Attributes
    ----------
    names : str or None
        Comma-separated, of `settings.AXES`.
    fractions, diameters : tuple of float or None
        Time steps over 2/omega; disc diameters, m.
    kernels : tuple of str or None
    """

    names: str | None = None
    fractions: tuple[float, ...] | None = None
    kernels: tuple[str, ...] | None = None
    diameters: tuple[float, ...] = ()


def bench_case(
    case: Case,
    store: Store,
    *,
    axes: Axes = Axes(),
    quick: bool = False,
    members: int | None = None,
    figures: bool = True,
    say: Say = print,
) -> str:
    """Benchmark a case.

    Parameters
    ----------
    case : Case
    store : Store
        Of ``bench.json``; table and figures are written beside it.
    axes : Axes
    quick : bool
        Three steps, two starts, nothing but step, kernel and touch: minutes become seconds.
    members : int, optional
        Starts of each setting; default 5 (2 if quick). The reference gets as many.
    figures : bool
    say : callable
        Takes one line of progress.

    Returns
    -------
    str
        The page ``bench.md``.

    Raises
    ------
    CaseError
        The case or an axis cannot be used.
    RunError
        No setting came to its end.
    """
    if members is not None and members < 1:
        raise CaseError(f"--members {members}: allowed is 1 or more")
    restitution = case.fields.contact.restitution
    chosen = parse_axes(axes.names or ("f,touch,kernel" if quick else None))
    usable, notes = usable_kernels()
    usable = [kernel for kernel in usable if axes.kernels is None or kernel in axes.kernels] or usable
    settings = make_settings(
        chosen, restitution=restitution, kernels=usable, diameters=axes.diameters,
        fractions=axes.fractions or (QUICK_FRACTIONS if quick else FRACTIONS),
        penetrations=(5.0, 20.0) if quick else (5.0, 10.0, 20.0, 40.0),
    )  # fmt: skip
    reference = reference_setting(0.02 if quick else min(FRACTIONS), usable)
    settings = list(dict.fromkeys([reference, *settings]))
    rounds = members if members is not None else (2 if quick else 5)
    for note in notes:
        say(f"note: {note}")
    say(f"{case.name}: {len(settings)} settings x {rounds} starts -> {store.path.parent}")
    _run_all(store, case, settings, rounds, say)
    runs = {setting: _stored_runs(store, setting, case) for setting in settings}
    rows = make_rows(runs, reference, case.name)
    _finish(store, case, rows, names_of([run for group in runs.values() for run in group]), rounds, notes)
    if figures:
        draw_all(store.data, store.path.parent)
    return store.write_table(page(store.data))


def _run_all(store: Store, case: Case, settings: Sequence[Setting], rounds: int, say: Say) -> None:
    identity = (case.hash, versions())
    todo = [pair for pair in in_turn(settings, rounds) if pair[1].key(*identity, pair[0]) not in store.pieces]
    for kernel in {setting.kernel for _, setting in todo}:
        # load every engine before the clock starts: a first run pays for libraries and for the plugin's build
        run_setting(case.replace(QUIET_CHANGES), Setting(kernel, 0.05), 0)
    for done, (member, setting) in enumerate(todo, 1):
        key = setting.key(*identity, member)
        run = store.piece(key, lambda s=setting, m=member: run_setting(case, s, m), Measured)
        outcome = f"{run.cpu_seconds:.2f} s" if run.complete else f"{run.status}: {run.message}"
        say(f"  {done}/{len(todo)} {setting.label}, start {member + 1}: {outcome}")


def _stored_runs(store: Store, setting: Setting, case: Case) -> list[Measured]:
    """Return every stored run of a setting, also of starts that only an earlier call asked for."""
    keys = [setting.key(case.hash, versions(), member) for member in range(MOST_MEMBERS)]
    return [Measured(**store.pieces[key]) for key in keys if key in store.pieces]


def make_rows(runs: dict[Setting, list[Measured]], reference: Setting, name: str) -> list[Row]:
    """Return a row for each setting.

    Raises
    ------
    RunError
        No run is complete.
    """
    every = [run for group in runs.values() for run in group]
    if not any(run.complete for run in every):
        raise RunError(f"no setting of {name} came to its end; the first one says: {every[0].message}")
    return [_row(setting, group, runs[reference], setting == reference) for setting, group in runs.items()]


def _row(setting: Setting, runs: list[Measured], reference: list[Measured], is_reference: bool) -> Row:
    complete = [run for run in runs if run.complete]
    kinds = {kind for run in complete for kind in run.breakdown}
    errors = setting_errors(runs, reference) if complete else {}
    if is_reference:  # its distance from itself says nothing
        errors = {name: entry if name in EXACT else entry.of_reference() for name, entry in errors.items()}
    return Row(
        label=setting.label,
        family=setting.family,
        setting=asdict(setting),
        plain=setting.plain,
        runs=len(complete),
        failed=[run.message for run in runs if not run.complete],
        seconds=middle(run.cpu_seconds for run in complete),
        seconds_all=[run.cpu_seconds for run in complete],
        wall_seconds=middle(run.wall_seconds for run in complete),
        disc_steps_per_second=middle(run.disc_steps / run.cpu_seconds for run in complete if run.cpu_seconds),
        breakdown={kind: middle(run.breakdown.get(kind) for run in complete) for kind in sorted(kinds)},
        reference=is_reference,
        errors=errors,
    )


def _finish(store: Store, case: Case, rows: list[Row], quantities: list[str], rounds: int, notes) -> None:
    """Write ``bench.json`` with rows, Pareto fronts and choices."""
    fields = case.fields
    store.finish(
        case=case.name,
        case_hash=case.hash,
        restitution=fields.contact.restitution,
        friction=fields.contact.friction,
        duration=fields.run.duration,
        members=rounds,
        reference=next(row.label for row in rows if row.reference),
        notes=list(notes),
        time="median processor seconds of the engine, output included, analysis not",
        rows=rows,
        quantities={name: summarise_quantity(rows, name) for name in quantities},
    )


def summarise_quantity(rows: list[Row], name: str) -> dict:
    """Return Pareto front (labels), the cheapest setting for each of `TARGETS`, and the median floor of the errors."""
    usable = [row for row in rows if row.seconds and name in row.errors and row.errors[name].error is not None]
    choices = {f"{target:g}": cheapest(usable, name, target) for target in TARGETS}
    front = pareto([(row.seconds, row.errors[name].error) for row in usable])
    return {
        "pareto": [usable[i].label for i in front],
        "cheapest": {target: row and row.label for target, row in choices.items()},
        "floor": middle(row.errors[name].floor for row in usable),
    }
