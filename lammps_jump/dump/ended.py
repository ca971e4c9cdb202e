# SPDX-License-Identifier: GPL-2.0-or-later
"""State of discs and pushed walls at the end of a run, or at a frame of its dump, from which another run goes on.

Every engine writes ``end.npz``, with all digits. Of an engine's own it holds `DiscsAtTime.exact` alone.

Lists come from the file of a run that may have been handed on. The engine does not look at them again: an index beyond
the discs would end it, and a pair that is missing would change the run in silence.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from pathlib import Path

import numpy as np

from lammps_jump.dump.walls import NO_WALLS, PushedWalls
from lammps_jump.errors import DumpError
from lammps_jump.files import read_arrays, write_arrays
from lammps_jump.foreign import foreign
from lammps_jump.scene.scene import CONTACT, Scene

from .find import read_dump
from .frame import LARGEST_VALUE

LIST = ("list_start", "list_discs", "list_owner", "list_shift")
"""Neighbour list: where each row begins, the discs of rows; in a periodic channel disc and shift (m) of each row."""
BITS = ("x0", "y0", "ux", "uy", "uomega", "fx", "fy", "torque")
"""Columns of a disc that decide bits: its place when the list was made (m), velocities, force."""
ALL_BITS = ("x0", "y0", "fx", "fy")
"""Columns that every scene has."""
KINDS = {
    "list_start": np.int64, "list_discs": np.int32, "list_owner": np.int32, "list_shift": float, "skin": float,
    "period": float, "fixed": float, "fixed_diameters": float,
}  # fmt: skip
"""Kind of each array but ``discs``."""
ROUND = 1e-9
"""Part of a length by which a pair at the edge of the list may lie on either side of it."""


def check_kept(kept: Mapping[str, np.ndarray], discs: np.ndarray) -> None:
    """Raise ValueError where arrays are not such as the native engine keeps of these discs.

    Parameters
    ----------
    kept : mapping of str to ndarray
        ``discs`` has a row a disc in the order of the engine's memory: ``order``, the place of the disc among `discs`
        and the fixed ones after them, and columns of `BITS`. `LIST` is its neighbour list, up to a ``skin`` (m) beyond
        contact, in a channel of this ``period`` (m; 0: none). ``fixed`` and ``fixed_diameters`` (m) tell the discs of
        rough beds.
    discs : ndarray
        With x, y and diameter (m).
    """
    if not kept:
        return
    if missing := {"discs", "skin", "period", "fixed", "fixed_diameters", *LIST[:2]} - set(kept):
        raise ValueError(f"{min(missing)} is missing")
    for name, array in kept.items():
        if name != "discs" and (name not in KINDS or array.dtype != KINDS[name]):
            raise ValueError(f"{name} holds {array.dtype}, which no engine writes")
    own, fixed = kept["discs"], kept["fixed"]
    n = len(discs) + len(fixed)
    names = own.dtype.names or ()
    if fixed.ndim != 2 or fixed.shape[1] != 2 or kept["fixed_diameters"].shape != (len(fixed),):
        raise ValueError("the discs of rough beds have no places and diameters")
    if own.shape != (n,) or names[:1] != ("order",) or set(names[1:]) - set(BITS) or not set(ALL_BITS) <= set(names):
        raise ValueError(f"it keeps {len(own)} discs in another form than an engine")
    if own.dtype["order"] != np.int64 or not np.array_equal(np.sort(own["order"]), np.arange(n)):
        raise ValueError("the order of the discs in memory is none")
    if not all(own.dtype[name] == np.float64 and np.isfinite(own[name]).all() for name in names[1:]):
        raise ValueError("a place, velocity or force of the native engine is no number")
    skin, period = _length(kept, "skin"), _length(kept, "period")
    if skin <= 0.0:
        raise ValueError(f"the skin of its list is {skin:g} m")
    check_list(n, period, *(kept.get(name) for name in LIST))  # type: ignore[arg-type]
    places = np.concatenate([np.column_stack([discs["x"], discs["y"]]), fixed])[own["order"]]
    sizes = np.concatenate([discs["diameter"], kept["fixed_diameters"]])[own["order"]]
    listed = np.column_stack([own["x0"], own["y0"]])
    way = np.hypot(*(places - listed).T)
    if not (way <= 0.5 * skin * (1 + ROUND)).all():  # a NaN is not
        raise ValueError(
            f"a disc has gone {way.max():.3g} m since its neighbours were listed, {0.5 * skin:.3g} m at most"
        )
    if not _is_whole(kept, (listed, 0.5 * sizes), skin, period):
        raise ValueError("its neighbour list lacks discs that are close to each other")


def _length(kept: Mapping[str, np.ndarray], name: str) -> float:
    """A length, m; ValueError for an array, or a number that is no length."""
    if kept[name].shape or not 0.0 <= float(kept[name]) < np.inf:
        raise ValueError(f"{name} is no length")
    return float(kept[name])


def check_list(
    n: int,
    period: float,
    start: np.ndarray,
    discs: np.ndarray,
    owner: np.ndarray | None = None,
    shift: np.ndarray | None = None,
) -> int:
    """Number of the sorted rows of a neighbour list of n discs; ValueError where it is none.

    Rows of their numbers come first, with neighbours of higher numbers; then those of discs that came later, with lower
    ones; then, in a channel with a `period` (m), those of images. Numbers of a row ascend.
    """
    if (owner is None) != (period == 0.0) or (shift is None) != (owner is None):
        raise ValueError("its neighbour list is of another channel")
    for name, array in zip(LIST, (start, discs, owner, shift), strict=True):
        if array is not None and array.dtype != KINDS[name]:
            raise ValueError(f"{name} holds {array.dtype}, which no engine writes")
    rows = n if owner is None else owner.size
    if not (start.ndim == discs.ndim == 1 and start.size == rows + 1 and rows >= n and (n or not rows)):
        raise ValueError(f"its neighbour list has {start.size - 1} rows for {n} discs")
    counts = np.diff(start)
    if start[0] or (counts < 0).any() or start[-1] != discs.size:
        raise ValueError("rows of its neighbour list do not follow each other")
    if discs.size and not 0 <= int(discs.min()) <= int(discs.max()) < n:
        raise ValueError(f"its neighbour list names disc {int(discs.max())}, of {n}")
    row = np.repeat(np.arange(rows), counts)
    if ((np.diff(discs) <= 0) & (np.diff(row) == 0)).any():
        raise ValueError("a row of its neighbour list does not ascend")
    late = np.flatnonzero((discs < row) & (row < n))
    ordered = int(row[late[0]]) if late.size else n
    early, is_late = row < ordered, (row >= ordered) & (row < n)
    if (discs[early] <= row[early]).any() or (discs[early] >= ordered).any() or (discs[is_late] >= row[is_late]).any():
        raise ValueError("a pair of its neighbour list stands in the wrong row")
    if owner is not None and shift is not None:
        own = np.array_equal(owner[:n], np.arange(n)) and not shift[:n].any() and shift.shape == owner.shape
        images = owner[n:]
        if (
            not own
            or (shift[n:] != period).any()
            or ((images < 0) | (images >= n)).any()
            or (np.diff(images) <= 0).any()
        ):
            raise ValueError("images of its neighbour list are none")
    return ordered


def _is_whole(kept: Mapping[str, np.ndarray], disc: tuple[np.ndarray, np.ndarray], skin: float, period: float) -> bool:
    """Tells whether the list holds all pairs whose surfaces were closer than the skin, of places (m) and radii (m)."""
    from scipy.spatial import cKDTree  # 0.1 s, which a case without an earlier run need not wait for

    places, radii = disc
    n, reach = len(radii), 2.0 * float(radii.max(initial=0.0)) + skin
    start, discs = kept["list_start"], kept["list_discs"].astype(np.int64)
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    tree = cKDTree(places)

    def lacks(one: np.ndarray, two: np.ndarray, apart: np.ndarray, listed: np.ndarray) -> bool:
        wanted = np.hypot(*apart.T) < (radii[one] + radii[two] + skin) * (1 - ROUND)
        return not np.isin((one * n + two)[wanted], listed).all()

    one, two = tree.query_pairs(reach, output_type="ndarray").T
    own = row < n
    pairs = np.minimum(row, discs)[own] * n + np.maximum(row, discs)[own]
    if lacks(one, two, places[one] - places[two], pairs):
        return False
    if not period:
        return True
    beyond = [period, 0.0]
    near = np.flatnonzero(places[:, 0] + period < places[:, 0].max(initial=-np.inf) + reach)
    neighbours = tree.query_ball_point(places[near] + beyond, reach)
    one = np.repeat(near, [len(others) for others in neighbours])
    two = np.array([other for others in neighbours for other in others], np.int64)
    images = kept["list_owner"][row[~own]] * n + discs[~own]
    return not lacks(one, two, places[one] + beyond - places[two], images)


MOVES = ("vx", "vy", "spin", "half_vx", "half_vy", "half_spin")
DISC = np.dtype([("id", np.int64), *((name, float) for name in ("x", "y", *MOVES, "diameter"))])
"""A disc: place (m), velocity (m/s) and spin (rad/s) of the step and of the half step before, diameter (m)."""
NONE = 0, -1
"""First and last id of no disc."""
EXACT = "exact_"
"""Begins the names of an engine's own arrays in the file."""
AT_END, STOPPED, AT_FRAME, NO_END = (
    "its end",
    "where it was stopped",
    "the nearest frame",
    "the last frame of its dump: it has no end.npz",
)
"""State of a run that it is, in words."""
MOST_IDS = 1 << 40
"""Ids are below; what stands for a fixed disc is above (`lammps_jump.case.earlier`)."""
DENSITIES = 1e-3, 1e6
"""Least and largest density that a case may have, kg/m^3."""
WIDEST = 16.0
"""Largest diameter over the smallest: a case lists those from a quarter to four times its nominal one."""


