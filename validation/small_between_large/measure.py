# SPDX-License-Identifier: GPL-2.0-or-later
"""Small discs between large ones: whether they come through, when, and what the springs of their contacts gather.

Units of the scenes: diameter and mass of a small disc and g are 1.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, nan, radians, sin
from pathlib import Path

import numpy as np

from lammps_jump import load_case
from lammps_jump.dump import Frame
from lammps_jump.engines.lammps.loader import new_engine
from lammps_jump.physics.slip import Springs
from lammps_jump.scene import Motion, MovingWall, Scene, Sizes, handmade_scene
from lammps_jump.scene.scene import Fixed
from lammps_jump.scene.tracks import Translate
from lammps_jump.scene.walls import Circle
from lammps_jump.script import script_text
from lammps_jump.studies.runs import run_frames

MENDED = "mended"
"""The stock kernel with the velocity Verlet of Vyas et al. 2025."""
WORD = "synchronized_verlet"
"""That scheme in a `pair_coeff` of LAMMPS' style granular."""
RATIO = 2.0 / 7.0
"""Stiffness of a tangential spring over that of the normal one."""
SMALL = 0.5
"""Radius of a small disc."""


def grains(places, diameters, *, seconds: float, frames: int, **more) -> Scene:
    """Discs with springs and spin; the first ids have these diameters. `more` as of `handmade_scene`."""
    given = {"friction": 0.5, "restitution": 0.5, "gravity": (0.0, -1.0), "impact_speed": 4.0}
    width = max(x for x, _ in places)
    still = np.zeros((len(places), 2))
    scene = handmade_scene(
        places, more.pop("velocities", still), diameter=1.0, density=1.0, largest_overlap=0.01, skin=0.3,
        sizes=Sizes((1.0,), (1.0,), (1.0,), given=tuple(diameters)), friction_law="history",
        springs=Springs(RATIO, 1.0), rotation=True, correct_restitution=True, overlap_limit=0.5,
        domain=((-100.0, width + 100.0), (-150.0, 60.0)), **{**given, **more},
    )  # fmt: skip
    every = max(1, round(seconds / scene.time_step / frames))
    return replace(scene, steps=every * frames, output_steps=every)


def frames_of(scene: Scene, kernel: str) -> list[Frame]:
    """The frames of a run on a kernel, or of the stock script with the scheme of Vyas et al."""
    if kernel != MENDED:
        return run_frames(scene, kernel, dump_format="binary")[1]
    lines = script_text(scene, kernel="stock", dump_format="binary").splitlines()
    text = "\n".join(f"{line} {WORD}" if line.startswith("pair_coeff") else line for line in lines)
    return run_frames(scene, "stock", dump_format="binary", script=f"{text}\n")[1]


def column(frames: list[Frame], name: str) -> np.ndarray:
    """A column of all frames, shape (frames, discs)."""
    return np.array([frame.column(name) for frame in frames])


def passed(time: np.ndarray, height: np.ndarray, low: float) -> np.ndarray:
    """When each disc falls below a height, between two frames in a straight line; NaN: never."""
    found = []
    for own in height.T:
        below = np.flatnonzero(own < low)
        if not below.size or not below[0]:
            found.append(nan)
            continue
        j = below[0]
        found.append(time[j - 1] + (time[j] - time[j - 1]) * (own[j - 1] - low) / (own[j - 1] - own[j]))
    return np.array(found)


def three(kernel: str, fraction: float, ratio: float, gap: float, count: int, friction: float) -> dict:
    """Times at which small discs have fallen between two fixed large ones; NaN: they have not.

    Parameters
    ----------
    kernel : str
    fraction : float
        Time step over 2/omega.
    ratio : float
        Diameter of the large ones.
    gap : float
        Between them.
    count : int
        Triples, each with its small disc at another place above the gap.
    friction : float
    """
    apart, way = 0.5 * (ratio + gap), 1.1 * gap
    middles = 3.0 * ratio * np.arange(count)
    large = [(x, 0.0) for middle in middles for x in (middle - apart, middle + apart)]
    offsets = way * (2.0 * (np.arange(count) + 0.5) / count - 1.0) + 1e-3
    small = [(middle + off, 0.5 * ratio + 1.5) for middle, off in zip(middles, offsets, strict=True)]
    scene = grains(
        large + small, [ratio] * 2 * count + [1.0] * count, seconds=14.0, frames=560, fixed=Fixed(1, 2 * count),
        time_step_fraction=fraction, friction=friction,
    )  # fmt: skip
    frames = frames_of(scene, kernel)
    time = np.array([frame.time for frame in frames])
    return {"times": passed(time, column(frames, "y")[:, 2 * count :], -0.5 * ratio).tolist()}


