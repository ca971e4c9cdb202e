# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS commands of the styles that come with it, and of both kernels.

Each function takes the scene and returns lines, or none where the scene does not need them.
"""

from __future__ import annotations

from math import ceil, log2

from lammps_jump.files import DUMP_NAMES
from lammps_jump.physics.contact import WallLaw
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.sizes import ID_STEP

from .probes import stock_probes
from .regions import first_forces, number, numbers
from .walls import fix_names, granular_law, spring_words, stock_gates, stock_walls, unwritten

DATA_FILE = "discs.data"
MOLECULE_FILE = "disk.mol"
WORDED = {
    "stiffness", "damping", "tangential", "friction", "sign_ramp", "touch", "spring_ratio", "spring_damping", "rolling",
    "rolling_damping", "rolling_friction",
}  # fmt: skip
"""Numbers of the law that scripts have in words of their own, or refuse by them (`lacking`)."""
GUARDS_PER_FRAME = 2
LOG_LINES_PER_FRAME = 5
probes, gates = stock_probes, stock_gates


def _rolls(scene: Scene) -> bool:
    return scene.springs is not None and scene.springs.rolling is not None


def more_numbers(scene: Scene) -> dict[str, float]:
    """Numbers of the law that are not 0, but `WORDED`: LAMMPS' styles have none, the plugin takes them by name."""
    return {name: value for name, value in scene.law_numbers()._asdict().items() if name not in WORDED and value}


def lacking(scene: Scene) -> str:
    """Features of a scene that LAMMPS' styles lack, with the field that asks for them; empty where they write all.

    The rolling spring of two discs changes its sign there when the two change their order in memory (measured: an error
    of 4e-8 d in that step, 2e-3 d after 1,600 more): discs are not sorted then, but those that go round or leave
    disorder the others.
    """
    if scene.hydrograph:  # fix deposit has one interval and one speed for all its discs
        return "'inflow.table'"
    if scene.touch == "smooth":
        return "'touch: smooth'"
    if more := more_numbers(scene):
        return f"'contact.{next(iter(more))}'"
    if scene.rubs and not FRICTION_LAWS[scene.friction_law].in_stock:
        return f"'friction_law: {scene.friction_law}'"
    if _rolls(scene) and (scene.periodic or scene.outlets):
        return f"'contact.rolling' {'in a periodic channel' if scene.periodic else 'with an outflow'}"
    if scene.springs and scene.moves and first_step(scene):
        # the second run first looks at walls where they were a step before (`first_forces`), which cuts springs there
        return "'friction_law: history' with walls that move and inlets that wait for a gate"
    return unwritten(scene)


def settings(scene: Scene, ranks: int) -> list[str]:
    """Units, dimension, atom style and how space is divided."""
    return [
        "units           si",
        "dimension       2",
        "atom_style      sphere",
        f"boundary        {'p' if scene.periodic else 'f'} f p",
        "newton          off",
        "comm_modify     vel yes",
        *(["processors      * 1 1"] if ranks > 1 else []),
    ]


def box_and_discs(scene: Scene) -> list[str]:
    """The simulation box and the discs at the start; masses are set, because a data file means spheres."""
    if len(scene.positions):
        what = SIZE if scene.sizes else f"mass {number(scene.mass)}"
        lines = [f"read_data       {DATA_FILE}", *size_variables(scene), f"set             group all {what}"]
    else:
        half = half_depth(scene)
        extent = numbers(*scene.domain[0], *scene.domain[1], -half, half)
        lines = [f"region          domain block {extent}", "create_box      1 domain", *size_variables(scene)]
    if scene.fixed:
        lines += [
            f"group           bed id {scene.fixed.first}:{scene.fixed.last}",
            "group           free subtract all bed",
        ]
    return lines


def half_depth(scene: Scene) -> float:
    """Half the size of the box in z, m: a power of two, no less than the largest radius.

    Ranks that share their discs anew scale positions to the box and back. With another size that moves discs by 1e-17 m
    out of the plane, and collisions amplify it.
    """
    return 2.0 ** ceil(log2(0.5 * scene.largest))


