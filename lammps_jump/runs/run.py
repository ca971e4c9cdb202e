# SPDX-License-Identifier: GPL-2.0-or-later
"""The public objects: a case that can be run, and a run folder whose results are read or made on first use."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypedDict, Unpack, cast, overload

from lammps_jump import runs
from lammps_jump.analysis import QUANTITIES, report
from lammps_jump.analysis.report.page import LivePage, show_page
from lammps_jump.case.base import HOW_TO_CHANGE
from lammps_jump.case.case import Changes, ReadCase
from lammps_jump.case.fields import CaseFields
from lammps_jump.engines import NATIVE_KERNELS, ProgressCallback, RunResult, Setting
from lammps_jump.errors import CaseError, DumpError, NearestNames, RunError
from lammps_jump.files import CURVES
from lammps_jump.folders import holder, locked, require_replaceable
from lammps_jump.scene.scene import Scene

from .folder import default_folder, require_case, result_of
from .summary import compose, open_results, read_summary, results_in
from .view import Frames, case_html, number_table, write_preview

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from matplotlib.figure import Figure

    from lammps_jump.analysis import Energy, Force, Front, Jump
    from lammps_jump.analysis.flow import Flow
    from lammps_jump.analysis.forces.history import Forces

    from .results import ResultsInMemory
    from .stepped import SteppedRun

Status = Literal["complete", "unchecked", "interrupted", "failed", "running"]


class EngineOptions(TypedDict, total=False):
    """Options of `run` that replace the case's own."""

    engine: str | None
    kernel: str | None
    ranks: int | str | None


def run(
    case: ReadCase,
    folder: str | Path | None = None,
    *,
    force: bool = False,
    resume: bool = False,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    **own: Unpack[EngineOptions],
) -> Run:
    """Run a case and analyse it; a result that the folder already holds is returned at once.

    Parameters
    ----------
    case : Case
    folder : str or Path, optional
        Run folder, made where it is missing; default ``runs/<stem of the case file>``, then changed values.
    force : bool
        Delete the run that the folder holds, and start anew.
    resume : bool
        Go on with the interrupted run in the folder; the result is of the whole run.
    progress : callable, optional
        Called with a `Progress` about twice a second.
    should_stop : callable, optional
        Called as often; True ends the run as an interruption does.
    engine : {'lammps', 'native', 'twin'}, optional
    kernel : {'auto', 'stock', 'compiled'}, optional
    ranks : int or 'auto', optional
        In place of the case's own.

    Raises
    ------
    CaseError, SetupError, ResumeError
        Before anything is written.
    RunError, RunInterrupted
        A run that failed or was ended; its folder is kept, and ``error.run`` is the run as far as it came.
    TypeError
        Something else than a case.
    """
    if not isinstance(case, ReadCase):
        raise TypeError(f"run() takes a case; write load_case({str(case)!r}).run()")
    if unknown := sorted(own.keys() - EngineOptions.__annotations__):
        raise TypeError(f"run() has no argument '{unknown[0]}'")
    paths = {f"engine.{'name' if name == 'engine' else name}": value for name, value in own.items()}
    if changes := {path: value for path, value in paths.items() if value is not None}:
        case = case.replace(changes)  # it makes its scene anew
    place = Path(folder or default_folder(case))
    try:
        runs.start.start(case, place, force=force, resume=resume, progress=progress, should_stop=should_stop)
    except RunError as error:
        error.run = Run(place)
        raise
    return Run(place)


class BoundRun(NearestNames):
    """Method ``case.run``: a call runs the case, and a name is that of its field, such as ``case.run.duration``."""

    in_words = "the group 'run' of a case"

    def __init__(self, case: Case):
        object.__setattr__(self, "_case", case)

    def __call__(self, folder: str | Path | None = None, **given: Any) -> Run:
        """Run the case; see `run`."""
        return run(self._case, folder, **given)

    def __getattr__(self, name: str) -> Any:
        group = vars(self)["_case"].fields.run
        return getattr(group, name) if name in type(group).model_fields else self._missing(name)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"run.{name}: the fields of a case do not change; {HOW_TO_CHANGE}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *type(self._case.fields.run).model_fields})

    def __repr__(self) -> str:
        return repr(self._case.fields.run)


