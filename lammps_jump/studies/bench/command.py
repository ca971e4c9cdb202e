"""The ``bench`` command: which of the benchmarks is meant, and what is printed."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from lammps_jump.errors import CaseError

COLLISION = "collision"


def run_bench(
    case: Path,
    *,
    out: Path | None = None,
    quick: bool = False,
    axes: str | None = None,
    members: int | None = None,
    cells: bool = False,
    skips: bool = False,
    speed: bool = False,
    table: bool = False,
    diameters: str | None = None,
    fractions: str | None = None,
    kernels: str | None = None,
    assignments: Sequence[str] = (),
    fresh: bool = False,
    say: Callable[[str], None] = print,
) -> str:
    """Run a benchmark and return its table as markdown; see `study.bench_case`.

    Raises
    ------
    CaseError
        No such case, axis or number; ``--table`` without a stored benchmark.
    """
    if str(case) == COLLISION:
        from .collision import bench_collisions, collision_table

        folder = out or Path("runs") / "bench" / COLLISION
        return collision_table(bench_collisions(folder, quick=quick)["rows"])
    if cells:
        from .cells import bench_cells

        return bench_cells(case, out=out, quick=quick, assignments=assignments, fresh=fresh, say=say)
    if skips:
        from .skips import bench_skips

        return bench_skips(case, out=out, quick=quick, assignments=assignments, fresh=fresh, say=say)
    if speed:
        from .speed import bench_speed

        return bench_speed(case, out=out, quick=quick, assignments=assignments, fresh=fresh, say=say)
    from .table import markdown

    names = tuple(word.strip() for word in kernels.split(",")) if kernels else None
    if names and not set(names) <= {"stock", "compiled", "native"}:
        raise CaseError(f"--kernels {kernels!r}: allowed are stock, compiled and native, with commas between")

    if table:
        return markdown(stored(case, out))
    from .study import bench_case

    sizes = _numbers("--diameters", diameters) if diameters else ()
    steps = _numbers("--fractions", fractions) if fractions else None
    return markdown(
        bench_case(
            case, out=out, axes=axes, quick=quick, members=members, assignments=assignments, diameters=sizes,
            fractions=steps, kernels=names,
            fresh=fresh, say=say,
        )
    )  # fmt: skip


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise CaseError(f"{option} {text!r}: expected numbers with commas between, such as 0.1,0.2") from None
    if not all(0 < value < float("inf") for value in values):
        raise CaseError(f"{option} {text!r}: every value must be above 0")
    return values


def stored(case: Path, out: Path | None) -> dict:
    """A finished benchmark of a case.

    Raises
    ------
    CaseError
        Where there is none.
    """
    from lammps_jump.case import load_case

    path = (out or Path("runs") / "bench" / load_case(case).case.name) / "bench.json"
    try:
        data = json.loads(path.read_text())
    except (OSError, ValueError):
        raise CaseError(f"{path}: no benchmark is stored there; run `lammps-jump bench {case}` first") from None
    if "rows" not in data:
        raise CaseError(f"{path}: the benchmark is not finished; run `lammps-jump bench {case}` to go on with it")
    return data
