# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of one or two discs on one engine. Units of the scenes at a floor: d, m and g are 1."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin, sqrt

import numpy as np

from lammps_jump.physics.slip import Rolling, Springs
from lammps_jump.scene import Plane, Scene, handmade_scene
from lammps_jump.studies.bench import collision_scene, expected, measure_collisions
from lammps_jump.studies.runs import run_frames

FLOOR = Plane("floor", "y", 0.0, "above")
APART = 3.0
"""Diameters between discs that must not touch each other."""
SLOW = 0.003
"""Speed at which a contact turns by less than a thousandth of a diameter."""
RATIO = 2.0 / 7.0
"""Stiffness of a tangential spring over that of the normal one."""


def on_a_floor(heights, velocities, *, seconds: float, **more) -> Scene:
    """Discs side by side over a floor, one for each velocity; `more` as of `handmade_scene`."""
    places = [(APART * i, y) for i, y in enumerate(heights)]
    return between(places, velocities, (FLOOR,), seconds=seconds, **more)


def between(places, velocities, walls: tuple[Plane, ...], *, seconds: float, **more) -> Scene:
    """Discs between walls; `more` as of `handmade_scene`."""
    given = {"friction_law": "history", "springs": Springs(RATIO, 0.5), "rotation": True, "restitution": 0.5}
    scene = handmade_scene(
        places, velocities, walls, diameter=1.0, density=1.0, impact_speed=1.0, skin=0.3, overlap_limit=0.5,
        steps=1, output_steps=1, domain=((-1e3, 1e3), (-10.0, 10.0)),
        **{"gravity": (0.0, -1.0), "largest_overlap": 0.01, "time_step_fraction": 0.02, **given, **more},
    )  # fmt: skip
    return with_steps(scene, seconds)


def with_steps(scene: Scene, seconds: float, frames: int = 1) -> Scene:
    """The scene, run for so long."""
    every = max(1, round(seconds / scene.time_step / frames))
    return replace(scene, steps=every * frames, output_steps=every)


def head_on(kernel: str, restitution: float, fraction: float) -> dict:
    """Restitution, duration and overlap of pairs head-on, means over 64 entry phases, over their exact values."""
    exact = expected(restitution)
    found = measure_collisions(collision_scene(fraction, restitution), kernel)
    return {name: float(values.mean() / exact[name]) for name, values in found.items()}


def at_the_floor(kernel: str, restitution: float, fraction: float) -> dict:
    """Restitution of discs at a floor, mean over 16 entry phases, over the one that is asked for; no weight."""
    speed = 0.5
    still = {"gravity": (0.0, 0.0), "time_step_fraction": fraction, "restitution": restitution}
    bare = on_a_floor([1.0], [(0.0, -speed)], seconds=1.0, **still)
    gaps = speed * bare.time_step * (1.0 + (np.arange(16) + 0.5) / 16)
    scene = on_a_floor(0.5 + gaps, [(0.0, -speed)] * 16, seconds=1.0, correct_restitution=True, **still)
    scene = with_steps(scene, 6.0 / scene.coefficients.omega_wall)
    _, frames = run_frames(scene, kernel)
    return {"restitution": float(frames[-1].vy.mean() / speed / restitution)}


def sliding(kernel: str, restitution: float, friction: float, slips: list[float]) -> dict:
    """Oblique impacts on a floor: speed along the floor and of the rim after it, over mu times the speed of impact."""
    speed = 0.5
    velocities = [(slip * friction * speed, -speed) for slip in slips]
    scene = on_a_floor(
        [0.5 + 1e-6] * len(slips), velocities, seconds=1.0, gravity=(0.0, 0.0), restitution=restitution,
        friction=friction, time_step_fraction=0.01, friction_law="viscous", springs=None,
    )  # fmt: skip
    scene = with_steps(scene, 6.0 / scene.coefficients.omega_wall)
    _, frames = run_frames(scene, kernel)
    unit = friction * speed
    return {"slip": list(slips), "along": frames[-1].vx / unit, "rim": 0.5 * spin_of(frames[-1]) / unit}