def nip(kernel: str, fraction: float, ratio: float, friction: float, degrees: list[float]) -> dict:
    """Rise of small discs in the nip of two large circles that close on them, slowly and without turning.

    `degrees`: angle of the contacts from the line of the centres, of each; no weight.
    """
    reach, speed, way = 0.5 * ratio + SMALL, 0.02, 0.02
    middles = 3.0 * ratio * np.arange(len(degrees))
    walls, places = [], []
    for number, (middle, angle) in enumerate(zip(middles, degrees, strict=True)):
        places.append((middle, reach * sin(radians(angle))))
        for side, sign in (("left", -1.0), ("right", 1.0)):
            centre = (middle + sign * reach * cos(radians(angle)), 0.0)
            closes = Translate(velocity=(-sign * speed, 0.0), until=way / speed, ease=0.0)
            walls.append((Circle(f"{side}{number}", centre, 0.5 * ratio), closes, centre))
    bare = {"time_step_fraction": fraction, "friction": friction, "gravity": (0.0, 0.0), "restitution": 0.2}
    step = grains(places, [1.0] * len(places), seconds=1.0, frames=1, **bare).time_step
    moving = tuple(
        MovingWall(wall, Motion(kind=closes, about=centre, time_step=step)) for wall, closes, centre in walls
    )
    scene = grains(places, [1.0] * len(places), seconds=1.5 * way / speed, frames=3, walls=moving, **bare)
    frames = frames_of(scene, kernel)
    rise = column(frames, "y")[-1] - [y for _, y in places]
    return {"degrees": list(degrees), "rise": rise.tolist()}


def moving(kernel: str, fraction: float, ratio: float, friction: float, degrees: list[float]) -> dict:
    """Small discs in the nip of two free large ones that run at each other: way from the middle of these, and speeds.

    `degrees` as of `nip`; no weight.
    """
    reach, speed = 0.5 * ratio + SMALL, 0.2
    middles = 3.0 * ratio * np.arange(len(degrees))
    large, small, thrown = [], [], []
    for middle, angle in zip(middles, degrees, strict=True):
        half = (reach + 1e-3) * cos(radians(angle))
        large += [(middle - half, 0.0), (middle + half, 0.0)]
        thrown += [(speed, 0.0), (-speed, 0.0)]
        small.append((middle, (reach + 1e-3) * sin(radians(angle))))
    n = len(degrees)
    scene = grains(
        large + small, [ratio] * 2 * n + [1.0] * n, seconds=4.0, frames=40, velocities=thrown + [(0.0, 0.0)] * n,
        gravity=(0.0, 0.0), time_step_fraction=fraction, friction=friction,
    )  # fmt: skip
    last = frames_of(scene, kernel)[-1]
    y, v = last.y, last.vy
    pair = 0.5 * (y[: 2 * n : 2] + y[1 : 2 * n : 2])
    return {"degrees": list(degrees), "way": (y[2 * n :] - pair).tolist(), "speed": (v[2 * n :] / speed).tolist()}


