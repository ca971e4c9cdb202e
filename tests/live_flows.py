# SPDX-License-Identifier: GPL-2.0-or-later
"""A flow of a live page in node, and the native run of the case that it offers."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.core import browser
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import image_of
from lammps_jump.errors import SetupError
from lammps_jump.files import plain
from lammps_jump.live import page, prepare
from lammps_jump.live.prepare import WORD

HERE = Path(__file__).resolve().parent / "live"
NODE = shutil.which("node")
COLUMNS = ("x", "y", "vx", "vy", "fx", "fy", "omega")


def lacking_core() -> str:
    """Why there is no core for browsers; empty where there is one."""
    try:
        browser.browser_core()
    except SetupError as error:
        return str(error)
    return ""


def lacking() -> str:
    """Why a live flow cannot be stepped by node; empty where it can."""
    return lacking_core() or ("" if NODE else "node is not here")


def state_of(simulation: NativeSimulation) -> bytes:
    """What `LiveCore.state` gives, of the native engine."""
    d = simulation.discs
    columns = [one[: d.n] for one in (getattr(d, name) for name in COLUMNS) if one is not None]
    return b"".join(one.tobytes() for one in (np.array([simulation.step, d.n]), d.ids[: d.n], *columns))


def stepped(
    case: ReadCase, folder: Path, steps: int, moves: list[tuple[int, str, float]], begin: dict[str, float] | None = None
) -> tuple[bytes, str, dict[str, Any]]:
    """State of a flow after so many steps with sliders moved on the way, the case that it offers, and the rest."""
    flow = prepare(case)
    start = flow.simulation.scene.settle_steps
    scripts = [str(page.HERE / name) for name in ("core.js", "moves.js", "download.js")]
    head = page.head_of(flow, browser.browser_core())
    (folder / "head").write_text(json.dumps(plain(head)))
    (folder / "image").write_bytes(image_of(flow.simulation, flow.target, WORD, flow.discs))
    job = {
        "scripts": scripts, "core": str(browser.CODE), "image": str(folder / "image"), "head": str(folder / "head"),
        "moves": [[start + step, name, value] for step, name, value in moves], "until": start + steps, "begin": begin,
        "out": str(folder / "out"),
    }  # fmt: skip
    (folder / "job").write_text(json.dumps(job))
    subprocess.run([NODE, "--no-warnings", str(HERE / "host.mjs"), str(folder / "job")], check=True)
    told = json.loads((folder / "out.json").read_text())
    return (folder / "out").read_bytes(), (folder / "out.yaml").read_text(), told


def native(text: str, steps: int) -> bytes:
    """State of the native run of a case of a page, so many steps behind t = 0."""
    scene = ReadCase.parse(text).scene()
    simulation = NativeSimulation(scene, ledger=False)
    simulation.run(scene.settle_steps + steps)
    return state_of(simulation)