class RunGroup:
    """The attribute ``run`` of a case; of the class, the function `run`."""

    @overload
    def __get__(self, case: None, owner: type) -> Callable[..., Run]: ...
    @overload
    def __get__(self, case: Case, owner: type) -> BoundRun: ...
    def __get__(self, case: Case | None, owner: type) -> Callable[..., Run] | BoundRun:
        return run if case is None else BoundRun(case)


@dataclass(frozen=True)
class Case(ReadCase):
    """A validated case that can be run; made by `load_case`.

    Attributes
    ----------
    name : str
    hash : str
        Twelve hex digits, equal for cases that give the same run.
    fields : CaseFields
        The values, every default filled in; frozen.
    """

    run = RunGroup()  # case.run(folder, …) and case.run.duration
    preview = write_preview

    def set(self, path: str | Mapping[str, object], value: object = None) -> Case:
        """The case with another value, ``case.set("run.duration", 2)``, or several, ``case.set({"slope": 3})``.

        Raises
        ------
        CaseError
            A path that is not there, or a value that is not allowed.
        """
        return self.replace(path if isinstance(path, Mapping) else {path: value})

    def start(
        self, folder: str | Path | None = None, *, moves: Sequence[str] = (), force: bool = False, resume: bool = False
    ) -> SteppedRun:
        """A run of the case on the native engine that Python steps: ``with case.start(folder) as run: run.advance(2)``.

        Parameters
        ----------
        folder : str or Path, optional
            As of `run`.
        moves : sequence of str
            Names of walls without a motion that may be moved: their motion is a table from the start.
        force, resume : bool
            As of `run`.

        Raises
        ------
        CaseError, SetupError, ResumeError
            As of `run`, when the block begins.
        """
        return runs.stepped.SteppedRun(
            self, Path(folder or default_folder(self)), moves=moves, force=force, resume=resume
        )

    def __or__(self, changes: Mapping[str, object]) -> Case:
        return self.replace(changes) if isinstance(changes, Mapping) else NotImplemented

    def _repr_html_(self) -> str:
        return case_html(self.name, self.scene())


def _no_field(name: str, value: object) -> CaseError:
    """The error for a keyword of `load_case` that is no field of a case, with the group that has it."""
    known = {group: getattr(field.annotation, "model_fields", {}) for group, field in CaseFields.model_fields.items()}
    groups = [group for group, fields in known.items() if name in fields]
    hint = f"write {groups[0]}={{'{name}': {value!r}}}" if groups else f"use one of {', '.join(known)}"
    return CaseError(f"load_case: a case has no field '{name}'; {hint}")


def load_case(source: str | Path | Mapping[str, object], changes: Changes | None = None, **more: object) -> Case:
    """Read, change and validate a case; as `Case.load`.

    Parameters
    ----------
    source : str, Path or mapping
        A YAML file, a run folder (its ``case.yaml``), or the fields themselves.
    changes : mapping or iterable of str, optional
        Values by path, ``{"contact.friction": 0.1, "walls.sill.y": [-10, 3]}``.
    **more
        Changes by group: ``load_case(file, run={"duration": 2}, slope=3)``.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, the value, what is allowed and what to do.
    """
    given: dict[str, object] = {}
    for name, value in more.items():
        if name not in CaseFields.model_fields:
            raise _no_field(name, value)
        parts = value.items() if isinstance(value, Mapping) else [("", value)]
        given |= {f"{name}.{part}".rstrip("."): one for part, one in parts}
    if changes is None or isinstance(changes, Mapping):
        return Case.load(source, {**(changes or {}), **given})
    return Case.load(source, changes).replace(given)


def open_run(folder: str | Path) -> Run:
    """The run in a folder: finished, interrupted, failed, or still going on.

    Raises
    ------
    CaseError
        The folder holds no run.
    """
    if (Path(folder) / "study.yaml").is_file():
        raise CaseError(f"{folder}: holds a study, not a run; lammps_jump.open({str(folder)!r}) opens it")
    require_case(Path(folder))
    return Run(folder)