SIZE = "diameter v_diameter mass v_mass"
"""Settings that a disc gets from `size_variables`."""


def size_variables(scene: Scene) -> list[str]:
    """Diameter and mass of a disc as functions of its id, where discs are not equal (see `Sizes`)."""
    if scene.sizes is None:
        return []
    pieces = scene.sizes.pieces.tolist()
    terms = [f"{number(low)}+{number(slope)}*(v_quantile-{number(begin)})" for begin, _, low, slope in pieces]
    if len(pieces) > 1:
        within = [f"(v_quantile>={number(begin)})*(v_quantile<{number(end)})" for begin, end, _, _ in pieces]
        terms = [f"{where}*({term})" for where, term in zip(within, terms, strict=True)]
    own = [(f"(id>={first})*(id<={last})", number(diameter)) for first, last, diameter in scene.sizes.own]
    if scene.sizes.given:  # as the data file has them
        own.append((f"(id<={len(scene.sizes.given)})", "2*radius"))
    if own:
        terms = [f"({'+'.join(terms)})*({'*'.join(f'(1-{where})' for where, _ in own)})"]
        terms += [f"{where}*{diameter}" for where, diameter in own]
    return [
        f"variable        turned atom (id+{number(scene.sizes.shift)})*{number(ID_STEP)}",
        "variable        quantile atom v_turned-floor(v_turned)",
        f"variable        diameter atom {'+'.join(terms)}",
        f"variable        mass atom {number(scene.density)}*v_diameter*v_diameter",
    ]


def molecule(scene: Scene) -> list[str]:
    """The disc that inlets and pours insert, where there are some."""
    return [f"molecule        disk {MOLECULE_FILE}"] if scene.inlets or scene.pours else []


def law(scene: Scene) -> list[tuple[str, list[str]]]:
    """Sections of the contact law, neighbours, motion and walls."""
    return [
        ("contact law: stiffness, gamma_n = c/m_eff, gamma_t, friction", contact_law(scene)),
        ("neighbours", neighbours(scene)),
        ("motion", motion(scene)),
        ("walls", [line.replace(" all wall/gran", f" {moving_group(scene)} wall/gran") for line in stock_walls(scene)]),
        ("rough beds: after all that pushes discs", ["fix             fixed bed freeze"] if scene.fixed else []),
    ]


def contact_law(scene: Scene) -> list[str]:
    """gran/hooke with gamma = c/m_eff; friction only where there is some.

    Discs that are not equal need the dashpot c = 2 xi sqrt(k m_eff) of each pair. gran/hooke has c = gamma m_eff, which
    gives heavy pairs another restitution than light ones (measured: 0.198 at equal masses, 0.536 at 1 : 10).
    """
    c = scene.coefficients
    if scene.sizes or scene.springs:
        nominal = WallLaw(c.stiffness, c.gamma_normal, c.gamma_tangential, c.friction)
        springs = spring_words(scene, nominal, 0.5 * c.mass)
        law = granular_law(c.stiffness, c.damping_ratio * c.correction, c.tangential_ratio, c.friction, springs)
        return ["pair_style      granular", f"pair_coeff      * * {law}"]
    friction_words = f"{numbers(c.gamma_tangential, c.friction)} 1" if c.friction else "0 0 0"
    return [
        f"pair_style      gran/hooke {number(c.stiffness)} NULL {number(c.gamma_normal)} {friction_words}",
        "pair_coeff      * *",
    ]


def neighbours(scene: Scene) -> list[str]:
    """Neighbour lists, rebuilt when a disc has moved half the skin; discs that roll keep their order in memory."""
    return [
        f"neighbor        {number(scene.skin)} bin",
        *(["atom_modify     sort 0 0"] if _rolls(scene) else []),
        "neigh_modify    delay 0 every 1 check yes",
    ]


