"""The engines behind one door: which one runs a scene and how, and the run of its script."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lammps_jump.engines as engines
from lammps_jump.case.case import ReadCase
from lammps_jump.engines.checkpoint import Checkpoint
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.plugin.build import availability, plugin_path
from lammps_jump.engines.ranks import choose_ranks
from lammps_jump.engines.result import ProgressCallback, RunResult
from lammps_jump.errors import SetupError
from lammps_jump.provenance import __version__
from lammps_jump.script import write_script
from lammps_jump.script.resume import write_continuation


@dataclass(frozen=True)
class Setting:
    """How a scene is run.

    Attributes
    ----------
    engine : {'lammps', 'native'}
    kernel : {'stock', 'compiled', 'numba'}
    ranks : int
        MPI ranks.
    plugin : Path or None
        The library of the compiled kernel, where it can be used.
    dump_format : {'text', 'gz', 'binary'}
    """

    engine: str
    kernel: str
    ranks: int = 1
    plugin: Path | None = None
    dump_format: str = "text"


def choose(case: ReadCase) -> tuple[Setting, tuple[str, ...]]:
    """The setting for a case on this machine, and what to tell the user about it.

    Raises
    ------
    CaseError, SetupError
        Ranks that the engine does not take; an engine or kernel that cannot be used here.
    """
    engine, scene, dump_format = case.fields.engine, case.scene(), case.fields.run.dump_format
    if engine.name == "native":
        if engine.ranks not in (1, "auto"):
            raise case.source.error("engine.ranks", f"{engine.ranks} ranks; the native engine runs on one core")
        return Setting("native", "numba", dump_format=dump_format), ()
    load_lammps()
    ranks, notes = choose_ranks(engine.ranks, scene)
    stock = Setting("lammps", "stock", ranks, dump_format=dump_format)
    if engine.kernel == "stock":
        return stock, tuple(notes)
    try:
        status = availability()
        if not status.available:
            raise SetupError(status.reason)
        return Setting("lammps", "compiled", ranks, plugin_path(), dump_format), tuple(notes)
    except SetupError as error:
        sign_law = scene.friction_law == "sign" and scene.coefficients.friction > 0
        if engine.kernel == "compiled" or scene.touch == "smooth" or sign_law:
            raise SetupError(f"the compiled kernel is needed here and cannot be used: {error}") from None
        return stock, (*notes, f"stock LAMMPS styles are used: {error}")


def run_key(case: ReadCase, setting: Setting) -> str:
    """Equal for runs of the same case with the same kernel."""
    return f"{case.hash}-{setting.kernel}"


def write_scripts(case: ReadCase, folder: Path, setting: Setting) -> None:
    """Write what LAMMPS reads into a run folder; nothing for the native engine."""
    if setting.engine == "lammps":
        header = _header(case, setting)
        write_script(case.scene(), folder, header=header, dump_format=setting.dump_format, **_kernel(setting))


def _kernel(setting: Setting) -> dict[str, Any]:
    return {"kernel": setting.kernel, "ranks": setting.ranks, "plugin": setting.plugin}


def _header(case: ReadCase, setting: Setting, script: str = "in.lammps") -> tuple[str, ...]:
    scene, c = case.scene(), case.scene().coefficients
    return (
        f"written by lammps-jump {__version__} from case {run_key(case, setting)}; run it with: lmp -in {script}",
        f"d = {scene.diameter:g} m, m = {c.mass:g} kg/m, k = {c.stiffness:g} N/m, e = {c.restitution:g}, "
        f"ks = {c.friction:g}",
        f"dt = {c.time_step:.6g} s = {c.time_step_fraction:g} of 2/omega; stable up to {c.stable_fraction:.3f} "
        "in the densest packing",
    )


def run_engine(
    case: ReadCase,
    folder: Path,
    setting: Setting,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    resume: Checkpoint | None = None,
) -> RunResult:
    """Run the scene of a case in a folder that `write_scripts` prepared.

    Parameters
    ----------
    progress : callable, optional
        Called with a `Progress` about twice a second.
    should_stop : callable, optional
        Asked at the same times; True ends the run as 'interrupted'.
    resume : Checkpoint, optional
        Go on from there.
    """
    scene = case.scene()
    if setting.engine == "native":
        return engines.native.run_native(
            scene, folder, progress=progress, should_stop=should_stop, dump_format=setting.dump_format, resume=resume
        )
    if resume is not None:
        write_continuation(
            scene,
            folder,
            state=resume.state,
            step=resume.step,
            removed=resume.removed,
            header=_header(case, setting, "in.resume.lammps"),
            dump_format=setting.dump_format,
            **_kernel(setting),
        )
    return engines.lammps.run_lammps(
        scene, folder, progress=progress, should_stop=should_stop, resume=resume, **_kernel(setting)
    )
