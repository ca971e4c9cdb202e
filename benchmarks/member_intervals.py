# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether intervals over members hold: sets drawn from many starts of one case, each held against the other starts.

Run as ``python benchmarks/member_intervals.py FOLDER [--size N]``, with the folder of a study of one point and three
times as many members as a set has, or more: ``build-and-run CASE --members 64 --out FOLDER``. Printed for each
number that was collected: mean, standard deviation, and the share of sets whose 95 % interval holds. A set and the rest
are both samples, so the difference of their means is held against t·sd·√(1/n + 1/m), sd that of the set. The exit
status is 1 where a number covers less than 0.9. The last column is the share of pilots of four starts whose 90 % range
of the scatter, from which `check --of` foretells starts, holds that of the other starts: by F, as both are samples.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy import stats

from lammps_jump.runs.known import SURE
from lammps_jump.sweeps import open_sweep

DRAWS = 4000
LEAST = 0.9
"""Share of 95 % intervals that must hold."""


def coverage(values: np.ndarray, size: int, generator: np.random.Generator) -> float:
    """Share of the drawn sets whose interval holds the mean of the other starts."""
    rest = len(values) - size
    drawn = generator.permuted(np.tile(values, (DRAWS, 1)), axis=1)
    chosen, others = drawn[:, :size], drawn[:, size:]
    half = stats.t.ppf(0.975, size - 1) * chosen.std(axis=1, ddof=1) * np.sqrt(1 / size + 1 / rest)
    return float((np.abs(chosen.mean(axis=1) - others.mean(axis=1)) <= half).mean())


def foretold(values: np.ndarray, generator: np.random.Generator, size: int = 4) -> float:
    """Share of pilots of this size whose range of the scatter over the mean, of `SURE`, holds that of the others.

    The range is that of many starts; the others are as few as they are, so the quantiles are those of F.
    """
    drawn = generator.permuted(np.tile(values, (DRAWS, 1)), axis=1)
    chosen, others = drawn[:, :size], drawn[:, size:]
    shares = [part.var(axis=1, ddof=1) / part.mean(axis=1) ** 2 for part in (chosen, others)]
    tail = 0.5 - 0.5 * SURE
    low, high = (stats.f.ppf(share, size - 1, others.shape[1] - 1) for share in (tail, 1 - tail))
    ratio = shares[0] / shares[1]
    return float(((low <= ratio) & (ratio <= high)).mean())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, default=8, help="members of a set")
    given = parser.parse_args()
    found = open_sweep(given.folder)
    print("| number | starts | mean | sd | 95 % interval over members holds | range of a pilot's scatter holds |")
    print("|---|---:|---:|---:|---:|---:|")
    holds = True
    for item in found.study.collect:
        values = found.values[item.path].to_numpy(float)
        values = values[np.isfinite(values)]
        if len(values) < 3 * given.size or not values.std() > 0:
            continue
        share = coverage(values, given.size, np.random.default_rng(1))
        holds &= share >= LEAST
        print(f"| {item.heading} | {len(values)} | {values.mean():.4g} | {values.std(ddof=1):.2g} | {share:.2f} "
              f"| {foretold(values, np.random.default_rng(1)):.2f} |")  # fmt: skip
    sys.exit(not holds)


if __name__ == "__main__":
    main()
