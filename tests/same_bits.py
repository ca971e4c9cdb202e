# SPDX-License-Identifier: GPL-2.0-or-later
"""Hashes of all arrays of the native engine, every 100 steps, of all scenes and of every feature of the contact.

    python tests/same_bits.py store FILE       # before a change of the engine's loops
    python tests/same_bits.py compare FILE     # after it; exit status 1 where a bit of a trajectory differs
    python tests/same_bits.py compare FILE --only drum
    python tests/same_bits.py compare FILE --threads 3

A hash is that of ids, places, velocities, spins, forces, torques, springs, sums on walls and lids that move. The energy
ledger, the energies of the list of contacts and the sums between stations are compared with a tolerance instead: their
order of summing is the compiler's. pytest does not collect this file.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from pathlib import Path

import numpy as np

from lammps_jump.case import load_case
from lammps_jump.core.columns import PushedColumns, SumsOnWallColumns
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core

INPUTS = Path(__file__).resolve().parent.parent / "inputs"
STEPS, EVERY = 1500, 100
HASHED = (
    "ids", "x", "y", "vx", "vy", "fx", "fy", "ux", "uy", "omega", "torque", "uomega", "radius", "partner", "sigma",
    "spring", "roll",
)  # fmt: skip
SLOTS = "partner", "sigma", "spring", "roll"
PUSHED = [of.start + axis for of in (PushedColumns.PLACE, PushedColumns.SPEED, PushedColumns.FORCE) for axis in (0, 1)]
"""Columns of walls that discs push: places, velocities and forces along x and y."""
ROUND_OFF = 1e-9
"""Of the ledger, over its throughput: 1,500 steps of sums in another order differ by some 1e-12."""

TURNS = {"contact.friction": 0.3, "contact.rotation": True}
KINDS: dict[str, dict[str, object]] = {
    "frictionless": {"contact.friction": 0},
    "viscous": {"contact.friction": 0.3},
    "viscous_spin": TURNS,
    "sign": {"contact.friction": 0.3, "contact.friction_law": "sign"},
    "sign_spin": {**TURNS, "contact.friction_law": "sign"},
    "history": {"contact.friction": 0.3, "contact.friction_law": "history"},
    "history_spin": {**TURNS, "contact.friction_law": "history"},
    "rolling": {**TURNS, "contact.friction_law": "history", "contact.rolling": {"friction": 0.1}},
    "smooth": {"contact.friction": 0, "contact.touch": "smooth"},
    "smooth_spin": {**TURNS, "contact.touch": "smooth"},
    "smooth_sign": {**TURNS, "contact.friction_law": "sign", "contact.touch": "smooth"},
}
"""Contacts that the jump has, discs of several sizes with one integrator and equal ones with the other."""
EXTRAPOLATED = ("dam_break", "wave_paddle", "drum", "hydraulic_jump", "sluice_gate")
"""Scenes that run with the other integrator too."""
LID = """
name: lid
gravity: 9.81
discs: {diameter: 0.1, density: 1000}
contact: {restitution: 0.4, friction: 0.3, largest_overlap: 0.05, impact_speed: 4, rotation: true}
domain: {x: [-1, 4], y: [-1, 6]}
walls:
  - {name: box, kind: box, x: [0, 2], y: [0, 5]}
  - {name: lid, kind: block, x: [0.1, 1.9], y: [1.2, 1.4],
     motion: {kind: load, mass: 300, force: [0, -3000], from: 0.02}}
  - {name: arm, kind: block, x: [0.5, 0.7], y: [0.5, 0.6],
     motion: {kind: oscillate, amplitude: [0.05, 0.02], period: 0.3}}
initial:
  - {kind: column, x: [0, 2], y: [0, 0.45], gate: false}
  - {kind: column, x: [0, 2], y: [0.65, 1.15], gate: false}
