# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies that move freely: how far each came, whether it rests, slides, tips or floats, and what hit it.

Discs count as a fluid of their bulk density: the mass of those beside the body per area, away from bed and surface. The
level is that of the mass: from a height within the bulk, the mass above it over bulk density and width; the mean over
all such heights.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees, nan
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.quantity import HeadlineNumber, Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.statistics import STUDENT, mean_of
from lammps_jump.analysis.verdicts.bodies import farthest_first
from lammps_jump.dump.frame import Frame
from lammps_jump.dump.walls import BodyHistory, read_bodies
from lammps_jump.errors import DumpError
from lammps_jump.files import BODIES
from lammps_jump.physics.bodies import depth_of_area
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.motion import MovingWall, Pose
from lammps_jump.scene.walls import Wall
from lammps_jump.units import Estimates, as_summary, estimate, known, number

from .standing import Standing, standing_of

GAP, TOP = 1.0, 2.0
"""Diameters that are left out beside the body, and below the surface and above the bed."""
NARROWEST, LOWEST = 4.0, 3.0
"""Width of a strip beside the body, and height of the bulk in it, diameters, at least."""


class Around(NamedTuple):
    """Discs beside a body: bulk density (kg/m^2), height y of their level and of the lowest point of the body (m)."""

    density: float
    level: float
    keel: float


NOTHING = Around(np.nan, np.nan, np.nan)


def around(frame: Frame, flow: Flow, wall: Wall) -> Around:
    """The discs beside a body of one frame; NaN where too few lie there."""
    outline = _outline(wall)
    if outline is None:
        return NOTHING
    (x0, y0), (x1, _) = outline.min(axis=0), outline.max(axis=0)
    d = flow.scene.diameter
    wide = max(NARROWEST * d, 0.5 * (x1 - x0))
    low, high = flow.x_range
    strips = [(max(low, x0 - GAP * d - wide), x0 - GAP * d), (x1 + GAP * d, min(high, x1 + GAP * d + wide))]
    strips = [(a, b) for a, b in strips if b - a >= NARROWEST * d]
    if not strips:
        return NOTHING
    bed = float(np.nanmax(flow.bed_height(np.array([sum(strip) / 2 for strip in strips])), initial=-np.inf))
    masses = flow.relative_masses(frame) * flow.scene.mass
    weights = sum(_bell(frame.x, *strip) for strip in strips) * masses
    width = sum(0.5 * (b - a) for a, b in strips)  # of the bells
    there = weights > 0
    y, mass = frame.y[there], weights[there]
    bottom = max(bed + TOP * d, float(y.min(initial=np.inf)))
    ceiling = (float(np.quantile(y, 0.99)) if len(y) else -np.inf) - TOP * d
    if not ceiling - bottom >= LOWEST * d:
        return NOTHING
    density = float((mass * _bell(y, bottom, ceiling)).sum() / (width * 0.5 * (ceiling - bottom)))
    if not density > 0:
        return NOTHING
    above = float((mass * np.clip((y - bottom) / (ceiling - bottom), 0.0, 1.0)).sum())
    return Around(density, 0.5 * (bottom + ceiling) + above / (density * width), float(y0))


def _bell(place: np.ndarray, low: float, high: float) -> np.ndarray:
    """Weights sin^2 between two ends, 0 outside; their mean is a half.

    Sharp ends would count a layer of discs or not: an error of up to a layer in so few.
    """
    part = (place - low) / (high - low)
    return np.where((part > 0) & (part < 1), np.sin(np.pi * part) ** 2, 0.0)


def _outline(wall: Wall) -> np.ndarray | None:
    """Corners of a body, shape (n, 2), m."""
    rings = wall.outline((-np.inf, np.inf), (-np.inf, np.inf))
    return np.asarray(rings[0]) if len(rings) == 1 else None


def draught_by_weight(wall: Wall, weight: float, pressure: float) -> float:
    """Depth of the keel below the level at which a body displaces its weight, m; NaN where it would sink.

    Parameters
    ----------
    wall : Wall
        At the turn that it has.
    weight : float
        N/m.
    pressure : float
        Bulk density times gravity, N/m^3.

    Notes
    -----
    Archimedes: the weight of the displaced fluid is that of the body.
    """
    outline = _outline(wall)
    return float("nan") if outline is None else depth_of_area(outline, weight / pressure)


STILL = 0.01
"""Diameters from its last pose within which a body counts as at rest there."""
LAST = 0.1
"""Share of the time, at the end, that a body must have been at rest."""
LATE = 0.25
"""Share of the time, at the end, over which draught and heel are means."""
CARRIED = 0.1
"""Share of its weight by which the force of the discs may differ on a body that floats."""
LEAST = 8
"""Frames that a mean needs."""


