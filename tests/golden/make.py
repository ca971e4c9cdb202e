# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the golden scripts and pages anew: ``python tests/golden/make.py``; read the difference before committing it.

``python tests/golden/make.py pages quick_jump`` makes the pages that are named, ``scripts`` the scripts alone.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
INPUTS = HERE.parents[1] / "inputs"
PAGES = HERE / "pages"
if __name__ == "__main__":
    sys.path.insert(0, str(HERE.parent))
    os.environ |= {"LAMMPS_JUMP_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import pytest  # noqa: E402
from made_up import blank_figures, on_the_spot  # noqa: E402
from same_results import changed, masked, page_text  # noqa: E402

import lammps_jump as lj  # noqa: E402
from lammps_jump.script import script_text  # noqa: E402

JET = "run.time_step_fraction=0.1; analysis.window"
SHORT = {
    "breach": "run.duration=1; initial.0.folder=runs/settled_bed",
    "caisson": "run.duration=3",
    "column_collapse": "run.duration=1.5; initial.0.settle=0.1",
    "dam_break": "run.duration=2",
    "dam_break_triangle": "run.duration=0.5; initial.0.settle=0.1",
    "crown_wall": "run.duration=2",
    "drum": "run.duration=0.4; analysis.window=[0.2, 0.4]",
    "energy_box_16": "run.duration=5",
    "energy_box_7": "run.duration=5",
    "flap_gate": "run.duration=3",
    "floating_box": "run.duration=2",
    "heap": "run.duration=1",
    "hopper": "run.duration=2.5",
    "hydraulic_jump": f"run.duration=6; {JET}=[4, 6]",
    "hydraulic_jump_frictionless": f"run.duration=8; {JET}=[6, 8]",
    "hydraulic_jump_graded": "run.duration=4; analysis.window=[2, 4]",
    "inclined_flow": "run.duration=2; analysis.window=[1, 2]",
    "quick_jump": "run.duration=4; analysis.window=[2, 4]",
    "rockfall": "run.duration=3",
    "settled_bed": "run.duration=1",
    "sieved_column": "run.duration=1",
    "shock": "run.duration=0.8; analysis.window=[0.4, 0.8]",
    "sluice_gate": "run.duration=3",
    "spillway": "run.duration=0.6; analysis.window=[0.3, 0.6]",
    "stable_jump": "run.duration=4; analysis.window=[2, 4]",
    "tailgate": "run.duration=3",
    "wave_paddle": "run.duration=0.5",
    "wave_structure": "run.duration=5; initial.0.settle=0.3",
    "weir_rating": "run.duration=1; analysis.window=[0.5, 1]",
}
"""What makes a run of each scene short, and lets its page still show what the scene is of.

Sines of sloping, turning and swinging walls differ in the last bit from one C library to another, and collisions
amplify that: such scenes are cut before it is seen.
"""
BEFORE = {"breach": "settled_bed"}
"""Scenes that begin where the run of another one ends."""
HASHES = r"^ *(Hash of the case|SHA-256 of) .*$|\b[0-9a-f]{64}\b|(?<=; key )[0-9a-f]{12}"
"""What changes with the code, and with the last bit of a number."""


def golden_texts() -> dict[str, str]:
    """File name -> script, for every scene and both kernels."""
    texts = {}
    scenes = (path for path in sorted(INPUTS.glob("*.yaml")) if path.stem not in BEFORE)  # those need a run
    for path in scenes:
        scene = lj.load_case(path).scene()
        for kernel in ("stock", "compiled"):
            texts[f"{path.stem}.{kernel}.lammps"] = script_text(scene, kernel=kernel)
    return texts


def golden_page(name: str, folder: Path) -> str:
    """What the page of a short run of a scene shows; it runs in this folder, on the engine that all machines have.

    Pictures are not drawn; clock, versions and hashes are taken out.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lammps_jump.analysis.pipeline.draw_figures", blank_figures)
        patch.setattr("lammps_jump.analysis.pipeline.aside", on_the_spot)
        for scene in filter(None, (BEFORE.get(name), name)):
            case = folder / f"{scene}.yaml"
            case.write_text((INPUTS / case.name).read_text())
            changes = ["engine.name=native", *changed(SHORT[scene])[1::2]]
            lj.load_case(case, changes).run(folder / "runs" / scene)
    page = (folder / "runs" / name / "report.html").read_text()
    text = re.sub(HASHES, "", masked(page_text(page), f"{name}/report.html"), flags=re.MULTILINE)
    lines = (" ".join(line.split()) for line in text.replace("\N{MINUS SIGN}", "-").splitlines())
    return "".join(f"{line}\n" for line in lines if line)


def main(what: str = "", *names: str) -> None:
    """Write what is asked for; everything without a word."""
    if what in ("", "scripts"):
        for name, text in golden_texts().items():
            (HERE / name).write_text(text)
    if what in ("", "pages"):
        PAGES.mkdir(exist_ok=True)
        for name in names or SHORT:
            with tempfile.TemporaryDirectory() as folder:
                (PAGES / f"{name}.txt").write_text(golden_page(name, Path(folder)))


if __name__ == "__main__":
    main(*sys.argv[1:])
