# SPDX-License-Identifier: GPL-2.0-or-later
"""A run folder that is looked at, whoever writes it: its frames, curves and state so far. Nothing is written there."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lammps_jump import runs
from lammps_jump.analysis.budgets import energy
from lammps_jump.analysis.devices import waves
from lammps_jump.analysis.draw.chart import Chart
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.forces import figures as forces
from lammps_jump.analysis.passes import Collector, Gathered, Watcher, feed
from lammps_jump.analysis.profiles import Binner, add_means
from lammps_jump.analysis.report.frames import FramePacker
from lammps_jump.analysis.report.player import about_run
from lammps_jump.case.case import ReadCase
from lammps_jump.dump import DumpTail, Frame, FrameCheck, make_frame
from lammps_jump.dump.find import ForceHistory, forces_of, read_forces
from lammps_jump.engines.checkpoint import has_checkpoint
from lammps_jump.engines.lammps.outputs import forces_text
from lammps_jump.errors import DumpError, JumpError
from lammps_jump.files import DUMP_NAMES, plain
from lammps_jump.folders import holder
from lammps_jump.foreign import reason
from lammps_jump.quoting import shortened
from lammps_jump.runs.folder import has_output, require_case
from lammps_jump.runs.summary import read_summary
from lammps_jump.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

PLACES = (0.25, 0.5, 0.75)
"""Of the channel, where the depth is followed if the case has no gauges."""
TITLES = {
    "gauges": "Depth",
    "forces": "Force on the structures",
    "energy": "Energy of the discs, that of contacts left out",
}


class GatheredSoFar(NamedTuple):
    """Profiles and energies of the frames that have come, which later ones do not change."""

    profiles: xr.Dataset
    energy: energy.EnergyHistory


class SoFar:
    """Collects what the curves of a run are made of.

    Attributes
    ----------
    collectors : list of Collector
        To be shown every frame.
    """

    def __init__(self, case: ReadCase, flow: Flow, folder: Path):
        scene, (low, high) = flow.scene, flow.x_range
        places = scene.gauges or tuple(float(np.round(low + part * (high - low), 3)) for part in PLACES)
        self.flow = replace(flow, scene=replace(scene, gauges=places))
        self.folder, self.engine = folder, case.fields.engine.name
        self.binner = Binner(flow)
        # elastic energy needs the contacts of every frame: the report has it
        self.energy = energy.EnergyLedger(flow, elastic=False)
        self.collectors: list[Collector] = [self.binner, self.energy]

    def gathered(self) -> GatheredSoFar | None:
        """Data of the curves, of the frames that have come; None where there are none."""
        if not self.binner.frames:
            return None
        return GatheredSoFar(self.binner.result(), self.energy.result())

    def curves(self, so_far: GatheredSoFar, *, live: bool) -> list[dict[str, Any]]:
        """Title, key and described curve (or the reason why it is absent) of each."""
        profiles, history, absent = add_means(so_far.profiles), so_far.energy, ""
        records: dict[str, ForceHistory] = {}
        try:
            records = self._forces()
        except (DumpError, OSError) as error:
            absent = str(error)
        if not records and self.flow.scene.probes:
            late = self.engine != "lammps" and live
            absent = absent or f"the {self.engine} engine writes forces at its end" if late else "no force yet"
        gathered = Gathered(self.flow, profiles, None, {"energy": history}, records)
        shown: dict[str, Any] = {}
        if wave_rows := waves.analyse(gathered):
            shown |= waves.figures(wave_rows, gathered)
        if records and (pushed := forces.analyse(gathered)):
            shown["forces"] = forces.history_chart(pushed)
            absent = "" if shown["forces"] else "nothing has touched them so far"
        shown["energy"] = energy.energy_chart(energy.analyse_energy(history, self.flow))
        charts = [
            {"key": name, "title": TITLES[name], "chart": plain(shown[name].plain)}
            for name in TITLES
            if isinstance(shown.get(name), Chart)
        ]
        return charts + ([{"key": "forces", "title": TITLES["forces"], "absent": absent}] if absent else [])

    def _forces(self) -> dict[str, ForceHistory]:
        """Rows of forces so far: LAMMPS writes a file a structure, of which one is made at the end."""
        table = self.folder / "forces.csv"
        if table.is_file():
            return read_forces(table)
        if not self.flow.scene.probes:
            return {}
        return forces_of(forces_text(self.flow.scene, self.folder), table)


AT_ONCE = 16_000_000
"""Bytes of a dump that are read before a page is answered again."""
LONGEST = 0.4
"""Seconds after which a page is answered, though more frames are there."""
MOST_SENT = 6_000_000
"""Bytes of frames in an answer, about."""
SHADES = 64
"""Radii that are distinguished."""


class WatchedState(NamedTuple):
    """State of a run that is watched.

    Attributes
    ----------
    status : str
        none, running, complete, interrupted, failed or unchecked. The page has damaged too: frames cannot be shown.
    message : str
        Of the summary; of a running one, which process writes.
    cut_off : bool
        It was ended by force: its last frame may be a part of one.
    steps : int, optional
        At which it ended, of its summary.
    steady : str
        Why it was stopped before its end, as steady, drowned or at rest.
    """

    status: str
    message: str = ""
    cut_off: bool = False
    steps: int | None = None
    steady: str = ""

    @property
    def goes_on(self) -> bool:
        """Tells whether the last frame may not be whole yet."""
        return self.cut_off or self.status in ("none", "running")


class Times(NamedTuple):
    """Time of the last frame that was read, time at which the run ended, and that which the case asks for, s.

    The first two are None where they are not known.
    """

    read: float | None
    ended: float | None
    asked: float


def reached(state: WatchedState, times: Times, *, whole: bool) -> str:
    """Text on how far a run has come, after the words of its status; empty where nothing is known.

    Parameters
    ----------
    state : WatchedState
    times : Times
    whole : bool
        All frames that are there have been read.
    """
    read, ended, duration = times
    of = f"of {duration:zg} s"
    if state.status not in ("complete", "unchecked", "interrupted", "failed"):
        return "" if read is None else f"{read:z.2f} {of}"
    last = read if ended is None else ended
    after = ""
    if not whole and read is not None and last is not None and read < last:
        after = f"; frames read up to {read:z.2f} of {last:z.2f} s"
    if state.steady or state.status in ("interrupted", "failed"):
        at = "" if last is None else f" at {last:z.2f} s"
        why = " ".join(shortened(state.steady or state.message).split()).rstrip(".")
        return f"ended{at}, before its {duration:zg} s{f': {why}' if why else ''}{after}"
    return "" if last is None else f"{last:z.2f} s{after}"


class _Schedule(FrameCheck):
    """Refuses a frame that is not of the schedule of a scene, before another collector sees it."""

    def __init__(self, scene: Scene, path: Path):
        super().__init__(scene)
        self.path = path

    def add(self, frame: Frame, time: float) -> None:
        """Take in the next frame; DumpError where its step, time, ids or places are none of the run."""
        super().add(frame, time)
        if self.first_trouble:
            raise DumpError(f"{self.path}: {self.first_trouble}")


class WatchedRun:
    """One run folder; it need not be there yet."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._lock, self._drawing = Lock(), Lock()
        self._begun = 0
        self._forget()

    def _forget(self) -> None:
        """Begin anew: the folder holds another run, or one that went on from an earlier time."""
        self._begun += 1
        self._case: ReadCase | None = None
        self._packer: FramePacker
        self._tail: DumpTail
        self._flow: Flow
        self._so_far: SoFar
        self._check: _Schedule
        self._frames, self._trouble, self._is_expected = 0, "", False

    def expect(self, case: ReadCase) -> None:
        """Show the discs of a case as it begins, until its run has written a frame; nothing where they cannot be had.

        The command that makes the run takes a second or two to load what it needs.
        """
        with self._lock, suppress(JumpError):
            self._forget()
            scene = case.scene()
            if not len(scene.positions) or scene.settle_steps or scene.earlier is not None:
                return
            self._case = case
            self._prepare(case)
            (x, y), (vx, vy) = scene.positions.T, scene.velocities.T
            columns = {"id": np.arange(1, len(x) + 1), "x": x, "y": y, "vx": vx, "vy": vy}
            self._packer.add(make_frame(0, 0.0, scene.domain, columns), 0.0)
            self._is_expected = True

    @property
    def state(self) -> WatchedState:
        """State of the run, by lock and summary."""
        if writer := holder(self.folder):
            return WatchedState("running", writer)
        stored: Mapping[str, Any] = {}
        with suppress(JumpError):
            stored = read_summary(self.folder)
        if status := stored.get("status"):
            steps = stored.get("steps")
            return WatchedState(
                str(status),
                str(stored.get("message") or ""),
                steps=steps if isinstance(steps, int) else None,
                steady=str(stored.get("stopped_when_steady") or ""),
            )
        if has_checkpoint(self.folder):
            return WatchedState("interrupted", "it was cut off and can go on from its checkpoint", cut_off=True)
        if has_output(self.folder):
            said = "it was cut off and left no checkpoint: to go on is to start from the beginning"
            return WatchedState("interrupted", said, cut_off=True)
        return WatchedState("none")

    def _open(self) -> bool:
        """Read the case of the folder once it is there."""
        if self._case is None and (self.folder / "case.yaml").is_file():
            case = ReadCase.load(require_case(self.folder))
            self._prepare(case)
            self._case = case
        return self._case is not None

    def _prepare(self, case: ReadCase) -> None:
        """Begin to read the frames of a case."""
        self._flow = runs.results.flow_of(case, self.folder)
        kind = case.fields.run.dump_format
        self._packer = FramePacker(self._flow, maps=False)
        self._tail = DumpTail(self.folder / DUMP_NAMES[kind], kind)
        self._so_far = SoFar(case, self._flow, self.folder)
        self._check = _Schedule(case.scene(), self._tail.path)

    def update(self) -> dict[str, Any]:
        """Read what is new, for a while at most; what a page is to know.

        A frame that cannot be read, or is not of the schedule, is the last one that is looked at: ``trouble`` tells it
        from then on, and a run that came to its end is ``damaged``.

        Raises
        ------
        JumpError
            A case that cannot be read.
        """
        with self._lock:
            state = self.state
            content: dict[str, Any] = {**state._asdict(), "frames": 0, "of": self._key, "trouble": ""}
            if self._is_expected and self._tail.path.exists():
                self._forget()
            if not self._open() or self._case is None:
                return content
            if self._tail.was_cut:
                self._forget()
                self._open()
            self._take_in(state)
            times, case = self._packer.times, self._case.fields
            content |= {"of": self._key, "frames": len(times), "more": not (self._tail.at_end or self._trouble)}
            content |= {"name": case.name, "description": case.description, "duration": case.run.duration}
            content |= {"seen": self._frames, "time": times[-1] if times else None, "trouble": self._trouble}
            if self._trouble and state.status in ("complete", "unchecked"):
                content |= {"status": "damaged", "message": self._trouble}
            ended = None if state.steps is None else self._flow.scene.time(state.steps)
            content["reached"] = reached(state, Times(content["time"], ended, case.run.duration), whole=self._is_read)
            if any(len(rows) for _, rows in self._packer.kept):
                content["about"] = {**about_run(self._packer, self.folder), **self._scale}
            return content

    def curves(self) -> list[dict[str, Any]]:
        """Curves of what has been read, as `SoFar.curves`; frames are answered while they are made."""
        with self._drawing:
            with self._lock:
                gathered = self._so_far.gathered() if self._case is not None else None
                so_far, live = self._so_far if gathered else None, self.state.goes_on
            return so_far.curves(gathered, live=live) if gathered and so_far else []

    def _take_in(self, state: WatchedState) -> None:
        """Read frames that are new, for a while, and show them to the packer and to what makes curves."""
        started = perf_counter()
        collectors: list[Watcher] = [self._check, self._packer, *self._so_far.collectors]
        try:
            while not self._trouble:
                for _ in feed(self._tail.new_frames(ended=not state.goes_on, most=AT_ONCE), self._flow, collectors):
                    self._frames += 1
                if self._tail.at_end or perf_counter() - started > LONGEST:
                    break
            if self._tail.at_end and not self._trouble and state.status == "complete":
                self._trouble = self._missing()
        except (JumpError, OSError) as error:
            self._trouble = str(error)
        except Exception as error:  # the server reports it once; the frames after it are not looked at either
            self._trouble = f"{self._tail.path}: a frame cannot be shown ({reason(error)})"
            raise

    def _missing(self) -> str:
        """Lack of a complete run against its schedule, in words; empty for nothing."""
        with suppress(JumpError):
            stored = read_summary(self.folder)
            troubles = self._check.result(stored["steps"], stored["discs"]["present"] + stored["discs"].get("fixed", 0))
            return f"{self._tail.path}: {'; '.join(troubles)}" if troubles else ""
        return ""

    @property
    def _is_read(self) -> bool:
        """Tells whether all frames that are there have been looked at."""
        return self._tail.at_end and not self._trouble

    @property
    def _key(self) -> str:
        """Another one where frames that a page has are no longer those that are kept."""
        return f"{self._begun}-{self._packer.thinned}" if self._case is not None else f"{self._begun}"

    @property
    def _scale(self) -> dict[str, Any]:
        """Units of the rows of `frames`."""
        scene = self._flow.scene
        return {"q": self._packer.q, "qv": 1.0, "radii": self._radii, "share": self._packer.share, "map": None,
                "of": self._key, "end": scene.time(scene.steps)}  # fmt: skip

    @property
    def _radii(self) -> np.ndarray:
        scene = self._flow.scene
        many = SHADES if scene.largest > scene.smallest else 1
        return 0.5 * np.linspace(scene.smallest, scene.largest, many)

    def frames(self, first: int, key: str) -> bytes:
        """Kept frames from a number on, for `live.js`; none where they are not those that the page knows.

        Little-endian, for each frame: float64 time (s), int32 count and 0, then count numbers each of int32 id, x and y
        (in q), float32 u and v (m/s), and int32 shade, an index into the radii.
        """
        with self._lock:
            if self._case is None or key != self._key or first < 0:
                return b""
            parts: list[bytes] = []
            size = 0
            for time, rows in self._packer.kept[first:]:
                parts.append(struct.pack("<dii", time, len(rows), 0))
                share = (rows["radius"] - self._radii[0]) / max(self._radii[-1] - self._radii[0], 1e-300)
                shade = np.clip(np.rint(share * (len(self._radii) - 1)), 0, SHADES)
                columns = [*(rows[name].astype("<i4") for name in ("id", "x", "y")),
                           *(rows[name].astype("<f4") for name in "uv"), shade.astype("<i4")]  # fmt: skip
                parts += [column.tobytes() for column in columns]
                size += 16 + 24 * len(rows)
                if size > MOST_SENT:
                    break
            return b"".join(parts)


def watched(folder: Path) -> WatchedRun:
    """A run folder that is there.

    Raises
    ------
    CaseError
        It holds no run.
    """
    require_case(folder)
    return WatchedRun(folder)