def elastic(kernel: str, pair: bool) -> dict:
    """Overlap over time of an elastic impact, two discs or one on a floor, off half a sine; over the largest."""
    speed, gap = 0.5, 1e-4
    still = {"gravity": (0.0, 0.0), "restitution": 1.0, "time_step_fraction": 0.01, "seconds": 1.0}
    if pair:
        places = [(0.0, 1.0), (1.0 + gap, 1.0)]
        scene = between(places, [(0.5 * speed, 0.0), (-0.5 * speed, 0.0)], (), **still)
        omega = scene.coefficients.omega_wall * sqrt(2.0)  # stiffness of walls is that of pairs
    else:
        scene = on_a_floor([0.5 + gap], [(0.0, -speed)], **still)
        omega = scene.coefficients.omega_wall
    steps = round((pi / omega + 4 * gap / speed) / scene.time_step)
    _, frames = run_frames(replace(scene, steps=steps, output_steps=1), kernel)
    time = np.array([frame.time for frame in frames]) - gap / speed
    seen = np.array([1.0 - (f.x[1] - f.x[0]) if pair else 0.5 - f.y[0] for f in frames])
    touches = (time >= 0) & (omega * time <= pi)
    depth = speed / omega
    off = seen[touches] - depth * np.sin(omega * time[touches])
    last = frames[-1]
    after = last.vx[1] - last.vx[0] if pair else last.vy[0]
    return {"overlap": float(np.abs(off).max() / depth), "restitution": float(after / speed)}


def state_of(frame, chosen: slice) -> dict:
    """Places, velocities and the speed of the rim, R times spin, of some discs."""
    found = {"x": frame.x, "y": frame.y, "u": frame.vx, "v": frame.vy, "rim": 0.5 * spin_of(frame)}
    return {name: values[chosen] for name, values in found.items()}


SPINNING = {"gravity": (0.0, 0.0), "time_step_fraction": 0.01, "friction_law": "viscous", "springs": None}
"""Contacts of the discs that get their spin from a first impact."""


HARD = 1e-4
"""Largest overlap of discs that meet each other: the contact turns by less than a thousandth while it lasts."""


def with_spin_at_a_lid(kernel: str, restitution: float, friction: float, slips: list[float]) -> dict:
    """Discs that get spin at a floor run against a lid: before and after it."""
    speed = 0.5
    velocities = [(slip * friction * speed, -speed) for slip in slips]
    places = [(APART * i, 0.5 + 1e-6) for i in range(len(slips))]
    rise = 0.6
    scene = between(
        places, velocities, (FLOOR, Plane("lid", "y", 1.0 + rise, "below")), seconds=1.0, restitution=restitution,
        friction=friction, **SPINNING,
    )  # fmt: skip
    scene = with_steps(scene, 1.2 * rise / (restitution * speed), 4)
    _, frames = run_frames(scene, kernel)
    return {"before": state_of(frames[-2], slice(None)), "after": state_of(frames[-1], slice(None))}


def with_spin_at_each_other(kernel: str, restitution: float, friction: float, slips: list[float], alike: bool) -> dict:
    """Discs with spin from a floor meet discs from a lid: `alike` with the same spin, else without any."""
    speed, gap = 0.5, 0.06
    lid = 2.0 + gap
    flight = 0.5 * gap / (restitution * speed)
    places, velocities = [], []
    for number, slip in enumerate(slips):
        along = slip * friction * speed
        way = along_after(slip, restitution) * friction * speed * flight
        middle = 2 * APART * number
        places += [(middle - way, 0.5 + 1e-6), (middle + way * alike, lid - 0.5 - 1e-6)]
        velocities += [(along, -speed), (-along * alike, speed)]
    scene = between(
        places, velocities, (FLOOR, Plane("lid", "y", lid, "below")), seconds=1.0, restitution=restitution,
        friction=friction, largest_overlap=HARD, **SPINNING,
    )  # fmt: skip
    scene = with_steps(scene, 1.4 * flight, 4)
    _, frames = run_frames(scene, kernel)
    before, after = frames[-3], frames[-1]
    return {
        "before": [state_of(before, slice(i, None, 2)) for i in (0, 1)],
        "after": [state_of(after, slice(i, None, 2)) for i in (0, 1)],
    }


