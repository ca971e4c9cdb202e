"""``lammps-jump bench CASE``: run time against error over the settings of a case; resumable, in one ``bench.json``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from lammps_jump.case import case_hash, load_case
from lammps_jump.errors import CaseError, RunError
from lammps_jump.studies.timing import Store, in_turn, machine, middle, versions

from .errors import EXACT, cheapest, names_of, pareto, setting_errors
from .runs import run_setting
from .settings import FRACTIONS, QUICK_FRACTIONS, Setting, make_settings, parse_axes, reference_setting, usable_kernels

BENCH_FILE = "bench.json"
MOST_MEMBERS = 100
TARGETS = (0.01, 0.05)
"""Errors for which the cheapest setting is named."""

Say = Callable[[str], None]


def bench_case(
    path: str | Path,
    *,
    out: Path | None = None,
    axes: str | None = None,
    quick: bool = False,
    members: int | None = None,
    assignments: Sequence[str] = (),
    fractions: Sequence[float] | None = None,
    kernels: Sequence[str] | None = None,
    diameters: Sequence[float] = (),
    fresh: bool = False,
    figures: bool = True,
    say: Say = print,
) -> dict[str, Any]:
    """Benchmark a case.

    Parameters
    ----------
    path : path
        Case file.
    out : Path, optional
        Folder of ``bench.json``, ``bench.md`` and figures; default ``runs/bench/<name>``.
    axes : str, optional
        Comma-separated, of `settings.AXES`.
    quick : bool
        Three steps, two starts, nothing but step, kernel and touch: minutes become seconds.
    members : int, optional
        Starts of each setting; default 5 (2 if quick). The reference gets as many.
    assignments : sequence of str
        ``--set`` texts for all settings.
    fractions, kernels, diameters : sequence, optional
        In place of the default values of those axes.
    fresh : bool
        Measure again what is stored.
    figures : bool
    say : callable
        Takes one line of progress.

    Returns
    -------
    dict
        The content of ``bench.json``.

    Raises
    ------
    CaseError
        The case or an axis cannot be used.
    RunError
        No setting came to its end.
    """
    if members is not None and members < 1:
        raise CaseError(f"--members {members}: allowed is 1 or more")
    own = load_case(path, list(assignments)).case
    chosen = parse_axes(axes or ("f,touch,kernel" if quick else None))
    usable, notes = usable_kernels()
    usable = [kernel for kernel in usable if kernels is None or kernel in kernels] or usable
    fractions = tuple(fractions or (QUICK_FRACTIONS if quick else FRACTIONS))
    settings = make_settings(
        chosen, restitution=own.contact.restitution, kernels=usable, fractions=fractions, diameters=diameters,
        penetrations=(5.0, 20.0) if quick else (5.0, 10.0, 20.0, 40.0),
    )  # fmt: skip
    reference = reference_setting(0.02 if quick else min(FRACTIONS), usable)
    settings = list(dict.fromkeys([reference, *settings]))
    rounds = members if members is not None else (2 if quick else 5)
    folder = Path(out) if out else Path("runs") / "bench" / own.name
    store = Store(folder / BENCH_FILE, fresh=fresh)
    for note in notes:
        say(f"note: {note}")
    say(f"{own.name}: {len(settings)} settings x {rounds} starts -> {folder}")
    _run_all(store, path, list(assignments), own, settings, rounds, say)
    return finish(store, own, settings, reference, rounds, notes, figures=figures)


def _run_all(store: Store, path, assignments, own, settings: list[Setting], rounds: int, say: Say) -> None:
    identity = (case_hash(own), versions())
    todo = [pair for pair in in_turn(settings, rounds) if _key(pair[1], identity, pair[0]) not in store.pieces]
    _warm_engines(path, assignments, {setting.kernel for _, setting in todo})
    for done, (member, setting) in enumerate(todo, 1):
        key = _key(setting, identity, member)
        run = store.piece(key, lambda s=setting, m=member: run_setting(path, assignments, s, m))
        if run["status"] == "complete":
            say(f"  {done}/{len(todo)} {setting.label}, start {member + 1}: {run['cpu_seconds']:.2f} s")
        else:
            say(f"  {done}/{len(todo)} {setting.label}, start {member + 1}: {run['status']}: {run['message']}")


def _warm_engines(path, assignments, kernels: set[str]) -> None:
    """Load every engine once before the clock starts: a first run pays for libraries and for the plugin's build."""
    for kernel in kernels:
        texts = [*assignments, "run.duration=0.001", "run.output_interval=0.001", "analysis.energy=false"]
        texts += ["analysis.jump=false", "analysis.front=false", "probes.forces=[]", "analysis.window=null"]
        run_setting(path, texts, Setting(kernel, 0.05), 0)


