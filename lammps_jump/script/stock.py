"""LAMMPS commands, one function a block: each takes the Scene and returns lines, or none where nothing is needed."""

from __future__ import annotations

from lammps_jump.files import DUMP_NAMES, FORCES_HEADER
from lammps_jump.scene.scene import Gate, Scene
from lammps_jump.scene.walls import Block, Box, Plane, Wall

DATA_FILE = "discs.data"
MOLECULE_FILE = "disk.mol"
FAR = 1e4
"""Metres that an opened gate is out of the way."""
FAR_SIDE = "_far_side"
"""What the name of a gate's face on the side away from its column ends with."""
GUARDS_PER_FRAME = 2
LOG_LINES_PER_FRAME = 5


def number(value: float) -> str:
    """Shortest text that LAMMPS reads back as the same double."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def settings(scene: Scene, ranks: int) -> list[str]:
    """Units, dimension, atom style and how space is shared out."""
    lines = [
        "units           si",
        "dimension       2",
        "atom_style      sphere",
        "boundary        f f p",
        "newton          off",
        "comm_modify     vel yes",
    ]
    if ranks > 1:
        lines.append("processors      * 1 1")
    return lines


def box_and_discs(scene: Scene) -> list[str]:
    """The simulation box and the discs at the start; masses are set, because a data file means spheres."""
    if len(scene.positions):
        lines = [f"read_data       {DATA_FILE}", f"set             group all mass {number(scene.mass)}"]
    else:
        (xlo, xhi), (ylo, yhi) = scene.domain
        half = number(scene.radius)
        lines = [
            f"region          domain block {number(xlo)} {number(xhi)} {number(ylo)} {number(yhi)} -{half} {half}",
            "create_box      1 domain",
        ]
    return lines + molecule(scene)


def molecule(scene: Scene) -> list[str]:
    """The disc that inlets and pours insert, where there are some."""
    return [f"molecule        disk {MOLECULE_FILE}"] if scene.inlets or scene.pours else []


def _gamma(value: float) -> str:
    # the wall fixes divide by gamma_n: zero would give NaN forces
    return number(value) if value > 0 else "1e-12"


def contact_law(scene: Scene) -> list[str]:
    """gran/hooke with gamma = c/m_eff; friction only where there is some."""
    c = scene.coefficients
    rub = f"{number(c.gamma_tangential)} {number(c.friction)} 1" if c.friction else "0 0 0"
    return [
        f"pair_style      gran/hooke {number(c.stiffness)} NULL {number(c.gamma_normal)} {rub}",
        "pair_coeff      * *",
    ]


def neighbours(scene: Scene) -> list[str]:
    """Neighbour lists: rebuilt when a disc has moved half the skin."""
    return [f"neighbor        {number(scene.skin)} bin", "neigh_modify    delay 0 every 1 check yes"]


def motion(scene: Scene) -> list[str]:
    """Time step, integration and gravity."""
    lines = [
        f"timestep        {number(scene.time_step)}",
        f"fix             motion all {'nve/sphere disc' if scene.rotation else 'nve'}",
    ]
    return lines + gravity(scene)


def gravity(scene: Scene) -> list[str]:
    """Gravity, where there is some."""
    gx, gy = scene.gravity
    strength = (gx**2 + gy**2) ** 0.5
    if not strength:
        return []
    return [f"fix             gravity all gravity {number(strength)} vector {number(gx)} {number(gy)} 0"]


def _wall_law(scene: Scene) -> str:
    c = scene.coefficients
    rub = f"{number(c.gamma_tangential_wall)} {number(c.friction)} 1" if c.friction else "0 0 0"
    return f"hooke {number(c.stiffness_wall)} NULL {_gamma(c.gamma_normal_wall)} {rub}"


def wall(scene: Scene, item: Wall) -> list[str]:
    """One wall: planes as wall/gran, blocks as the outside of a region, a box as two pairs of planes."""
    law, tail = _wall_law(scene), " contacts" if item.name in scene.probes else ""
    if isinstance(item, Plane):
        ends = f"{number(item.at)} NULL" if item.side == "above" else f"NULL {number(item.at)}"
        return [f"fix             wall_{item.name} all wall/gran {law} {item.axis}plane {ends}{tail}"]
    if isinstance(item, Box):
        return [
            f"fix             wall_{item.name}_{axis} all wall/gran {law} {axis}plane {number(low)} "
            f"{number(high)}{tail}"
            for axis, (low, high) in (("x", item.x), ("y", item.y))
        ]
    assert isinstance(item, Block)
    extent = " ".join(number(value) for value in (*item.x, *item.y))
    # faces in z at infinity: a finite one counts as a contact of its own
    return [
        f"region          solid_{item.name} block {extent} INF INF side out",
        f"fix             wall_{item.name} all wall/gran/region {law} region solid_{item.name}{tail}",
    ]


def walls(scene: Scene) -> list[str]:
    """All permanent walls."""
    return [line for item in scene.walls for line in wall(scene, item)]


def outlets(scene: Scene) -> list[str]:
    """Regions in which discs are deleted; the fixes' scalars count them."""
    lines = []
    for index, outlet in enumerate(scene.outlets, 1):
        ends = f"{number(outlet.at)} INF" if outlet.side == "above" else f"INF {number(outlet.at)}"
        extent = f"{ends} INF INF" if outlet.axis == "x" else f"INF INF {ends}"
        lines += [
            f"region          outlet_{index} block {extent} INF INF",
            f"fix             outlet_{index} all evaporate {outlet.every_steps} 1000000 outlet_{index} {scene.seed}",
        ]
    return lines


