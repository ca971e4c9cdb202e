# SPDX-License-Identifier: GPL-2.0-or-later
"""State of the discs at the end of a run, or at a frame of its dump, from which another run goes on.

Every engine writes ``end.npz``, with all digits. It holds no number of an engine's own but those of `Ended.exact`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from lammps_jump.dump.find import read_dump
from lammps_jump.errors import DumpError
from lammps_jump.files import read_arrays, write_arrays
from lammps_jump.scene.scene import CONTACT, Scene

MOVES = ("vx", "vy", "spin", "half_vx", "half_vy", "half_spin")
DISC = np.dtype([("id", np.int64), *((name, float) for name in ("x", "y", *MOVES, "diameter"))])
"""A disc: place (m), velocity (m/s) and spin (rad/s) of the step and of the half step before, diameter (m)."""
NONE = 0, -1
"""First and last id of no disc."""
EXACT = "exact_"
"""Begins the names of an engine's own arrays in the file."""


@dataclass(frozen=True, eq=False)
class Ended:
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
        As `lammps_jump.scene.scene.Earlier.chains`.
    exact : mapping of str to ndarray
        As there.
    fixed : (int, int)
        First and last id of the discs of rough beds, which are left out.
    """

    time: float
    density: float
    discs: np.ndarray
    contacts: np.ndarray = field(default_factory=lambda: np.empty(0, CONTACT))
    chains: tuple[str, ...] = ()
    exact: Mapping[str, np.ndarray] = field(default_factory=dict)
    fixed: tuple[int, int] = NONE

    def __deepcopy__(self, memo: object) -> Ended:
        """Itself: nothing of it is ever changed."""
        return self

    @cached_property
    def key(self) -> str:
        """Twelve hex digits, the hash of all numbers."""
        found = hashlib.sha256(repr((self.time, self.density, self.chains)).encode())
        for array in (self.discs, self.contacts, *self.exact.values()):
            found.update(array.tobytes())
        return found.hexdigest()[:12]


def ended(
    scene: Scene,
    step: int,
    columns: Mapping[str, np.ndarray],
    slots: tuple[np.ndarray, ...] | None = None,
    exact: Mapping[str, np.ndarray] | None = None,
) -> Ended:
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
    return Ended(scene.time(step), scene.density, _without(discs, fixed), contacts, scene.chains, exact or {}, fixed)


def _without(discs: np.ndarray, fixed: tuple[int, int]) -> np.ndarray:
    return discs[(discs["id"] < fixed[0]) | (discs["id"] > fixed[1])]


def write_ended(path: Path, found: Ended) -> None:
    """Write a state; OSError where that cannot be."""
    write_arrays(
        path,
        of=np.array([found.time, found.density, *found.fixed]),
        discs=found.discs,
        contacts=found.contacts,
        chains=np.array(found.chains, str),
        **{EXACT + name: array for name, array in found.exact.items()},
    )


def read_ended(path: Path) -> Ended:
    """The state that `write_ended` wrote.

    Raises
    ------
    DumpError
        The file cannot be read, or holds something else.
    """
    try:
        stored = read_arrays(path)
        time, density, first, last = map(float, stored["of"])
        discs, contacts = stored["discs"], stored["contacts"]
        if discs.dtype != DISC or contacts.dtype != CONTACT or not _is_sound(discs, contacts, len(stored["chains"])):
            raise ValueError("its columns are not those of a run")
        exact = {name.removeprefix(EXACT): array for name, array in stored.items() if name.startswith(EXACT)}
        chains, fixed = tuple(map(str, stored["chains"])), (int(first), int(last))
        return Ended(time, density, discs, contacts, chains, exact, fixed)
    except (OSError, ValueError, LookupError, TypeError, MemoryError, BadZipFile) as error:
        raise DumpError(f"{path}: holds no state of discs ({getattr(error, 'strerror', None) or error})") from None


def _is_sound(discs: np.ndarray, contacts: np.ndarray, chains: int) -> bool:
    ids = discs["id"]
    numbers = [discs[name] for name in ("x", "y", "vx", "vy", "spin", "diameter")]
    return bool(
        discs.ndim == contacts.ndim == 1
        and (np.diff(ids) > 0).all()
        and all(np.isfinite(values).all() for values in numbers)
        and (discs["diameter"] > 0).all()
        and (contacts["disc"] > 0).all()
        and (contacts["partner"] >= -chains).all()
        and all(np.isfinite(contacts[name]).all() for name in ("foot", "spring", "roll"))
    )


def at_frame(folder: Path, time: float, density: float, diameter: float, fixed: tuple[int, int] = NONE) -> Ended:
    """The state at the frame of a folder's dump that is nearest to a time (s; infinite: the last frame).

    Parameters
    ----------
    folder : Path
    time : float
    density, diameter : float
        Of the discs, where the dump does not say, kg/m^3 and m.
    fixed : (int, int)
        As of `Ended`.

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
    discs = np.zeros(frame.n, DISC)
    for name in ("half_vx", "half_vy", "half_spin"):
        discs[name] = np.nan
    discs["id"], discs["x"], discs["y"], discs["vx"], discs["vy"] = frame.ids, frame.x, frame.y, frame.vx, frame.vy
    discs["spin"] = frame.columns.get("omegaz", 0.0)
    discs["diameter"] = diameter if frame.radii is None else 2.0 * frame.radii
    return Ended(float(times[index]), density, _without(discs, fixed), fixed=fixed)
