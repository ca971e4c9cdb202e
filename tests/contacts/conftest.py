# SPDX-License-Identifier: GPL-2.0-or-later
"""What the contact tests share: a table entry turned into a scene and a record, on each host of `hosts`."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hosts import start

from lammps_jump.physics import contact
from lammps_jump.scene.faces import MOST, touching
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.walls import Block, Box, Plane

WALL_KINDS = {"plane": Plane, "block": Block, "box": Box}
ENGINES = {
    # integrator, friction law
    "lammps": ("velocity_verlet", "viscous"),
    "compiled": ("velocity_verlet", "viscous"),
    "compiled_sign": ("velocity_verlet", "sign"),
    "native_verlet": ("velocity_verlet", "viscous"),
    "native_leapfrog": ("leapfrog_extrapolated", "viscous"),
    "native_thesis": ("leapfrog_extrapolated", "sign"),
}


# --- from a table entry to a record -----------------------------------------------------------------------------


def make_scene(case: dict, engine: str, *, correct: bool = False) -> Scene:
    """The scene of a table entry for one engine."""
    integrator, law = ENGINES[engine]
    given = contact.ContactNumbers(
        density=case["density"],
        diameter=case["diameter"],
        restitution=case["restitution"],
        friction=case["friction"],
        stiffness=case["stiffness"],
        stiffness_wall=case["stiffness"],
        impact_speed=3.0,
        time_step_fraction=case["fraction"],
        integrator=integrator,
        correct_restitution=correct,
        rotation=case["rotation"],
    )
    coefficients = contact.derive(given)
    slope = radians(case["slope"])
    gravity = (case["gravity"] * sin(slope), -case["gravity"] * cos(slope))
    resting = 0.5 * case["diameter"] + coefficients.mass * gravity[1] / coefficients.stiffness
    places = [(disc["x"], resting if disc["y"] == "resting" else disc["y"]) for disc in case["discs"]]
    walls = []
    for wall in case.get("walls", []):
        fields = {key: tuple(value) if isinstance(value, list) else value for key, value in wall.items()}
        walls.append(WALL_KINDS[fields.pop("kind")](**fields))
    return Scene(
        name="contact",
        description="",
        diameter=case["diameter"],
        density=case["density"],
        gravity=gravity,
        coefficients=coefficients,
        friction_law=law,
        rotation=case["rotation"],
        integrator=integrator,
        domain=((-6.0, 6.0), (-6.0, 6.0)),
        positions=np.array(places, float),
        velocities=np.array([(disc.get("vx", 0), disc.get("vy", 0)) for disc in case["discs"]], float),
        walls=tuple(walls),
        steps=10**9,
        output_steps=10**8,
        skin=0.3 * case["diameter"],
        overlap_limit=0.5 * case["diameter"],
    )


@dataclass
class Record:
    """What an engine did: t (s,), x and v (s, n, 2), w (s, n), the start included."""

    case: dict
    scene: Scene
    t: np.ndarray
    x: np.ndarray
    v: np.ndarray
    w: np.ndarray

    @property
    def c(self) -> contact.Coefficients:
        return self.scene.coefficients

    @property
    def omega(self) -> float:
        """Contact frequency: of the wall where there is one, else of the pair."""
        return self.c.omega_wall if self.scene.walls else self.c.omega

    @property
    def gap(self) -> np.ndarray:
        """`gaps` of the samples, shape (s,)."""
        return gaps(self.scene, self.x)

    def normal(self) -> np.ndarray:
        """Unit normal at touch, from wall to disc 1, or from disc 2 to disc 1."""
        i = int(np.argmax(self.gap < 0))
        if self.scene.walls:
            nx, ny = wall_normal(self.scene.permanent[0], *self.x[i, 0])
            return np.array([float(nx), float(ny)])
        r = self.x[i, 0] - self.x[i, 1]
        return r / np.hypot(*r)


def wall_normal(wall, x, y):
    """Unit normal at the nearest point of a wall."""
    found, which, faces = np.empty((MOST, 4)), np.empty(MOST, np.int64), np.arange(len(wall.faces.codes))
    touching(wall.faces, 0, faces, (x, y, 10.0), found, which)
    return found[0, 1:3]


def gaps(scene: Scene, x: np.ndarray) -> np.ndarray:
    """Distance of surfaces at positions x (s, n, 2): of the first wall and disc 1, or of the two discs."""
    if scene.walls:
        return scene.permanent[0].distance(*x[:, 0].T) - scene.radius
    return np.hypot(*(x[:, 1] - x[:, 0]).T) - scene.diameter


def play(case: dict, engine: str, folder: Path) -> Record:
    """Run an entry on an engine."""
    scene = make_scene(case, engine)
    sim = start(engine, scene, [disc.get("spin", 0.0) for disc in case["discs"]], folder)
    samples, every = [(0, sim.positions, sim.velocities, sim.spin)], case["samples"] or 1

    def sample() -> None:
        sim.run(every)
        samples.append((samples[-1][0] + every, sim.positions, sim.velocities, sim.spin))

    try:
        if "seconds" in case["run"]:
            left = round(case["run"]["seconds"] / scene.time_step / every)
        else:
            while gaps(scene, samples[-1][1][None])[0] > 0:
                sample()
                assert len(samples) < 20_000, "the discs never touch"
            omega = scene.coefficients.omega_wall if scene.walls else scene.coefficients.omega
            duration = contact.contact_duration(case["restitution"], omega)
            left = int(case["run"]["contacts"] * duration / scene.time_step)
        for _ in range(left):
            sample()
    finally:
        sim.close()
    t, x, v, w = (np.array(part) for part in zip(*samples, strict=True))
    return Record(case, scene, t * scene.time_step, x, v, w)


@pytest.fixture
def rig():
    """`make_scene`, `start` and `play`."""
    return SimpleNamespace(make_scene=make_scene, start=start, play=play)


@pytest.fixture(params=["native_verlet", pytest.param("compiled", marks=pytest.mark.lammps)])
def started(request, rig, tmp_path):
    """A function that starts a scene, on the native engine and on the compiled styles in turn."""
    running = []

    def start(scene):
        running.append(rig.start(request.param, scene, [], tmp_path))
        return running[-1]

    yield start
    for engine in running:
        engine.close()
