# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs, bodies, lids and tailgates of earlier runs: read beside a case, chosen and placed as the case says."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import degrees, inf
from pathlib import Path
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from lammps_jump.dump.ended import DISC, STOPPED, DiscsAtTime, at_frame, read_ended
from lammps_jump.dump.walls import PushedWalls, outline_of, went_of
from lammps_jump.errors import CaseError, DumpError, FieldError
from lammps_jump.files import END_FILE, START_FILE, SUMMARY_FILE, checksum, read_json
from lammps_jump.folders import holder
from lammps_jump.foreign import foreign
from lammps_jump.physics.elementary import cos, hypot, sin
from lammps_jump.quoting import echoed, one_line, typed
from lammps_jump.scene import MovingWall, Sizes, Wall, WallState
from lammps_jump.scene.meeting import corner_names
from lammps_jump.scene.motion import Pose, WallAtStep
from lammps_jump.scene.scene import CONTACT, EarlierState, Fixed, chains_of
from lammps_jump.units import to_si

from .base import EarlierDiscs, EarlierRun
from .checks import depths
from .fields import CaseFields
from .text import CaseSource, PathKey, Runs, StartState, parse_source, read_text

NOUNS = {"free": "body", "load": "lid", "hold": "tailgate"}
"""Names of walls, by how they move."""
SAME = 1e-9
"""Difference of outlines that is round-off, over the size of a wall."""
LEAST_TURN = 1e-3
"""Turn in degrees from which on it is named."""


class Pushable(NamedTuple):
    """A wall of a case whose pose is state: its place there, how it moves, point of turning (m) and release (s)."""

    wall: Wall
    kind: str
    about: tuple[float, float]
    begin: float


@dataclass(frozen=True)
class ContinuedWalls:
    """State of the walls of a case from earlier runs.

    Attributes
    ----------
    walls : mapping of str to Went
        Those that go on, by name.
    left : mapping of int to frozenset of str
        By the number of the item of ``initial``: walls of its run that do not go on from there.
    said : tuple of str
        Which go on, begin anew and are left out, in words.
    """

    walls: Mapping[str, WallState] = field(default_factory=dict)
    left: Mapping[int, frozenset[str]] = field(default_factory=dict)
    said: tuple[str, ...] = ()

    def placed(self, one: Wall, about: Mapping[str, tuple[float, float]]) -> Wall:
        """A wall where it begins."""
        went = self.walls.get(one.name)
        return one if went is None else WallAtStep(one, went.pose, about[one.name])


def going_on(case: CaseFields, runs: Runs, pushed: Sequence[Pushable]) -> ContinuedWalls:
    """Walls of a case that go on from the runs that its discs come from: those of the same name, motion and outline.

    Parameters
    ----------
    case : CaseFields
    runs : mapping of tuple to StartState
        `CaseSource.begun`.
    pushed : sequence of Pushable
        Of the case.
    """
    walls: dict[str, WallState] = {}
    left: dict[int, frozenset[str]] = {}
    said: list[str] = []
    own, anew = {one.wall.name: one for one in pushed}, dict.fromkeys((one.wall.name for one in pushed), "")
    items = [(index, item) for index, item in enumerate(case.initial) if isinstance(item, EarlierRun)]
    for index, item in items:
        state, in_folder = runs["initial", index].state.walls, set()
        for name, kind in zip(state.names, state.kinds, strict=True):
            one, noun = own.get(name), f"{NOUNS.get(kind, 'wall')} '{name}'"
            if one is None:
                in_folder.add(name)
                said.append(f"{noun} of {item.folder} stays behind: this case has none of that name")
            elif why := _unlike(one, item, state, walls):
                in_folder.add(name)
                anew[name] = f"{why} in {item.folder}"
            elif state.row(name)["released"]:
                walls[name] = _went(one, item, state)
                said.append(_told(one, walls[name], noun, item))
            else:
                said.append(f"{noun} is still held in {item.folder}: it waits here until from, {one.begin:zg} s")
                anew.pop(name, None)
        left[index] = frozenset(in_folder)
    for name, why in anew.items() if items else ():
        if name not in walls:
            known = all(runs["initial", index].state.walls.known for index, _ in items)
            there = " and ".join(item.folder for _, item in items)
            why = why or (f"{there} has none of that name" if known else f"{there} kept nothing of it")
            said.append(f"{NOUNS[own[name].kind]} '{name}' begins anew, where this case has it: {why}")
    return ContinuedWalls(walls, left, tuple(said))