def stored_runs(store: Store, setting: Setting, own) -> list[dict[str, Any]]:
    """Every stored run of a setting, also of starts that an earlier call asked for and this one did not."""
    keys = [_key(setting, (case_hash(own), versions()), member) for member in range(MOST_MEMBERS)]
    return [store.pieces[key] for key in keys if key in store.pieces]


def _key(setting: Setting, identity: tuple, member: int) -> str:
    return setting.key(*identity, member)


def finish(store: Store, own, settings, reference, rounds: int, notes, *, figures: bool) -> dict[str, Any]:
    """Rows, errors, Pareto fronts and choices from the stored runs; writes ``bench.json``, the table and figures."""
    runs = {setting: stored_runs(store, setting, own) for setting in settings}
    if not any(run["status"] == "complete" for group in runs.values() for run in group):
        first = next(run for group in runs.values() for run in group)
        raise RunError(f"no setting of {own.name} came to its end; the first one says: {first['message']}")
    rows = [_row(setting, runs[setting], runs[reference], setting == reference) for setting in settings]
    quantities = names_of([run for group in runs.values() for run in group])
    store.data |= {
        "case": own.name,
        "case_hash": case_hash(own),
        "restitution": own.contact.restitution,
        "friction": own.contact.friction,
        "duration": own.run.duration,
        "members": rounds,
        "reference": reference.label,
        "versions": versions(),
        "machine": machine(),
        "notes": list(notes),
        "time": "median processor seconds of the engine, output included, analysis not",
        "rows": rows,
        "quantities": {name: summarise_quantity(rows, name) for name in quantities},
    }
    store.save()
    from .table import markdown

    (store.path.parent / "bench.md").write_text(markdown(store.data))
    if figures:
        from .figures import draw_all

        draw_all(store.data, store.path.parent)
    return store.data


def _row(
    setting: Setting, runs: list[dict[str, Any]], reference: list[dict[str, Any]], is_reference: bool
) -> dict[str, Any]:
    complete = [run for run in runs if run["status"] == "complete"]
    seconds = middle(run["cpu_seconds"] for run in complete)
    rates = [run["disc_steps"] / run["cpu_seconds"] for run in complete if run["cpu_seconds"]]
    kinds = {kind for run in complete for kind in run["breakdown"]}
    errors = setting_errors(runs, reference) if complete else {}
    if is_reference:  # its distance from itself says nothing
        for name, entry in errors.items():
            entry |= {} if name in EXACT else {"error": None, "floor": None}
    return {
        "label": setting.label,
        "family": setting.family,
        "setting": {name: getattr(setting, name) for name in setting.__dataclass_fields__},
        "plain": setting.plain,
        "runs": len(complete),
        "failed": [run["message"] for run in runs if run["status"] != "complete"],
        "seconds": seconds,
        "seconds_all": [run["cpu_seconds"] for run in complete],
        "wall_seconds": middle(run["wall_seconds"] for run in complete),
        "disc_steps_per_second": middle(rates),
        "breakdown": {kind: middle(run["breakdown"].get(kind) for run in complete) for kind in sorted(kinds)},
        "reference": is_reference,
        "errors": errors,
    }


def summarise_quantity(rows: list[dict[str, Any]], name: str) -> dict[str, Any]:
    """Pareto front (labels) and the cheapest setting for each of `TARGETS`; the reference's own scatter."""
    usable = [row for row in rows if row["seconds"] and (row["errors"].get(name) or {}).get("error") is not None]
    points = [(row["seconds"], row["errors"][name]["error"]) for row in usable]
    choices = {}
    for target in TARGETS:
        row = cheapest(usable, name, target)
        choices[f"{target:g}"] = row["label"] if row else None
    floors = [row["errors"][name]["floor"] for row in usable]
    return {"pareto": [usable[i]["label"] for i in pareto(points)], "cheapest": choices, "floor": middle(floors)}
