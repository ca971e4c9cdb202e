# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks that others print, on the native engine. Units of the scenes of one or two discs: d, m and g."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians, sqrt, tan

import numpy as np
from scipy.linalg import expm

from lammps_jump import Run
from lammps_jump.physics.slip import Springs
from lammps_jump.scene import Plane, Scene, handmade_scene
from lammps_jump.studies.runs import run_frames

FLOOR = Plane("floor", "y", 0.0, "above")
SHARE = 2.0 / 7.0
"""Stiffness of the tangential spring over the normal one, as in MFiX's linear cases."""


def scene_of(places, velocities, walls: tuple[Plane, ...], seconds: float, **more) -> Scene:
    """Discs between walls, a frame at every step; `more` as of `handmade_scene`."""
    given = {"gravity": (0.0, -1.0), "largest_overlap": 0.1, "time_step_fraction": 0.01, "friction_law": "history",
             "springs": Springs(SHARE, 0.0), "rotation": True, "restitution": 1.0}  # fmt: skip
    scene = handmade_scene(
        places, velocities, walls, diameter=1.0, density=1.0, impact_speed=1.0, skin=0.3, overlap_limit=0.6,
        steps=1, output_steps=1, domain=((-1e3, 1e3), (-10.0, 10.0)), **{**given, **more},
    )  # fmt: skip
    return replace(scene, steps=round(seconds / scene.time_step), output_steps=1)


def linear(matrix: np.ndarray, state: np.ndarray, time: np.ndarray) -> np.ndarray:
    """States of a linear system at some times from 0 on, exactly; shape (times, state)."""
    return np.array([expm(matrix * t) @ state for t in time])


def falling(restitution: float) -> dict:
    """A disc that falls from 2.5 d and bounces (MFiX DEM01): largest error of its height over the initial one.

    The three stages of the closed form: free fall, a damped spring with weight until the overlap is 0, free flight.
    """
    start = 2.5
    scene = scene_of([(0.0, start)], [(0.0, 0.0)], (FLOOR,), 3.6, restitution=restitution)
    _, frames = run_frames(scene, "native")
    time, seen = np.array([f.time for f in frames]), np.array([f.y[0] for f in frames])
    c, way = scene.coefficients, start - 0.5
    touch, speed = sqrt(2 * way), sqrt(2 * way)
    matrix = np.array([[0, 1, 0], [-c.stiffness_wall, -c.damping_wall, -1.0], [0, 0, 0]])  # overlap, its rate, weight
    lasts = np.linspace(0, 1.2 * pi / sqrt(c.stiffness_wall), 4001)
    inside = linear(matrix, np.array([0.0, -speed, 1.0]), lasts)
    end = int(np.flatnonzero(inside[1:, 0] >= 0)[0]) + 1
    leave, up = touch + lasts[end], inside[end, 1]
    exact = np.where(
        time < touch,
        start - 0.5 * time**2,
        np.where(
            time < leave,
            0.5 + np.interp(time - touch, lasts, inside[:, 0]),
            0.5 + up * (time - leave) - 0.5 * (time - leave) ** 2,
        ),
    )
    chosen = time < leave + 2 * up  # before it falls on the floor again
    return {"error": float(np.abs(seen - exact)[chosen].max() / start), "time": time[chosen], "seen": seen[chosen],
            "exact": exact[chosen]}  # fmt: skip


