# SPDX-License-Identifier: GPL-2.0-or-later
"""What the scenes of the thesis T-4359 do on the native engine."""

from __future__ import annotations

import numpy as np

from lammps_jump import Run, load_case
from lammps_jump.studies.bench import collision_scene, measure_collisions
from lammps_jump.studies.points import TREE


def box(run: Run) -> dict:
    """Largest deviation of the energy from its start, in shares of it."""
    return {"deviation": run.summary["energy"]["max_deviation"]}


def collision(restitution: float, fraction: float) -> dict:
    """Restitution of two discs at a share of the largest stable step, mean over where in a step they meet."""
    scene = collision_scene(fraction, restitution)
    return {"restitution": float(np.mean(measure_collisions(scene, "native")["restitution"]))}


def inflow(speed: float) -> dict:
    """Froude number of a jet of 1 m depth, and discharge of the rows over that of the depth."""
    scene = load_case(TREE.parent / "inputs" / "hydraulic_jump.yaml", {"inflow.mean_speed": speed}).scene()
    gravity = -scene.gravity[1]
    return {
        "froude": speed / float(np.sqrt(gravity)),
        "carried": sum(scene.discharges) / speed,
        "rows": len(scene.inlets),
    }


def dam(run: Run) -> dict:
    """Discs, overlap at the foot of a column over (n - 1) m g/k, place of the front, processor time (s)."""
    scene, first = run.scene, run.frames[0]
    column = np.sort(first.y[first.x < scene.radius * 1.5])  # the one at the wall
    overlaps = scene.diameter - np.diff(column)
    above = np.arange(len(overlaps), 0, -1)
    hydrostatic = above * scene.mass * -scene.gravity[1] / scene.coefficients.stiffness
    front = run.summary["front"]
    return {
        "discs": first.n,
        "overlap": float(overlaps[0] / hydrostatic[0]),
        "front": front["position_99"],
        "speed": front["speed"],
        "seconds": run.result.cpu_seconds,
    }


def wave(run: Run) -> dict:
    """Speed of the wave that a structure throws back (m/s), and its largest force over the hydrostatic one."""
    force = run.summary["force"]
    found = run.results["force"]
    reflected = found.reflected
    time, position = np.asarray(reflected.time), np.asarray(reflected.position)
    seen = np.isfinite(position)
    return {
        "speed": float(np.polyfit(time[seen], position[seen], 1)[0]),
        "way": float(position[seen][0] - position[seen][-1]),
        "peak": force["structure"]["peak"] / force["structure"]["hydrostatic"],
    }


def jump(run: Run) -> dict:
    """Verdict, depth behind over Bélanger's less 1, length over that of (4.27), speed of the front (m/s)."""
    found = run.summary["jump"]
    length, theory = found.get("length"), found.get("length_theory")
    return {
        "verdict": found["verdict"],
        "reason": found.get("reason"),
        "froude": found.get("froude"),
        "deviation": found.get("belanger_deviation"),
        "length": length / theory if length and theory else None,
        "speed": found.get("speed"),
        "seconds": run.result.cpu_seconds,
        "discs": run.result.present,
    }