@dataclass(frozen=True, eq=False)
class DiscsAtTime:
    """Discs of a run at one time, those of rough beds left out.

    Attributes
    ----------
    time : float
        Simulated time, s.
    density : float
        Of the discs, kg/m^3.
    discs : ndarray of DISC, by id
        Velocities of the half step are NaN where they are not known.
    contacts : ndarray of lammps_jump.scene.scene.CONTACT
        What discs remember of their contacts.
    chains : tuple of str
        As `lammps_jump.scene.scene.EarlierState.chains`.
    exact : mapping of str to ndarray
        As there.
    fixed : (int, int)
        First and last id of the discs of rough beds, which are left out.
    which : str
        Which state of the run it is, in words: `AT_END`, `STOPPED`, `AT_FRAME` or `NO_END`. It is in no hash.
    walls : PushedWalls
        Bodies, lids and tailgates.
    """

    time: float
    density: float
    discs: np.ndarray
    contacts: np.ndarray = field(default_factory=lambda: np.empty(0, CONTACT))
    chains: tuple[str, ...] = ()
    exact: Mapping[str, np.ndarray] = field(default_factory=dict)
    fixed: tuple[int, int] = NONE
    which: str = AT_END
    walls: PushedWalls = NO_WALLS

    def __deepcopy__(self, memo: object) -> DiscsAtTime:
        """Itself: nothing of it is ever changed."""
        return self

    @cached_property
    def key(self) -> str:
        """Twelve hex digits, the hash of all numbers."""
        digest = hashlib.sha256(repr((self.time, self.density, self.chains)).encode())
        for array in (self.discs, self.contacts, *self.exact.values(), *self.walls.arrays.values()):
            digest.update(array.tobytes())
        return digest.hexdigest()[:12]


