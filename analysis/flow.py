"""What an analysis must know of a flow beyond the dump: discs, walls, gravity, where to look and when."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import hypot

import numpy as np

from lammps_jump.dump.frame import Frame
from lammps_jump.scene.scene import Gate, InletRow, Outlet, Scene
from lammps_jump.scene.walls import Floor, Interval, Wall


@dataclass(frozen=True)
class FlowContext:
    """A flow as the analysis sees it; made by `from_scene` or `from_dump`.

    Attributes
    ----------
    name : str
    diameter, mass, density : float
        m; kg per metre of width; kg/m^3.
    gravity : (float, float)
        m/s^2.
    domain : ((float, float), (float, float))
        m.
    x_range : (float, float)
        The stretch that profiles cover, m: from the inlet to the outlet, else as far as walls and discs go.
    walls : tuple of Wall
        Permanent walls.
    gates : tuple of Gate
        Walls that are taken away at a step.
    inlets, outlets : tuple
    time_step : float or None
        s.
    settle_steps : int
        Steps before t = 0.
    stiffness, stiffness_wall : float or None
        N/m; None where nothing tells (then no elastic energy and no contact stress).
    dashpot, dashpot_wall : float
        N s/m of a pair and of a disc at a wall, as the engine used them (0 where nothing tells).
    restitution, friction : float or None
    gamma_tangential : float
        1/s, LAMMPS' friction ramp.
    friction_law, touch : str
    touch_width : float
        m.
    rotation : bool
    inflow_depth, inflow_speed : float or None
        y1 (m) and Va (m/s) where discs flow in by rows.
    duration : float or None
        s.
    bin_width : float
        m.
    window : (float, float) or None
        Times over which means are taken, s; None: the second half of the frames.
    probes : tuple of str
        Walls whose force was recorded.
    engine : str or None
    notes : tuple of str
        What was guessed, in sentences.
    """

    name: str
    diameter: float
    mass: float
    density: float
    gravity: tuple[float, float]
    domain: tuple[Interval, Interval]
    x_range: Interval
    walls: tuple[Wall, ...] = ()
    gates: tuple[Gate, ...] = ()
    inlets: tuple[InletRow, ...] = ()
    outlets: tuple[Outlet, ...] = ()
    time_step: float | None = None
    settle_steps: int = 0
    stiffness: float | None = None
    stiffness_wall: float | None = None
    dashpot: float = 0.0
    dashpot_wall: float = 0.0
    restitution: float | None = None
    friction: float | None = None
    gamma_tangential: float = 0.0
    friction_law: str = "hooke"
    touch: str = "sharp"
    touch_width: float = 0.0
    rotation: bool = False
    inflow_depth: float | None = None
    inflow_speed: float | None = None
    duration: float | None = None
    bin_width: float = 1.0
    window: tuple[float, float] | None = None
    probes: tuple[str, ...] = ()
    engine: str | None = None
    notes: tuple[str, ...] = field(default=())

    @property
    def radius(self) -> float:
        """Disc radius, m."""
        return 0.5 * self.diameter

    @property
    def g(self) -> float:
        """Magnitude of gravity, m/s^2."""
        return hypot(*self.gravity)

    def time(self, frame: Frame) -> float:
        """Simulated time of a frame, s: the file's own, else from the step, else the step number itself."""
        if frame.time is not None:
            return frame.time
        if self.time_step is not None:
            return (frame.step - self.settle_steps) * self.time_step
        return float(frame.step)

    def wall(self, name: str) -> Wall:
        """The wall or gate of that name; KeyError where there is none."""
        for wall in (*self.walls, *(gate.wall for gate in self.gates)):
            if wall.name == name:
                return wall
        raise KeyError(name)

    def shut_gates(self, time: float) -> tuple[Wall, ...]:
        """Gates that are still there at a time, s."""
        step_time = self.time_step or 0.0
        return tuple(gate.wall for gate in self.gates if time < (gate.release_step - self.settle_steps) * step_time)

    def walls_at(self, time: float) -> tuple[Wall, ...]:
        """Walls that stand at a time (s), gates that are still shut among them."""
        return (*self.walls, *self.shut_gates(time))

    def bed_height(self, x: np.ndarray | float) -> np.ndarray:
        """Height of the floor at x, m; NaN where nothing lies below.

        It is the highest of the walls' floors that those below carry without a gap that a disc could pass, tried from
        the lowest underside up. A solid above such a gap (a sluice gate) is no floor.

        Parameters
        ----------
        x : array_like, m

        Returns
        -------
        ndarray of x's shape, m
        """
        x = np.asarray(x, float)
        bed = np.full(x.shape, -np.inf)
        for floor in sorted(self._floors(), key=lambda floor: floor.underside):
            carried = np.isinf(bed) | (floor.underside <= bed + self.diameter)
            here = (x >= floor.x[0]) & (x <= floor.x[1]) & carried
            bed = np.where(here, np.maximum(bed, floor.top), bed)
        return np.where(np.isinf(bed), np.nan, bed)

    def _floors(self) -> list[Floor]:
        return [floor for wall in self.walls for floor in wall.floors()]

    def mean_bed(self, edges: np.ndarray) -> np.ndarray:
        """Mean floor height of each bin, m: exact for piecewise level floors; NaN where any part has no floor.

        Parameters
        ----------
        edges : ndarray, shape (bins + 1,), m

        Returns
        -------
        ndarray, shape (bins,), m
        """
        ends = [x for floor in self._floors() for x in floor.x]
        cuts = np.unique(np.concatenate([edges, [x for x in ends if edges[0] < x < edges[-1]]]))
        middle, width = 0.5 * (cuts[1:] + cuts[:-1]), np.diff(cuts)
        # rounding of a bin edge must not borrow a sliver of the next step
        middle, width = middle[width > 1e-9 * self.diameter], width[width > 1e-9 * self.diameter]
        height = self.bed_height(middle)
        index = np.clip(np.searchsorted(edges, middle, side="right") - 1, 0, len(edges) - 2)
        total = np.bincount(index, height * width, len(edges) - 1)
        return total / np.bincount(index, width, len(edges) - 1)

    def with_bins(self, bin_width: float | None = None, window: tuple[float, float] | None = None) -> FlowContext:
        """The same flow with other bins or another window."""
        return replace(self, bin_width=bin_width or self.bin_width, window=window or self.window)