def moving_group(scene: Scene) -> str:
    """Group of the discs that move; inserted ones join no group: there ``fix freeze`` alone holds the fixed ones."""
    return "free" if scene.fixed and not (scene.inlets or scene.pours) else "all"


def motion(scene: Scene) -> list[str]:
    """Time step, integration and gravity."""
    lines = [
        f"timestep        {number(scene.time_step)}",
        f"fix             motion {moving_group(scene)} {'nve/sphere disc' if scene.rotation else 'nve'}",
    ]
    return lines + gravity(scene)


def gravity(scene: Scene) -> list[str]:
    """Gravity, where there is some."""
    strength = (scene.gravity[0] ** 2 + scene.gravity[1] ** 2) ** 0.5
    if not strength:
        return []
    return [f"fix             gravity all gravity {number(strength)} vector {numbers(*scene.gravity)} 0"]


def outlets(scene: Scene) -> list[str]:
    """Regions in which discs are deleted; the fixes' scalars count them."""
    lines, seed = [], max(1, scene.seed)
    for index, outlet in enumerate(scene.outlets, 1):
        ends = f"{number(outlet.at)} INF" if outlet.side == "above" else f"INF {number(outlet.at)}"
        extent = f"{ends} INF INF" if outlet.axis == "x" else f"INF INF {ends}"
        lines += [
            f"region          outlet_{index} block {extent} INF INF",
            f"fix             outlet_{index} all evaporate {outlet.every_steps} 1000000 outlet_{index} {seed}",
        ]
    return lines


def inlets(scene: Scene) -> list[str]:
    """One ``fix deposit`` for each row: a point as region (flat in z too), a disc as molecule, ids in turn.

    A molecule has one diameter, the largest. Where discs are not equal, `own_sizes` gives them their own.
    """
    lines = []
    for index, row in enumerate(scene.inlets, 1):
        count = row.limit or (scene.steps - row.first_step) // row.every_steps + 2
        fall = f" vy {numbers(row.vy, row.vy)}" if row.vy else ""
        lines += [
            f"region          inlet_{index} block {numbers(row.x, row.x, row.y, row.y)} 0 0",
            f"fix             inlet_{index} all deposit {count} 0 {row.every_steps} {scene.seed + index} "
            f"region inlet_{index} mol disk id max near {number(row.clearance)} attempt 1 "
            f"vx {numbers(row.vx, row.vx)}{fall}",
        ]
    return [*lines, *own_sizes(scene)] if lines else []


def own_sizes(scene: Scene) -> list[str]:
    """``fix set`` gives inserted discs their own diameter and mass, where discs are not equal."""
    return [f"fix             size all set {scene.size_steps} 0 group all {SIZE}"] if scene.sizes else []


def pours(scene: Scene, sizes: list[str]) -> list[str]:
    """fix pour for filling; a mol template keeps mass and diameter exact.

    ``diam poly`` of fix pour would give masses of spheres, which grow as d^3.
    """
    lines, half = [], 0.5 * scene.largest
    for index, item in enumerate(scene.pours, 1):
        lines += [
            f"region          pour_{index} block {numbers(*item.x, *item.y, -half, half)}",
            f"fix             pour_{index} all pour {item.count} 0 {scene.seed + 100 + index} region pour_{index} "
            f"mol disk vol {number(item.volume_fraction)} 200 vel 0 0 {number(-item.speed_down)}",
        ]
    return [*lines, *sizes] if lines else []


def output(scene: Scene, dump_format: str) -> list[str]:
    """Dump with ten digits (six are the default), simulated time in each frame, discs in order of their id."""
    style = "custom/gz" if dump_format == "gz" else "custom"
    digits = "" if dump_format == "binary" else " format float %.10g"
    return [
        f"dump            frames all {style} {scene.output_steps} {DUMP_NAMES[dump_format]} "
        f"{' '.join(scene.dump_columns)}",
        f"dump_modify     frames sort id time yes{digits}",
    ]


