# SPDX-License-Identifier: GPL-2.0-or-later
"""``run.accuracy``: the cheapest setting that the stored calibration shows to meet an accuracy.

``calibration.json`` is made from finished benchmarks by ``python benchmarks/accuracy_store.py``. A setting
is *shown* to meet an accuracy where its error and the floor of that error (the scatter of the ensembles, see
`lammps_jump.studies.bench`) are both within it. A small error under a high floor proves nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from lammps_jump.case import CaseFields, ReadCase
from lammps_jump.case.packing import disc_sizes
from lammps_jump.case.to_scene import contact_coefficients
from lammps_jump.errors import CaseError
from lammps_jump.files import read_json
from lammps_jump.physics import contact
from lammps_jump.physics.slip import FRICTION_LAWS, slip_warnings

from .plugin.product import availability

STORE = Path(__file__).with_name("calibration.json")
KINDS = {
    "box": ("closed elastic box", "energy deviation"),
    "column": ("collapsing column", "front position"),
    "jet": ("jet and jump", "sequent depth"),
}
"""Kind of scene: its name in messages, and the quantity of its accuracy."""


@dataclass(frozen=True)
class CalibratedSetting:
    """A setting of the stored calibration.

    Attributes
    ----------
    label, kernel : str
    fraction : float
        Time step over 2/omega.
    assignments : list of str
        ``--set`` texts that make a case use it.
    seconds : float
        Processor time, s.
    error, floor : float
        Shares of the quantity.
    """

    label: str
    kernel: str
    fraction: float
    assignments: list[str]
    seconds: float
    error: float
    floor: float

    @property
    def shown(self) -> float:
        """Accuracy that this setting is shown to meet, a share."""
        return max(self.error, self.floor)


def with_accuracy(case: ReadCase) -> tuple[ReadCase, tuple[str, ...]]:
    """Return a case with the cheapest setting that meets the accuracy it asks for, and the reason.

    Raises
    ------
    CaseError
        No stored setting is shown to be that accurate.
    """
    if case.fields.run.accuracy is None:
        return case, ()
    usable = ["stock", "native", *(["compiled"] if availability().available else [])]
    setting, reason = choose_setting(case.fields, case.fields.run.accuracy, usable=usable)
    return case.replace(setting.assignments), (reason,)


def scene_kind(case: CaseFields) -> str | None:
    """Return 'box', 'column' or 'jet', the calibration that is valid for a case; None where there is none."""
    if case.gravity == 0 and case.contact.restitution > 0.99 and case.inflow is None:
        return "box"
    if case.inflow is not None and case.inflow.kind == "rows":
        return "jet"
    if any(item.kind == "column" for item in case.initial):
        return "column"
    return None


@lru_cache(maxsize=4)
def read_store(path: Path = STORE) -> dict[str, dict[str, Any]]:
    """Return the stored calibration by kind of scene.

    Raises
    ------
    CaseError
        Where the file is missing or cannot be read.
    """
    try:
        return read_json(path)["kinds"]
    except (OSError, ValueError) as error:
        raise CaseError(
            f"run.accuracy: the stored calibration {path.name} cannot be read ({error}); set run.time_step_fraction"
        ) from None


def choose_setting(
    case: CaseFields, accuracy: float, *, usable: Iterable[str] = ("stock", "compiled", "native"), path: Path = STORE
) -> tuple[CalibratedSetting, str]:
    """Return the cheapest stored setting that is shown to meet an accuracy, and why, in one paragraph.

    Parameters
    ----------
    case : lammps_jump.case.CaseFields
    accuracy : float
        Share: 0.01 is 1 %.
    usable : iterable of str
        Kernels that run here, of 'stock', 'compiled', 'native'.
    path : Path
        The calibration file.

    Raises
    ------
    CaseError
        No calibration is valid for such a scene, or none of its settings is shown to be that accurate.
    """
    kind, kinds = scene_kind(case), read_store(path)
    if kind not in kinds:
        known = ", ".join(f"{KINDS[name][0]} ({entry['case']})" for name, entry in kinds.items())
        raise CaseError(
            f"run.accuracy: no calibration speaks for a scene like '{case.name}'; there is one for: {known}. "
            "Set run.time_step_fraction instead (0.05 is the thesis' value)"
        )
    every = [CalibratedSetting(**row) for row in kinds[kind]["rows"]]
    rows = [row for row in every if fits(row, case, set(usable))]
    good = [row for row in rows if row.shown <= accuracy]
    if not good:
        best = min(rows, key=lambda row: row.shown, default=None)
        shown = f"the best shown is {100 * best.shown:z.2g} % ({best.label})" if best else "none fits"
        raise CaseError(
            f"run.accuracy: {100 * accuracy:zg} % in {KINDS[kind][1]} is shown by no stored setting that fits here; "
            f"{shown}. Ask for that, or set run.time_step_fraction"
        )
    chosen = min(good, key=lambda row: row.seconds)
    base = next((row for row in rows if row.label == "stock f=0.05"), None)
    return chosen, _reason(chosen, base, kinds[kind], case, accuracy)


def fits(row: CalibratedSetting, case: CaseFields, usable: set[str]) -> bool:
    """Return whether a stored setting can be used for a case here: engine, kernel, law, stable contacts and slip.

    The calibration is without friction, so it shows nothing about a step at which friction reverses the slip.
    """
    engine, law = case.engine, case.contact
    if row.kernel not in usable or (engine.name != "lammps") != (row.kernel == "native"):
        return False
    if engine.name == "lammps" and engine.kernel not in ("auto", row.kernel):
        return False
    if row.kernel == "stock" and getattr(case.inflow, "table", None):  # fix deposit has one interval and speed
        return False
    if row.kernel == "stock" and law.friction > 0 and not FRICTION_LAWS[law.friction_law].in_stock:
        return False
    integrator = "leapfrog_extrapolated" if row.kernel == "native" else "velocity_verlet"
    if row.fraction > contact.stable_fraction(contact.damping_ratio(law.restitution), integrator):
        return False
    coefficients = contact_coefficients(case, integrator, disc_sizes(case), row.fraction)
    return not slip_warnings(coefficients, law.friction_law, law.rotation)


def _reason(
    row: CalibratedSetting, base: CalibratedSetting | None, entry: dict[str, Any], case: CaseFields, accuracy: float
) -> str:
    """Return which setting, how sure, how much quicker than the thesis' step, and what the calibration lacks."""
    words, quantity = KINDS[scene_kind(case) or ""]
    quicker = f", {base.seconds / row.seconds:z.1f} times quicker than stock LAMMPS at f = 0.05" if base else ""
    text = (
        f"{row.label}: the cheapest shown to be within {100 * accuracy:zg} % in {quantity} of a {words} "
        f"(measured on {entry['case']}: {100 * row.error:z.2g} %, scatter {100 * row.floor:z.2g} %{quicker})"
    )
    if case.contact.friction and not entry["friction"]:
        text += "; the calibration is without friction, this case has some"
    if abs(case.contact.restitution - entry["restitution"]) > 0.05:
        text += f"; the calibration is for e = {entry['restitution']:zg}, this case has {case.contact.restitution:zg}"
    return text
