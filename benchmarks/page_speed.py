# SPDX-License-Identifier: GPL-2.0-or-later
"""Processor time of the core for browsers, in node as in a page, over that of the native engine on one core.

Run as ``python benchmarks/page_speed.py CASE [--quick] [--out DIR]``, after ``make wasm``. Both step the same flow,
with the same bits, and take turns, so that ratios hold on a busy machine. In the turns that do not count the core is
compiled.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from taking_turns import main

import lammps_jump.live
from lammps_jump import Case
from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.core.browser import browser_core
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import image_of
from lammps_jump.errors import RunError
from lammps_jump.live.page import fields
from lammps_jump.studies.runs import middle
from lammps_jump.sweeps import Results, Say, Store

SETUP, WARM, TURNS = 1500, 2, 7
"""Steps before the image is taken; turns that do not count, and those that do."""
WORK, QUICK_WORK = 2_000_000, 200_000
"""Disc-steps of a turn."""


@contextmanager
def in_node(simulation: NativeSimulation, target: int) -> Iterator[subprocess.Popen[str]]:
    """Node with a simulation as a page has it: it reads numbers of steps, and answers with a line of JSON."""
    here = Path(__file__).parent
    script = (Path(lammps_jump.live.__file__).parent / "core.js").read_text() + (here / "page_speed.js").read_text()
    with tempfile.TemporaryDirectory() as place:
        files = [Path(place) / name for name in ("step.js", "core.wasm", "image", "fields.json")]
        image = image_of(simulation, target, 4)
        texts = (script.encode(), browser_core().code, image, json.dumps(fields()).encode())
        for file, text in zip(files, texts, strict=True):
            file.write_bytes(text)
        with subprocess.Popen(["node", *files], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            yield process


def steps_in(process: subprocess.Popen[str], steps: int) -> dict[str, Any]:
    """What node tells of so many steps."""
    assert process.stdin is not None and process.stdout is not None  # both were asked for as pipes
    process.stdin.write(f"{steps}\n")
    process.stdin.flush()
    return json.loads(process.stdout.readline())


def time_page(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time both in turn. A row holds median nanoseconds a disc-step of both, and their ratio within a turn."""
    simulation = NativeSimulation(case.scene(), ledger=False)
    simulation.run(SETUP)
    discs = simulation.discs.n
    steps = max(10, (QUICK_WORK if quick else WORK) // discs)
    found = []
    with in_node(simulation, simulation.step + (WARM + TURNS) * steps) as process:
        for turn in range(WARM + TURNS):
            work, before = simulation.disc_steps, time.process_time()
            simulation.run(steps)
            native, page = time.process_time() - before, steps_in(process, steps)
            if page["wrong"] or page["step"] != simulation.step:
                raise RunError(
                    f"{case.name}: node stopped at step {page['step']} of {simulation.step}: {page['wrong']}"
                )
            if turn >= WARM:
                scale = 1e9 / (simulation.disc_steps - work)
                found.append((scale * native, scale * page["seconds"], page["seconds"] / native))
                say("  page {1:.1f} ns, native {0:.1f} ns, ratio {2:.2f}".format(*found[-1]))
    native, page, ratio = (middle(column) for column in zip(*found, strict=True))
    return {"rows": [{"discs": discs, "page": page, "native": native, "ratio": ratio}]}


def page_of_times(data: Results, folder: Path) -> list[str]:
    """Return the table."""
    columns: dict[str, Column] = {
        data["case"]: lambda row: f"{row['discs']:,} discs",
        "page (ns):": "{page:z.1f}",
        "native (ns):": "{native:z.1f}",
        "ratio:": "{ratio:z.2f}",
    }
    return [markdown(columns, data["rows"])]


if __name__ == "__main__":
    raise SystemExit(main(__doc__, "page", time_page, page_of_times))
