# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene: numbers of a case that both engines take and the analysis reads."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from math import isinf, nan, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.core.law import LawNumbers
from lammps_jump.identity import LATER
from lammps_jump.physics.contact import Coefficients, ContactNumbers, WallLaw, derive, stiffness
from lammps_jump.physics.inlet import Hydrograph
from lammps_jump.physics.slip import FRICTION_LAWS, Springs, slots_of

from .motion import STILL, MovingWall, Pose, WallState, arms
from .pressed import FaceStretch
from .sizes import Sizes
from .walls import Interval, Wall

STABILITY_MEAN = 0.1
"""Time of the moving mean over which least factors of safety are given, where a case has none, s."""


@dataclass(frozen=True, slots=True)
class InletRow:
    """One row of inflow: a disc enters at (x, y) with velocity (vx, vy).

    It enters with the largest diameter of the scene (see `Scene.size_steps`).

    Attempts are made at the steps ``first_step + i every_steps`` (i = 0, 1, …). An attempt succeeds unless a
    centre lies closer than `clearance` to (x, y) or `limit` discs have entered; a refused one waits for the
    next turn. A disc enters after the drift of that step and before its forces (LAMMPS' ``pre_exchange``).

    A row of an inflow against time has `turns`, the steps of its attempts in their order, and `speeds`, the velocity
    along x that each of them gives, m/s. Then `vx` is the largest of them, `first_step` the first turn and
    `every_steps` the mean time between turns over the run.
    """

    x: float
    y: float
    vx: float
    vy: float
    first_step: int
    every_steps: int
    clearance: float
    limit: int | None = None
    turns: tuple[int, ...] = ()
    speeds: tuple[float, ...] = ()

    def turns_until(self, step: int) -> Sequence[int]:
        """Steps of its attempts up to a step, if all succeed."""
        if self.turns:
            return self.turns[: bisect_right(self.turns, step)]
        return range(self.first_step, step + 1, self.every_steps)[: self.limit]

    def turns_around(self, step: int) -> tuple[int, int] | None:
        """Steps of the last attempt up to a step and of the first one after it; None where one of them is missing."""
        if self.turns:
            place = bisect_right(self.turns, step)
            return (self.turns[place - 1], self.turns[place]) if 0 < place < len(self.turns) else None
        done = (step - self.first_step) // self.every_steps
        if done < 0 or (self.limit is not None and done + 1 >= self.limit):
            return None
        last = self.first_step + done * self.every_steps
        return last, last + self.every_steps

    def speed_at(self, step: int) -> float:
        """Velocity along x of a disc that enters at a step, m/s; of an inflow against time at the last turn by then."""
        return self.speeds[max(0, bisect_right(self.turns, step) - 1)] if self.turns else self.vx


@dataclass(frozen=True, slots=True)
class Pour:
    """Discs dropped at random places of a region, for filling a container (LAMMPS ``fix pour``)."""

    x: Interval
    y: Interval
    count: int
    volume_fraction: float
    speed_down: float


@dataclass(frozen=True, slots=True)
class Outlet:
    """A half-plane where discs are taken out, every `every_steps` steps; never inside the studied flow.

    Discs with ``coordinate > at`` (side 'above') or ``< at`` (side 'below') leave, before the forces of the step.
    """

    axis: str
    at: float
    side: str
    every_steps: int


@dataclass(frozen=True, slots=True)
class Stations:
    """Two upright planes at `x` (m) at `first_step`, which move at `speed` (m/s) along x until `last_step`."""

    x: Interval
    speed: float
    first_step: int
    last_step: int


@dataclass(frozen=True, slots=True)
class WallWeight:
    """Weight and strength of a wall at rest: density over its outline (kg/m^3), friction of its base."""

    density: float
    friction: float


@dataclass(frozen=True, slots=True)
class Fixed:
    """Discs of rough beds, which stay: their first and last id."""

    first: int
    last: int

    @property
    def count(self) -> int:
        """Number of them."""
        return self.last - self.first + 1

    def holds(self, ids: ArrayLike) -> np.ndarray:
        """Mask of the ids that are those of fixed discs; shape of `ids`."""
        ids = np.asarray(ids)
        return (ids >= self.first) & (ids <= self.last)


