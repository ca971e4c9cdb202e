# SPDX-License-Identifier: GPL-2.0-or-later
"""A run that Python steps: it stops at any time, shows its discs and walls, moves a wall, and goes on.

What is changed becomes part of the case in the folder, as a table of motion or of the inflow. So that case, run from
its start, gives the same frames. A change is taken where it leaves what has happened as it was, and no other.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, replace
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from lammps_jump import engines
from lammps_jump.analysis import quantities
from lammps_jump.case.case import ReadCase
from lammps_jump.case.inflow import RowsInflow
from lammps_jump.case.text import nearest
from lammps_jump.dump.frame import Frame
from lammps_jump.engines import Job, Setting
from lammps_jump.engines.choice import choose_setting, with_header
from lammps_jump.engines.interrupts import counted_interrupts
from lammps_jump.engines.native import EnginePart, take_frame
from lammps_jump.errors import CaseError, NearestNames, RunError, RunInterrupted, SetupError
from lammps_jump.files import SUMMARY_FILE, write_text
from lammps_jump.folders import clear, require_unlocked, write_marker
from lammps_jump.identity import scene_key
from lammps_jump.scene.motion import MovingWall, Pose
from lammps_jump.scene.scene import InletRow, Scene
from lammps_jump.scene.tracks import BEGIN, TableMotion

from .conclude import AnalysisThread, Conclusion
from .folder import case_text, left_to_do, marker_of, resumable, run_folder, write_folder
from .start import files_at_risk
from .summary import read_summary

STANDS_THERE = {"kind": "table", "points": [[0.0, 0.0, 0.0, 0.0]]}
"""Motion of a wall that may be moved later."""
INFLOW = ("depth", "mean_speed", "discharge")


class SteppedRun(NearestNames):
    """A run of a case on the native engine, a part at a time; made by ``case.start``, used in a ``with`` block.

    After the block the folder holds what a run there leaves: at its end a whole run with its analysis, before it an
    interrupted one with a checkpoint, from which ``lammps-jump run FOLDER --resume`` goes on.

    Parameters
    ----------
    case : ReadCase
    folder : Path
    moves : sequence of str
        Names of walls without a motion that may be moved.
    force : bool
        Delete the run that the folder holds.
    resume : bool
        Go on with the interrupted run in the folder.

    Attributes
    ----------
    case : ReadCase
        With what was changed so far.
    folder : Path
    """

    in_words = "a run in steps"

    def __init__(
        self, case: ReadCase, folder: Path, *, moves: Sequence[str] = (), force: bool = False, resume: bool = False
    ):
        if isinstance(moves, str):
            moves = (moves,)
        self.case = case.replace({"engine.name": "native", **{f"walls.{name}.motion": STANDS_THERE for name in moves}})
        self.folder = folder
        self._force, self._resume = force, resume
        self._open: ExitStack | None = None
        self._part: EnginePart
        self._setting: Setting
        self._notes: tuple[str, ...] = ()
        self._failed = ""
        self._before: Mapping[str, float] = {}

    # --- the block ----------------------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        begin = time.perf_counter()
        if self._force and self._resume:
            raise CaseError("resume goes on with a run, force starts a new one: use one of the two")
        self.case, self._setting, self._notes = choose_setting(self.case)
        require_unlocked(self.folder)
        left_to_do(self.case, self.folder, self._setting, force=self._force, resume=self._resume)
        with ExitStack() as stack:
            stack.enter_context(run_folder(self.folder, marker_of(self.case, self._setting)))
            left = left_to_do(self.case, self.folder, self._setting, force=self._force, resume=self._resume)
            if left != "run":
                raise SetupError(
                    f"{self.folder}: holds this run, which is complete; lammps_jump.open reads it, force=True runs it "
                    "again, and another folder keeps both"
                )
            stack.enter_context(files_at_risk(self.folder))
            self._begin(begin)
            self._open = stack.pop_all()
        return self

    def _begin(self, begin: float) -> None:
        checkpoint = resumable(self.case, self.folder, self._setting) if self._resume else None
        if checkpoint is None:
            write_folder(self.case, self.folder, marker_of(self.case, self._setting))
            self._before = {"build": time.perf_counter() - begin}
        else:
            self._before = read_summary(self.folder).get("wall_seconds") or {}
        setting = with_header(self.case, self._setting)
        engines.write_inputs(Job(self.case.scene(), self.folder, setting, Path.cwd(), checkpoint))
        self._part = EnginePart(self.case.scene(), self.folder, setting, checkpoint)
        if checkpoint is None:
            self._part.output()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._open is not None
        with self._open:
            self._open = None
            self._part.close()
            at_end = self.step >= self.case.scene().steps
            status = "failed" if self._failed else "complete" if at_end else "interrupted"
            result = self._part.ended(status, self._failed)
            clear(self.folder, set(quantities.result_files()) - {SUMMARY_FILE})
            with AnalysisThread(self.case, self.folder, self._setting, whole=False) as ahead:
                end = Conclusion(
                    self.case, self.folder, self._setting, result, "", self._before, self._notes, ahead=ahead
                )
                try:
                    end.conclude()
                except RunInterrupted:
                    pass  # as it is meant: the folder says how to go on
                except RunError:
                    if error is None:
                        raise

    # --- stepping -----------------------------------------------------------------------------------------------

    def advance(self, duration: float | None = None, *, to: float | None = None, steps: int | None = None) -> float:
        """Go on for a time, to a time, or for a number of steps, and not beyond the end of the run.

        Parameters
        ----------
        duration : float, optional
            s; to the nearest step, and at least one.
        to : float, optional
            Simulated time, s.
        steps : int, optional

        Returns
        -------
        float
            The time reached, s.

        Raises
        ------
        CaseError
            None or several of the three, or a value that is not allowed.
        RunError
            A guard ended the run, or it is at its end.
        KeyboardInterrupt
            Ctrl-C; the step is done, and leaving the block keeps a checkpoint.
        """
        scene = self._scene()
        target = self._target(duration, to, steps)
        if self.step >= scene.steps:
            raise RunError(f"{self.folder}: is at its end, {self.time:z.4g} s; a longer run has a larger run.duration")
        try:
            with counted_interrupts() as pressed:
                while self.step < target:
                    self._part.to_next_output(target)
                    if pressed():
                        raise KeyboardInterrupt
        except RunError as error:
            self._failed = str(error)
            raise
        return self.time

    def _target(self, duration: float | None, to: float | None, steps: int | None) -> int:
        given = {"duration": duration, "to": to, "steps": steps}
        values = {name: value for name, value in given.items() if value is not None}
        if len(values) != 1:
            raise CaseError("advance needs one of duration (s), to (s) and steps, for example advance(2.0)")
        ((name, value),) = values.items()
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not isfinite(value):
            raise CaseError(f"advance: {name} is {value!r}; allowed is a number")
        scene = self._scene()
        if name == "steps" and int(value) != value:
            raise CaseError(f"advance: steps is {value!r}; allowed is a whole number above 0")
        more = value - self.time if name == "to" else value
        if more <= 0:
            least = f"a time behind {self.time:z.6g} s, where the run is" if name == "to" else "a number above 0"
            raise CaseError(f"advance: {name} is {value!r}; allowed is {least}")
        left = scene.steps - self.step
        whole = more if name == "steps" else min(left, more / scene.time_step)
        return self.step + min(left, max(1, round(whole)))

    def _scene(self) -> Scene:
        if self._open is None:
            raise RunError(f"{self.folder}: steps inside its block alone: `with case.start(folder) as run:`")
        if self._failed:
            raise RunError(f"{self.folder}: has failed and goes no further: {self._failed}")
        return self.case.scene()

    # --- what there is now --------------------------------------------------------------------------------------

    @property
    def step(self) -> int:
        """Steps done."""
        return self._part.simulation.step

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.case.scene().time(self.step)

    @property
    def discs(self) -> Frame:
        """The discs now: ``run.discs.x``, m; ``vx``, m/s; ``run.discs.to_dataframe()``."""
        return take_frame(self._part.simulation)

    @property
    def walls(self) -> Mapping[str, WallNow]:
        """The walls that are there now, by name; bodies too."""
        simulation = self._part.simulation
        poses = simulation.walls.poses()
        there = ((one, one.at(self.step, poses.get(one.wall.name))) for one in simulation.scene.walls)
        return _Walls({one.wall.name: WallNow(self, one, now) for one, now in there if now is not None})

    @property
    def energy(self) -> dict[str, float]:
        """Kinetic, gravitational and elastic energy now, J/m."""
        return asdict(self._part.simulation.energy())

    # --- changes ------------------------------------------------------------------------------------------------

    def set(self, path: str, value: object, *, over: float | None = None) -> None:
        """Change a wall or the inflow from now on.

        Parameters
        ----------
        path : str
            ``walls.NAME.x``, ``walls.NAME.y``: where the wall is to be, [low, high], m. ``walls.NAME.angle``: its turn
            from where the case has it, degrees. ``inflow.depth`` (m), ``inflow.mean_speed`` (m/s) and
            ``inflow.discharge`` (m^2/s), where the case gives ``inflow.table``. Any other path of the case, where the
            value leaves all that has happened as it was.
        value
        over : float, optional
            Time that the change takes, s; a wall needs one.

        Raises
        ------
        CaseError
            A path or value that is not allowed, or one that would change what has happened.
        """
        group, _, rest = path.partition(".")
        name, _, part = rest.rpartition(".")
        if group == "walls" and part in ("x", "y", "angle"):
            if name not in self.walls:
                raise CaseError(f"{path}: there is no wall '{name}' now; {nearest(name, list(self.walls))}")
            self.walls[name].put(part, value, over)
        elif group == "inflow" and rest in INFLOW:
            self._set_inflow(rest, value, over)
        else:
            self._take({path: value})

    def _set_inflow(self, name: str, value: object, over: float | None) -> None:
        inflow = self.case.fields.inflow
        if not isinstance(inflow, RowsInflow) or inflow.table is None:
            raise CaseError(
                f"inflow.{name}: changes in a run whose inflow is a table; start with inflow.table: [[0, depth, speed]]"
            )
        new = _number(f"inflow.{name}", value)
        now, dt, graph = self._just_now(), self.case.scene().time_step, inflow.hydrograph
        if now < inflow.table[-1][0]:
            raise CaseError(
                f"inflow.{name}: the table goes on until t = {inflow.table[-1][0]:z.6g} s; advance to then first"
            )
        depth, speed = float(graph.depths[-1]), float(graph.speeds[-1])
        if name == "depth":
            target = (new, speed)
        else:
            target = (depth, new if name == "mean_speed" else new / depth if depth else new)
        later = now + (dt if over is None else _positive("over", over))
        rows = [*inflow.table, (now, depth, speed), (later, *target)]
        self._take({"inflow.table": [list(row) for row in rows]})

    def _just_now(self) -> float:
        """A time after the next step, s: the speed of a wall at a step, centred, knows where it is at the next."""
        scene = self.case.scene()
        return (self.step - scene.settle_steps + 1.5) * scene.time_step

    def _take(self, changes: Mapping[str, object]) -> None:
        """Go on as another case, whose past is the same."""
        old = self._scene()
        case = self.case.replace(changes)
        new = case.scene()
        if wrong := _of_another_past(old, new, self.step):
            raise CaseError(
                f"{', '.join(changes)}: {wrong}. What can change are walls that move by a table (start with "
                "moves=[name]) and an inflow by a table, from now on"
            )
        self._part.go_on_as(new)
        self.case = case
        write_marker(self.folder, marker_of(case, self._setting))
        write_text(self.folder / "case.yaml", case_text(case))
        self._part.save()  # one of before is of another case: a process that is killed from here on could not go on

    def __repr__(self) -> str:
        if self._open is None:
            return f"SteppedRun({str(self.folder)!r})"
        return f"SteppedRun({str(self.folder)!r}, t = {self.time:z.4g} s, {self._part.simulation.discs.n} discs)"


class _Walls(dict[str, "WallNow"]):
    """Walls by name; one that is not there is answered with the nearest."""

    def __missing__(self, name: str) -> WallNow:
        raise KeyError(f"there is no wall '{name}' now; {nearest(name, list(self))}")


class WallNow(NearestNames):
    """A wall of a run in steps, where it is now.

    Attributes
    ----------
    name : str
    """

    in_words = "a wall of a run"

    def __init__(self, run: SteppedRun, one: MovingWall, now: Any):
        self.name = one.wall.name
        self._run, self._one, self._now = run, one, now

    @property
    def x(self) -> tuple[float, float]:
        """From and to, m; infinite where the wall has no end."""
        return self._now.extent[0]

    @property
    def y(self) -> tuple[float, float]:
        """From and to, m."""
        return self._now.extent[1]

    @property
    def pose(self) -> Pose:
        """Displacement (m, m) and turn (rad) from where the case has the wall."""
        return getattr(self._now, "pose", Pose())

    @property
    def angle(self) -> float:
        """Turn from where the case has the wall, degrees."""
        return float(np.degrees(self.pose.angle))

    def move(self, x: float = 0.0, y: float = 0.0, angle: float = 0.0, *, over: float) -> None:
        """Move the wall from now on, evenly: by x and y (m) and an angle (degrees), in a time `over` (s).

        Raises
        ------
        CaseError
            A wall that does not move by a table, that is still moving, or a number that is not allowed.
        """
        run, kind = self._run, self._one.motion.kind
        path = f"walls.{self.name}"
        by = [_number(f"{path}.{name}", value) for name, value in (("x", x), ("y", y), ("angle", angle))]
        lasts = _positive("over", over)
        if not isinstance(kind, TableMotion):
            raise CaseError(f"{path}: does not move by a table; start with case.start(folder, moves=['{self.name}'])")
        now = run._just_now()
        last = kind.points[-1]
        if now < last[0]:
            raise CaseError(f"{path}: moves until t = {last[0]:z.6g} s; advance to then, and move it again")
        there = [begin + more for begin, more in zip(last[1:], by, strict=True)]
        rows = [*kind.points, (now, *last[1:]), (now + lasts, *there)]
        run._take({f"{path}.motion.points": [list(row) for row in rows]})

    def put(self, part: str, value: object, over: float | None) -> None:
        """Move the wall until its x or y is [low, high] (m), or its turn an angle (degrees); as `move`."""
        path = f"walls.{self.name}.{part}"
        if over is None:
            raise CaseError(f"{path}: a wall takes time to move; give over=, s, for example over=0.5")
        if part == "angle":
            self.move(angle=_number(path, value) - self.angle, over=over)
            return
        low, high = getattr(self, part)
        wanted = list(value) if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) else []
        if len(wanted) != 2 or not isfinite(low + high):
            raise CaseError(
                f"{path}: {value!r}; allowed are two numbers, [low, high], of a wall that ends: move it by x, y"
            )
        first, second = (_number(path, one) for one in wanted)
        shift = first - low
        if abs(second - high - shift) > 1e-9 * max(1.0, abs(high), abs(low)):
            raise CaseError(
                f"{path}: [{first:zg}, {second:zg}] m is {second - first:z.6g} m long; allowed is its own "
                f"length, {high - low:z.6g} m"
            )
        self.move(**{part: shift}, over=over)

    def __repr__(self) -> str:
        return f"WallNow({self.name!r}, x = {self.x}, y = {self.y} m)"


def _number(path: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not isfinite(value):
        raise CaseError(f"{path}: {value!r}; allowed is a number")
    return float(value)


def _positive(path: str, value: object) -> float:
    seconds = _number(path, value)
    if seconds <= 0:
        raise CaseError(f"{path}: {seconds:zg} s; allowed is a time above 0")
    return seconds


def _of_another_past(old: Scene, new: Scene, step: int) -> str:
    """Differences of a scene from another one up to a step; empty where there is none."""
    if len(old.walls) != len(new.walls) or len(old.inlets) != len(new.inlets):
        return "it would change how many walls or rows of the inflow there are"
    for one, other in zip(old.walls, new.walls, strict=True):
        same = replace(other.motion, kind=one.motion.kind) == one.motion and repr(other.wall) == repr(one.wall)
        if not same or (one.motion.kind != other.motion.kind and not _same_way(one, other, old.time(step + 1))):
            return f"it would change where wall '{one.wall.name}' has been, or what it is"
    for row, another in zip(old.inlets, new.inlets, strict=True):
        if not _same_entries(row, another, step):
            return "it would change which discs have entered"
    rest = replace(new, walls=old.walls, inlets=old.inlets, hydrograph=old.hydrograph)
    if scene_key(replace(rest, outlets=old.outlets)) != scene_key(old):
        return "it belongs to the whole run"
    if rest.outlets != old.outlets:
        return "it is so fast that outlets would have to look more often from the start; take a slower change"
    return ""


def _same_way(one: MovingWall, other: MovingWall, time: float) -> bool:
    """Tells whether two motions by a table are the same up to a time, s, to the last bit."""
    if not isinstance(one.motion.kind, TableMotion) or not isinstance(other.motion.kind, TableMotion):
        return False
    first, second = (motion.track[motion.track[:, BEGIN] <= time] for motion in (one.motion, other.motion))
    return np.array_equal(first, second)


def _same_entries(one: InletRow, other: InletRow, step: int) -> bool:
    if (one.x, one.y, one.vy, one.clearance, one.limit) != (other.x, other.y, other.vy, other.clearance, other.limit):
        return False
    if not (one.turns and other.turns):
        return one == other
    done = one.turns_until(step), other.turns_until(step)
    count = len(done[0])
    return done[0] == done[1] and one.speeds[:count] == other.speeds[:count]
