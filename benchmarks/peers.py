# SPDX-License-Identifier: GPL-2.0-or-later
"""What a step costs beside other programs: stock LAMMPS, LIGGGHTS and YADE on the same dam break.

Run as ``python benchmarks/peers.py [DISCS ...] [--turns 5] [--out DIR]``. Discs of one size start from the same places
and velocities, 0.6 s after the release of the column of inputs/dam_break.yaml, with the same mass, stiffness, damping
and step. Two laws are tried: without friction, and with a tangential spring. Each program does two numbers of steps,
in turns with the others, on one thread and without output. Printed are medians of the difference in processor time
over the difference in steps, ns a disc-step, and how far the centre of mass of each is from that of the native engine,
in diameters, after the short run. A program that is not installed is left out, and named.
"""

from __future__ import annotations

import argparse
import math
import pickle
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np
import timed

import lammps_jump as lj
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.plugin import plugin_path

RELEASED = 0.6
"""Time after the release from which all start, s."""
FEW, WORK = 200, 1.2e7
"""Steps of the short run, and disc-steps by which the long one is longer."""
LAWS = {
    "frictionless": {"contact.friction": 0.0},
    "springs": {
        "contact.friction": 0.3,
        "contact.friction_law": "history",
        "contact.tangential_ratio": 2 / 7,
        "contact.tangential_damping_ratio": 0.0,
        "contact.rotation": True,
    },
}
SKIN = 0.3
"""Skin of the other programs' lists over the diameter; ours have their default."""


class Start(NamedTuple):
    """What all programs are given."""

    case: lj.Case
    places: np.ndarray
    velocities: np.ndarray
    law: str

    @property
    def density(self) -> float:
        """Density of spheres whose mass is that of our discs, kg/m^3."""
        scene = self.case.scene()
        return 6 * scene.mass / (math.pi * scene.diameter**3)


def start_of(discs: int, law: str, room: Path) -> Start:
    """The column some time after its release."""
    planes = [
        {"name": name, "kind": "plane", "axis": axis, "at": 0, "side": "above"}
        for name, axis in (("floor", "y"), ("back", "x"))
    ]
    changes = {"engine.name": "native", "walls": planes, "outflow": [], "analysis.front": False, **LAWS[law]}
    changes |= {"run.duration": RELEASED, "run.output_interval": RELEASED}
    sets = timed.column(discs, 60, **changes)
    before = lj.load_case(timed.CASE, sets).run(room / f"{discs}_{law}")
    last = list(before.frames())[-1].sorted()
    places, velocities = np.column_stack([last.x, last.y]), np.column_stack([last.vx, last.vy])
    return Start(lj.load_case(timed.CASE, sets).after(before), places, velocities, law)


