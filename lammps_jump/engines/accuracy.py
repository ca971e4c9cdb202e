"""``run.accuracy``: a case loaded with the cheapest setting that is shown to meet what it asks.

The stored calibration (``calibration.json``) is made by `lammps_jump.studies.calibration_store`. A setting is *shown*
to meet an accuracy where both its error and the floor of that error (the scatter of the ensembles, see
`lammps_jump.studies.bench.errors`) are within it: a small error under a high floor proves nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from lammps_jump.case import LoadedCase, load_case
from lammps_jump.case.to_scene import contact_coefficients
from lammps_jump.engines import plugin
from lammps_jump.errors import CaseError
from lammps_jump.physics import contact
from lammps_jump.physics.slip import slip_warnings

STORE = Path(__file__).with_name("calibration.json")
KINDS = {
    "box": ("closed elastic box", "energy deviation"),
    "column": ("collapsing column", "front position"),
    "jet": ("jet and jump", "sequent depth"),
}
"""Kind of scene: what it is called, and the quantity that its accuracy speaks of."""


@dataclass(frozen=True)
class Choice:
    """A setting chosen by accuracy.

    Attributes
    ----------
    assignments : tuple of str
        ``--set`` texts that make a case use it.
    reason : str
        Which setting and why, in one paragraph.
    error, floor : float
        Of the stored calibration, as shares.
    """

    assignments: tuple[str, ...]
    reason: str
    error: float
    floor: float


def scene_kind(case: Any) -> str | None:
    """'box', 'column' or 'jet': which calibration speaks for a case; None where none does."""
    if case.gravity == 0 and case.contact.restitution > 0.99 and case.inflow is None:
        return "box"
    if case.inflow is not None and case.inflow.kind == "rows":
        return "jet"
    if any(item.kind == "column" for item in case.initial):
        return "column"
    return None


@lru_cache(maxsize=4)
def read_store(path: Path = STORE) -> dict[str, Any]:
    """The stored calibration.

    Raises
    ------
    CaseError
        Where the file is missing or cannot be read.
    """
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise CaseError(
            f"run.accuracy: the stored calibration {path.name} cannot be read ({error}); set run.time_step_fraction"
        ) from None


def choose_setting(
    case: Any,
    accuracy: float,
    *,
    usable: Iterable[str] = ("stock", "compiled", "native"),
    path: Path = STORE,
) -> Choice:
    """The cheapest stored setting that is shown to meet an accuracy.

    Parameters
    ----------
    case : lammps_jump.case.Case
    accuracy : float
        Share: 0.01 is 1 %.
    usable : iterable of str
        Kernels that run here, of 'stock', 'compiled', 'native'.
    path : Path
        The calibration file.

    Returns
    -------
    Choice

    Raises
    ------
    CaseError
        No calibration speaks for such a scene, or none of its settings is shown to be that accurate.
    """
    kind = scene_kind(case)
    calibrated = read_store(path)["kinds"]
    if kind is None or kind not in calibrated:
        known = ", ".join(f"{KINDS[name][0]} ({entry['case']})" for name, entry in calibrated.items())
        raise CaseError(
            f"run.accuracy: no calibration speaks for a scene like '{case.name}'; there is one for: {known}. "
            "Set run.time_step_fraction instead (0.05 is the thesis' value)"
        )
    entry, (words, quantity) = calibrated[kind], KINDS[kind]
    rows = [row for row in entry["rows"] if _fits(row, case, set(usable))]
    good = [row for row in rows if row["error"] <= accuracy and row["floor"] <= accuracy]
    if not good:
        best = min(rows, key=lambda row: max(row["error"], row["floor"]), default=None)
        shown = (
            f"the best shown is {100 * max(best['error'], best['floor']):.2g} % ({best['label']})"
            if best
            else "none fits"
        )
        raise CaseError(
            f"run.accuracy: {100 * accuracy:g} % in {quantity} is shown by no stored setting that fits here; {shown}. "
            "Ask for that, or set run.time_step_fraction"
        )
    row = min(good, key=lambda item: item["seconds"])
    return Choice(
        tuple(row["assignments"]),
        _reason(row, rows, entry, case, accuracy, quantity, words),
        row["error"],
        row["floor"],
    )


def _fits(row: dict[str, Any], case: Any, usable: set[str]) -> bool:
    """Whether a stored setting can be used for a case here: engine, kernel, law, stability of contacts and of slip.

    The calibration is without friction: a step at which friction turns the slip round every time is not shown by it.
    """
    kernel = row["kernel"]
    if kernel not in usable or (case.engine.name == "native") != (kernel == "native"):
        return False
    if case.engine.name == "lammps" and case.engine.kernel not in ("auto", kernel):
        return False
    if kernel == "stock" and case.contact.friction_law == "sign" and case.contact.friction > 0:
        return False
    integrator = "leapfrog_extrapolated" if kernel == "native" else "velocity_verlet"
    if row["fraction"] > contact.stable_fraction(contact.damping_ratio(case.contact.restitution), integrator):
        return False
    coefficients = contact_coefficients(case, integrator, row["fraction"])
    return not slip_warnings(coefficients, case.contact.friction_law, case.contact.rotation)


def _reason(row, rows, entry, case, accuracy: float, quantity: str, words: str) -> str:
    """One paragraph: which, how sure, how much quicker than the thesis' step, and what differs from the calibration."""
    base = next((other for other in rows if other["label"] == "stock f=0.05"), None)
    quicker = f", {base['seconds'] / row['seconds']:.1f} times quicker than stock LAMMPS at f = 0.05" if base else ""
    text = (
        f"{row['label']}: the cheapest shown to be within {100 * accuracy:g} % in {quantity} of a {words} "
        f"(measured on {entry['case']}: {100 * row['error']:.2g} %, scatter {100 * row['floor']:.2g} %{quicker})"
    )
    if case.contact.friction and not entry["friction"]:
        text += "; the calibration is without friction, this case has some"
    if abs(case.contact.restitution - entry["restitution"]) > 0.05:
        text += f"; the calibration is for e = {entry['restitution']:g}, this case has {case.contact.restitution:g}"
    return text


def load_with_accuracy(path: str | Path, assignments: list[str]) -> tuple[LoadedCase, tuple[str, ...]]:
    """Load a case; where it asks for an accuracy, with the cheapest setting that is shown to meet it, and why.

    Raises
    ------
    CaseError
    """
    loaded = load_case(path, assignments)
    if loaded.case.run.accuracy is None:
        return loaded, ()
    usable = ["stock", "native", *(["compiled"] if plugin.availability().available else [])]
    choice = choose_setting(loaded.case, loaded.case.run.accuracy, usable=usable)
    return load_case(path, [*assignments, *choice.assignments]), (choice.reason,)