def ended(
    scene: Scene,
    step: int,
    columns: Mapping[str, np.ndarray],
    slots: tuple[np.ndarray, ...] | None = None,
    exact: Mapping[str, np.ndarray] | None = None,
    walls: PushedWalls = NO_WALLS,
) -> DiscsAtTime:
    """The state at a step.

    Parameters
    ----------
    scene : Scene
    step : int
    columns : mapping of str to ndarray, shape (n,)
        Columns of `DISC`, in any order of the discs.
    slots : tuple of ndarray, shape (n, S), optional
        Partners, feet, springs and rolling springs that each disc remembers, in the same order.
    exact : mapping, optional
    walls : PushedWalls, optional
    """
    ids = columns["id"].astype(np.int64)
    discs = np.zeros(len(ids), DISC)
    for name in columns:
        discs[name] = columns[name]
    contacts = np.empty(0, CONTACT)
    if slots is not None:
        partner, *values = slots
        at = np.nonzero((partner != 0) & (partner < ids[:, None]))  # of two discs that both remember, the larger id
        contacts = np.zeros(len(at[0]), CONTACT)
        contacts["disc"], contacts["partner"] = ids[at[0]], partner[at]
        for name, array in zip(("foot", "spring", "roll"), values, strict=True):
            contacts[name] = array[at]
    discs = discs[np.argsort(ids, kind="stable")]
    fixed = (scene.fixed.first, scene.fixed.last) if scene.fixed else NONE
    moving = _without(discs, fixed)
    return DiscsAtTime(scene.time(step), scene.density, moving, contacts, scene.chains, exact or {}, fixed, walls=walls)


