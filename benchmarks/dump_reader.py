# SPDX-License-Identifier: GPL-2.0-or-later
"""How fast dumps are read: rows a second of this reader, by format, against MDAnalysis where it is installed.

Run as ``python benchmarks/dump_reader.py [--discs N] [--frames N] [--repeats N]``. The files are made up
in a temporary folder. Formats are timed in turn, several times, in CPU seconds; medians are shown, for machines are
noisy.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np

from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter

COLUMNS = ("id", "x", "y", "vx", "vy")


def make_files(folder: Path, discs: int, frames: int, seed: int = 1) -> dict[str, Path]:
    """The same made-up trajectory in every format."""
    rng = np.random.default_rng(seed)
    files = {
        "text %.10g": (folder / "dump10.lammpstrj", "text", "%.10g"),
        "text %.17g": (folder / "dump17.lammpstrj", "text", "%.17g"),
        "gzip %.10g": (folder / "dump.lammpstrj.gz", "gz", "%.10g"),
        "binary": (folder / "dump.lammpsbin", "binary", "%g"),
    }
    writers = {name: DumpWriter(path, COLUMNS, fmt, precision) for name, (path, fmt, precision) in files.items()}
    ids = np.arange(1, discs + 1)
    for step in range(frames):
        x, y, vx, vy = rng.uniform(0, 60, discs), rng.uniform(0, 7, discs), *rng.normal(size=(2, discs))
        columns = dict(zip(COLUMNS, (ids, x, y, vx, vy), strict=True))
        for writer in writers.values():
            writer.write_frame(make_frame(100 * step, 0.1 * step, [[-1, 95], [-15, 40]], columns))
    for writer in writers.values():
        writer.close()
    return {name: path for name, (path, _, _) in files.items()}


def make_plain(path: Path, discs: int, frames: int, seed: int = 1) -> Path:
    """A text dump that MDAnalysis' own reader takes: with type and z, without ITEM: UNITS and TIME."""
    rng = np.random.default_rng(seed)
    one = np.ones(discs)
    with DumpWriter(path, ("id", "type", "x", "y", "z", "vx", "vy"), units=None) as writer:
        for step in range(frames):
            x, y, vx, vy = rng.uniform(0, 60, discs), rng.uniform(0, 7, discs), *rng.normal(size=(2, discs))
            columns = {"id": np.arange(1, discs + 1), "type": one, "x": x, "y": y, "z": 0 * one, "vx": vx, "vy": vy}
            writer.write_frame(make_frame(step, None, [[-1, 95], [-15, 40]], columns))
    return path


def rows_read(path: Path) -> int:
    """Read a whole dump with our reader; the number of rows."""
    return sum(frame.n for frame in open_dump(path))


def rows_read_mdanalysis(path: Path) -> int:
    """The same with MDAnalysis' own LAMMPSDUMP reader."""
    import warnings

    import MDAnalysis

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it guesses masses and the time step, and says so
        universe = MDAnalysis.Universe(str(path), format="LAMMPSDUMP", topology_format="LAMMPSDUMP")
        return sum(ts.n_atoms for ts in universe.trajectory)


def benchmark(discs: int = 6000, frames: int = 100, repeats: int = 5) -> dict[str, float]:
    """Rows a CPU second by format (medians).

    Parameters
    ----------
    discs, frames, repeats : int

    Returns
    -------
    dict of str to float
        Our reader by format, and ``MDAnalysis`` where it is installed (a text file of its liking, fewer frames).
    """
    with tempfile.TemporaryDirectory() as folder:
        files = make_files(Path(folder), discs, frames)
        few = make_plain(Path(folder) / "few.lammpstrj", discs, max(2, frames // 10))
        tasks = {name: (rows_read, path) for name, path in files.items()}
        try:
            import MDAnalysis  # noqa: F401

            tasks["MDAnalysis"] = (rows_read_mdanalysis, few)
        except ImportError:
            pass
        rows_read(few)  # the compiled loops are loaded
        rates: dict[str, list[float]] = {name: [] for name in tasks}
        for _ in range(repeats):
            for name, (read, path) in tasks.items():
                begin = time.process_time()
                rows = read(path)
                rates[name].append(rows / (time.process_time() - begin))
    return {name: median(values) for name, values in rates.items()}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--discs", type=int, default=6000)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    rates = benchmark(options.discs, options.frames, options.repeats)
    print(f"{options.frames} frames of {options.discs} discs, 5 columns; median of {options.repeats}, CPU seconds")
    for name, rate in rates.items():
        print(f"{name:12s} {rate / 1e6:8.2f} M rows/s")


if __name__ == "__main__":
    main()
