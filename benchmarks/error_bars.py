# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether the error bars of one run hold: stated errors against the scatter between starts, and coverage.

Run as ``python benchmarks/error_bars.py CASE [--starts N] [--first N] [--set PATH=VALUE] [--out DIR]``. The starts are
members of a study, which is kept. Printed for each number of ``summary.json`` that has an error: mean and standard
deviation of the starts; root mean square of the stated errors over that deviation; chi2, the mean of (deviation from
the mean of starts / stated error)^2; its value for perfect errors, k/(k - 2) with k degrees of freedom; the share of
95 % intervals that hold the mean of the starts; what the report says of the number. The exit status is 1 where a number
covers less than 0.9 and the report does not say that one run cannot tell.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

import lammps_jump as lj
from lammps_jump.analysis.statistics import STUDENT, WAVES
from lammps_jump.units import sure_of

LEAST = 0.9
"""Share of 95 % intervals that must hold the truth."""

Numbers = dict[str, tuple[float, float, bool]]
"""By the path in ``summary.json``: value, standard error, and whether the report says that one run cannot tell it."""


def with_errors(found: Mapping, path: str = "") -> Iterator[tuple[str, tuple[float, float, bool]]]:
    """Every number of a summary that has an error; of a list the first and the last."""
    for key, value in found.items():
        error = found.get(f"{key}_error")
        if isinstance(value, Mapping):
            yield from with_errors(value, f"{path}{key}.")
        elif isinstance(value, list) and isinstance(error, list) and value:
            yield from ((f"{path}{key}.{k}", (value[k], error[k], sure_of(found, key).bound)) for k in (0, -1))
        elif isinstance(value, float) and error is not None:
            yield f"{path}{key}", (value, error, sure_of(found, key).bound)


def row(key: str, starts: list[Numbers]) -> tuple[list[str], bool]:
    """One line of the table, and whether the number holds or says that one run cannot tell it."""
    values, errors, said = np.array([start[key] for start in starts], float).T
    mean, deviation, n = values.mean(), values.std(ddof=1), len(values)
    off = np.abs(values - mean)
    chi2 = np.mean((off / errors) ** 2) * n / (n - 1)
    covered = np.mean(off < STUDENT * errors)
    ratio = np.sqrt(np.mean(errors**2)) / deviation
    note = "± at least …" if said[0] else ("±" if covered >= LEAST else "BELOW")
    return [f"`{key}`", f"{mean:.4g}", f"{deviation:.2g}", f"{ratio:.2f}", f"{chi2:.1f}", f"{WAVES / (WAVES - 2):.1f}",
            f"{covered:.2f}", note], note != "BELOW"  # fmt: skip


def table(name: str, verdicts: list[str], starts: list[Numbers]) -> bool:
    """Print the table of a scene; whether every number holds."""
    counts = {word: verdicts.count(word) for word in dict.fromkeys(verdicts)}
    measured = [start for start in starts if "jump.y2" in start]
    if not measured:
        print(f"{name}: no start has a jump with errors: {counts}")
        return True
    known = [key for key in measured[0] if all(key in start for start in measured)]
    print(f"{name}: {len(starts)} starts, verdicts {counts}\n")
    print("| number | mean | sd of starts | rms error/sd | chi2 | perfect | 95 % covers | report says |")
    print("|---|---:|---:|---:|---:|---:|---:|---|")
    rows = [row(key, measured) for key in known]
    for cells, _ in rows:
        print(f"| {' | '.join(cells)} |")
    return all(holds for _, holds in rows)


def main() -> None:
    """Run the starts and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", type=Path)
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument(
        "--first", type=int, default=1000, help="number of the first start: other numbers, fresh starts"
    )
    parser.add_argument("--set", action="append", default=[], dest="changes", metavar="PATH=VALUE")
    parser.add_argument("--out", type=Path, default=Path("runs/error_bars"))
    given = parser.parse_args()
    case, last = lj.load_case(given.case, given.changes), given.first + given.starts - 1
    found = lj.sweep(case, given.out, members=f"{given.first}-{last}", collect=["jump.y2"])
    starts = [dict(with_errors(run.summary)) for run in found.runs]
    sys.exit(not table(case.name, list(found.values["jump.verdict"]), starts))


if __name__ == "__main__":
    main()