def _without(discs: np.ndarray, fixed: tuple[int, int]) -> np.ndarray:
    return discs[(discs["id"] < fixed[0]) | (discs["id"] > fixed[1])]


def write_ended(path: Path, discs: DiscsAtTime) -> None:
    """Write a state; OSError where that cannot be."""
    write_arrays(
        path,
        of=np.array([discs.time, discs.density, *discs.fixed]),
        discs=discs.discs,
        contacts=discs.contacts,
        chains=np.array(discs.chains, str),
        which=np.array(discs.which),
        **discs.walls.arrays,
        **{EXACT + name: array for name, array in discs.exact.items()},
    )


def read_ended(path: Path) -> DiscsAtTime:
    """The state that `write_ended` wrote, each number held against what it means.

    Raises
    ------
    DumpError
        The file cannot be read, or holds something else.
    """
    with foreign(DumpError, f"{path}: holds no state of discs"):
        stored = read_arrays(path)
        time, density, first, last = stored["of"].tolist()
        if stored["chains"].dtype.kind != "U" or stored["chains"].ndim != 1:
            raise ValueError("its chains have no names")
        exact = {name.removeprefix(EXACT): array for name, array in stored.items() if name.startswith(EXACT)}
        if not all(float(id).is_integer() for id in (first, last)):
            raise ValueError(f"its fixed discs have the numbers {first:g} to {last:g}")
        discs = DiscsAtTime(
            time, density, stored["discs"], stored["contacts"], tuple(map(str, stored["chains"])), exact,
            (int(first), int(last)), str(stored["which"]), PushedWalls.of(stored, len(stored["chains"])),
        )  # fmt: skip
        _check(discs)
        return discs


def _check(discs: DiscsAtTime) -> None:
    """Raise ValueError where a number of a state is none that a run has."""
    (low, high), (first, last) = DENSITIES, discs.fixed
    if not abs(discs.time) <= LARGEST_VALUE or not low <= discs.density <= high:
        raise ValueError(f"its time is {discs.time:g} s and its density {discs.density:g} kg/m3")
    if (first, last) != NONE and not 1 <= first <= last < MOST_IDS:
        raise ValueError(f"its fixed discs have the numbers {first} to {last}")
    if discs.which not in (AT_END, STOPPED, AT_FRAME, NO_END):
        raise ValueError(f"it says that it is {discs.which!r}"[:100])
    check_discs(discs.discs, discs.fixed)
    _check_contacts(discs)
    check_kept(discs.exact, discs.discs)