class Run(NearestNames):
    """A run of a case, seen through its folder.

    Parameters
    ----------
    folder : str or Path
    changes : mapping, optional
        Values of the case's analysis in place of the stored ones; then every result is made in memory.

    Attributes
    ----------
    folder : Path
    """

    in_words = "a run"
    habits: ClassVar[dict[str, str]] = {
        "[]": 'run.frames[10] for a frame, run.summary["jump"] for numbers, run.profiles.mass_depth for profiles',
        "trajectory": "run.frames",
        "n_frames": "len(run.frames)",
        "time": "run.times",
        "start_time": "run.times[0]",
        "duration": "run.times[-1], s",
        "dt": "run.scene.time_step",
        "time_step": "run.scene.time_step",
        "universe": "run.frames, or `MDAnalysis.Universe(path of the dump)`",
        "profile": "run.profiles.mass_depth",
        "numbers": "run.summary",
        "head": "run.frames[0].to_dataframe().head()",
        "discs": "run.frames[-1], the discs of a frame",
        "particles": "run.frames[-1], the discs of a frame",
        "atoms": "run.frames[-1], the discs of a frame",
        "positions": 'run.frames[-1].to_numpy("x", "y")',
        "velocities": 'run.frames[-1].to_numpy("vx", "vy")',
        "data": "run.profiles, run.summary or run.to_xarray()",
        "savefig": 'run.plot().savefig("depth.png")',
        "animate": "`lammps-jump animate FOLDER` in a terminal",
        "to_csv": "`lammps-jump export FOLDER --csv` in a terminal, or run.profiles.to_dataframe()",
        "to_dataframe": "run.profiles.to_dataframe(), or run.frames[-1].to_dataframe()",
        "to_netcdf": 'run.profiles.to_netcdf("profiles.nc")',
        "info": "print(run), or run.summary",
        "describe": "print(run), or run.summary",
        "close": "no close: a run holds no file open",
        "params": "run.case",
        "config": "run.case",
        "load": "run.summary; nothing is to be loaded",
    }

    def __init__(self, folder: str | Path, changes: Mapping[str, object] | None = None):
        self.folder = Path(folder)
        self._changes = dict(changes or {})

    @cached_property
    def case(self) -> Case:
        """The case as run."""
        return Case.load(require_case(self.folder), self._changes)

    @property
    def scene(self) -> Scene:
        """The engine-neutral numbers of the case."""
        return self.case.scene()

    @cached_property
    def _stored(self) -> Mapping[str, Any]:
        return MappingProxyType(read_summary(self.folder))

    @cached_property
    def _found(self) -> ResultsInMemory:
        return runs.results.analyse_in_memory(self.case, self.folder)

    @property
    def _setting(self) -> Setting:
        engine = self.case.fields.engine
        kernel = NATIVE_KERNELS.get(engine.name, engine.kernel)
        return Setting(engine.name, self._stored.get("kernel") or kernel, self._stored.get("ranks", 1))

    @cached_property
    def status(self) -> Status:
        """Status of the run; read again by another `open_run`."""
        return "running" if holder(self.folder) else cast(Status, self.result.status)

    @cached_property
    def result(self) -> RunResult:
        """Work of the engine: steps, seconds (s), discs, energy ledger (J/m), versions."""
        return result_of(self.case, self.folder, self._stored, self._setting, write=False)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Notes on the case, the run and its analysis, in sentences."""
        return tuple(self.summary["warnings"])

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """The numbers of the run by the keys of ``summary.json``; of a run without one, those made in memory."""
        if self._stored and not self._changes:
            return self._stored
        seconds = {"build": 0.0, "run": self.result.seconds, "analysis": 0.0}
        parts = {**self._found.parts, "warnings": self._found.warnings}
        composed = compose(self.case, self._setting, self.result, seconds=seconds, parts=parts)
        kept = ("case_hash", "wall_seconds")
        return MappingProxyType(composed | {key: self._stored[key] for key in kept if key in self._stored})

    @cached_property
    def profiles(self) -> xr.Dataset:
        """Profiles over time (s) and x (m): mass_depth (m), velocity (m/s), discharge (m^2/s) …, means and errors."""
        path = self.folder / "profiles.nc"
        if self._changes or not path.exists() or self._stored.get("analysed", {}) is None:
            return self._found.gathered.profiles
        return results_in(self.folder, self._stored).dataset()

    @property
    def results(self) -> Mapping[str, Any]:
        """Results of the analyses, by their keys in ``summary.json``; each is an attribute too, as ``run.heap``."""
        return MappingProxyType(dict(self._found.results))

    def __getattr__(self, name: str) -> Any:
        if name in QUANTITIES:
            return self._found.results.get(name)
        return self._missing(name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *QUANTITIES})

    @property
    def jump(self) -> Jump:
        """The hydraulic jump; `verdict` and `reason` say whether there is one."""
        return cast("Jump", self._found.results["jump"])

    @property
    def front(self) -> Front:
        """The front of a collapsing column; `reason` says why there is none."""
        return cast("Front", self._found.results["front"])

    @property
    def energy(self) -> Energy:
        """Energy of the discs; over time in `history`."""
        return cast("Energy", self._found.results["energy"])

    @property
    def forces(self) -> Mapping[str, Force]:
        """Force on each probed structure, by its name; over time in `history`."""
        forces = cast("Forces | None", self._found.results.get("force"))
        return {} if forces is None else forces.structures

    @cached_property
    def frames(self) -> Frames:
        """The frames of the dump: ``run.frames[10]``, ``run.frames.at(1.5)``, or a loop over ``run.frames``.

        Their number and times are those of the first look; another `open_run` looks again.
        """
        scene = self.scene
        return Frames(self.folder, scene.time_step, scene.settle_steps)

    @property
    def times(self) -> np.ndarray:
        """Times of the frames, s, shape (n,)."""
        return self.frames.times

    @property
    def path(self) -> Path:
        """The folder, by the name that pathlib has for it."""
        return self.folder

    def to_xarray(self) -> xr.Dataset:
        """All frames over time and disc; `Frames.to_xarray`. Profiles are in `profiles`."""
        return self.frames.to_xarray()

    def analyse(self, *, window: tuple[float, float] | None = None, bin_width: float | None = None) -> Run:
        """The same run analysed otherwise, in memory.

        Parameters
        ----------
        window : (float, float), optional
            Times over which means are taken, s.
        bin_width : float, optional
            Width of the profile bins, m.

        Raises
        ------
        CaseError
            A value that is not allowed, once a result is requested.
        """
        given = {"analysis.window": window, "analysis.bin_width": bin_width}
        return Run(self.folder, self._changes | {path: value for path, value in given.items() if value is not None})

    def plot(self, name: str = "", **of_axes: Any) -> Figure:
        """The main figure of the report, or one whose name is `name` or begins so: ``run.plot("depth")``.

        Raises
        ------
        DumpError
            No figure, or none of that name; the message lists those that are.
        TypeError
            Axes, or anything else: a figure has its own.
        """
        if of_axes:
            said = f"run.plot has no {next(iter(of_axes))}: it makes a figure of its own, and returns it"
            raise TypeError(f"{said}; for axes of yours write run.profiles.mass_depth.plot(…)")
        return runs.results.draw(self._found, self.folder, runs.results.figure_named(self._found, name))

    def show(self) -> Any:
        """Show the run: in a notebook its player, else its page in the browser; the page is written where it lacks.

        Raises
        ------
        SetupError
            In a notebook: anywidget is not installed.
        """
        if report.is_running():
            return self.widget()
        page = self.folder / "report.html"
        show_page(page if page.is_file() else self.report())
        return None

    def figure(self, name: str = "depth_profile") -> Figure:
        """A figure of the report, by the name of its file; matplotlib, without pyplot.

        Raises
        ------
        DumpError
            A name that is not known; the message lists those that are.
        """
        return runs.results.draw(self._found, self.folder, name)

    def figures(self, ending: Literal["png", "pdf", "svg"] = "png", *, arrows: bool = True) -> list[Path]:
        """Draw every figure of the run into ``figures`` of its folder, as files with this ending; the paths.

        Without `arrows` the discs have no forces on the outlines of structures.

        Raises
        ------
        SetupError
            ``figures`` is a link, or holds a file of this name that is not of this program.
        """
        with locked(self.folder):
            return runs.results.draw_all(self._found, self.folder, ending, arrows=arrows)

    def report(self, path: str | Path | None = None, *, live: LivePage | None = None) -> Path:
        """Write the report page; into the run folder where no `path` is given. Figures are those of the folder.

        With `live` of `lammps_jump.live.live_part` its reader can go on with the flow, and change it.
        """
        if path is None:
            require_replaceable(self.folder, "report.html")
        with nullcontext() if path else locked(self.folder):
            player = runs.results.player_of(self.case, self.folder)
            return runs.results.write_report(self.folder, self.summary, self.case, player, path, live=live)

    def compare(self, other: Run, path: str | Path) -> Path:
        """Write a page of this run and another one, side by side, with one time.

        Raises
        ------
        SetupError
            A file exists at `path` already.
        DumpError
            A run that is not complete, results that are not those of its summary, or a page that cannot be written.
        """
        return _compare(
            [(run.folder, run.summary, runs.results.flow_of(run.case, run.folder)) for run in (self, other)], Path(path)
        )

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r}, {self.status})"

    def widget(self) -> Any:
        """The player as a widget of a notebook: ``time`` is the time that is shown, s, and ``seek(time)`` goes to one.

        Raises
        ------
        SetupError
            anywidget is not installed.
        DumpError
            The run has no frame that holds a disc.
        """
        player = runs.results.player_of(self.case, self.folder)
        if player is None:
            raise DumpError(f"{self.folder}: has no frame with discs in it, and nothing to play")
        return report.player_widget(player, self.case.name)

    def _repr_mimebundle_(self, **given: object) -> Any:
        """The player, where anywidget is installed and something can be played; else a notebook shows pictures."""
        if not report.widgets_are_there():
            return {}
        try:
            return self.widget()._repr_mimebundle_(**given)
        except DumpError:
            return {}

    def _repr_html_(self) -> str:
        """View of the run for notebooks: a line, at most five numbers, a picture."""
        lead = [f"<p><b>{html.escape(self.case.name)}</b>: {self.status}. {html.escape(self.result.message)}</p>"]
        analysis = self.case.fields.analysis
        if analysis.jump:
            lead.append(f"<p>{html.escape(self.jump.verdict)}: {html.escape(self.jump.reason)}</p>")
        parts = [self.results[name] for name in QUANTITIES if getattr(analysis, name, False) and name in self.results]
        return "\n".join([*lead, number_table(parts), _picture(self.figure())])


def compare_folders(first: Path, second: Path, path: Path) -> Path:
    """Write a page of two folders side by side, each of a run or of the results of a bare dump; as `Run.compare`."""
    sides: list[tuple[Path, Mapping[str, Any], Flow]] = []
    for folder in (first, second):
        if runs.results.is_of_a_dump(folder):
            sides.append((folder, runs.results.summary_of_dump(folder), runs.results.flow_of_dump(folder)))
        else:
            run = open_run(folder)
            sides.append((folder, run.summary, runs.results.flow_of(run.case, folder)))
    return _compare(sides, path)


def _compare(sides: Sequence[tuple[Path, Mapping[str, Any], Flow]], path: Path) -> Path:
    require_replaceable(path.parent, path.name)
    for folder, *_ in sides:
        open_results(folder).require_same(CURVES)
    names = _apart(*(folder for folder, *_ in sides))
    return runs.results.write_comparison([(name, *side) for name, side in zip(names, sides, strict=True)], path)


def _apart(first: Path, second: Path) -> tuple[str, str]:
    """Names of two folders; their paths where the names are the same."""
    first, second = first.absolute(), second.absolute()
    return (first.name, second.name) if first.name != second.name else (str(first), str(second))


def _picture(figure: Figure) -> str:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=90)
    return f"<img alt='figure of the run' src='data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}'>"
