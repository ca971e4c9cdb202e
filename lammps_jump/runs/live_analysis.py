# SPDX-License-Identifier: GPL-2.0-or-later
"""The analysis of a run that still goes on: the frames are read while the engine writes them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Self

import lammps_jump.runs as runs
from lammps_jump.case.case import ReadCase
from lammps_jump.dump.check import FrameCheck
from lammps_jump.dump.tail import GrowingDump
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import JumpError
from lammps_jump.files import DUMP_NAMES
from lammps_jump.provenance import usable_cores

if TYPE_CHECKING:
    from lammps_jump.analysis.passes import Gathered
    from lammps_jump.analysis.report.frames import FramePacker


class Ahead:
    """A thread that imports the analysis, 0.9 s, and then reads the frames of a run as they are written.

    Frames are read ahead where the engine leaves a core free and its dump can be read while it grows.

    Parameters
    ----------
    case : ReadCase
    folder : Path
        Run folder without a dump of an earlier part.
    setting : Setting
    whole : bool
        The run is not the continuation of another one.
    """

    def __init__(self, case: ReadCase, folder: Path, setting: Setting, *, whole: bool):
        self.check = FrameCheck(case.scene())
        self._case, self._folder = case, folder
        self._gathered: Gathered | None = None
        self.packer: FramePacker
        self._ended = threading.Event()
        kind = setting.dump_format
        self._dump = GrowingDump(folder / DUMP_NAMES[kind], kind, self._ended)
        self._follows = whole and kind in ("text", "binary") and setting.ranks < usable_cores()
        self._thread = threading.Thread(target=self._work, name="analysis")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._dump.given_up = True
        self._ended.set()
        self._thread.join()

    def _work(self) -> None:
        try:
            self._follow()
        except Exception:  # where the program is at its end, what is still to be loaded cannot be
            if threading.main_thread().is_alive():
                raise

    def _follow(self) -> None:
        with suppress(JumpError, OSError):  # what is wrong with the files is said when they are read again
            runs.results.load(self._case)
            if self._follows:
                flow = runs.results.flow_of(self._case, self._folder)
                self.packer = runs.results.packer_for(self._case, flow)
                watch = (self.packer, self.check) if runs.results.has_player(self._case) else (self.check,)
                self._gathered = runs.results.collect(self._case, flow, self._folder, self._dump, *watch)

    def result(self, outputs: Mapping[str, Mapping[str, int | str]], waiting: Callable[[int], None]) -> Gathered | None:
        """Gathered frames of a run that has ended; None where the dump among its `outputs` is still to be read.

        `waiting` is called with the number of frames read so far.
        """
        found = outputs.get(self._dump.path.name)
        self._dump.given_up = found is None
        self._ended.set()
        while self._thread.is_alive():
            waiting(self.check.frames)
            self._thread.join(0.2)
        same = found is not None and found["sha256"] == self._dump.read.hexdigest()
        return self._gathered if same else None
