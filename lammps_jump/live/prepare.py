# SPDX-License-Identifier: GPL-2.0-or-later
"""A case as a live page begins it: what its sliders move has a table, and all else that follows stays the same.

A run of the downloaded case must have the numbers of the page. So the case of the page has what would else follow from
the moves or from the duration: the domain is written out, rows of the inlet are as far apart as its fastest speed asks
for, and the frame interval is a binary fraction, so that the time step is the same for every number of frames.

Words of law and weight differ in the image of a scene where a number of the case has another value. Two simulations of
one scene are set up, with the two values. What the core takes of them is compared, number by number.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import addressof, c_double, c_void_p
from dataclasses import dataclass, replace
from math import ceil, floor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.case import ReadCase
from lammps_jump.case.base import EarlierRun
from lammps_jump.case.discs import Column
from lammps_jump.case.fields import LiveSlider
from lammps_jump.case.inflow import PourInflow, RowsInflow
from lammps_jump.case.live import NUMBERS
from lammps_jump.engines.accuracy import with_accuracy
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import Image, image_of, narrowed, placed_image
from lammps_jump.errors import CaseError, JumpError
from lammps_jump.physics.inlet import REFUSAL_GAP
from lammps_jump.scene.tracks import Oscillate, TableMotion

WORD = 4
"""Bytes of a pointer in a browser."""
TABLES = ("at_wall", "between", "load")
"""Arrays of numbers of the state that follow from the case alone."""
MOST_START = 1_500
"""Words of a start that differ, at most; a flow begins with fewer."""

Words = list[tuple[int, float]]


class PlacedWords:
    """Numbers of a simulation with their places in its image.

    Parameters
    ----------
    base : NativeSimulation
        At its start.
    """

    def __init__(self, base: NativeSimulation):
        self.time_step = base.scene.time_step
        self._found = _numbers_of(base)
        self._image = image_of(base, 0, WORD)

    def against(self, other: NativeSimulation) -> tuple[Words, Words | None]:
        """Words that another value changes in a running flow, and at its start; None where that is not laid out alike.

        Raises
        ------
        CaseError
            The other has another time step, or is made of other parts.
        """
        if other.scene.time_step != self.time_step:
            raise CaseError("it changes the time step, so that a flow cannot go on with it; drop the slider")
        there = _numbers_of(other)
        if [place for place, _ in there] != [place for place, _ in self._found]:
            raise CaseError("the flow is made of other parts with it; take values that are all above 0")
        words = [two for one, two in zip(self._found, there, strict=True) if _bits(one[1]) != _bits(two[1])]
        if not all(np.isfinite(number) for _, number in words):
            raise CaseError("nothing rubs with one of its values; take values above 0")
        return words, self._start(image_of(other, 0, WORD))

    def _start(self, image: bytes) -> Words | None:
        """Words of the start of another image that differ from this one."""
        if len(image) != len(self._image):
            return None
        begin = _begin(image)
        if image[:begin] != self._image[:begin]:
            return None
        count = (len(image) - begin) // 8
        own, other = (np.frombuffer(one, "<i8", count, begin) for one in (self._image, image))
        differ = np.nonzero(own != other)[0]
        numbers = other.view("<f8")[differ]
        if not np.isfinite(numbers).all() or len(numbers) > MOST_START:
            return None
        return list(zip((8 * differ).tolist(), numbers.tolist(), strict=True))


def _bits(number: float) -> bytes:
    return bytes(c_double(number))


def _begin(image: bytes) -> int:
    """Begin of the memory of an image in its file."""
    pointers = int.from_bytes(image[24:32], "little")
    return 48 + 8 * pointers


def _numbers_of(simulation: NativeSimulation) -> Words:
    """Numbers of law and weight, with their places in the image."""
    image, state, events = placed_image(simulation, 0, WORD)
    numbers = [*_of_struct(image, state), *_of_struct(image, events)]
    for name in TABLES:
        numbers += _of_table(image, getattr(state, name))
    if state.corners:
        corners = image.known[state.corners]
        numbers += [*_of_struct(image, corners), *_of_table(image, corners.at_wall)]
    return numbers


def _of_struct(image: Image, struct: ctypes.Structure) -> Words:
    """Its numbers, and those of structs in it."""
    begin, narrow, numbers = image.places[addressof(struct)], narrowed(type(struct), WORD), []
    for name, kind, *_ in type(struct)._fields_:
        place = begin + getattr(narrow, name).offset
        if kind is c_double:
            numbers.append((place, float(getattr(struct, name))))
        elif kind is not c_void_p and issubclass(kind, ctypes.Structure):
            raw = np.frombuffer(bytes(getattr(struct, name)), "<f8")
            numbers += [(place + 8 * k, float(number)) for k, number in enumerate(raw)]
    return numbers


def _of_table(image: Image, address: int | None) -> Words:
    if not address:
        return []
    what: Any = image.known[address]
    raw = np.frombuffer(what.tobytes() if isinstance(what, np.ndarray) else bytes(what), "<f8")
    return [(image.places[address] + 8 * k, float(number)) for k, number in enumerate(raw)]


MOST_DISCS = 20_000
"""At the start; more are slower than a tenth of real time in most browsers."""
SHORTEST, LONGEST = 60.0, 600.0
"""Flow that a page is to know, s: four times the duration of the case, between these."""
MOST_SIZES = 40_000
"""Diameters of discs that may enter; 0.3 MB of the page."""
FEW, LEAST_LARGER = 1000, 1.25
"""Discs of a start with fewer, about, and by how much they are larger at least: below that it is not worth while."""
FINER = 1e-4
"""Share of the frame interval by which it may be shorter, to be a binary fraction of a second."""
STOPS = 11
"""Values of a number of the case that its slider has."""
NOT_HERE = (
    "a live page computes by the native engine, on one thread: stock scripts, ranks, pours (whose places are random "
    f"numbers of Python) and more than {MOST_DISCS:,} discs are not in it"
)

Told = Callable[[str], None]


@dataclass(frozen=True)
class NumberStop:
    """A value of a number of the case, and what it is in the image of the scene.

    Attributes
    ----------
    value : float
    words : list of (int, float)
        Places in the image and numbers there: of the law, of weights.
    start : list of (int, float) or None
        The same with all that the start has otherwise; None: a flow cannot begin with it here.
    """

    value: float
    words: list[tuple[int, float]]
    start: list[tuple[int, float]] | None


@dataclass(frozen=True)
class LiveFlow:
    """Parts of a live page.

    Attributes
    ----------
    case : ReadCase
        As the page begins it.
    sliders : mapping of str to LiveSlider
    simulation : NativeSimulation
        At t = 0.
    stops : mapping of str to tuple of NumberStop
        Of the sliders that change a number of the case.
    target : int
        Last step that the page knows.
    discs : int
        Discs that there may be until then, those that leave counted.
    notes : tuple of str
        What the page does otherwise than the case.
    """

    case: ReadCase
    sliders: Mapping[str, LiveSlider]
    simulation: NativeSimulation
    stops: Mapping[str, tuple[NumberStop, ...]]
    target: int
    discs: int
    notes: tuple[str, ...]


class LiveStart(NamedTuple):
    """A start of a page that has several.

    Attributes
    ----------
    label : str
        Its words in the list.
    flow : LiveFlow
    time : float
        Of the recorded run at which it begins, s.
    few : bool
        It has fewer discs than the case, which a phone begins with.
    """

    label: str
    flow: LiveFlow
    time: float = 0.0
    few: bool = False


def refuse(case: ReadCase) -> None:
    """CaseError where a page cannot have a case."""
    engine, wrong = case.fields.engine, ""
    if isinstance(case.fields.inflow, PourInflow):
        wrong = "inflow: a pour"
    elif engine.name == "lammps" and engine.kernel == "stock":
        wrong = "engine.kernel: stock"
    elif engine.ranks not in (1, "auto"):
        wrong = f"engine.ranks: {engine.ranks}"
    elif (count := len(case.scene().positions)) > MOST_DISCS:
        wrong = f"{count:,} discs"
    if wrong:
        raise CaseError(f"{case.source.file}: {wrong}: {NOT_HERE}")


def sensible(case: ReadCase) -> dict[str, LiveSlider]:
    """Sliders of a case that names none."""
    fields, live_sliders = case.fields, {}
    high = _height(case)
    for wall in fields.walls:
        motion = getattr(wall, "motion", None)
        if getattr(wall, "join", None) is not None:
            continue  # lines of one join have one motion
        if isinstance(motion, Oscillate | TableMotion):
            if one := _along(wall.name, motion):
                live_sliders[wall.name] = one
        elif motion is None and wall.name in fields.probes.forces and getattr(wall, "finite", False):
            live_sliders[wall.name] = LiveSlider(path=f"walls.{wall.name}", move="y", range=(-0.5 * high, 0.5 * high))
    inflow = fields.inflow
    if isinstance(inflow, RowsInflow) and inflow.table is None and inflow.schedule == "exact":
        depth, speed = inflow.over(0.0, 0.0)
        low, top = (float(f"{share * depth * speed:.3g}") for share in (0.75, 1.25))
        live_sliders["discharge"] = LiveSlider(path="inflow", range=(low, top))
    if fields.contact.friction > 0:
        live_sliders["friction"] = LiveSlider(path="contact.friction", range=(0.05, max(1.0, fields.contact.friction)))
    if 0.05 <= fields.contact.restitution <= 0.95:
        live_sliders["restitution"] = LiveSlider(path="contact.restitution", range=(0.05, 0.95))
    if fields.gravity > 0 and fields.seam is None and abs(fields.slope) < 10:
        live_sliders["slope"] = LiveSlider(path="slope", range=(-10, 10))
    return live_sliders


def _height(case: ReadCase) -> float:
    """A height of the flow, m, to two digits."""
    columns = [item.y[1] - item.y[0] for item in case.fields.initial if isinstance(item, Column)]
    inflow = case.fields.inflow
    depths = [max(inflow.hydrograph.depths)] if isinstance(inflow, RowsInflow) else []
    return float(f"{max([*columns, *depths, 10 * case.fields.discs.diameter]):.2g}")


def _along(name: str, motion: Oscillate | TableMotion) -> LiveSlider | None:
    """A slider over twice the way of a wall that moves along an axis."""
    if motion.turns:
        return None
    if isinstance(motion, Oscillate):
        far = [abs(part) for part in motion.amplitude]
    else:
        far = [max(abs(row[axis]) for row in motion.points) for axis in (1, 2)]
    if not max(far):
        return None
    most = 2 * max(far)
    return LiveSlider(path=f"walls.{name}", move="x" if far[0] >= far[1] else "y", range=(-most, most))


def prepare(
    given: ReadCase,
    report: Told = lambda text: None,
    *,
    numbers: bool = True,
    like: Mapping[str, LiveSlider] | None = None,
) -> LiveFlow:
    """A case made ready for a live page: set up, and run to t = 0 where discs settle first.

    Parameters
    ----------
    given : ReadCase
    report : callable
        Hears what is being done.
    numbers : bool
        Also make the sliders of numbers of the case, for which it is set up with each of their values.
    like : mapping of str to LiveSlider, optional
        Those of another start of the page, in place of the case's own; values that the case refuses are left out.

    Raises
    ------
    CaseError
        What a page cannot have, or a slider that cannot be.
    """
    case, _ = with_accuracy(given)
    refuse(case)
    own = case.fields.live if like is None else None
    sliders = dict(like if like is not None else sensible(case) if own is None else own)
    case = case.replace(_changes(case, sliders))
    if case.fields.domain is None:
        (x0, x1), (y0, y1) = case.scene().domain
        case = case.replace({"domain": {"x": [x0, x1], "y": [y0, y1]}})
    scene = case.scene()
    target = _target(case)
    discs = len(scene.positions) + _entering(case, target)
    simulation = NativeSimulation(scene, ledger=False)
    stops = {}
    for name, one in sliders.items():
        if numbers and one.path in NUMBERS:
            report(f"{name}: setting the case up with {STOPS} values of {one.path}")
            if several := _stops(case, one, simulation, asked=own is not None):
                stops[name] = several
    sliders = {name: one for name, one in sliders.items() if one.path not in NUMBERS or name in stops}
    _require_apart(sliders, stops)
    case = case.replace(
        {
            "live": {name: one.model_dump(exclude_none=True) for name, one in sliders.items()},
            "description": given.fields.description,
        }
    )
    if scene.settle_steps:
        report("letting the discs settle")
        simulation.run(scene.settle_steps)
        stops = {name: tuple(replace(stop, start=None) for stop in several) for name, several in stops.items()}
    return LiveFlow(case, sliders, simulation, stops, target, discs, tuple(_notes(given, case, sliders)))


def with_fewer(given: ReadCase, flow: LiveFlow) -> list[LiveStart]:
    """The starts of a case: its own, and where it has many discs one with fewer, larger ones, for slow machines.

    Depths and discharges stay, as far as the rows of larger discs have them. A case that does not do with larger discs
    has its own start alone.
    """
    count = len(flow.simulation.scene.positions)
    scale = float(f"{(count / FEW) ** 0.5:.2g}")
    if scale < LEAST_LARGER or any(isinstance(item, EarlierRun) for item in given.fields.initial):
        return [LiveStart("", flow)]
    try:
        larger = given.replace({"discs.diameter": float(f"{scale * given.fields.discs.diameter:.4g}")})
        other = prepare(larger, like=flow.sliders)
    except JumpError:
        return [LiveStart("", flow)]
    fewer = len(other.simulation.scene.positions)
    if other.sliders.keys() != flow.sliders.keys() or not 0 < fewer < count:
        return [LiveStart("", flow)]
    return [
        LiveStart(f"{count:,} discs at the start", flow),
        LiveStart(f"{fewer:,} discs, {scale:g} times as large", other, few=True),
    ]


def from_times(
    given: ReadCase, run: Path, times: Sequence[float | str], report: Told = lambda text: None, *, numbers: bool = True
) -> list[LiveStart]:
    """Starts with the discs of a run at some times, s, or at its end (``last``); see `prepare`."""
    live_starts: list[LiveStart] = []
    for time in times:
        case = given.after(run, time)
        moment = next(iter(case.source.begun.values())).state.time
        if any(one.time == moment for one in live_starts):
            continue  # the same frame is nearest
        report(f"from t = {moment:zg} s of the run")
        flow = prepare(case, report, numbers=numbers)
        live_starts.append(LiveStart(f"from t = {moment:zg} s of the run", flow, moment))
    return live_starts


class FrameInterval(NamedTuple):
    """Interval of the frames, s, and how many windows of the probes it has.

    Whatever the number of frames, steps of one length divide windows, frames and duration: `scene.schedule.fitted_step`
    and `plan_steps` then find the same step and the same number of steps from frame to frame.
    """

    interval: float
    windows: int

    @classmethod
    def of(cls, case: ReadCase) -> FrameInterval:
        """The interval nearest below that of a case which is a binary fraction of a second."""
        scene = case.scene()
        window = scene.probe_steps if scene.probes or scene.groups or scene.bodies else scene.output_steps
        windows = max(1, round(scene.output_steps / window))
        longest = windows * window * scene.time_step
        fraction = 2.0 ** ceil(np.log2(1.0 / (FINER * longest)))
        return cls(floor(longest * fraction) / fraction, windows)


def _changes(case: ReadCase, sliders: Mapping[str, LiveSlider]) -> dict[str, Any]:
    """Changes of a case that its page needs."""
    fields, frame = case.fields, FrameInterval.of(case)
    changes: dict[str, Any] = {
        "engine": {"name": "native", **({"skin": fields.engine.skin} if fields.engine.skin else {})},
        "run.output_interval": frame.interval,
        "run.duration": max(1, round(fields.run.duration / frame.interval)) * frame.interval,
        "probes.interval": frame.interval / frame.windows,
        "run.members": None,
        "run.stop_when_steady": False,
        "run.accuracy": None,
        "live": {name: one.model_dump(exclude_none=True) for name, one in sliders.items()},
    }
    for wall in {one.wall for one in sliders.values() if one.wall}:
        changes[f"walls.{wall}.motion"] = {"kind": "table", "points": [[0, 0, 0, 0]]}
    if any(one.path == "inflow" for one in sliders.values()) and isinstance(fields.inflow, RowsInflow):
        changes["inflow"] = _tabled(fields.inflow, next(one for one in sliders.values() if one.path == "inflow"))
    return changes


def _tabled(inflow: RowsInflow, slider: LiveSlider) -> dict[str, Any]:
    """An inflow as a table of one row, its rows as far apart as the largest rise of the speed asks for."""
    graph = inflow.hydrograph
    depth, speed = graph.depths[0], graph.speeds[0]
    if not depth:
        raise CaseError("live: the inflow begins with depth 0, so that its discharge cannot change; drop the slider")
    rise = max(slider.range[1], depth * speed) / min(slider.range[0], depth * speed)
    kept = inflow.model_dump(exclude_none=True, exclude={"depth", "mean_speed", "discharge", "table"})
    gap = max(inflow.spacing, ceil(1e6 * REFUSAL_GAP * 2.0 * rise / (1.0 + rise)) / 1e6)
    return {**kept, "spacing": gap, "table": [[0, depth, speed]]}


def _target(case: ReadCase) -> int:
    """Last step that the page knows."""
    scene = case.scene()
    seconds = min(max(4 * case.fields.run.duration, SHORTEST), LONGEST)
    steps = int(seconds / scene.time_step)
    if scene.sizes is not None and (rate := _rate(case)):
        room = MOST_SIZES - len(scene.positions)
        steps = min(steps, max(1, int(room / rate / scene.time_step)))
    return scene.settle_steps + steps


def _rate(case: ReadCase) -> float:
    """Discs that may enter in a second, at most."""
    scene, inflow = case.scene(), case.fields.inflow
    if not isinstance(inflow, RowsInflow):
        return 0.0
    area = scene.sizes.mean_square if scene.sizes is not None else scene.diameter**2
    graph = inflow.hydrograph
    most = [depth * speed for depth, speed in zip(graph.depths, graph.speeds, strict=True)]
    most += [one.range[1] for one in (case.fields.live or {}).values() if one.path == "inflow"]
    return 1.05 * max(most) / area


def _entering(case: ReadCase, target: int) -> int:
    scene = case.scene()
    return int(_rate(case) * (target - scene.settle_steps) * scene.time_step) + 100 * bool(scene.inlets)


def _stops(case: ReadCase, slider: LiveSlider, base: NativeSimulation, *, asked: bool) -> tuple[NumberStop, ...]:
    """The values of a slider that changes a number; none where a flow cannot take them and no slider was given."""
    own = float(case[slider.path])
    values = {float(f"{value:.6g}") for value in np.linspace(*slider.range, STOPS)} | {own}
    stops, core = [], PlacedWords(base)
    for value in sorted(values):
        try:
            scene = case.replace({slider.path: value}).scene()
            other = NativeSimulation(scene, ledger=False)
            stops.append(NumberStop(value, *core.against(other)))
        except JumpError as error:
            if asked:
                raise CaseError(f"live: {slider.path} = {value:z.6g}: {error}") from None
    return tuple(stops) if len(stops) > 1 and own in [stop.value for stop in stops] else ()


def _require_apart(sliders: Mapping[str, LiveSlider], stops: Mapping[str, Iterable[NumberStop]]) -> None:
    """CaseError where two sliders change the same numbers of the core: one would undo the other."""
    taken: dict[int, str] = {}
    for name, places in stops.items():
        own = {place for stop in places for place, _ in stop.words}
        for place in own:
            if place in taken:
                raise CaseError(
                    f"live: {sliders[taken[place]].path} and {sliders[name].path} change the same numbers of the "
                    "contact; keep one of the two sliders"
                )
        taken |= dict.fromkeys(own, name)


def _notes(given: ReadCase, case: ReadCase, sliders: Mapping[str, LiveSlider]) -> Iterable[str]:
    for wall in given.fields.walls:
        motion = getattr(wall, "motion", None)
        if motion is not None and any(one.wall == wall.name for one in sliders.values()):
            yield f"The slider takes the place of the motion of {wall.name} ({motion.kind})."
    frames = iter(given.source.begun.values())
    for item in given.fields.initial:
        if isinstance(item, EarlierRun):
            frame = next(frames, None)  # the one nearest to the time that was requested
            time = frame.state.time if frame and item.time is not None else item.time
            moment = "its end" if time is None else f"t = {time:zg} s"
            yield (
                f"The flow begins with the discs of the run {item.folder} at {moment}; its time begins at 0. The "
                "downloaded case names that folder: run it where the folder is."
            )
    if any(one.path in NUMBERS for one in sliders.values()):
        names = ", ".join(name for name, one in sliders.items() if one.path in NUMBERS)
        yield (
            f"Not in a downloaded case: changes of {names} while the flow runs, as a case has no table of them. Set "
            "them and begin again from the start, and they are."
        )
    if isinstance(given.fields.inflow, RowsInflow) and case.fields.inflow != given.fields.inflow:
        yield "Discs of the inflow enter farther apart than in the case, as its speed may grow."
    yield NOT_HERE[0].upper() + NOT_HERE[1:] + "."