inflow: {kind: pour, x: [2.2, 3.5], y: [1, 3], count: 30}
run: {duration: 3, time_step_fraction: 0.05, output_interval: 0.05, seed: 1}
probes: {forces: [box, lid]}
"""


def entries():
    """Name, source and changes of each entry."""
    for path in sorted(path for path in INPUTS.glob("*.yaml") if "kind: run" not in path.read_text()):
        yield path.stem, path, {"engine.name": "native"}
        if path.stem in EXTRAPOLATED:
            yield (
                f"{path.stem}.extrapolated",
                path,
                {"engine.name": "native", "run.integrator": "leapfrog_extrapolated"},
            )
    for kind, changes in KINDS.items():
        for discs, sizes in (("sizes", {}), ("equal", {"discs.sizes": None})):
            integrator = "velocity_verlet" if discs == "sizes" else "leapfrog_extrapolated"
            others = {"run.integrator": integrator, "engine.name": "native"}
            yield f"jump.{kind}.{discs}", INPUTS / "quick_jump.yaml", {**changes, **sizes, **others}
    for kind in ("viscous_spin", "history_spin", "sign_spin"):
        yield f"drum.{kind}", INPUTS / "drum.yaml", KINDS[kind]
        yield f"lid.{kind}", LID, KINDS[kind]
    stations = {"engine.name": "native", "probes.stations": {"x": [8, 16], "speed": -0.5, "window": [0.05, 3]}}
    for kind in ("viscous_spin", "frictionless", "sign_spin"):
        yield f"stations.{kind}", INPUTS / "quick_jump.yaml", {**stations, **KINDS[kind]}


def scene_of(source, changes):
    """The scene of an entry."""
    if isinstance(source, Path):
        return load_case(source, changes).scene()
    path = Path("/tmp") / f"same_bits_{hashlib.sha256(source.encode()).hexdigest()[:12]}.yaml"
    path.write_text(source)
    return load_case(path, changes).scene()


def by_partner(discs) -> np.ndarray:
    """Order of the slots of each disc by what they remember: which slot has it is no part of the state."""
    partner, sigma = discs.partner[: discs.n], discs.sigma[: discs.n]
    return np.lexsort((sigma, partner), axis=1)


def digest(simulation) -> str:
    """Hash of what the trajectory is made of; -0 counts as 0."""
    found = hashlib.sha256()
    d = simulation.discs
    for name in HASHED:
        array = getattr(d, name)
        if array is not None:
            rows = array[: d.n] + 0
            rows = np.take_along_axis(rows, by_partner(d), 1) if name in SLOTS else rows
            found.update(np.ascontiguousarray(rows).tobytes())
    walls = simulation.walls
    found.update((walls.sums[walls.gone == 0][:, SumsOnWallColumns.FORCE] + 0).tobytes())
    if walls.moves is not None:
        found.update((walls.moves.pushed[walls.gone == 0][:, PUSHED] + 0).tobytes())
    return found.hexdigest()[:16]


def numbers(simulation) -> dict[str, list[float]]:
    """What is compared with a tolerance: the ledger, and sums over the list of contacts."""
    asked = simulation.scene.contact_output or simulation.scene.rubs
    who, found = simulation.contacts() if asked else (np.empty(0), np.empty(0))
    contacts = [float(len(who)), *np.abs(found).sum(axis=0).tolist()] if len(who) else [0.0]
    sums = [float(value) for value in simulation.ledger.values()]
    return {"ledger": sums, "contacts": contacts, "stations": simulation.stations.sums.tolist()}


def record(source, changes, threads="1") -> dict[str, object]:
    """Hashes of an entry, and numbers at its end."""
    simulation = NativeSimulation(scene_of(source, changes), loops=Core(threads))
    hashes = [digest(simulation)]
    for _ in range(STEPS // EVERY):
        simulation.run(EVERY)
        hashes.append(digest(simulation))
    return {"hashes": hashes, **numbers(simulation)}


def differences(before: dict, now: dict) -> list[str]:
    """What differs, in words."""
    found = []
    pairs = zip(before["hashes"], now["hashes"], strict=True)
    first = next((i for i, (a, b) in enumerate(pairs) if a != b), None)
    if first is not None:
        found.append(f"trajectory from step {first * EVERY}")
    for name in ("ledger", "contacts", "stations"):
        a, b = np.array(before[name]), np.array(now[name])
        if a.size == 0 or (name == "contacts" and a.size == 1):
            continue
        scale = np.nanmax(np.abs(a), initial=1e-300)
        if a.shape != b.shape or not np.allclose(a, b, rtol=0, atol=ROUND_OFF * scale, equal_nan=True):
            worst = "shape" if a.shape != b.shape else f"{np.nanmax(np.abs(a - b)) / scale:.1e}"
            found.append(f"{name} {worst}")
    return found


def main() -> int:
    """Store or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("store", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--threads", default="1", help="a number, or auto:MOST")
    asked = parser.parse_args()
    kept = json.loads(asked.file.read_text()) if asked.file.exists() else {}
    wrong = 0
    for name, source, changes in entries():
        if asked.only not in name or (asked.what == "store" and name in kept):
            continue
        try:
            now = record(source, changes, asked.threads)
        except Exception as error:
            if asked.what == "store":
                print(f"{name}: left out, {error}"[:200], flush=True)
                continue
            now, found = None, [f"failed: {error!r}"]
        if asked.what == "store":
            kept[name] = now
            asked.file.write_text(json.dumps(kept))
        elif name in kept:
            if now is not None:
                found = differences(kept[name], now)
            wrong += bool(found)
            print(f"{name}: {'; '.join(found) or 'same'}", flush=True)
    print(f"{wrong} differ" if asked.what == "compare" else f"{len(kept)} stored")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