def inlets(scene: Scene) -> list[str]:
    """One fix deposit a row: a point region (flat in z too), the disc as a one-atom molecule, ids counted on."""
    lines = []
    for index, row in enumerate(scene.inlets, 1):
        count = row.limit or (scene.steps - row.first_step) // row.every_steps + 2
        x, y = number(row.x), number(row.y)
        fall = f" vy {number(row.vy)} {number(row.vy)}" if row.vy else ""
        lines += [
            f"region          inlet_{index} block {x} {x} {y} {y} 0 0",
            f"fix             inlet_{index} all deposit {count} 0 {row.every_steps} {scene.seed + index} "
            f"region inlet_{index} "
            f"mol disk id max near {number(row.clearance)} attempt 1 vx {number(row.vx)} {number(row.vx)}{fall}",
        ]
    return lines


def pours(scene: Scene) -> list[str]:
    """fix pour for filling; a mol template keeps mass and diameter exact."""
    lines = []
    for index, item in enumerate(scene.pours, 1):
        extent = " ".join(number(value) for value in (*item.x, *item.y))
        half = number(scene.radius)
        lines += [
            f"region          pour_{index} block {extent} -{half} {half}",
            f"fix             pour_{index} all pour {item.count} 0 {scene.seed + 100 + index} region "
            f"pour_{index} mol disk "
            f"vol {number(item.volume_fraction)} 200 vel 0 0 {number(-item.speed_down)}",
        ]
    return lines


def output(scene: Scene, dump_format: str) -> list[str]:
    """Dump with ten digits (six are the default), simulated time in each frame, discs in order of their id."""
    columns = "id x y vx vy" + (" omegaz" if scene.rotation else "")
    style = "custom/gz" if dump_format == "gz" else "custom"
    lines = [f"dump            frames all {style} {scene.output_steps} {DUMP_NAMES[dump_format]} {columns}"]
    if dump_format == "binary":
        lines.append("dump_modify     frames sort id time yes")
    else:
        lines.append("dump_modify     frames sort id time yes format float %.10g")
    return lines


