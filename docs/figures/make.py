# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws the picture that README.md opens with: ``make figures``, or ``python docs/figures/make.py``."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import lammps_jump as lj
from lammps_jump.analysis.draw.film import snapshots
from lammps_jump.runs.results import flow_of

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
SCENE = "stable_jump"


def main() -> None:
    """Run the scene and draw its first, middle and last frame."""
    case = lj.load_case(ROOT / "inputs" / f"{SCENE}.yaml")
    with TemporaryDirectory() as folder:
        frames = list(case.replace({"analysis.figures": "none"}).run(Path(folder) / SCENE).frames())
    three = [frames[0], frames[len(frames) // 2], frames[-1]]
    snapshots(three, flow_of(case)).savefig(HERE / f"{SCENE}.png")


if __name__ == "__main__":
    main()
