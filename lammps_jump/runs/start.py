"""From a case to a finished run folder: load, build, run, analyse, summarise, report."""

from __future__ import annotations

import importlib
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lammps_jump import analysis, dump
from lammps_jump.case import LoadedCase, case_hash, resolved_yaml
from lammps_jump.case.derived import inflow_theory
from lammps_jump.case.to_scene import build_scene
from lammps_jump.engines.accuracy import load_with_accuracy
from lammps_jump.engines.checkpoint import Checkpoint, remove_checkpoint
from lammps_jump.engines.choice import choose
from lammps_jump.engines.interrupts import terminate_as_interrupt
from lammps_jump.engines.launch import run, write_inputs
from lammps_jump.engines.result import ProgressCallback, RunResult
from lammps_jump.engines.setting import Job, Setting
from lammps_jump.errors import CaseError, DumpError, RunError, RunInterrupted, SetupError
from lammps_jump.files import OWN_FILES, RESULT_FILES, clear
from lammps_jump.provenance import versions
from lammps_jump.scene.scene import Scene

from . import summary as summaries
from .progress import ProgressLine

Say = Callable[[str], None]


@dataclass(frozen=True)
class Prepared:
    """A case made ready: everything decided, nothing written yet."""

    loaded: LoadedCase
    scene: Scene
    folder: Path
    setting: Setting
    notes: tuple[str, ...]

    @property
    def kernel(self) -> str:
        """Kernel of the engine."""
        return self.setting.kernel

    @property
    def ranks(self) -> int:
        """MPI ranks."""
        return self.setting.ranks

    @property
    def job(self) -> Job:
        """What the engine gets."""
        return Job(self.scene, self.folder, replace(self.setting, header=_header(self)), Path.cwd())

    @property
    def hash(self) -> str:
        """Hash of the resolved case with the engine's choices."""
        return f"{case_hash(self.loaded.case)}-{self.kernel}"


def prepare(path: str | Path, assignments: list[str], out: Path | None) -> Prepared:
    """Validate a case and decide folder, kernel and ranks; writes nothing.

    Raises
    ------
    CaseError, SetupError
    """
    loaded, chosen = load_with_accuracy(path, assignments)
    scene = build_scene(loaded)
    folder = out or Path("runs") / loaded.case.name
    engine = loaded.case.engine
    if engine.name == "native" and engine.ranks not in (1, "auto"):
        raise loaded.source.error("engine.ranks", f"{engine.ranks} ranks; the native engine runs on one core")
    setting, notes = choose(engine.name, engine.kernel, engine.ranks, scene)
    setting = replace(setting, dump_format=loaded.case.run.dump_format)
    return Prepared(loaded, scene, folder, setting, (*chosen, *notes))


def build_and_run(
    path: str | Path,
    *,
    out: Path | None = None,
    assignments: list[str] | None = None,
    force: bool = False,
    quiet: bool = False,
    live: bool = False,
    say: Say = print,
) -> dict[str, Any]:
    """The whole job; returns the summary.

    Raises
    ------
    CaseError, SetupError
        Before anything is written.
    RunError, RunInterrupted
        After a run that failed or was ended; its folder is kept, with what it had.
    """
    begin = time.perf_counter()
    prepared = prepare(path, assignments or [], out)
    if not force:
        stored = stored_result(prepared)
        if stored is not None:
            say(
                f"{prepared.folder} already holds this run ({stored['steps']} steps, "
                f"{stored['wall_seconds']['run']:.1f} s "
                "of computing): nothing to do. --force runs it again."
            )
            return stored
    if live and prepared.loaded.case.run.dump_format != "text":
        raise CaseError(f"--live reads text dumps; run.dump_format is {prepared.loaded.case.run.dump_format}")
    for note in (*prepared.scene.warnings, *prepared.notes):
        say(f"note: {note}")
    _announce(prepared, say)
    write_folder(prepared)
    built = time.perf_counter() - begin
    return run_folder(prepared, build_seconds=built, quiet=quiet, live=live, say=say)