def _unlike(one: Pushable, item: EarlierRun, state: PushedWalls, taken: Mapping[str, WallState]) -> str:
    """Why a wall does not go on; empty where it does."""
    name = one.wall.name
    if name in taken:
        return "it goes on from another run, and there is one of its name"
    if state.kinds[state.names.index(name)] != one.kind:
        return f"it is a {NOUNS.get(state.kinds[state.names.index(name)], 'wall')}"
    old, new = state.outline(name), outline_of(one.wall)
    size = float(np.ptp(new[:, :2], axis=0).max()) or 1.0
    if len(old) != len(new) or np.abs(new - old - (*(new - old)[0, :2], 0.0)).max() > SAME * size:
        return "it has another outline"
    row, (dx, dy) = state.row(name), (new - old)[0, :2]
    if hypot(*(one.about - row["about"] - (dx, dy))) > SAME * size:
        return "it turns about another point"
    x, y = _centre(row)
    ends = item.within
    outside = ends is not None and any(
        not low <= value <= high
        for value, (low, high) in ((x, ends.x or (-inf, inf)), (y, ends.y or (-inf, inf)))
    )  # fmt: skip
    return "it lies outside of within" if outside else ""


def _centre(row: np.void) -> tuple[float, float]:
    """Centre of mass of a wall of an earlier run, m."""
    (x, y, angle), (ax, ay) = row["place"].tolist(), row["arm"].tolist()
    c, s = cos(angle), sin(angle)
    return row["about"][0] + x + c * ax - s * ay, row["about"][1] + y + s * ax + c * ay


def _went(one: Pushable, item: EarlierRun, state: PushedWalls) -> WallState:
    """State of a wall that goes on, from its run."""
    row = state.row(one.wall.name)
    dx, dy = (outline_of(one.wall) - state.outline(one.wall.name))[0, :2].tolist()
    way = item.shift[0] - dx, item.shift[1] - dy
    x, y, angle = row["place"].tolist()
    went = went_of(row, Pose(x + way[0], y + way[1], angle))
    if went.listed is not None:
        went = replace(went, listed=Pose(went.listed.x + way[0], went.listed.y + way[1], went.listed.angle))
    if item.velocities == "rest":
        went = replace(went, speed=Pose(), half=None, before=None, force=None)
    return went


def _told(one: Pushable, went: WallState, noun: str, item: EarlierRun) -> str:
    """A sentence on a wall that goes on."""
    x, y, angle = went.pose
    turned = f" and turned by {degrees(angle):z.3g} degrees" if abs(degrees(angle)) >= LEAST_TURN else ""
    released = "; it is free from the start, whatever from says" if one.begin > 0 and one.kind != "hold" else ""
    moved = f"moved by ({x:z.4g}, {y:z.4g}) m{turned}"
    return f"{noun} goes on from {item.folder}, {moved} from where this case has it{released}"


def renumbered(contacts: np.ndarray, column: str, old: Sequence[str], new: Sequence[str]) -> np.ndarray:
    """Contacts whose `disc` is 1 + the number of a name, or `partner` -1 - that, by new names; none of others."""
    place = {name: number for number, name in enumerate(new)}
    numbers = np.array([place.get(name, -1) for name in (*old, "")])
    sign = -1 if column == "partner" else 1
    renumbering = numbers[sign * contacts[column] - 1]
    kept = contacts[renumbering >= 0].copy()
    kept[column] = sign * (1 + renumbering[renumbering >= 0])
    return kept


