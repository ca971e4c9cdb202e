# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the golden scripts anew: ``python tests/golden/make.py``; read the difference before committing it."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.case import load_case
from lammps_jump.script import script_text

HERE = Path(__file__).parent
INPUTS = HERE.parents[1] / "inputs"


def golden_texts() -> dict[str, str]:
    """File name -> script, for every scene and both kernels."""
    texts = {}
    scenes = (path for path in sorted(INPUTS.glob("*.yaml")) if "kind: run" not in path.read_text())  # those need a run
    for path in scenes:
        scene = load_case(path).scene()
        for kernel in ("stock", "compiled"):
            texts[f"{path.stem}.{kernel}.lammps"] = script_text(scene, kernel=kernel)
    return texts


if __name__ == "__main__":
    for name, text in golden_texts().items():
        (HERE / name).write_text(text)