CONTACT = np.dtype([("disc", np.int64), ("partner", np.int64), *((name, float) for name in ("foot", "spring", "roll"))])
"""A contact that a disc remembers, of two discs that with the larger id: a slot of `lammps_jump.physics.law`."""


@dataclass(frozen=True, eq=False)
class EarlierState:
    """State that the n discs at the start have of an earlier run, without place, velocity and diameter.

    Attributes
    ----------
    spins : ndarray, shape (n,)
        rad/s.
    half : ndarray, shape (n, 3)
        Velocity (m/s) and spin (rad/s) of the half step before the start; NaN of discs that have none.
    contacts : ndarray of CONTACT
        Contacts that go on. A partner -1 - c means the chain ``chains[c]``.
    chains : tuple of str
        Names of chains, as `Scene.chains`.
    exact : mapping of str to ndarray
        What an engine of the same kind needs to go on bit for bit, where all discs are there as they were.
    origins : tuple of str
        Where they come from, in words.
    walls : mapping of str to Went
        What walls whose pose is state have of that run, by name; the scene has it with their motions.
    corners : ndarray of CONTACT
        Contacts of corners of walls with faces, which go on: `disc` counts `corner_names` from 1, `partner` is as
        above.
    corner_names : tuple of str
        As `lammps_jump.scene.meeting.corner_names`.
    """

    spins: np.ndarray
    half: np.ndarray
    contacts: np.ndarray
    chains: tuple[str, ...]
    exact: Mapping[str, np.ndarray]
    origins: tuple[str, ...]
    walls: Mapping[str, WallState] = field(default_factory=dict)
    corners: np.ndarray = field(default_factory=lambda: np.empty(0, CONTACT))
    corner_names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Text with the hash of all numbers, by which scenes are distinguished."""
        digest = sha256(repr(self.chains).encode())
        for array in (self.spins, self.half, self.contacts, *self.exact.values(), self.corners):
            digest.update(array.tobytes())
        return f"Earlier({digest.hexdigest()})"

    def slots(self, count: int) -> dict[str, np.ndarray]:
        """Contact history of each disc, arrays of shape (n, count), named as `lammps_jump.physics.law.Slots`."""
        return _slots(self.contacts, len(self.spins), count)

    def corner_slots(self, count: int) -> dict[str, np.ndarray]:
        """The same of each corner."""
        return _slots(self.corners, len(self.corner_names), count)


def _slots(contacts: np.ndarray, number: int, count: int) -> dict[str, np.ndarray]:
    """Contacts in the slots of so many discs or corners, `count` each."""
    slots = {name: np.zeros((number, count)) for name in ("sigma", "spring", "roll")}
    slots["partner"] = np.zeros((number, count), np.int64)
    rows = contacts[np.argsort(contacts["disc"], kind="stable")]
    slot = np.arange(len(rows)) - np.searchsorted(rows["disc"], rows["disc"])
    rows, slot = rows[slot < count], slot[slot < count]
    for name, own in (("partner", "partner"), ("sigma", "foot"), ("spring", "spring"), ("roll", "roll")):
        slots[name][rows["disc"] - 1, slot] = rows[own]
    return slots


def chains_of(walls: Iterable[MovingWall]) -> tuple[str, ...]:
    """Names of the chains of walls as contacts remember them: the wall, and the number of the chain there."""
    return tuple(f"{wall.name}:{number}" for wall, _ in walls for number in range(len(wall.chains())))


class Measures:
    """Sizes and times that follow from few fields of a scene."""

    diameter: float
    coefficients: Coefficients
    sizes: Sizes | None
    steps: int
    settle_steps: int

    @property
    def largest(self) -> float:
        """Largest diameter, m."""
        return self.sizes.largest if self.sizes else self.diameter

    @property
    def smallest(self) -> float:
        """Smallest diameter, m."""
        return self.sizes.smallest if self.sizes else self.diameter

    @property
    def mean_square(self) -> float:
        """Mean squared diameter by number, m^2: the area that a disc represents."""
        return self.sizes.mean_square if self.sizes else self.diameter * self.diameter

    def diameters(self, ids: ArrayLike) -> np.ndarray:
        """Diameter of each id, m; shape of `ids`."""
        return self.sizes.diameters(ids) if self.sizes else np.full(np.shape(ids), self.diameter)

    @property
    def time_step(self) -> float:
        """Time step, s."""
        return self.coefficients.time_step

    def time(self, step: float) -> float:
        """Simulated time of a step, s."""
        return (step - self.settle_steps) * self.time_step

    def discharges_of(self, rows: tuple[InletRow, ...]) -> tuple[float, ...]:
        """Discharge of inlet rows in whole steps, without refused turns, m^2/s: mean squared diameter by time.

        Against time it is the mean over the run.
        """
        steps = self.steps - self.settle_steps
        each = (steps / len(row.turns) if row.turns else row.every_steps for row in rows)
        return tuple(self.mean_square / (every * self.time_step) for every in each)


@dataclass(frozen=True)
class InitialState(Measures):
    """Beginning of a scene: discs at the start, their contact, and steps; fields as of `Scene`."""

    diameter: float
    sizes: Sizes | None
    coefficients: Coefficients
    overlap_limit: float
    positions: np.ndarray
    velocities: np.ndarray
    steps: int
    settle_steps: int
    output_steps: int
    probe_steps: int
    stiffer: str
    fixed: Fixed | None = None
    beds: tuple[Wall, ...] = ()
    earlier: EarlierState | None = None


@dataclass(frozen=True)
class Scene(Measures):
    """A case in engine-neutral numbers (SI).

    Step numbers count from the first step of the run; simulated time is ``(step - settle_steps) * dt``, so that
    gates open at t = 0.

    Attributes
    ----------
    diameter : float
        Nominal diameter, m; of every disc where there are no `sizes`.
    coefficients : Coefficients
        Of a contact of two nominal discs, and of one with a wall. Its time step suits the smallest discs.
    gravity : (float, float)
        Acceleration (gx, gy), m/s^2; (0, 0) means that no engine spends time on it.
    positions, velocities : ndarray, shape (n, 2)
        Discs at the start, read-only; their ids are 1 … n in this order.
    walls : tuple of MovingWall
        Each wall with its motion; a `Wall` given alone is at rest. A gate is a wall whose motion takes it away.
    hydrograph : Hydrograph, optional
        The inflow against time that the rows carry out; without it they are steady.
    probes : tuple of str
        Names of walls whose force is recorded every step and averaged over `probe_steps`; those of groups are added.
    groups : tuple of (str, tuple of str)
        Names of groups and of their walls, whose forces are summed.
    gauges : tuple of float
        Places along x where the analysis follows the depth, m.
    pressure : tuple of FaceStretch
        Stretches of outlines, in the order of the walls, over which the native engine sums forces at every step.
    stability : tuple of (str, Weighed)
        Walls that are looked at as if they had this weight, by name; their forces are recorded too.
    stability_mean : float
        Time of the moving mean over which least factors of safety are given, s.
    stations : Stations, optional
        Between them the native engine keeps an energy budget.
    sizes : Sizes, optional
        Diameters where discs are not equal.
    fixed : Fixed, optional
        Ids of the discs of rough beds. Their diameter is in `sizes`, which such a scene always has.
    beds : tuple of Wall
        Lines over the tops of rough beds, which push no disc: for what asks for the bed.
    earlier : Earlier, optional
        What discs at the start have of an earlier run.
    periodic : bool
        What leaves the domain along x enters at its other end.
    size_steps : int
        A disc that an inlet or a pour inserts has the largest diameter. At the end of the next step that is a multiple
        of this number it gets its own.
    own_laws : mapping of str to WallLaw
        Contact of walls that have numbers of their own, by name.
    springs : Springs, optional
        Of a contact law with memory.
    cohesion : float
        Constant attraction of two discs, or of a disc and a wall, while they touch, N per m of width.
    slots : int
        Contacts that a disc remembers; 0: the contact law has no memory.
    contact_output : bool
        The native engine and the compiled kernel write the contacts of each frame with their forces
        (`lammps_jump.dump.contacts`).
    warnings, adapted : tuple of str
        What to beware of; which requested values whole steps have changed.
    stiffer : str
        Advice: what makes the contacts of the case stiffer.
    steps : int
        All steps of the run, `settle_steps` included; output every `output_steps`.
    """

    name: str
    description: str
    diameter: float
    density: float
    gravity: tuple[float, float]
    coefficients: Coefficients
    friction_law: str
    rotation: bool
    integrator: str
    domain: tuple[Interval, Interval]
    positions: np.ndarray
    velocities: np.ndarray
    walls: tuple[MovingWall, ...]
    inlets: tuple[InletRow, ...] = ()
    hydrograph: Hydrograph | None = None
    pours: tuple[Pour, ...] = ()
    outlets: tuple[Outlet, ...] = ()
    probes: tuple[str, ...] = ()
    stations: Stations | None = None
    steps: int = 0
    settle_steps: int = 0
    output_steps: int = 1
    probe_steps: int = 1
    seed: int = 1
    skin: float = 0.0
    overlap_limit: float = 0.0
    touch: str = "sharp"
    touch_width: float = 0.0
    cohesion: float = field(default=0.0, metadata=LATER)
    sizes: Sizes | None = None
    size_steps: int = 1
    fixed: Fixed | None = None
    beds: tuple[Wall, ...] = ()
    periodic: bool = False
    own_laws: Mapping[str, WallLaw] = field(default_factory=dict)
    springs: Springs | None = None
    slots: int = 0
    contact_output: bool = False
    skipped: tuple[str, ...] = field(default=())
    warnings: tuple[str, ...] = field(default=())
    adapted: tuple[str, ...] = field(default=())
    stiffer: str = "make the contacts stiffer"
    groups: tuple[tuple[str, tuple[str, ...]], ...] = ()
    gauges: tuple[float, ...] = ()
    pressure: tuple[FaceStretch, ...] = field(default=(), metadata=LATER)
    stability: tuple[tuple[str, WallWeight], ...] = ()
    stability_mean: float = STABILITY_MEAN
    earlier: EarlierState | None = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        """Keeps walls given alone at rest; records what is weighed and groups; CaseError where these move apart."""
        walls = tuple(MovingWall(one) if isinstance(one, Wall) else one for one in self.walls)
        object.__setattr__(self, "walls", walls)
        if self.springs is not None and not self.slots:
            object.__setattr__(self, "slots", slots_of(self.smallest, self.largest))
        if self.stability:
            weighed = (name for name, _ in self.stability)
            object.__setattr__(self, "probes", tuple(dict.fromkeys((*self.probes, *weighed))))
        if self.groups:
            members = (member for _, group in self.groups for member in group)
            object.__setattr__(self, "probes", tuple(dict.fromkeys((*self.probes, *members))))
            by_name = {one.wall.name: one for one in walls}
            for name, group in self.groups:
                arms(name, [by_name[member] for member in group])

    @property
    def has_windows(self) -> bool:
        """Tells whether forces are recorded over windows of steps: of walls, of bodies, or along outlines."""
        return bool(self.probes or self.bodies or self.pressure)

    @property
    def period(self) -> float | None:
        """Length of a periodic channel, m; None of another."""
        return self.domain[0][1] - self.domain[0][0] if self.periodic else None

    def crosses(self, wall: Wall) -> bool:
        """Tells whether a wall goes across the seam of a periodic channel."""
        (low, high), (left, right) = wall.extent[0], self.domain[0]
        return self.periodic and low <= left and right <= high

    @property
    def chains(self) -> tuple[str, ...]:
        """Names of the chains of its walls."""
        return chains_of(self.walls)

    @property
    def radius(self) -> float:
        """Nominal radius, m."""
        return 0.5 * self.diameter

    @property
    def mass(self) -> float:
        """Nominal mass per metre of width, kg."""
        return self.coefficients.mass

    @property
    def mean_mass(self) -> float:
        """Mean mass of a disc by number, kg/m."""
        return self.density * self.mean_square

    @property
    def expected_discs(self) -> int:
        """Discs in play at the end if none leaves: those at the start and all that the inlets can bring."""
        steps = self.steps - self.settle_steps
        brought = sum(row.limit or len(row.turns) or steps // row.every_steps for row in self.inlets)
        return len(self.positions) + brought + sum(item.count for item in self.pours)

    @property
    def most_discs(self) -> int:
        """Largest id that a disc can have, where rows let in as many as they have turns."""
        turns = sum(len(row.turns) or self.steps // row.every_steps + 1 for row in self.inlets)
        return max(self.expected_discs, len(self.positions) + turns)

    @property
    def drawn_discs(self) -> int:
        """Of `expected_discs` those whose diameter is drawn: not of rough beds, nor of an earlier run."""
        own = sum(last - first + 1 for first, last, _ in self.sizes.own) if self.sizes else 0
        return self.expected_discs - own - (len(self.sizes.given) if self.sizes else 0)

    @property
    def discharges(self) -> tuple[float, ...]:
        """`discharges_of` the inlets, m^2/s."""
        return self.discharges_of(self.inlets)

    def pour_turns(self, pour: Pour) -> range:
        """Steps at which a pour lets discs in: again when its region of height H is empty, as LAMMPS' fix pour.

        t = (sqrt(v^2 + 2 g H) - v) / g
        """
        v, g, height = pour.speed_down, max(0.0, -self.gravity[1]), pour.y[1] - pour.y[0]
        clear = (sqrt(v * v + 2 * g * height) - v) / g if g > 0 else height / v
        return range(1, self.steps + 1, max(1, round(clear / self.time_step)))

    def masses(self, diameters: ArrayLike) -> np.ndarray:
        """Mass of discs of these diameters (m), kg/m; shape of `diameters`."""
        return self.density * np.square(np.asarray(diameters, float))

    @property
    def dump_columns(self) -> tuple[str, ...]:
        """Columns of the dump, in order: spin where discs have one, radii where they are not equal."""
        return ("id", "x", "y", "vx", "vy", *(["omegaz"] * self.rotation), *(["radius"] * bool(self.sizes)))

    @property
    def standing(self) -> tuple[MovingWall, ...]:
        """Walls that are never taken away."""
        return tuple(one for one in self.walls if isinf(one.motion.gone))

    @property
    def permanent(self) -> tuple[Wall, ...]:
        """The same without bodies, where the case has them, without their motion, and the lines of rough beds."""
        return (*(one.wall for one in self.standing if not one.motion.free), *self.beds)

    @property
    def bodies(self) -> tuple[MovingWall, ...]:
        """Bodies, which are among its walls."""
        return tuple(one for one in self.walls if one.motion.free)

    @property
    def gates(self) -> tuple[MovingWall, ...]:
        """Walls that are taken away."""
        return tuple(one for one in self.walls if not isinf(one.motion.gone))

    def walls_at(
        self, step: float, loaded: Mapping[str, Pose] | None = None, rates: Mapping[str, Pose] | None = None
    ) -> tuple[Wall, ...]:
        """Walls that are there at a step, where they are.

        `loaded` are the poses of walls that the discs push, by name, and `rates` their velocities, 0 where not given.
        """
        poses, speeds = loaded or {}, rates or {}
        walls = (one.at(step, poses.get(one.wall.name), speeds.get(one.wall.name, STILL)) for one in self.walls)
        return tuple(wall for wall in walls if wall is not None)

    def wall_law(self, name: str) -> WallLaw:
        """Contact with the wall of that name."""
        return self.own_laws.get(name, self.coefficients.wall_law)

    def law_numbers(self, wall: str | None = None, *, sized: bool | None = None) -> LawNumbers:
        """Numbers of the law of two discs or, with its name, of a disc and a wall.

        Those of a size of 1 m where `sized`, which the scene's discs tell unless it is given.
        """
        c, mass = self.coefficients, self.mass
        own, effective = self.wall_law(wall) if wall else c.pair_law, mass if wall else 0.5 * mass
        damping, tangential = effective * own.gamma_normal, effective * own.gamma_tangential
        if (self.sizes is not None) if sized is None else sized:
            damping = sqrt(mass) / self.radius * (own.gamma_normal * sqrt(effective))
            # without a dashpot springs with memory have none along the contact either; the other laws are refused
            rubs = own.friction and own.gamma_normal
            tangential = own.gamma_tangential / own.gamma_normal * damping if rubs else 0.0
        springs, roll = self.springs, self.springs.rolling if self.springs else None
        return LawNumbers(
            stiffness=own.stiffness,
            damping=damping,
            tangential=tangential,
            friction=own.friction if self.rubs else nan,
            sign_ramp=FRICTION_LAWS[self.friction_law].ramp or 0.0 if self.rubs else 0.0,
            touch=self.touch_width if self.touch == "smooth" else 0.0,
            cohesion=self.cohesion,
            spring_ratio=springs.tangential_ratio if springs else 0.0,
            spring_damping=springs.tangential_damping_ratio if springs else 0.0,
            rolling=roll.stiffness_ratio * own.stiffness if roll else 0.0,
            rolling_damping=roll.damping * effective * own.gamma_normal if roll else 0.0,
            rolling_friction=(roll.friction if own.rolling is None else own.rolling) if roll else 0.0,
        )

    @property
    def rubs(self) -> bool:
        """Tells whether anything has friction."""
        return (
            self.springs is not None
            or self.coefficients.friction > 0
            or any(law.friction > 0 for law in self.own_laws.values())
        )

    @property
    def moves(self) -> bool:
        """Tells whether any wall moves."""
        return any(motion.kind is not None for _, motion in self.walls)

    @property
    def lids(self) -> tuple[str, ...]:
        """Names of the walls whose pose is state of the run: those that discs push, and tailgates."""
        return tuple(wall.name for wall, motion in self.walls if motion.is_state)

    def wall(self, name: str) -> Wall:
        """The wall of that name; KeyError for an unknown one."""
        return {wall.name: wall for wall, _ in self.walls}[name]


OF_A_HANDMADE = {
    "restitution": 0.2,
    "friction": 0.0,
    "time_step_fraction": 0.05,
    "integrator": "velocity_verlet",
    "correct_restitution": False,
    "rotation": False,
    "tangential_damping": None,
    "touch": "sharp",
}
"""Fields of `lammps_jump.physics.contact.ContactNumbers` unless given."""


def handmade_scene(
    positions: ArrayLike,
    velocities: ArrayLike,
    walls: tuple[Wall | MovingWall, ...] = (),
    *,
    diameter: float = 0.2,
    density: float = 1000.0,
    largest_overlap: float = 0.1,
    impact_speed: float = 16.0,
    **others: Any,
) -> Scene:
    """A `Scene` from discs, walls and contact parameters.

    Parameters
    ----------
    positions, velocities : array_like, shape (n, 2)
        m, m/s.
    walls : tuple of Wall or MovingWall
        A `Wall` is at rest.
    diameter, density : float
        m, kg/m^3.
    largest_overlap, impact_speed : float
        Over the diameter (1/n), and v0 (m/s), of thesis (3.20), for the stiffness of discs and walls.
    others
        `stiffness_wall` (N/m; that of disc pairs unless given), further fields of the contact (`OF_A_HANDMADE`) and of
        `Scene` (sizes, steps, inlets, outlets, probes …). Unless given, the domain extends to 100 m on all sides, and
        the overlap limit is twice the largest overlap.
    """
    k = stiffness(density, largest_overlap, impact_speed)
    law = {name: others.get(name, value) for name, value in OF_A_HANDMADE.items()}
    springs = others.get("springs")
    contact = ContactNumbers(
        density=density,
        diameter=diameter,
        stiffness=k,
        stiffness_wall=others.pop("stiffness_wall", None) or k,
        impact_speed=impact_speed,
        smallest=sizes.smallest if (sizes := others.get("sizes")) else None,
        tangential_damping_ratio=springs.tangential_damping_ratio if springs else None,
        **law,
    )
    fields = {
        "name": "handmade",
        "description": "",
        "gravity": (0.0, -9.81),
        "friction_law": "viscous",
        "domain": ((-100.0, 100.0), (-100.0, 100.0)),
        "overlap_limit": 2.0 * diameter * largest_overlap,
        **{name: law[name] for name in ("rotation", "integrator", "touch")},
        **{name: value for name, value in others.items() if name not in OF_A_HANDMADE},
    }
    return Scene(
        diameter=diameter,
        density=density,
        coefficients=derive(contact),
        positions=np.asarray(positions, float).reshape(-1, 2),
        velocities=np.asarray(velocities, float).reshape(-1, 2),
        walls=walls,  # type: ignore[arg-type]  # the scene keeps plain walls at rest
        **fields,
    )