QUIET = {"OMP_NUM_THREADS": "1", "LAMMPS_JUMP_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Settings for one thread."""


def seconds(spent: Any) -> float:
    """Processor seconds of a process."""
    return spent.ru_utime + spent.ru_stime


def ours(start: Start, steps: int, **engine: str) -> lj.Case:
    """The case for so many steps, with one frame at their end."""
    step = start.case.scene().coefficients.time_step
    changes = {f"engine.{name}": value for name, value in engine.items()}
    return start.case.replace({"run.duration": steps * step, "run.output_interval": steps * step, **changes})


def native(start: Start, steps: int, folder: Path) -> tuple[float, np.ndarray]:
    """The native engine."""
    (folder / "scene").write_bytes(pickle.dumps(ours(start, steps, name="native").scene()))
    code = (
        "import pickle, pathlib, numpy as np\n"
        "from lammps_jump.engines.native import NativeSimulation\n"
        "s = NativeSimulation(pickle.loads(pathlib.Path('scene').read_bytes()))\n"
        f"s.run({steps})\n"
        "np.savetxt('end', [np.mean(s.discs.x[:s.discs.n]), np.mean(s.discs.y[:s.discs.n])])\n"
    )
    spent, _ = timed.ended([sys.executable, "-c", code], folder, **QUIET)
    return seconds(spent), np.loadtxt(folder / "end")


def lammps(kernel: str) -> Callable[[Start, int, Path], tuple[float, np.ndarray]]:
    """LAMMPS, by the script that this program writes."""

    def run(start: Start, steps: int, folder: Path) -> tuple[float, np.ndarray]:
        case = ours(start, steps, name="lammps", kernel=kernel)
        write_script(case.scene(), folder, kernel=kernel)
        script = "in.plugin.lammps" if kernel == "compiled" else "in.lammps"
        words = ("-var", "plugin", plugin_path()) if kernel == "compiled" else ()
        spent, _ = timed.lammps_ended(script, folder, *words, **QUIET)
        last = list(lj.dump.read_dump(folder))[-1]
        return seconds(spent), np.array([last.x.mean(), last.y.mean()])

    return run


def liggghts(start: Start, steps: int, folder: Path) -> tuple[float, np.ndarray]:
    """LIGGGHTS, with the stiffness and damping of each contact given."""
    scene = start.case.scene()
    law, d = scene.coefficients, scene.diameter
    springs = start.law == "springs"
    density = 4 * scene.mass / (math.pi * d * d)  # in two dimensions LIGGGHTS takes the area of a disc
    rows = "\n".join(
        f"{i} 1 {d:.17g} {density:.17g} {x:.17g} {y:.17g} 0" for i, (x, y) in enumerate(start.places.tolist(), start=1)
    )
    speeds = "\n".join(f"{i} {u:.17g} {v:.17g} 0 0 0 0" for i, (u, v) in enumerate(start.velocities.tolist(), start=1))
    (folder / "start.data").write_text(
        f"discs\n\n{len(start.places)} atoms\n1 atom types\n-1 60 xlo xhi\n-1 20 ylo yhi\n"
        f"{-d:.17g} {d:.17g} zlo zhi\n\nAtoms\n\n{rows}\n\nVelocities\n\n{speeds}\n"
    )
    model = "model hooke/stiffness tangential " + ("history" if springs else "off")
    damping = 0.5 * law.mass * law.gamma_normal
    friction = law.friction if springs else 0.0
    ratio = 2 / 7 if springs else 0.0
    (folder / "in.peer").write_text(f"""\
units si
atom_style sphere
dimension 2
newton off
boundary f f p
communicate single vel yes
read_data start.data
neighbor {SKIN * d:.17g} bin
neigh_modify delay 0
fix k all property/global kn peratomtypepair 1 {law.stiffness:.17g}
fix kt all property/global kt peratomtypepair 1 {ratio * law.stiffness:.17g}
fix gn all property/global gamman_abs peratomtypepair 1 {damping:.17g}
fix gt all property/global gammat_abs peratomtypepair 1 0.0
fix mu all property/global coefficientFriction peratomtypepair 1 {friction:.17g}
pair_style gran {model} absolute_damping on tangential_damping off
pair_coeff * *
fix floor all wall/gran {model} primitive type 1 yplane 0.0 absolute_damping on tangential_damping off
fix back all wall/gran {model} primitive type 1 xplane 0.0 absolute_damping on tangential_damping off
fix pull all gravity 9.81 vector 0 -1 0
fix move all nve/sphere
fix flat all enforce2d
timestep {law.time_step:.17g}
thermo {steps}
compute middle all com
thermo_style custom step atoms c_middle[1] c_middle[2]
thermo_modify norm no lost error format float %20.15g
run {steps}
""")
    spent, shown = timed.ended(["liggghts", "-in", "in.peer", "-log", "none"], folder, **QUIET)
    last = next(line.split() for line in reversed(shown.splitlines()) if line.split()[:1] == [str(steps)])
    return seconds(spent), np.array([float(last[2]), float(last[3])])


def yade(start: Start, steps: int, folder: Path) -> tuple[float, np.ndarray]:
    """YADE, viscoelastic spheres held in the plane; contact time and restitution of a pair are given."""
    scene = start.case.scene()
    law, d = scene.coefficients, scene.diameter
    np.savetxt(folder / "start", np.column_stack([start.places, start.velocities]), fmt="%.17g")
    half = 0.5 * law.mass
    duration = math.pi / math.sqrt(law.stiffness / half - (0.5 * law.gamma_normal) ** 2)
    restitution = math.exp(-0.5 * law.gamma_normal * duration)
    friction = math.atan(law.friction) if start.law == "springs" else 0.0
    (folder / "peer.py").write_text(f"""\
import numpy as np
rows = np.loadtxt('start')
O.materials.append(ViscElMat(density={start.density:.17g}, frictionAngle={friction:.17g}, tc={duration:.17g},
    en={restitution:.17g}, et=1.0, label='disc'))
for x, y, u, v in rows:
    one = sphere((x, y, 0), {d / 2:.17g}, material='disc')
    one.state.blockedDOFs = 'zXY'
    one.state.vel = (u, v, 0)
    O.bodies.append(one)
O.bodies.append([utils.wall(0, axis=1, sense=1, material='disc'), utils.wall(0, axis=0, sense=1, material='disc')])
O.engines = [ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist={0.5 * SKIN * d:.17g}),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
        [Law2_ScGeom_ViscElPhys_Basic()]),
    NewtonIntegrator(damping=0, gravity=(0, -9.81, 0))]
O.dt = {law.time_step:.17g}
O.run({steps}, True)
np.savetxt('end', [np.mean([b.state.pos[i] for b in O.bodies if isinstance(b.shape, Sphere)]) for i in (0, 1)])
""")
    spent, _ = timed.ended(["yade", "-x", "-n", "-j1", "peer.py"], folder, **QUIET)
    return seconds(spent), np.loadtxt(folder / "end")


PROGRAMS: dict[str, Callable[[Start, int, Path], tuple[float, np.ndarray]]] = {
    "native": native,
    "compiled": lammps("compiled"),
    "stock": lammps("stock"),
    "liggghts": liggghts,
    "yade": yade,
}


def measured(asked: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Yield a row for each number of discs, law and program."""
    missing = [name for name in ("liggghts", "yade") if shutil.which(name) is None]
    for name in missing:
        print(f"{name} is not installed: left out", file=sys.stderr)
    names = [name for name in PROGRAMS if name not in missing]
    with tempfile.TemporaryDirectory() as room:
        for discs in asked.discs:
            for law in LAWS:
                yield from compared(start_of(discs, law, Path(room)), names, asked.turns, Path(room) / "turn")


def compared(start: Start, names: list[str], turns: int, folder: Path) -> Iterator[dict[str, Any]]:
    """Yield a row for each of these programs, run in turns."""
    count = len(start.places)
    more = int(WORK / count)
    spent: dict[str, list[float]] = {name: [] for name in names}
    ends: dict[str, np.ndarray] = {}
    for _ in range(turns):
        for name in names:
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            few, ends[name] = PROGRAMS[name](start, FEW, folder)
            many, _ = PROGRAMS[name](start, FEW + more, folder)
            spent[name].append(1e9 * (many - few) / more / count)
    for name, found in spent.items():
        apart = float(np.hypot(*(ends[name] - ends["native"]))) / start.case.scene().diameter
        times = {"ns": median(found), "least": min(found), "most": max(found)}
        yield {"discs": count, "law": start.law, "program": name, **times, "apart": apart}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("discs", nargs="*", type=int, default=[1200, 12000])
    parser.add_argument("--turns", type=int, default=5)
    sys.exit(timed.tell(parser, measured, "peers.json"))
