# SPDX-License-Identifier: GPL-2.0-or-later
"""Many runs as one: run what a study asks for and is not there yet, and look at what its folder holds."""

from __future__ import annotations

import html
import logging
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import lammps_jump.sweeps as sweeps
from lammps_jump.analysis.report.page import show_page
from lammps_jump.case.case import ReadCase
from lammps_jump.dump.exports import csv_text, write_netcdf
from lammps_jump.errors import CaseError, DumpError, NearestNames, RunInterrupted
from lammps_jump.files import SWEEP_FILES, write_json, write_text
from lammps_jump.folders import Marker, clear
from lammps_jump.provenance import usable_cores
from lammps_jump.quoting import typed
from lammps_jump.runs import known
from lammps_jump.runs.folder import run_folder
from lammps_jump.runs.run import Case

from .members import MemberState, require_no_links, run_members
from .pool import Pool
from .study import Study, read_study
from .study_folder import POINTS_FILE, StudyResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .members import Start

log = logging.getLogger(__name__)
LOADED_ASIDE = ("lammps_jump.sweeps.page", "scipy.special")
"""Modules that the page of a study needs."""


@dataclass(frozen=True)
class SweepProgress:
    """Progress of a study.

    Attributes
    ----------
    done, failed, total : int
        Runs.
    share : float
        Of all steps that were left to do.
    disc_steps : float
        Done so far, in this process.
    """

    done: int
    failed: int
    total: int
    share: float
    disc_steps: float


class Board:
    """Counts what the members at work have done.

    Parameters
    ----------
    found : Sweep
    retry : bool
        Those that failed are run again.
    show : callable
        Called with a `SweepProgress` at every change.
    """

    def __init__(self, sweep: Sweep, retry: bool, show: Callable[[SweepProgress], None]):
        count = Counter(state.stage for state in sweep.states.values())
        self.now = SweepProgress(count["done"], 0 if retry else count["failed"], len(sweep.states), 0.0, 0.0)
        self.left, self.show = len(sweep.left(retry)), show
        self._shares: dict[str, float] = {}
        self._steps: dict[str, float] = {}

    def heard(self, key: str, news: tuple[float, float, int]) -> None:
        """Take in the progress of a member: share and number of its steps, discs in play."""
        share, step, discs = news
        more = max(0.0, step - self._steps.get(key, step)) * discs
        self._steps[key] = step
        self._tell(key, share, disc_steps=self.now.disc_steps + more)

    def ended(self, key: str, state: MemberState) -> None:
        """Count a member."""
        good = state.stage == "done"
        self._tell(key, 1.0, done=self.now.done + good, failed=self.now.failed + (not good))

    def _tell(self, key: str, share: float, **changes: Any) -> None:
        self._shares[key] = share
        self.now = replace(self.now, share=sum(self._shares.values()) / max(self.left, 1), **changes)
        self.show(self.now)


class Sweep(NearestNames, StudyResults):
    """A study, seen through its folder, with its page and figures.

    Parameters
    ----------
    study : str, Path or Study
        The folder of a study; or a study that was read, with the folder of its runs.
    folder : Path, optional
    starts : sequence of Start, optional
        Default those that the folder lists, else those of the study.

    Raises
    ------
    CaseError
        The folder holds no study.
    """

    in_words = "a study"
    habits: ClassVar[dict[str, str]] = {
        "[]": "study.runs[0] for a run, study.table for its numbers",
        "to_dataframe": "study.table.to_dataframe()",
        "df": "study.table.to_dataframe()",
        "results": "study.table, or study.runs",
        "to_xarray": "study.table",
    }

    def __init__(self, study: str | Path | Study, folder: Path | None = None, starts: Sequence[Start] | None = None):
        if isinstance(study, str | Path):
            folder, study = Path(study), _stored_study(Path(study))
        if folder is None:
            raise TypeError("Sweep: a study that was read needs the folder of its runs")
        super().__init__(study, folder, starts)

    @property
    def path(self) -> Path:
        """The folder, by the name that pathlib has for it."""
        return self.folder

    def plot(self, name: str = "") -> Figure:
        """The first figure of the page, or the one whose name is `name` or holds it, such as ``plot("friction")``.

        Raises
        ------
        DumpError
            No figure, or none of that name; the message lists those that are.
        """
        there = {key: figure for key, _, figure in sweeps.page.figures_of(self)}
        fitting = [figure for key, figure in there.items() if name in key]
        if not fitting:
            known = ", ".join(there) or "none yet: no run is done"
            raise DumpError(f"figure '{name}': the study has none of that name; there are {known}")
        return fitting[0]

    def show(self) -> None:
        """Show the page of the study in the browser; it is written where it lacks."""
        page = self.folder / "sweep.html"
        show_page(page if page.is_file() else self.write())

    def write(self) -> Path:
        """Write table, figures and page into the folder; the path of the page."""
        clear(self.folder, [name for name in SWEEP_FILES if name.startswith("figures/")])
        frame = sweeps.table.flat(self.table, self.study)
        write_text(self.folder / "table.csv", csv_text(frame))
        write_netcdf(self.table, self.folder / "table.nc")
        write_json(self.folder / "summary.json", self.summary, indent=2)
        return sweeps.page.write_page(self)

    def figures(self, ending: Literal["png", "pdf", "svg"] = "png") -> list[Path]:
        """Draw every figure of the study into ``figures`` of its folder, as files with this ending; the paths."""
        with held_study(self.folder):
            return list(sweeps.page.draw(self, ending))

    def __repr__(self) -> str:
        return f"Sweep({str(self.folder)!r}, {self.status()})"

    def _repr_html_(self) -> str:
        table = sweeps.page.summary_frame(self).to_html(index=False)
        return f"<p><b>{html.escape(self.study.case.name)}</b>: {html.escape(self.status())}</p>{table}"