def guards(scene: Scene) -> list[str]:
    """Guards that end a run that has gone wrong: discs too deep in each other, lost to NaN, or out of the plane.

    No compute of LAMMPS gives the overlap of discs that are not equal: that of the smallest is used, so that
    larger ones overlap deeper before the run ends.
    """
    return [
        "compute         gaps all pair/local dist cutoff radius",
        "compute         gap all reduce min c_gaps inputs local",
        *guards_of(scene, f"{number(scene.smallest)}-c_gap"),
        "variable        height atom abs(z)",
        "compute         height all reduce max v_height",
        "variable        height_max equal c_height",
        f"fix             guard_plane all halt {_guard_steps(scene)} v_height_max > 0 error hard",
    ]


def guards_of(scene: Scene, overlap: str) -> list[str]:
    """Guards that end a run whose largest overlap, by a formula, is too large, or whose positions are no numbers."""
    every = _guard_steps(scene)
    return [
        f"variable        overlap equal {overlap}",
        f"fix             guard_overlap all halt {every} v_overlap > {number(scene.overlap_limit)} error hard",
        # a comparison with NaN is false: the sum of all positions must be a number
        "variable        finite equal xcm(all,x)+xcm(all,y)<1e300",
        f"fix             guard_finite all halt {every} v_finite == 0 error hard",
    ]


def _guard_steps(scene: Scene) -> int:
    return max(1, scene.output_steps // GUARDS_PER_FRAME)


def thermo(scene: Scene, removed: tuple[int, ...] = ()) -> list[str]:
    """Log lines with the disc balance; the style first, because it resets what thermo_modify says.

    The highest id counts all discs so far (ids are given in turn, ``id max``). `removed` is the number that each outlet
    took in earlier parts of an interrupted run; the names of the columns stay the same.
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


def schedule(scene: Scene, gates: list[str], inlets: list[str], kernel: str) -> list[str]:
    """Gates and the run; inlets that begin later need a second run, which begins without the gates' fixes.

    Inlets wait for gates. Where discs are not equal they also wait for a step of the raster on which ``fix set`` acts.
    The second run goes on with the forces of the half step, as `lammps_jump.script.assemble` explains.
    """
    first = first_step(scene)
    if not first:
        return [*gates, *inlets, f"run             {scene.steps}"]
    change = [*(f"unfix           {name}" for name in fix_names(gates)), *inlets]
    rest = f"run             {scene.steps - first}"
    if len(scene.positions):
        return [*gates, f"run             {first}", *between_runs(scene, kernel, change), f"{rest} pre no"]
    # without a disc LAMMPS knows no cutoff and makes too many bins
    bins = f"neigh_modify    binsize {number(0.5 * (scene.largest + scene.skin))}"
    return [bins, *gates, f"run             {first}", *change, rest]


def first_step(scene: Scene) -> int:
    """Step after which inlets begin; 0 where they do at once. No checkpoint is written up to it."""
    return max(0, min((row.first_step - 1 for row in scene.inlets), default=0))


def between_runs(scene: Scene, kernel: str, change: list[str]) -> list[str]:
    """Commands that define or take away fixes between two runs, the second of which is ``run … pre no``."""
    return [*half_step(scene, kernel, "-"), *change, *first_forces(scene, kernel), *half_step(scene, kernel)]


def half_step(scene: Scene, kernel: str, sign: str = "+") -> list[str]:
    """Velocities of the half step to those of the step, with the present forces; `sign` "-" for the way back.

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
        turn = f"{number(0.5 * scene.time_step / (scene.coefficients.inertia * scene.radius**2))}*f_turning[2]"
        if scene.sizes:  # I = m R^2/2 of each disc
            turn = f"{number(scene.time_step)}*f_turning[2]/(mass*radius*radius)"
        lines += [
            "fix             turning all store/state 0 omegaz tqz",
            f"variable        half_w atom f_turning[1]{sign}{turn}",
            "set             group all omega 0 0 v_half_w",
            "unfix           turning",
        ]
    if scene.fixed and kernel == "compiled":
        lines.append(f"set             group bed vx 0 vy 0{' omega 0 0 0' if scene.rotation else ''}")
    return lines