SAME_DENSITY = 1e-12
"""Relative difference of densities that is round-off."""
FIXED = 1 << 40
"""An id above all others."""
KNOWN: WeakValueDictionary[str, DiscsAtTime] = WeakValueDictionary()
"""Discs that cases of this process hold, by their keys: a study reads a run once."""


def read_runs(source: CaseSource) -> None:
    """Read the discs of the earlier runs that a case names; those that are read already are kept.

    Raises
    ------
    CaseError
        A folder outside the places where runs may lie, without a run, or with one that goes on or failed; a time
        outside its dump; discs other than those of the key.
    """
    known, source.begun = source.begun, {}
    items = source.data.get("initial")
    for index, item in enumerate(items if isinstance(items, list) else []):
        if not isinstance(item, dict) or item.get("kind") != "run" or not isinstance(item.get("folder"), str):
            continue
        path, name, time, key = ("initial", index), item["folder"], item.get("time", "last"), item.get("key")
        old = next((one for one in known.values() if (one.folder, one.time) == (name, time)), None)
        if old is None:
            old = StartState(name, time, _own(source, key) or _of_folder(source, path, name, time))
        if key is not None and key != old.state.key:
            raise FieldError(
                f"initial.{index}.key",
                f"the discs of {name} are not those of key {echoed(key)}: that run was made anew; "
                "drop key to begin from the discs that are there now",
            )
        source.begun[path] = old
        KNOWN[old.state.key] = old.state


def _own(source: CaseSource, key: object) -> DiscsAtTime | None:
    """The discs of this key: known in this process, or in the folder of the case, which is then a run folder."""
    if not isinstance(key, str) or not key.isalnum():
        return None
    if source.folder is None or key in KNOWN:
        return KNOWN.get(key)
    path = source.folder / START_FILE.format(key=key)
    try:
        discs = _read(path) if os.path.lexists(path) else None
    except DumpError as error:
        raise CaseError(f"{error}; without it the run cannot be read: put the file back") from None
    return discs


def _of_folder(source: CaseSource, path: PathKey, name: str, time: object) -> DiscsAtTime:
    """The discs of a run folder, at a time as the case has it."""
    place = source.place((*path, "folder"))
    base = source.folder or Path()
    folder = Path(os.path.normpath(base / name))
    try:
        moment = inf if time in (None, "last") else float(to_si(time, "s"))
    except (TypeError, ValueError):
        return DiscsAtTime(0.0, 1.0, np.empty(0, DISC))  # the field is refused for itself
    with foreign(CaseError, f"{place}: {echoed(name)} is no folder that can be read"):
        one_line(name)
        roots = {base.resolve(), Path.cwd().resolve()}
        inside = any(folder.resolve().is_relative_to(root) for root in roots)
        there = inside and (folder / "case.yaml").is_file()
    if not inside:
        raise CaseError(
            f"{place}: {echoed(name)} lies outside the folder of the case and the working directory; allowed is a run "
            "folder in one of them: copy the run there"
        )
    if not there:
        raise CaseError(f"{place}: {echoed(name)} holds no run; {_how_to_make(base, folder)}")
    try:
        return read_state(folder, moment)
    except DumpError as error:
        field = source.place((*path, "time")) if moment < inf else place
        raise CaseError(f"{field}: {name}: {error}") from None


def _how_to_make(base: Path, folder: Path) -> str:
    """Advice where a run is missing: the command that makes it, where a case of its name is there."""
    case = base / f"{folder.name}.yaml"
    if not case.is_file():
        return "name the folder of a run that has ended"
    shown = [Path(os.path.relpath(path)) for path in (case, folder)]
    return f"`{typed('build-and-run', shown[0], '--out', shown[1])}` makes it"