def along_after(slip: float, restitution: float) -> float:
    """Speed along a floor after an impact, over mu v_n, about: it sets where discs meet."""
    return max(slip - 1.04 * (1.0 + restitution), 2.0 * slip / 3.0)


def spin_of(frame) -> np.ndarray:
    """Spin of the discs, rad/s."""
    return frame.column("omegaz")


def rebound(kernel: str, spin: bool) -> dict:
    """Speed along a floor after an impact at 45 degrees of a disc with a bare tangential spring, over that before."""
    scene = on_a_floor(
        [0.5 + 1e-9], [(SLOW, -SLOW)], seconds=1.0, gravity=(0.0, 0.0), restitution=1.0, friction=1e3,
        rotation=spin, springs=Springs(RATIO, 0.0), time_step_fraction=0.005, largest_overlap=0.1,
    )  # fmt: skip
    scene = with_steps(scene, 1.3 * np.pi / scene.coefficients.omega_wall)
    _, frames = run_frames(scene, kernel)
    return {"along": float(frames[-1].vx[0] / SLOW)}


def slide_to_roll(kernel: str, friction: float) -> dict:
    """A disc that slides on a floor: speed at the end over that at the start, time until it rolls times 3 mu g/u0."""
    speed = 1.0
    scene = on_a_floor([0.5], [(speed, 0.0)], seconds=1.0, friction=friction, largest_overlap=0.05)
    sinks = 1.0 / scene.coefficients.stiffness_wall
    scene = on_a_floor([0.5 - sinks], [(speed, 0.0)], seconds=1.0, friction=friction, largest_overlap=0.05)
    _, frames = run_frames(with_steps(scene, 1.0 / friction, 60), kernel)
    t, u = np.array([frame.time for frame in frames]), np.array([frame.vx[0] for frame in frames])
    slides = (t > 0) & (u > 0.75 * speed)
    fall = np.polyfit(t[slides], u[slides], 1)
    rolls = (2 / 3 * speed - fall[1]) / fall[0]
    return {"end": float(u[-1] / speed), "rim": float(-0.5 * spin_of(frames[-1])[0] / speed),
            "time": float(rolls * 3 * friction / speed), "t": t * 3 * friction / speed, "u": u / speed}  # fmt: skip


def rest_on_a_slope(kernel: str, degrees: float) -> dict:
    """Way of a disc on a slope over the stretch of its spring, m g sin/kt, and its speed at the end."""
    tilt = radians(degrees)
    given = {
        "seconds": 20.0, "friction": 0.5, "rotation": False, "gravity": (sin(tilt), -cos(tilt)),
        "restitution": 0.2, "time_step_fraction": 0.1, "largest_overlap": 0.1,
    }  # fmt: skip
    sinks = cos(tilt) / on_a_floor([0.5], [(0.0, 0.0)], **given).coefficients.stiffness_wall
    scene = on_a_floor([0.5 - sinks], [(0.0, 0.0)], **given)
    _, frames = run_frames(scene, kernel)
    stretch = sin(tilt) / (RATIO * scene.coefficients.stiffness_wall)
    return {"way": float((frames[-1].x[0] - frames[0].x[0]) / stretch), "speed": float(abs(frames[-1].vx[0]))}


def roll_on_slopes(kernel: str, friction: float, degrees: list[float]) -> dict:
    """Speed of discs on slopes after 10 sqrt(d/g), with a spring against rolling."""
    speeds = []
    for angle in degrees:
        tilt = radians(angle)
        springs = Springs(RATIO, 0.5, rolling=Rolling(friction, 1.0, 1.0))
        scene = on_a_floor(
            [0.5 - 1e-4], [(0.0, 0.0)], seconds=10.0, friction=0.5, springs=springs, restitution=0.2,
            gravity=(sin(tilt), -cos(tilt)), time_step_fraction=0.1,
        )  # fmt: skip
        _, frames = run_frames(scene, kernel)
        speeds.append(float(frames[-1].vx[0]))
    return {"degrees": list(degrees), "speed": speeds}