@dataclass(frozen=True)
class BodyResult(Estimates):
    """Result of one body; absent numbers were not measured, and `reason` says why it has none at all."""

    mass: float = number("kg/m", "mass per metre of width", default=nan)
    inertia: float = number("kg m", "moment of inertia about the centre of mass, per metre of width", default=nan)
    start_x: float = number("m", "x of the centre of mass at the start", default=nan)
    start_y: float = number("m", "y of the centre of mass at the start", default=nan)
    start_angle: float = number("°", "turn at the start", default=nan)
    end_x: float = number("m", "x of the centre of mass at the end", default=nan)
    end_y: float = number("m", "y of the centre of mass at the end", default=nan)
    end_angle: float = number("°", "turn at the end", default=nan)
    largest_displacement: float = number("m", "largest displacement of the centre of mass", default=nan)
    largest_turn: float = number("°", "largest turn, either way", default=nan)
    rest: bool = False
    rest_since: float = number("s", "at rest since", default=nan)
    state: str | None = None
    side: str | None = None
    state_reason: str | None = None
    state_since: float = number("s", "lies or leans so, or has left, since", default=nan)
    lean: float = number("°", "turn from how it stood, anticlockwise", default=nan)
    slid_by: float = number("m", "way of the middle of its base along it, towards larger x", default=nan)
    base_way: float = number("m", "way of the middle of its base", default=nan)
    centre_way: float = number("m", "way of the centre of mass", default=nan)
    slides_at: float = number("s", "time at which it has slid by 1 % of its width", default=nan)
    tips_at: float = number("s", "time at which a corner has risen by 1 % of its width", default=nan)
    falls_at: float = number("s", "time at which it falls", default=nan)
    floats: bool = False
    draught: float = estimate(
        "m",
        "draught: level of the discs beside it over its lowest point",
        interval="± of the draught, 95 % from the swings of one run",
    )
    draught_by_weight: float = number("m", "draught at which it displaces its weight of discs", default=nan)
    heel: float = number("°", "turn while it floats, mean", default=nan)
    bulk_density: float = number("kg/m^3", "mass of the discs beside it over their area", default=nan)
    peak_force: float = number("N/m", "largest force of the discs, mean of a row of bodies.csv", default=nan)
    peak_at: float = number("s", "time of that force", default=nan)
    impulse_x: float = number("N s/m", "impulse of the discs along x", default=nan)
    impulse_y: float = number("N s/m", "impulse of the discs along y", default=nan)
    reason: str | None = None
    table: Mapping[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


class BodyWatch:
    """Collects what lies beside each body, frame by frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self._rows: dict[str, list[tuple[float, Around]]] = {name: [] for name in _bodies(flow)}

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        for wall in self.flow.walls_at(time):
            if wall.name in self._rows:
                self._rows[wall.name].append((time, around(frame, self.flow, wall)))

    def result(self) -> dict[str, np.ndarray]:
        """Time (s), bulk density (kg/m^2), level and lowest point (m) beside each body, shape (frames, 4)."""
        return {
            name: np.array([(time, *geometry) for time, geometry in rows]).reshape(-1, 4)
            for name, rows in self._rows.items()
        }


def _bodies(flow: Flow) -> dict[str, MovingWall]:
    """The bodies of a scene, by name."""
    return {one.wall.name: one for one in flow.scene.walls if isinstance(one.motion.kind, Free)}


def analyse(gathered: Gathered) -> dict[str, BodyResult] | None:
    """Results of the bodies; None for a scene without bodies."""
    flow, recorded = gathered.flow, gathered.histories.get("bodies", {})
    assert isinstance(recorded, dict)
    bodies = _bodies(flow)
    if not bodies:
        return None
    try:
        histories = read_bodies(flow.poses.path.parent / BODIES) if flow.poses else {}
        why = f"{BODIES} has no row of it"
    except DumpError as error:
        histories, why = {}, str(error)
    return {
        name: _found(flow, one, histories[name], recorded.get(name, np.empty((0, 4))))
        if name in histories else BodyResult(reason=why)
        for name, one in bodies.items()
    }  # fmt: skip


def _found(flow: Flow, one: MovingWall, history: BodyHistory, recorded: np.ndarray) -> BodyResult:
    """Result of one body, by its history and by the discs beside it."""
    kind = one.motion.kind
    assert isinstance(kind, Free)
    d, (low, high) = flow.scene.diameter, one.wall.extent[0]
    width = high - low
    x, y, angle = history.x, history.y, history.angle
    far, turned = np.hypot(x - x[0], y - y[0]), np.abs(angle - angle[0])
    off = np.hypot(x - x[-1], y - y[-1]) + 0.5 * width * np.abs(angle - angle[-1])
    moving = np.flatnonzero(off > STILL * d)
    first = int(moving[-1]) + 1 if moving.size else 0
    span = history.time[-1] - history.time[0]
    rests = first < len(off) and history.time[-1] - history.time[first] >= LAST * span and kind.begin < history.time[-1]
    standing, afloat = standing_of(flow, one, history), _afloat(flow, one, history, recorded)
    force = np.hypot(history.fx, history.fy)
    top = int(np.argmax(force))
    steps = np.diff(history.time, prepend=history.time[0])  # rows hold means over the time up to them
    return BodyResult(
        mass=kind.mass, inertia=kind.inertia,
        start_x=float(x[0]), start_y=float(y[0]), start_angle=degrees(angle[0]),
        end_x=float(x[-1]), end_y=float(y[-1]), end_angle=degrees(angle[-1]),
        largest_displacement=float(far.max()), largest_turn=degrees(turned.max()),
        rest=rests, rest_since=float(history.time[first]) if rests else nan,
        centre_way=float(np.hypot(x[-1] - x[0], y[-1] - y[0])),
        **_state(standing, afloat=bool(afloat)),
        peak_force=float(force[top]) if force[top] else nan, peak_at=float(history.time[top]) if force[top] else nan,
        impulse_x=float((steps * history.fx).sum()), impulse_y=float((steps * history.fy).sum()),
        **afloat,
        table={
            "time": history.time, "x": x, "y": y, "angle": np.degrees(angle), "fx": history.fx, "fy": history.fy,
            "base": _beside(standing.base, len(x)),
        },
    )  # fmt: skip


def _beside(base: np.ndarray | None, rows: int) -> np.ndarray:
    """Way of a base at each row of a history, m; NaN before the body is released, and of one without."""
    loads = np.full(rows, nan)
    if base is not None:
        loads[rows - len(base) :] = base
    return loads


def _state(standing: Standing, *, afloat: bool) -> dict[str, Any]:
    """Fields of a result that give the state of a body."""
    floats = afloat and standing.state != "left"
    return {
        "state": "afloat" if floats else standing.state,
        "side": None if floats else standing.side,
        "state_reason": None if floats else standing.reason,
        "state_since": nan if floats else standing.since,
        "lean": degrees(standing.turn),
        "base_way": float(standing.base[-1]) if standing.base is not None else nan,
        **{name: getattr(standing, name) for name in ("slid_by", "slides_at", "tips_at", "falls_at")},
    }


def _afloat(flow: Flow, one: MovingWall, history: BodyHistory, recorded: np.ndarray) -> dict[str, Any]:
    """Draught, heel and density of the discs beside a body that they carry; nothing for one that does not float."""
    kind = one.motion.kind
    assert isinstance(kind, Free)
    late = history.time >= history.time[-1] - LATE * (history.time[-1] - history.time[0])
    weight = -kind.weight[1]
    if kind.hinge is not None or not kind.axes[1] or weight <= 0 or late.sum() < LEAST:
        return {}
    if abs(float(history.fy[late].mean()) - weight) > CARRIED * weight:
        return {}
    frames = recorded[recorded[:, 0] >= history.time[late][0]]
    frames = frames[np.isfinite(frames).all(axis=1)]
    if len(frames) < LEAST or (frames[:, 2] <= frames[:, 3]).any():
        return {}
    draught, density = mean_of(frames[:, 2] - frames[:, 3]), float(frames[:, 1].mean())
    heel = float(np.degrees(history.angle[late]).mean())
    wall = one.at(0, Pose(angle=float(np.radians(heel)))) or one.wall
    return {
        "floats": True, "draught": draught.value, "draught_interval": STUDENT * draught.error, "heel": heel,
        "bulk_density": density, "draught_by_weight": draught_by_weight(wall, weight, density * flow.g),
    }  # fmt: skip


def summary(body_results: Mapping[str, BodyResult]) -> dict[str, object]:
    """As under ``bodies`` in ``summary.json``: the bodies by name."""
    return {name: as_summary(body) for name, body in body_results.items()}


def notes(body_results: Mapping[str, BodyResult] | None) -> list[str]:
    """Sentences on bodies of which nothing is known."""
    return [
        f"Nothing is known of the body {name}: {body.reason}."
        for name, body in (body_results or {}).items()
        if body.reason
    ]


LOOKS = ("first", "second", "third", "sum")
"""Of the lines of the first bodies; all others are faint."""


def figures(body_results: Mapping[str, BodyResult], _: Gathered) -> Drawings:
    """Way, turn and force of the bodies against time."""
    shown = [(name, body.table) for name, body in body_results.items() if len(body.table.get("time", ()))]
    if not shown:
        return {}
    curves: dict[str, list[Trace]] = {"Displacement\n[m]": [], "Turn [°]": [], "Force of the\ndiscs [N/m]": []}
    for place, (name, table) in enumerate(shown):
        look = LOOKS[place] if place < len(LOOKS) else "faint"
        label = name if len(shown) > 1 and place < len(LOOKS) else ""
        far, based = np.hypot(table["x"] - table["x"][0], table["y"] - table["y"][0]), len(shown) == 1
        based = based and bool(np.isfinite(table["base"]).any())
        values = far, table["angle"], np.hypot(table["fx"], table["fy"])
        for lines, line in zip(curves.values(), values, strict=True):
            lines.append(Trace("centre of mass" if based and line is far else label, table["time"], line, look))
        if based:
            curves["Displacement\n[m]"].append(Trace("middle of the base", table["time"], table["base"], "second"))
    panels = [Panel(label, lines) for label, lines in curves.items()]
    return {"bodies": Chart("bodies", TIME, panels)}


def section(body_results: Mapping[str, BodyResult]) -> Section:
    """The numbers of each body."""
    blocks: list[Table | Text] = []
    for name, body in body_results.items():
        keys = [key for key in KEYS if known(getattr(body, key))]
        if body.reason:
            blocks.append(Text(f"Nothing is known of the body {name}: {body.reason}.", "warn"))
        else:
            blocks.append(Table([("At the end", _words(body)), *described(body, *keys)], (f"Body {name}", "")))
    return Section("Bodies", blocks)


WORDS = {
    "stands": "stands", "slid": "has slid", "leans": "leans to the {}", "lies": "lies, {} side down",
    "afloat": "afloat", "left": "has left",
}  # fmt: skip


def _words(body: BodyResult) -> str:
    """The state of a body at the end."""
    return WORDS[body.state].format(body.side) if body.state else f"not told: {body.state_reason}"


KEYS = (
    "mass", "inertia", "start_x", "start_y", "end_x", "end_y", "end_angle", "centre_way", "base_way", "slid_by",
    "largest_displacement", "largest_turn", "slides_at", "tips_at", "falls_at", "state_since", "rest_since", "draught",
    "draught_interval", "draught_by_weight", "heel", "bulk_density", "peak_force", "peak_at", "impulse_x", "impulse_y",
)  # fmt: skip

QUANTITY = Quantity(
    name="bodies",
    title="Bodies",
    result=BodyResult,
    definitions="""\
rest          from then on the body stays within a hundredth of a diameter of its last pose, for a tenth of the time or
              longer
state         of the last pose: stands as it stood; slid, where the middle of its base has come by 1 % of its width
              along it; leans, turned by more than 2 degrees; lies, with another face within 15 degrees of the floor;
              afloat; left, with its centre of mass, the domain or over an outlet. Of a body that stood on nothing at
              the start, turns about a hinge or has no base (a circle) it is not told, and the reason is
base          the face of its convex hull that looks most downward at the start
slides, tips  both ends of its base have come along it, or one has risen and the other has not, by 1 % of its width;
              falls: nothing carries both. What happens in a fall is neither
lies, leans   since: from then on it has been so
floats        discs carry its weight within 10 % over the last quarter, where draught and heel are means
draught       level of the mass of the discs beside the body over its lowest point; by weight: where it displaces its
              weight at the bulk density of these discs (Archimedes)
impulse       sum of the force of the discs over time, both ends included
""",
    always=lambda flow: bool(_bodies(flow)),
    collector=BodyWatch,
    analyse=analyse,
    captions={"bodies": "Way, turn and force of the bodies"},
    figures=figures,
    section=section,
    notes=notes,
    summary=summary,
    headline=(
        HeadlineNumber("*.draught", "by its weight", "*.draught_by_weight", "draught of {name}", source="Archimedes"),
        HeadlineNumber("*.heel", label="heel of {name}, mean"),
        HeadlineNumber("*.largest_displacement", label="largest displacement, {name}"),
        HeadlineNumber("*.largest_turn", label="largest turn, {name}"),
    ),
    rank=114,
    structures=lambda _, summary: {name: "" for name, _ in farthest_first(summary)},
    kind="state",
    named=Named("body", "give the case bodies", "body_names", "<body>"),
)