def read_state(folder: Path, time: float = inf) -> DiscsAtTime:
    """The discs of a run folder at a time (s; infinite: at its end).

    Raises
    ------
    DumpError
        The run goes on, or failed, or its summary does not tell how it ended; a state other than the summary means; a
        time outside its dump.
    """
    if writer := holder(folder):
        raise DumpError(f"{writer} writes to this folder; wait until the run has ended")
    stored = _summary(folder)
    last = _kept(folder, stored)
    if time == inf and last is not None:
        return replace(last, which=STOPPED) if stored["status"] == "interrupted" else last
    try:
        data = parse_source(read_text(folder / "case.yaml"), "case.yaml").data
        density, diameter = float(data["discs"]["density"]), float(data["discs"]["diameter"])
        rough = any(wall["kind"] == "rough" for wall in data.get("walls") or ())
    except (CaseError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise DumpError(f"its case.yaml cannot be read ({error})") from None
    if rough and last is None:
        raise DumpError(f"has rough beds and no {END_FILE}, so that its fixed discs are not known; run it again")
    return at_frame(folder, time, density, diameter, last)


def _summary(folder: Path) -> dict[str, Any]:
    """The summary of a run that has ended or was stopped; DumpError for another one, and where there is none."""
    path = folder / SUMMARY_FILE
    with foreign(DumpError, f"{path.name}, which tells how the run ended, cannot be read", "run it again"):
        stored: dict[str, Any] = read_json(path)
        status = stored["status"]
    if status == "failed":
        raise DumpError("the run there failed; allowed is one that ended or was stopped")
    if status not in ("complete", "unchecked", "interrupted"):
        raise DumpError(f"{path.name}: the status {echoed(status)} is that of no run; run it again")
    return stored


def _kept(folder: Path, stored: dict[str, Any]) -> DiscsAtTime | None:
    """The state that a run kept of its end, where the folder has one; DumpError where it is not that of the summary."""
    path = folder / END_FILE
    if not os.path.lexists(path):
        return None
    with foreign(DumpError, f"{END_FILE}: cannot be read"):
        same = checksum(path) == stored["outputs"].get(END_FILE)
    if not same:
        raise DumpError(
            f"{END_FILE}: is not the one that the run wrote (its SHA-256 is not that of {SUMMARY_FILE}); put the file "
            "back, or run it again"
        )
    return _read(path)


def _read(path: Path) -> DiscsAtTime:
    """A file of a state, read once as long as it stays the same."""
    status = path.stat()
    return _read_once(path.resolve(), status.st_size, status.st_mtime_ns)


@lru_cache(maxsize=4)
def _read_once(path: Path, size: int, changed: int) -> DiscsAtTime:
    return read_ended(path)


def from_run(source: CaseSource, folder: Path, time: object) -> dict[str, object]:
    """Put the discs of a run into the source of a case, as its first item of ``initial``; that item."""
    try:
        moment = inf if time == "last" else float(time)  # type: ignore[arg-type]
        if not (folder / "case.yaml").is_file():
            raise DumpError("holds no run; name the folder of a run that has ended")
        source.begun = {("initial", 0): StartState(str(folder), time, read_state(folder, moment))}
    except (DumpError, TypeError, ValueError) as error:
        raise CaseError(f"{folder}: {error}") from None
    return {"kind": "run", "folder": str(folder), "time": time}


def with_restart(initial: Sequence[object], source: CaseSource) -> tuple[object, ...]:
    """The items of ``initial``, those of earlier runs with what their runs hold."""
    items = []
    for index, item in enumerate(initial):
        if isinstance(item, EarlierRun):
            discs = _chosen(item, source.begun["initial", index].state)
            x, y = discs["x"] + item.shift[0], discs["y"] + item.shift[1]
            fastest = 0.0 if item.velocities == "rest" else float(np.hypot(discs["vx"], discs["vy"]).max(initial=0.0))
            ends = (float(x.min(initial=inf)), float(x.max(initial=-inf))) if len(x) else (0.0, 0.0)
            item = item.read(EarlierDiscs(len(x), ends, float(y.max(initial=-inf)) if len(x) else 0.0, fastest))
        items.append(item)
    return tuple(items)


def _chosen(item: EarlierRun, state: DiscsAtTime) -> np.ndarray:
    """The discs that lie where the case takes them from."""
    discs, kept = state.discs, np.ones(len(state.discs), bool)
    for axis in "xy":
        if item.within is not None and (ends := getattr(item.within, axis)) is not None:
            kept &= (discs[axis] >= ends[0]) & (discs[axis] <= ends[1])
    return discs[kept]


class RestartDiscs(NamedTuple):
    """Discs of earlier runs: places (m), velocities (m/s), diameters (m), and what else they have."""

    positions: np.ndarray
    velocities: np.ndarray
    diameters: np.ndarray
    earlier: EarlierState


def load_restart(
    case: CaseFields, runs: Runs, walls: Iterable[tuple[str, Wall]], allowed: float,
    random: np.random.Generator, going: ContinuedWalls,
) -> RestartDiscs | None:  # fmt: skip
    """The discs of all earlier runs of a case, with ids from 1 on; None where it names none.

    Parameters
    ----------
    case : CaseFields
    runs : mapping of tuple to StartState
        `CaseSource.begun`.
    walls : iterable of (str, Wall)
        Walls that are there at the start, with their fields.
    allowed : float
        Depth in a wall that is allowed, m.
    random : Generator
        Of the shifts.
    going : GoingOn
        Walls that go on.

    Raises
    ------
    CaseError
        Another density, no disc, discs deep in a wall.
    """
    walls, parts, first = list(walls), [], 1
    for index, item in enumerate(case.initial):
        if isinstance(item, EarlierRun):
            state = runs["initial", index].state
            part = _one(case, index, state, walls, allowed, first, random)
            parts.append(part._replace(earlier=_without_memory_of(part.earlier, going.left[index])))
            first += len(part.positions)
    if not parts:
        return None
    whole = len(parts) == len(case.initial) == 1
    chains = tuple(dict.fromkeys(name for part in parts for name in part.earlier.chains))
    corners = tuple(dict.fromkeys(name for part in parts for name in part.earlier.corner_names))
    earlier = EarlierState(
        np.concatenate([part.earlier.spins for part in parts]),
        np.concatenate([part.earlier.half for part in parts]),
        np.concatenate([renamed(part.earlier, chains) for part in parts]),
        chains,
        parts[0].earlier.exact if whole else {},
        (*(text for part in parts for text in part.earlier.origins), *going.said),
        going.walls,
        np.concatenate([of_corners(part.earlier, corners, chains) for part in parts]),
        corners,
    )
    positions, velocities, sizes = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return RestartDiscs(positions, velocities, sizes, earlier)


def _one(
    case: CaseFields, index: int, state: DiscsAtTime, walls: Sequence[tuple[str, Wall]], allowed: float,
    first: int, random: np.random.Generator,
) -> RestartDiscs:  # fmt: skip
    """The discs of one item, with ids from `first` on."""
    item: EarlierRun = case.initial[index]  # type: ignore[assignment]
    if abs(case.discs.density / state.density - 1) > SAME_DENSITY:
        raise FieldError(
            "discs.density",
            f"is {case.discs.density:zg} kg/m3, the discs of {item.folder} have {state.density:zg}; "
            f"allowed is theirs: give density: {state.density!r}",
        )
    discs = _chosen(item, state)
    if not len(discs):
        raise FieldError(f"initial.{index}.within", f"holds none of the {len(state.discs)} discs of {item.folder}")
    places = np.column_stack([discs["x"], discs["y"]])
    if any(item.shift):
        places += item.shift
    if item.jitter:
        places += random.uniform(-item.jitter, item.jitter, places.shape) * case.discs.diameter
    free = _free(item, index, (places, discs["diameter"]), walls, allowed)
    dropped = int((~free).sum())
    discs, places = discs[free], places[free]
    rest = item.velocities == "rest"
    names = ("vx", "vy", "spin")
    moves = np.column_stack([0.0 * discs[name] if rest else discs[name] for name in names])
    half = np.column_stack([discs[f"half_{name}"] for name in names])
    contacts, lost = _contacts(state, discs["id"], first)
    unmoved = len(discs) == len(state.discs) and not (any(item.shift) or item.jitter or rest)
    said = f"begins from {item.folder} at t = {state.time:z.6g} s ({state.which}; key {state.key}): {len(discs)} discs"
    said += f", {dropped} more dropped, deep in a wall" if dropped else ""
    said += f"; the memory of {lost} contacts has lost its disc" if lost else ""
    origin = EarlierState(
        moves[:, 2], np.full_like(half, np.nan) if rest else half, contacts, state.chains,
        state.exact if unmoved else {}, (said,), {}, state.walls.corners, state.walls.corner_names,
    )  # fmt: skip
    return RestartDiscs(places, moves[:, :2], discs["diameter"].copy(), origin)


def _free(
    item: EarlierRun, index: int, discs: tuple[np.ndarray, np.ndarray],
    walls: Sequence[tuple[str, Wall]], allowed: float,
) -> np.ndarray:  # fmt: skip
    """Mask of the discs, by places and diameters, that are free of walls; refused where the case drops no others."""
    free = np.ones(len(discs[0]), bool)
    for place, wall in walls:
        depth = depths(wall, *discs)
        deep = depth > allowed * (1 + 1e-9)
        if deep.any() and item.in_walls == "refuse":
            worst = int(np.argmax(depth))
            x, y = discs[0][worst]
            raise FieldError(
                f"initial.{index}",
                f"{int(deep.sum())} discs of {item.folder} lie deep in wall '{wall.name}' ({place}), "
                f"the deepest by {depth[worst]:z.3g} m at ({x:zg}, {y:zg}); allowed is d/n = {allowed:z.3g} m: "
                "move the wall, take other discs (within, shift), or leave these out by in_walls: drop",
            )
        free &= ~deep
    if not free.any():
        raise FieldError(f"initial.{index}.in_walls", f"all discs of {item.folder} lie deep in walls; move the walls")
    return free


def _contacts(state: DiscsAtTime, ids: np.ndarray, first: int) -> tuple[np.ndarray, int]:
    """Contacts between these discs, or of one and a wall, with ids from `first` on; how many lack a disc.

    The k-th fixed disc of the run is `FIXED` + k, until its id is known (`restart_state`).
    """
    held, one, last = state.contacts, *state.fixed
    new = {name: np.where(held[name] < 0, held[name], 0) for name in ("disc", "partner")}
    for name, values in new.items():
        at = np.minimum(np.searchsorted(ids, held[name]), len(ids) - 1)
        values[:] = np.where(ids[at] == held[name], first + at, values)
        values[:] = np.where((held[name] >= one) & (held[name] <= last), FIXED + held[name] - one, values)
    loose = (new["disc"] > 0) & (new["disc"] < FIXED) | (new["partner"] > 0) & (new["partner"] < FIXED)
    there = (new["disc"] != 0) & (new["partner"] != 0)
    kept = held[there].copy()
    kept["disc"], kept["partner"] = new["disc"][there], new["partner"][there]
    return kept, int((loose & ~there).sum())


def renamed(earlier: EarlierState, chains: Sequence[str]) -> np.ndarray:
    """The contacts with partners -1 - c that mean these chains; those of other chains are left out."""
    place = {name: number for number, name in enumerate(chains)}
    numbers = np.array([place.get(name, -1) for name in (*earlier.chains, "")])
    renumbered_contacts = earlier.contacts.copy()
    walls = renumbered_contacts["partner"] < 0
    number = numbers[np.where(walls, -1 - renumbered_contacts["partner"], -1)]
    renumbered_contacts["partner"][walls] = -1 - number[walls]
    return renumbered_contacts[~walls | (number >= 0)]


def of_corners(earlier: EarlierState, corners: Sequence[str], chains: Sequence[str]) -> np.ndarray:
    """Contact history of corners, by these names of corners and chains; contacts of others are left out."""
    numbered = renumbered(earlier.corners, "disc", earlier.corner_names, corners)
    return renumbered(numbered, "partner", earlier.chains, chains)


def _without_memory_of(earlier: EarlierState, walls: frozenset[str]) -> EarlierState:
    """Nothing is remembered of contacts with these walls: their chains and corners have no name."""
    chains, corners = (
        tuple("" if name.rpartition(":")[0] in walls else name for name in names)
        for names in (earlier.chains, earlier.corner_names)
    )
    return replace(earlier, chains=chains, corner_names=corners)


def with_given(sizes: Sizes | None, diameter: float, taken: RestartDiscs | None) -> Sizes | None:
    """Sizes of all discs: those of earlier runs as they are, the others as drawn, equal ones of this diameter (m)."""
    if taken is None:
        return sizes
    ids = np.arange(1, len(taken.diameters) + 1)
    drawn = np.full(len(ids), diameter) if sizes is None else sizes.diameters(ids)
    if (drawn == taken.diameters).all():
        return sizes
    return replace(sizes or Sizes((1.0,), (diameter,), (diameter,)), given=tuple(taken.diameters.tolist()))


def restart_state(taken: RestartDiscs | None, count: int, fixed: Fixed | None) -> EarlierState | None:
    """State of so many discs at the start from earlier runs; those that come after have none of it.

    The fixed discs of this case replace those of the earlier run, one for one: no slot outlives a contact that is not
    there.
    """
    if taken is None:
        return None
    more, contacts = count - len(taken.positions), taken.earlier.contacts.copy()
    beds = fixed or Fixed(1, 0)
    kept = np.ones(len(contacts), bool)
    for name in ("disc", "partner"):
        bed = contacts[name] >= FIXED
        kept &= ~bed | (contacts[name] - FIXED < beds.count)
        contacts[name][bed] += beds.first - FIXED
    other = contacts["partner"] > contacts["disc"]  # the larger id remembers; to it the discs roll the other way round
    disc, partner = contacts["disc"][other], contacts["partner"][other]
    contacts["disc"][other], contacts["partner"][other] = partner, disc
    contacts["roll"][other] *= -1.0
    return replace(
        taken.earlier,
        spins=np.concatenate([taken.earlier.spins, np.zeros(more)]),
        half=np.concatenate([taken.earlier.half, np.full((more, 3), np.nan)]),
        contacts=contacts[kept],
    )


def for_walls(earlier: EarlierState | None, walls: Iterable[MovingWall], *, remembers: bool) -> EarlierState | None:
    """State of discs from an earlier run, for a scene of these walls; it says how much memory finds no partner."""
    if earlier is None:
        return None
    walls = tuple(walls)
    chains, corners = chains_of(walls), corner_names(walls)
    none = np.empty(0, CONTACT)
    contacts = renamed(earlier, chains) if remembers else none
    held = of_corners(earlier, corners, chains) if remembers else none
    had, kept = len(earlier.contacts) + len(earlier.corners), len(contacts) + len(held)
    why = "the law of this case remembers nothing"
    if remembers:
        why = "their walls are gone or begin anew" if "" in earlier.chains else "their walls are gone"
    said = [f"the memory of {kept} contacts comes along"] if kept else []
    said += [f"that of {had - kept} contacts is dropped: {why}"] if had > kept else []
    return replace(
        earlier, contacts=contacts, chains=chains, origins=(*earlier.origins, *said), corners=held, corner_names=corners
    )