def guards(scene: Scene) -> list[str]:
    """What ends a run that has gone wrong: discs too deep in each other, or out of the plane."""
    every = max(1, scene.output_steps // GUARDS_PER_FRAME)
    return [
        "compute         gaps all pair/local dist cutoff radius",
        "compute         gap all reduce min c_gaps inputs local",
        f"variable        overlap equal {number(scene.diameter)}-c_gap",
        f"fix             guard_overlap all halt {every} v_overlap > {number(scene.overlap_limit)} error hard",
        # a comparison with NaN is false: the sum of all positions must be a number
        "variable        finite equal xcm(all,x)+xcm(all,y)<1e300",
        f"fix             guard_finite all halt {every} v_finite == 0 error hard",
        "variable        height atom abs(z)",
        "compute         height all reduce max v_height",
        "variable        height_max equal c_height",
        f"fix             guard_plane all halt {every} v_height_max > 0 error hard",
    ]


def moment_point(item: Wall) -> tuple[float, float]:
    """The point that a probed wall's moment is about: lower left corner, or the plane's point nearest the origin."""
    if isinstance(item, Plane):
        return (item.at, 0.0) if item.axis == "x" else (0.0, item.at)
    return item.x[0], item.y[0]


def raw_forces(name: str) -> str:
    """File of one structure: LAMMPS buffers, so that two fixes writing one file would tear each other's lines."""
    return f"forces_{name}.raw"


def probes(scene: Scene) -> list[str]:
    """Force on each probed structure, every step summed, averaged over a window, one CSV row a window.

    The moment needs a product per disc, which only an atom-style variable can form; evaluated every step it would
    cost half a run (measured 1.7x on quick_jump), so it is the mean over the last tenth of each window.
    """
    if not scene.probes:
        return []
    n = scene.probe_steps
    few = max(1, n // 10)
    lines = ["variable        clock equal time"]
    for name in scene.probes:
        item = scene.wall(name)
        x0, y0 = (f"({number(value)})" for value in moment_point(item))
        parts = [f"f_wall_{name}_x", f"f_wall_{name}_y"] if isinstance(item, Box) else [f"f_wall_{name}"]
        pushes = " ".join(f"{part}[2] {part}[3]" for part in parts)
        arms = "+".join(f"({part}[5]-{x0})*{part}[3]-({part}[6]-{y0})*{part}[2]" for part in parts)
        columns = " ".join(f"c_push_{name}[{i + 1}]" for i in range(2 * len(parts)))
        # the columns hold the force on the disc; the structure feels the opposite
        along = [f"f_mean_{name}[{i + 1}]" for i in range(2 * len(parts))]
        row = f"${{clock}},{name},${{fx_{name}}},${{fy_{name}}},${{mz_{name}}}"
        lines += [
            f"compute         push_{name} all reduce sum {pushes}",
            f"fix             mean_{name} all ave/time 1 {n} {n} {columns}",
            f"variable        arm_{name} atom {arms}",
            f"compute         turn_{name} all reduce sum v_arm_{name}",
            f"fix             moment_{name} all ave/time 1 {few} {n} c_turn_{name}",
            f"variable        fx_{name} equal -({'+'.join(along[0::2])})",
            f"variable        fy_{name} equal -({'+'.join(along[1::2])})",
            f"variable        mz_{name} equal -f_moment_{name}",
            f'fix             write_{name} all print {n} "{row}" &',
            f'                file {raw_forces(name)} screen no title "{FORCES_HEADER}"',
        ]
    return lines


def thermo(scene: Scene, removed: tuple[int, ...] = ()) -> list[str]:
    """Log lines with the disc balance; the style first, because it resets what thermo_modify says.

    The highest id counts the discs that ever were (ids are given in turn, ``id max``). `removed` is what each outlet
    took in earlier parts of an interrupted run; the columns are called as without it.
    """
    names = [f"f_outlet_{index}" for index, _ in enumerate(scene.outlets, 1)]
    lines, top, called = [], "", ""
    if any(removed):
        before = enumerate(zip(names, removed, strict=True), 1)
        lines = [f"variable        gone_{index} equal {name}+{count}" for index, (name, count) in before]
        called = "".join(f" colname v_gone_{index} {name}" for index, name in enumerate(names, 1))
        names = [f"v_gone_{index}" for index, _ in enumerate(names, 1)]
    if scene.inlets or scene.pours:
        lines += ["variable        id atom id", "compute         top all reduce max v_id"]
        top = " c_top"
    return [
        *lines,
        f"thermo_style    custom step time atoms{''.join(f' {name}' for name in names)}{top}",
        f"thermo_modify   lost error flush yes{called}",
        f"thermo          {max(1, scene.output_steps // LOG_LINES_PER_FRAME)}",
    ]


def gate(scene: Scene, item: Gate) -> list[str]:
    """A gate: the face of a half-space that jumps out of the way at its release step.

    Taking its fix away between two runs would be the shorter text, but a second run computes its first forces anew
    with full-step velocities, where a run that goes on has half-step ones: the dashpots would jolt (1e-5 d).
    """
    name = item.wall.name
    if isinstance(item.wall, Block):
        # discs on both sides feel it: the faces of two half-spaces
        x = item.wall.x[0]
        sides = (Plane(name, "x", x, "below"), Plane(f"{name}{FAR_SIDE}", "x", x, "above"))
        return [line for side in sides for line in gate(scene, Gate(side, item.release_step))]
    plane = item.wall
    inward = f"{number(plane.sign)} 0 0" if plane.axis == "x" else f"0 {number(plane.sign)} 0"
    point = f"{number(plane.at)} 0 0" if plane.axis == "x" else f"0 {number(plane.at)} 0"
    away = f"move v_open_{name} NULL NULL" if plane.axis == "x" else f"move NULL v_open_{name} NULL"
    return [
        f"variable        open_{name} equal {number(-plane.sign * FAR)}*(step>={item.release_step})",
        f"region          shut_{name} plane {point} {inward} {away}",
        f"fix             wall_{name} all wall/gran/region {_wall_law(scene)} region shut_{name}",
    ]


def schedule(scene: Scene) -> list[str]:
    """The run itself; only inlets that wait for a gate need a second one."""
    lines = [line for item in scene.gates for line in gate(scene, item)]
    if not (scene.gates and scene.inlets):
        return [*lines, *inlets(scene), f"run             {scene.steps}"]
    lines.append(f"run             {scene.settle_steps}")
    fixes = [line.split()[1] for item in scene.gates for line in gate(scene, item) if line.startswith("fix ")]
    lines += [f"unfix           {name}" for name in fixes]
    return [*lines, *inlets(scene), f"run             {scene.steps - scene.settle_steps}"]


def half_step(scene: Scene, kernel: str, sign: str = "+") -> list[str]:
    """From the velocities of the half step to those of the step with the forces that are there; "-" for the way back.

    v_n = v_(n-1/2) + dt F_n / (2 m), and the same for spin with its torque. The compiled kernel keeps gravity out of
    the forces, unless a pour needs LAMMPS' own.
    """
    half = number(0.5 * scene.time_step)
    gx, gy = scene.gravity if kernel == "compiled" and not scene.pours else (0.0, 0.0)
    lines = [
        f"variable        half_x atom vx{sign}{half}*(fx/mass+({number(gx)}))",
        f"variable        half_y atom vy{sign}{half}*(fy/mass+({number(gy)}))",
        "set             group all vx v_half_x vy v_half_y",
    ]
    if scene.rotation:
        turn = number(0.5 * scene.time_step / (scene.coefficients.inertia * scene.radius**2))
        lines += [
            "fix             turning all store/state 0 omegaz tqz",
            f"variable        half_w atom f_turning[1]{sign}{turn}*f_turning[2]",
            "set             group all omega 0 0 v_half_w",
            "unfix           turning",
        ]
    return lines


def half_step_back(scene: Scene, kernel: str) -> list[str]:
    """What a restart file of this project is written after; see `lammps_jump.script.resume`."""
    return half_step(scene, kernel, "-")
