"""Files that a native run leaves: the dump in LAMMPS' own formats, and forces.csv."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import CaseError
from ..scene import Scene

DUMP_NAMES = {"text": "dump.lammpstrj", "gz": "dump.lammpstrj.gz", "binary": "dump.lammpsbin"}


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
    """

    def __init__(self, folder: Path, scene: Scene, dump_format: str = "text"):
        if dump_format not in DUMP_NAMES:
            raise CaseError(f"dump format {dump_format!r} is not known: use one of {', '.join(DUMP_NAMES)}")
        self.path = Path(folder) / DUMP_NAMES[dump_format]
        self.scene = scene
        self.binary = dump_format == "binary"
        self.columns = "id x y vx vy" + (" omegaz" if scene.rotation else "")
        opener = gzip.open if dump_format == "gz" else open
        level = {"compresslevel": 3} if dump_format == "gz" else {}
        self._file = opener(self.path, "wb", **level)
        self._first = True

    def write(self, frame: Frame) -> None:
        """Append one frame."""
        columns = [frame.ids, frame.x, frame.y, frame.vx, frame.vy]
        if self.scene.rotation:
            columns.append(frame.omegaz)
        table = np.column_stack(columns).astype(float)
        self._file.write(self._binary(frame, table) if self.binary else self._text(frame, table))
        self._file.flush()
        self._first = False

    def _text(self, frame: Frame, table: np.ndarray) -> bytes:
        (x_low, x_high), (y_low, y_high) = self.scene.domain
        head = "ITEM: UNITS\nsi\n" if self._first else ""
        head += f"ITEM: TIME\n{frame.time:.16g}\nITEM: TIMESTEP\n{frame.step}\nITEM: NUMBER OF ATOMS\n{len(table)}\n"
        head += f"ITEM: BOX BOUNDS ff ff pp\n{x_low:.16e} {x_high:.16e}\n{y_low:.16e} {y_high:.16e}\n"
        half = 0.5 * self.scene.diameter
        head += f"{-half:.16e} {half:.16e}\nITEM: ATOMS {self.columns}\n"
        row = "%d" + " %.10g" * (table.shape[1] - 1) + "\n"
        return (head + (row * len(table)) % tuple(table.ravel().tolist())).encode()

    def _binary(self, frame: Frame, table: np.ndarray) -> bytes:
        magic = b"DUMPCUSTOM"
        (x_low, x_high), (y_low, y_high) = self.scene.domain
        half = 0.5 * self.scene.diameter
        columns = self.columns.encode()
        units = b"si" if self._first else b""
        parts = [
            struct.pack("=q10sii", -len(magic), magic, 1, 2),  # marker, name, byte order, revision
            struct.pack("=qqi", frame.step, len(table), 0),  # step, discs, not triclinic
            struct.pack("=6i", 1, 1, 1, 1, 0, 0),  # boundaries: 1 fixed, 0 periodic
            struct.pack("=6d", x_low, x_high, y_low, y_high, -half, half),
            struct.pack("=i", table.shape[1]),
            struct.pack("=i", len(units)) + units,
            struct.pack("=bd", 1, frame.time),
            struct.pack("=i", len(columns)) + columns,
            struct.pack("=ii", 1, table.size),  # one writer, its numbers
            table.tobytes(),
        ]
        return b"".join(parts)

    def close(self) -> None:
        """Finish the file."""
        self._file.close()


def write_forces(folder: Path, scene: Scene, forces: list[tuple[int, str, float, float, float]]) -> None:
    """forces.csv: time (s, end of the window), structure, fx, fy (N per m of width), moment (N)."""
    lines = ["time,structure,fx,fy,moment\n"]
    lines += [f"{scene.time(s):.10g},{name},{fx:.10g},{fy:.10g},{m:.10g}\n" for s, name, fx, fy, m in forces]
    (Path(folder) / "forces.csv").write_text("".join(lines))
