"""``run.accuracy``: a case loaded with the cheapest setting that is shown to meet what it asks."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.case import LoadedCase, load_case


def load_with_accuracy(path: str | Path, assignments: list[str]) -> tuple[LoadedCase, tuple[str, ...]]:
    """Load a case; where it asks for an accuracy, with the cheapest setting that is shown to meet it, and why.

    Raises
    ------
    CaseError
    """
    loaded = load_case(path, assignments)
    if loaded.case.run.accuracy is None:
        return loaded, ()
    from lammps_jump.engines.plugin.build import availability
    from lammps_jump.studies.calibration_store import choose_setting

    usable = ["stock", "native", *(["compiled"] if availability().available else [])]
    choice = choose_setting(loaded.case, loaded.case.run.accuracy, usable=usable)
    return load_case(path, [*assignments, *choice.assignments]), (choice.reason,)
