# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether the error bars of one run hold: stated errors against the scatter between starts, and coverage.

Run as ``python benchmarks/error_bars.py CASE [--starts N] [--first N] [--set PATH=VALUE] [--out DIR]``. The starts are
members of a study, which is kept. Printed for each number: mean and standard deviation of the starts; root mean square
of the stated errors over that deviation; chi2, the mean of (deviation from the mean of starts / stated error)^2; its value for perfect
errors, k/(k - 2) with k degrees of freedom; the share of 95 % intervals that hold the mean of the starts.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

import lammps_jump as lj
from lammps_jump.analysis.jump.certainty import MISSED
from lammps_jump.analysis.statistics import STUDENT, WAVES

KEYS = (
    "y1", "y2", "h1", "h2", "u1", "u2", "froude", "froude_downstream", "sequent_ratio", "belanger_ratio",
    "belanger_deviation", "density_ratio", "density_relation_ratio", "full_relation_ratio", "speed", "toe_speed",
    "end_speed", "length", "length_mass", "head_upstream", "head_downstream", "energy_loss", "momentum_residual",
)  # fmt: skip
CANNOT_TELL = (*MISSED, "h2", "u2", "length")
"""Numbers whose error one run cannot tell: intervals cover less than 90 %, or they go with y2 (docs/analysis.md)."""


def row(key: str, table: pd.DataFrame) -> list[str]:
    """One line of the table."""
    values, errors = (table[f"jump.{name}"].to_numpy() for name in (key, f"{key}_error"))
    mean, deviation, n = values.mean(), values.std(ddof=1), len(values)
    off = np.abs(values - mean)
    chi2 = np.mean((off / errors) ** 2) * n / (n - 1)
    covered = np.mean(off < STUDENT * errors)
    ratio = np.sqrt(np.mean(errors**2)) / deviation
    note = "one run cannot tell" if key in CANNOT_TELL else ("" if covered >= 0.9 else "below 0.9")
    return [key, f"{mean:.4g}", f"{deviation:.2g}", f"{ratio:.2f}", f"{chi2:.1f}", f"{WAVES / (WAVES - 2):.1f}",
            f"{covered:.2f}", note]  # fmt: skip


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
    collect = [f"jump.{key}" for key in KEYS]
    found = lj.sweep(case, given.out, members=f"{given.first}-{last}", collect=collect)
    measured = found.values.dropna(subset="jump.y2_error")
    words = found.values["jump.verdict"].value_counts().to_dict()
    print(f"{case.name}: {given.starts} starts, verdicts {words}\n")
    print("| number | mean | sd of starts | rms error/sd | chi2/dof | perfect | 95 % covers | |")
    print("|---|---:|---:|---:|---:|---:|---:|---|")
    for key in KEYS:
        print(f"| {' | '.join(row(key, measured))} |")


if __name__ == "__main__":
    main()