def stacked(restitution: float) -> dict:
    """Two discs pressed between walls 1.8 d apart (MFiX DEM03): largest error of a height / overlap at a wall."""
    high, y1, y2 = 1.8, 0.45, 1.35
    lid = Plane("lid", "y", high, "below")
    scene = scene_of([(0.0, y1), (0.0, y2)], [(0.0, 0.0)] * 2, (FLOOR, lid), 4.0, restitution=restitution)
    _, frames = run_frames(scene, "native")
    c = scene.coefficients
    kw, k, cw, cp = c.stiffness_wall, c.stiffness, c.damping_wall, c.damping
    matrix = np.array([
        [0, 0, 1, 0, 0], [0, 0, 0, 1, 0],
        [-kw - k, k, -cw - cp, cp, 0.5 * kw - k - 1.0],
        [k, -kw - k, cp, -cw - cp, kw * (high - 0.5) + k - 1.0],
        [0, 0, 0, 0, 0],
    ])  # fmt: skip
    chosen = frames[:: max(1, len(frames) // 400)]
    exact = linear(matrix, np.array([y1, y2, 0, 0, 1.0]), np.array([f.time for f in chosen]))[:, :2]
    seen = np.array([[f.y[0], f.y[1]] for f in chosen])
    return {"error": float(np.abs(seen - exact).max() / 0.05)}


def oblique(restitution: float, friction: float, angles: list[float]) -> dict:
    """Impacts on a wall at angles from its normal in degrees: speed along it after / before, without weight."""
    tangents = [tan(radians(angle)) for angle in angles]
    scene = scene_of(
        [(3.0 * i, 0.5 + 1e-9) for i in range(len(angles))], [(0.5 * t, -0.5) for t in tangents], (FLOOR,), 0.45,
        gravity=(0.0, 0.0), restitution=restitution, friction=friction, time_step_fraction=0.005,
    )  # fmt: skip
    scene = replace(scene, output_steps=scene.steps)
    _, frames = run_frames(scene, "native")
    along, spin = frames[-1].vx, frames[-1].column("omegaz")
    unit = friction * 0.5
    return {
        "angles": list(angles), "ratio": along / (0.5 * np.array(tangents)), "slip": 0.5 * np.array(tangents) / unit,
        "rim": (along + 0.5 * spin) / unit,
    }  # fmt: skip


def heap(run: Run) -> dict:
    """Run-out of the bulk over the base, aspect, and number of discs."""
    found = run.summary["heap"]
    return {"run_out": found["run_out_over_base"], "aspect": found["aspect"],
            "discs": int(run.summary["discs"]["present"])}  # fmt: skip


def sunk_in(run: Run, drop: float) -> dict:
    """Depth of the lowest point of the large grain below the bed, and its whole fall, m; from `drop` m above it."""
    table = np.genfromtxt(run.folder / "bodies.csv", delimiter=",", names=True)
    name = next(name for name in table.dtype.names if name.split("_")[-1] == "y" or "_y_" in name or name == "y")
    fall = float(table[name][0] - table[name][-1])
    late = np.abs(table[name][-20:] - table[name][-1]).max()
    return {"depth": fall - drop, "fall": fall, "late": float(late)}


def bore(run: Run, still: float, behind: float) -> dict:
    """Speed of the front of a wave over a layer `still` m deep, m/s: where the depth is midway to `behind`."""
    d = run.scene.diameter
    edges = np.arange(0.0, 40.0, 4 * d)
    times, fronts = [], []
    for frame in run.frames():
        depth = np.histogram(frame.x, edges, weights=(2 * frame.radii) ** 2)[0] / (4 * d)
        deep = np.flatnonzero(depth > 0.5 * (still + behind))
        if 0.6 <= frame.time <= 2.0 and deep.size:
            k = int(deep[-1])
            share = (depth[k] - 0.5 * (still + behind)) / max(depth[k] - depth[k + 1], 1e-9)
            times.append(frame.time)
            fronts.append(edges[k] + 2 * d + 4 * d * min(share, 1.0))
    return {"speed": float(np.polyfit(times, fronts, 1)[0]), "time": times, "front": fronts}


def jump(run: Run) -> dict:
    """Length over y2, Froude number, and the part of the head that is lost, in the frame of the front."""
    found = run.summary["jump"]
    if found["verdict"] != "jump" or found.get("length_over_y2") is None:
        raise ValueError(f"no jump: {found['verdict']}, {found.get('reason')}")
    energy = next(part for part in (found, *found.values()) if isinstance(part, dict) and "head_upstream" in part)
    return {"froude": found["froude"], "length": found["length_over_y2"],
            "efficiency": energy["energy_loss"] / energy["head_upstream"]}  # fmt: skip
