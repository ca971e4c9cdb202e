"""Files that a native run leaves: the dump in LAMMPS' own formats, and forces.csv."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from lammps_jump.dump import write as dump_write
from lammps_jump.errors import CaseError
from lammps_jump.files import DUMP_NAMES, FORCES_HEADER
from lammps_jump.scene.scene import Scene


class Frame(NamedTuple):
    """Discs at one step, sorted by id; arrays of shape (n,), omegaz None where discs do not spin."""

    step: int
    time: float
    ids: np.ndarray
    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omegaz: np.ndarray | None


class DumpWriter:
    """Writes frames as LAMMPS' ``dump custom`` does: id x y vx vy, and omegaz where discs spin.

    Parameters
    ----------
    folder : Path
    scene : Scene
    dump_format : {'text', 'gz', 'binary'}
        dump.lammpstrj (10 digits), dump.lammpstrj.gz, or dump.lammpsbin (LAMMPS' binary format, revision 2).
    append : bool
        Write behind the frames that are there.
    """

    def __init__(self, folder: Path, scene: Scene, dump_format: str = "text", *, append: bool = False):
        if dump_format not in DUMP_NAMES:
            raise CaseError(f"dump format {dump_format!r} is not known: use one of {', '.join(DUMP_NAMES)}")
        self.columns = ("x", "y", "vx", "vy", *(("omegaz",) if scene.rotation else ()))
        self.box = (*scene.domain, (-scene.radius, scene.radius))
        path = Path(folder) / DUMP_NAMES[dump_format]
        self._file = dump_write.DumpWriter(path, ("id", *self.columns), dump_format, append=append)

    def write(self, frame: Frame) -> None:
        """Append one frame."""
        columns = {"id": frame.ids, **{name: getattr(frame, name) for name in self.columns}}
        self._file.write(frame.step, frame.time, self.box, columns)
        self._file.flush()

    def close(self) -> None:
        """Finish the file."""
        self._file.close()


def write_forces(folder: Path, scene: Scene, forces: list[tuple[int, str, float, float, float]]) -> None:
    """forces.csv: time (s, end of the window), structure, fx, fy (N per m of width), moment (N)."""
    lines = [FORCES_HEADER + "\n"]
    lines += [f"{scene.time(s):.10g},{name},{fx:.10g},{fy:.10g},{m:.10g}\n" for s, name, fx, fy, m in forces]
    (Path(folder) / "forces.csv").write_text("".join(lines))