def check_discs(discs: np.ndarray, fixed: tuple[int, int]) -> None:
    """Raises ValueError where ids, places, sizes or speeds of discs, with `fixed` ones, are those of no run."""
    if discs.dtype != DISC or discs.ndim != 1:
        raise ValueError("its columns are not those of a run")
    ids, sizes = discs["id"], discs["diameter"]
    if (ids < 1).any() or (ids >= MOST_IDS).any() or (np.diff(ids) <= 0).any():
        raise ValueError("its discs have no numbers that ascend from 1")
    if ((ids >= fixed[0]) & (ids <= fixed[1])).any():
        raise ValueError("a disc that moves has the number of a fixed one")
    least, most = (float(sizes.min()), float(sizes.max())) if len(sizes) else (1.0, 1.0)
    if not 0.0 < least <= most <= min(WIDEST * least * (1 + 1e-9), LARGEST_VALUE):  # a NaN is neither
        raise ValueError(f"diameters from {least:g} to {most:g} m are none of one case")
    for name in ("x", "y", *MOVES):
        values = discs[name]
        unknown = np.isnan(values) if name.startswith("half_") else np.zeros(len(values), bool)
        wrong = ~(np.abs(values) <= LARGEST_VALUE) & ~unknown
        if wrong.any():
            at = int(np.argmax(wrong))
            raise ValueError(f"{name} of disc {ids[at]} is {values[at]:g}")


def _check_contacts(discs: DiscsAtTime) -> None:
    """Raise ValueError where what discs remember is of no disc or chain, or no length."""
    contacts = discs.contacts
    if contacts.dtype != CONTACT or contacts.ndim != 1:
        raise ValueError("its contacts are not those of a run")
    disc, partner = contacts["disc"], contacts["partner"]
    if (disc < 1).any() or (disc >= MOST_IDS).any() or (partner >= MOST_IDS).any() or (disc == partner).any():
        raise ValueError("a contact is of no disc")
    if (partner == 0).any() or (partner < -len(discs.chains)).any():
        raise ValueError("a contact is with no wall")
    for name in ("foot", "spring", "roll"):
        if not (np.abs(contacts[name]) <= LARGEST_VALUE).all():
            raise ValueError(f"{name} of a contact is no length")


def at_frame(
    folder: Path, time: float, density: float, diameter: float, last: DiscsAtTime | None = None
) -> DiscsAtTime:
    """The state at the frame of a folder's dump that is nearest to a time (s; infinite: the last frame).

    Parameters
    ----------
    folder : Path
    time : float
    density, diameter : float
        Of the discs, where the dump does not say, kg/m^3 and m.
    last : Ended, optional
        State at the end of the run, where it kept one: it names fixed discs and pushed walls.

    Raises
    ------
    DumpError
        No dump that can be read, no frame in it, or a time outside of it.
    """
    dump = read_dump(folder)
    headers = dump.headers()
    times = np.array([inf if header.time is None else header.time for header in headers])
    if not len(times) or not np.isfinite(times).all():
        raise DumpError(f"{dump.path}: holds no frame with a time")
    if time < inf and not times[0] - 1e-9 <= time <= times[-1] + 1e-9:
        raise DumpError(f"{time:g} s is outside its dump; allowed is {times[0]:g} to {times[-1]:g} s")
    index = len(times) - 1 if time == inf else int(np.argmin(np.abs(times - time)))
    frame = dump[index].sorted()
    with foreign(DumpError, f"{dump.path}: no run can begin from its frame at {times[index]:g} s"):
        numbers = frame.columns.get("id", np.empty(0))
        if len(numbers) != frame.n or (numbers % 1 != 0).any() or (np.abs(numbers) >= MOST_IDS).any():
            raise ValueError("its discs have no numbers")
        discs = np.zeros(frame.n, DISC)
        for name in ("half_vx", "half_vy", "half_spin"):
            discs[name] = np.nan
        discs["id"], discs["x"], discs["y"], discs["vx"], discs["vy"] = frame.ids, frame.x, frame.y, frame.vx, frame.vy
        discs["spin"] = frame.columns.get("omegaz", 0.0)
        discs["diameter"] = diameter if frame.radii is None else 2.0 * frame.radii
        when, fixed = float(times[index]), NONE if last is None else last.fixed
        listed = DiscsAtTime(
            when, density, _without(discs, fixed), fixed=fixed, which=AT_FRAME if time < inf else NO_END,
            walls=PushedWalls(known=False) if last is None else last.walls.at(folder, when),
        )  # fmt: skip
        _check(listed)
        return listed