def from_scene(
    scene: Scene,
    *,
    bin_width: float | None = None,
    window: tuple[float, float] | None = None,
    x_range: Interval | None = None,
    inflow_depth: float | None = None,
    inflow_speed: float | None = None,
    engine: str | None = None,
) -> FlowContext:
    """The context of a run of our own.

    Parameters
    ----------
    scene : Scene
    bin_width : float, optional
        m; default five diameters.
    window : (float, float), optional
        Times for means, s; default the last quarter of the run.
    x_range : (float, float), optional
        m; default from the inlet (else the left wall, else the domain) to the outlet (else the right wall …).
    inflow_depth, inflow_speed : float, optional
        y1, m, and Va, m/s; default from the inlet rows: rows times spacing, and the mean of the rows' speeds.
    """
    c = scene.coefficients
    rows = scene.inlets
    if rows and inflow_depth is None:
        inflow_depth = len(rows) * scene.diameter
    if rows and inflow_speed is None:
        inflow_speed = float(np.mean([row.vx for row in rows]))
    duration = scene.time(scene.steps)
    return FlowContext(
        name=scene.name,
        diameter=scene.diameter,
        mass=c.mass,
        density=scene.density,
        gravity=scene.gravity,
        domain=scene.domain,
        x_range=x_range or _studied(scene.domain, scene.walls, rows, scene.outlets),
        walls=scene.walls,
        gates=scene.gates,
        inlets=rows,
        outlets=scene.outlets,
        time_step=c.time_step,
        settle_steps=scene.settle_steps,
        stiffness=c.stiffness,
        stiffness_wall=c.stiffness_wall,
        dashpot=c.gamma_normal * 0.5 * c.mass,
        dashpot_wall=c.gamma_normal_wall * c.mass,
        restitution=c.restitution,
        friction=c.friction,
        gamma_tangential=c.gamma_tangential,
        friction_law=scene.friction_law,
        touch=scene.touch,
        touch_width=scene.touch_width,
        rotation=scene.rotation,
        inflow_depth=inflow_depth,
        inflow_speed=inflow_speed,
        duration=duration,
        bin_width=bin_width or 5 * scene.diameter,
        window=window or (0.75 * duration, duration),
        probes=scene.probes,
        engine=engine,
    )


def _studied(domain, walls, inlets, outlets) -> Interval:
    """From the inlet to the outlet, else from wall to wall, else the domain."""
    low, high = domain[0]
    for wall in walls:
        start, end = wall.room("x")
        low, high = max(low, start), min(high, end)
    for outlet in outlets:
        if outlet.axis == "x":
            low, high = (low, min(high, outlet.at)) if outlet.side == "above" else (max(low, outlet.at), high)
    eastward = [row.x for row in inlets if row.vx > 0]
    westward = [row.x for row in inlets if row.vx < 0]
    return max([low, *eastward]), min([high, *westward])