def stored_result(prepared: Prepared) -> dict[str, Any] | None:
    """The summary of a finished run of the same resolved case in the same folder, else None."""
    try:
        stored = summaries.read_summary(prepared.folder)
    except DumpError:
        return None
    if stored is None or stored.get("status") != "complete" or stored.get("case_hash") != prepared.hash:
        return None
    try:
        same = (prepared.folder / "case.yaml").read_text() == resolved_yaml(prepared.loaded.case)
    except OSError:
        return None
    finished = all((prepared.folder / name).exists() for name in ("profiles.nc", "report.html"))
    return stored if same and finished and any(prepared.folder.glob("dump.lammps*")) else None


def write_folder(prepared: Prepared) -> None:
    """Make the run folder with ``case.yaml`` and, for LAMMPS, the script; earlier results of ours are removed.

    Raises
    ------
    SetupError
        Where the folder cannot be made or written.
    """
    folder = prepared.folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
        clear(folder, OWN_FILES)
        (folder / "case.yaml").write_text(resolved_yaml(prepared.loaded.case))
        write_inputs(prepared.job)
    except OSError as error:
        raise SetupError(
            f"{folder}: cannot be written ({error.strerror or error}); name another folder with --out, or "
            "mend its permissions"
        ) from None


def _header(prepared: Prepared) -> tuple[str, ...]:
    c = prepared.scene.coefficients
    version = versions().get("lammps_jump", "?")
    return (
        f"written by lammps-jump {version} from case {prepared.hash}; run it with: lmp -in in.lammps",
        f"d = {prepared.scene.diameter:g} m, m = {c.mass:g} kg/m, k = {c.stiffness:g} N/m, e = "
        f"{c.restitution:g}, ks = {c.friction:g}",
        f"dt = {c.time_step:.6g} s = {c.time_step_fraction:g} of 2/omega; stable up to "
        f"{c.stable_fraction:.3f} in the densest packing",
    )


def _announce(prepared: Prepared, say: Say) -> None:
    scene, c = prepared.scene, prepared.scene.coefficients
    engine = prepared.loaded.case.engine.name
    say(
        f"{scene.name}: {engine} ({prepared.kernel}{f', {prepared.ranks} ranks' if prepared.ranks > 1 else ''}), "
        f"{scene.steps} steps of {c.time_step:.4g} s, e = {c.restitution:g}, ks = {c.friction:g}, k = "
        f"{c.stiffness:.4g} N/m "
        f"-> {prepared.folder}"
    )


def run_folder(
    prepared: Prepared,
    *,
    build_seconds: float,
    quiet: bool,
    say: Say,
    live: bool = False,
    resume: Checkpoint | None = None,
    analysis_seconds: float = 0.0,
) -> dict[str, Any]:
    """Run the engine in a folder that `write_folder` made, analyse and report; see `build_and_run`.

    With `resume` go on there with an interrupted run; `build_seconds`, `analysis_seconds`: spent in earlier parts.
    """
    result, steady = _run_engine(prepared, quiet, live, resume)
    if resume is not None and result.status == "failed" and result.steps <= resume.step:
        raise RunError(f"{result.message} Nothing was added to the run, and its checkpoint is kept.")
    if result.status != "interrupted":
        remove_checkpoint(prepared.folder)
        (prepared.folder / "in.resume.lammps").unlink(missing_ok=True)
    begin = time.perf_counter() - analysis_seconds
    if resume is not None:
        clear(prepared.folder, RESULT_FILES)  # those of the part before
    parts: dict[str, Any] = {}
    trouble = ""
    try:
        with analysis_of(prepared.folder):
            parts = analyse(prepared, result, quiet)
    except DumpError as error:
        trouble = str(error)
    seconds = {"build": build_seconds, "run": result.seconds, "analysis": time.perf_counter() - begin}
    if result.status != "complete" and trouble:
        parts.setdefault("warnings", []).append(f"not analysed: {trouble}")
    if steady:
        parts["stopped_when_steady"] = steady
        say(f"note: {steady}")
    summary = compose(prepared, result, seconds, parts)
    summaries.write_summary(prepared.folder, summary)
    report(prepared, summary)
    seconds["analysis"] = time.perf_counter() - begin
    summaries.write_summary(prepared.folder, {**summary, "wall_seconds": seconds})
    if result.status == "interrupted":
        raise RunInterrupted(result.message)
    if result.status == "failed":
        raise RunError(result.message)
    if trouble:
        raise RunError(f"the run is complete, its dump could not be analysed: {trouble}")
    return {**summary, "wall_seconds": seconds}