def held_study(folder: Path) -> AbstractContextManager[None]:
    """Hold the folder of a study, made where it is missing, as the only process that runs it; see `run_folder`."""
    return run_folder(folder, Marker("sweep", SWEEP_FILES, {}))


def default_folder(study: str | Path | Mapping[str, Any] | ReadCase, case: Case) -> Path:
    """Folder of a study when none is named: ``runs/<stem of its file>``, of a case ``runs/<stem>_sweep``."""
    if not isinstance(study, str | Path):
        return Path("runs") / f"{case.name}_sweep"
    if Path(study).is_dir():
        return Path(study)
    of_a_case = Path(case.source.file) == Path(study)
    return Path("runs") / (f"{Path(study).stem}_sweep" if of_a_case else Path(study).stem)


def open_sweep(folder: str | Path) -> Sweep:
    """The study in a folder, finished or not; nothing is written.

    Raises
    ------
    CaseError
        The folder holds no study.
    """
    return Sweep(folder)


def _stored_study(folder: Path) -> Study:
    if not (folder / "study.yaml").is_file():
        raise CaseError(
            f"{folder}: holds no study (no study.yaml); "
            f"`{typed('sweep', 'STUDY.yaml', '--out', Path(folder))}` makes one"
        )
    return read_study(folder)


def sweep(
    study: str | Path | Mapping[str, Any] | ReadCase,
    folder: str | Path | None = None,
    *,
    jobs: int | None = None,
    retry: bool = False,
    progress: Callable[[SweepProgress], None] = lambda progress: None,
    **given: Any,
) -> Sweep:
    """Run the points and members of a study that its folder does not hold yet, and write table, figures and page.

    Parameters
    ----------
    study : str, Path, mapping or Case
        A study file, the folder of a study, or its fields: ``case``, ``axes``, ``members``, ``collect`` …; or a case,
        whose study is what is `given`.
    folder : str or Path, optional
        Default ``runs/<stem of the file>``.
    jobs : int, optional
        Processes at once; default one for each core that this process may use.
    retry : bool
        Run again what failed.
    progress : callable, optional
        Called with a `SweepProgress`.
    given
        Fields in place of those of the study.

    Raises
    ------
    CaseError, SetupError
        Before anything is run: a field or a point that cannot be used, a folder in use.
    RunInterrupted
        Ctrl-C or SIGTERM; the same call goes on.
    """
    read = read_study(study, **given)
    place = Path(folder) if folder is not None else default_folder(study, read.case)
    sweep = Sweep(read, place)
    ranks = read.case.fields.engine.ranks
    most = jobs or max(1, usable_cores() // (ranks if isinstance(ranks, int) else 1))
    members = sweep.members  # what cannot be run is refused before the folder is made
    with held_study(place), Pool(min(most, len(members))) as pool:
        Thread(target=_load_page).start()
        sweep = _complete(sweep, pool, retry, progress)
        pool.close()
        sweep.write()
    _remember(sweep)
    return sweep


def _remember(sweep: Sweep) -> None:
    """Keep how much the starts of each point scatter: `check` foretells from it how many a number takes."""
    study = sweep.study
    cells = {item.path: sweeps.table.records(sweep.table, item.path) for item in study.collect}
    for number, point in enumerate(study.points):
        here = {path: ones[number] for path, ones in cells.items()}
        numbers = {path: (one["mean"], one["sd"], int(one["n"])) for path, one in here.items()}
        known.remember_scatter(study.case.replace(point), numbers)


def _load_page() -> None:
    """Load what writes the page, 0.5 s, while the runs go on.

    What cannot be loaded is loaded again where it is needed, with its error. It cannot be where the study is refused
    and the program ends meanwhile.
    """
    with suppress(Exception):
        for module in LOADED_ASIDE:
            import_module(module)


def _complete(sweep: Sweep, pool: Pool, retry: bool, progress: Callable[[SweepProgress], None]) -> Sweep:
    """Run the members of a study, and more of them where ``until`` asks for narrower intervals."""
    while True:
        prepare(sweep)
        board, again = Board(sweep, retry, progress), ("failed",) if retry else ()
        states, folder = sweep.states, sweep.folder
        try:
            run_members(sweep.members, states, folder, pool, again=again, ended=board.ended, news=board.heard)
        except RunInterrupted as error:
            raise RunInterrupted(f"{sweep.folder}: {error}. {Sweep(sweep.study, sweep.folder).status()}") from None
        wider = sweep.wider()
        if wider is None:
            return sweep
        more = len(wider.starts) - len(sweep.starts)
        log.info(f"{more} more runs: {', '.join(sweep.study.fields.until)} is not known well enough yet")
        sweep = wider


def prepare(sweep: Sweep) -> None:
    """Write ``study.yaml`` and ``points.json`` into the folder of a study: all that its members need to be run.

    Raises
    ------
    SetupError
        The folder of a member is a link.
    """
    require_no_links(sweep.members, sweep.folder)
    write_text(sweep.folder / "study.yaml", sweep.study.to_yaml())
    listed = [{"point": member.point, "seed": member.seed, "key": member.key} for member in sweep.members]
    write_json(sweep.folder / POINTS_FILE, {"points": sweep.study.points, "members": listed})