def rolls(kernel: str, fraction: float, ratio: float) -> dict:
    """A small disc rolls off the top of a fixed large one, with friction enough: where it leaves, and its spring.

    A step adds r_n sin(a) to the spring, where the line of the centres turns by a. The way of the contact is r a, with
    the mean of r over the step.

    Returns
    -------
    dict
        `angle`: of the line of the centres to the vertical where they part, degrees; `begin`: at the start. `way`: of
        the contact, m; `excess`: largest sum of what the steps add too much, m.
    """
    reach, begin = 0.5 * ratio + SMALL, 3.0
    places = [(0.0, 0.0), (reach * sin(radians(begin)), reach * cos(radians(begin)))]
    scene = grains(
        places, [ratio, 1.0], seconds=16.0, frames=1, fixed=Fixed(1, 1), time_step_fraction=fraction, friction=5.0,
        restitution=0.2,
    )  # fmt: skip
    frames = frames_of(replace(scene, output_steps=max(1, round(0.1 / fraction))), kernel)
    x, y = column(frames, "x"), column(frames, "y")
    dx, dy = x[:, 1] - x[:, 0], y[:, 1] - y[:, 0]
    r, angle = np.hypot(dx, dy), np.arctan2(dx, dy)
    last = int(np.flatnonzero(r < reach)[-1])
    turn = np.diff(angle[: last + 1])
    excess = np.cumsum(r[:last] * np.sin(turn) - 0.5 * (r[:last] + r[1 : last + 1]) * turn)
    return {
        "begin": begin,
        "angle": float(np.degrees(angle[last])),
        "way": float(np.abs(r[:last] * turn).sum()),
        "excess": float(np.abs(excess).max()),
    }


SPHERES = """\
units si
atom_style sphere
atom_modify map array
newton off
boundary f f f
region room block -0.03 0.03 -0.02 0.02 -0.02 0.02
create_box 2 room
create_atoms 1 single -0.005 0 0
create_atoms 1 single 0.005 0 0
create_atoms 2 single 0 {y} {z}
group large type 1
group small type 2
set group large diameter 0.01 density 2500
set group small diameter 0.0005 density 2500
pair_style granular
pair_coeff * * hooke 1e4 0.5 tangential linear_history 8235 0 {friction} damping coeff_restitution {word}
comm_modify vel yes
timestep {step}
fix held large freeze
fix weight small gravity 9.81 vector 0 0 -1
fix motion small nve/sphere
thermo_modify lost ignore
"""
"""A small sphere over the place where two large fixed ones touch, of 20 times its diameter: three dimensions."""


def spheres(mended: bool, friction: float, step: float) -> dict:
    """Lowest place of a small sphere that rolls around the place where two large ones touch, over its circle's radius.

    It begins a degree beside the highest place of that circle. Where it leaves the large spheres, as on a cylinder of
    that radius, it falls out of the room: -inf.

    Parameters
    ----------
    mended : bool
        The velocity Verlet of Vyas et al. in place of that of LAMMPS.
    friction : float
    step : float
        s.
    """
    circle = float(np.sqrt(0.00525**2 - 0.005**2))
    y, z = circle * sin(radians(1.0)), circle * cos(radians(1.0))
    engine = new_engine(["-screen", "none", "-log", "none"])
    try:
        word = WORD if mended else ""
        engine.commands_string(SPHERES.format(y=y, z=z, friction=friction, word=word, step=step))
        heights = []
        for _ in range(300):
            engine.command(f"run {round(1e-3 / step)} pre {'no' if heights else 'yes'} post no")
            if engine.get_natoms() < 3:
                return {"height": -np.inf}
            heights.append(engine.numpy.extract_atom("x")[engine.extract_global("map_dummy") or 2][2] / circle)
        return {"height": float(min(heights))}
    finally:
        engine.close()


SILO = Path(__file__).with_name("silo.yaml")


def silo(kernel: str, fraction: float, seed: int) -> dict:
    """A bin of large discs and small ones, 8 to 1, that empties through a slot.

    Returns
    -------
    dict
        `half`: time until half of the mass is out, s; `left`: share of the small ones in the bin at
        the end, and `inside`, of the large ones; `time` (s) and `mass` in the bin, over that at the start.
    """
    changes = {"run.time_step_fraction": fraction, "run.seed": seed}
    scene = load_case(SILO, changes).scene()
    frames = frames_of(scene, kernel)
    time = np.array([frame.time for frame in frames])
    mass, left = [], []
    for frame in frames:
        large, above = frame.radii > scene.diameter, frame.y > 0.0
        mass.append(float((4.0 * frame.radii**2)[above].sum()))
        left.append((int((above & ~large).sum()), int((above & large).sum())))
    share = np.array(mass) / mass[0]
    small, big = np.array(left, float)[-1] / np.array(left, float)[0]
    return {
        "half": float(np.interp(-0.5, -share, time)),
        "left": float(small),
        "inside": float(big),
        "time": time.tolist(),
        "mass": share.tolist(),
    }