def compose(prepared: Prepared, result: RunResult, seconds: dict[str, float], parts: dict[str, Any]) -> dict[str, Any]:
    """The summary of a run of a prepared case."""
    found = dict(parts)
    warnings = [*prepared.scene.warnings, *prepared.notes, *found.pop("warnings", [])]
    summary = summaries.compose(
        prepared.scene, result, case_hash=prepared.hash, seconds=seconds, parts={**found, "warnings": warnings}
    )
    summary["ranks"] = prepared.ranks
    summary["theory"] = inflow_theory(prepared.loaded.case, prepared.scene)
    return summary


def _steady_watch(prepared: Prepared):
    """The watch of a case with ``run.stop_when_steady``, else None."""
    run = prepared.loaded.case.run
    if not run.stop_when_steady or not prepared.scene.inlets:
        return None

    from .steady_watch import SteadyWatch, studied_reach

    return SteadyWatch(prepared.scene, prepared.folder, studied_reach(analysis.from_scene(prepared.scene)))


def _load_analysis() -> None:
    """Import what the analysis needs, 0.7 s."""
    for name in ("numba", "xarray", "h5netcdf", "matplotlib.figure", "matplotlib.backends.backend_agg"):
        importlib.import_module(name)


def _run_engine(
    prepared: Prepared, quiet: bool, live: bool = False, resume: Checkpoint | None = None
) -> tuple[RunResult, str]:
    """Run; the text says why it was stopped as steady, and is empty where it was not."""
    scene = prepared.scene
    line = ProgressLine(scene.time(scene.steps), quiet=quiet, first_step=resume.step if resume else 0)
    watch = _steady_watch(prepared)
    view = None
    if live:
        from .live import LiveView

        view = LiveView(scene, prepared.folder, line)
    shown: ProgressCallback = view or line
    job = prepared.job
    threading.Thread(target=_load_analysis).start()  # meanwhile
    result = run(scene, prepared.folder, job.setting, progress=shown, should_stop=watch, resume=resume)
    line.finish()
    if view is not None:
        view.finish()
    if watch is not None and watch.reason and result.status == "interrupted":
        return replace(result, status="complete", message=""), watch.reason
    return result, ""


def analyse(prepared: Prepared, result: RunResult, quiet: bool) -> dict[str, Any]:
    """Analyse the dump of a run folder as its case asks; the parts of the summary that came of it."""
    case = prepared.loaded.case
    asked = case.analysis
    inflow = case.inflow if case.inflow is not None and case.inflow.kind == "rows" else None
    flow = analysis.from_scene(
        prepared.scene,
        bin_width=asked.bin_width,
        window=asked.window,
        inflow_depth=inflow.depth if inflow else None,
        inflow_speed=inflow.mean_speed if inflow else None,
    )
    wanted = [name for name in (*analysis.QUANTITIES, "fields") if getattr(asked, name, False)]
    folder = prepared.folder
    return analysis.analyse(flow, dump.find_dump(folder), folder, wanted, film=asked.animation, quiet=quiet)


@contextmanager
def analysis_of(folder: Path):
    """Ctrl-C and SIGTERM during the analysis of a run folder become a `RunInterrupted` that says what is left to do."""
    try:
        with terminate_as_interrupt():
            yield
    except KeyboardInterrupt:
        raise RunInterrupted(
            f"the analysis was ended; what the run wrote is kept: `lammps-jump analyze {folder}` analyses it"
        ) from None


def report(prepared: Prepared, summary: dict[str, Any]) -> None:
    """Write ``report.html``."""
    from lammps_jump.analysis.report.run import write_report

    write_report(prepared.folder, summary, resolved_yaml(prepared.loaded.case))
