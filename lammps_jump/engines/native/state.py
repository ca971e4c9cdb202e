# SPDX-License-Identifier: GPL-2.0-or-later
"""The whole state of a native simulation in a file: one that is read back goes on bit for bit as the other would have.

Between steps nothing is left out that the next step reads: velocities of the half step and of the one before, forces,
the order of the discs in memory and the present neighbour lists (both decide the order of sums), open windows of
the probes, the turns of the inlets, the random generator of a pour, and the energy ledger.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import astuple
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, Field, NonNegativeFloat

from lammps_jump.core.columns import Phase, PlacedColumns, PushedColumns, WallMotion
from lammps_jump.dump.ended import BITS, DiscsAtTime, ended
from lammps_jump.dump.walls import PushedWalls, pushed_walls
from lammps_jump.errors import ResumeError
from lammps_jump.files import read_arrays, write_arrays
from lammps_jump.foreign import foreign
from lammps_jump.scene.scene import Scene

from .arrays import Loops
from .discs import DiscArrays
from .ledger import EnergyNow, spin, velocities
from .simulation import NativeSimulation

COUNTS = ("step", "disc_steps", "rebuilds", "rebuild_seconds")
Count = Annotated[int, Field(ge=0, le=1 << 53)]


class Plain(BaseModel, strict=True, extra="forbid"):
    """Content of a file of a state, without its arrays: counts, sums, rows of forces, the random generator."""

    n: Count
    step: Count
    disc_steps: Count
    rebuilds: Count
    rebuild_seconds: NonNegativeFloat
    exchanged: dict[str, float]
    start_energy: Annotated[list[float], Field(min_length=3, max_length=3)]
    start_fallen: float
    window_begin: Count
    forces: list[list[int | str | float]]
    bodies: list[tuple[Count, str, list[float]]]
    window_sums: dict[str, Annotated[list[float], Field(min_length=4, max_length=4)]]
    gates: dict[str, float]
    rows: list[Count]
    pours: list[Count]
    random: dict[str, Any]
    traffic: Annotated[list[Count], Field(min_length=4, max_length=4)]


def save_state(simulation: NativeSimulation, path: Path) -> None:
    """Writes a simulation that is between two steps to an npz file.

    Parameters
    ----------
    simulation : NativeSimulation
        With neighbour lists (`CellSimulation` makes its lists every step and is not saved).
    path : Path
    """
    d = simulation.discs
    boundaries, windows, books = simulation.boundaries, simulation.windows, simulation.books
    plain = {
        "n": d.n,
        **{name: getattr(simulation, name) for name in COUNTS},
        "exchanged": books.exchanged,
        "start_energy": astuple(books.start),
        "start_fallen": books.start_fallen,
        "window_begin": windows.begin,
        "forces": windows.forces,
        "bodies": windows.bodies,
        "window_sums": {name: list(row) for name, row in windows.sums.items()},
        "gates": simulation.gates.areas,
        "rows": [state.entered for state in boundaries.rows],
        "pours": [state.entered for state in boundaries.pours],
        "random": boundaries.rng.bit_generator.state,
        "traffic": [boundaries.inserted, boundaries.removed, boundaries.inserted, boundaries.sized],
    }
    arrays = {name: getattr(d, name)[: d.n] for name in d.columns}
    near = {f"near_{name}": array for name, array in simulation.walls.listed.items()}
    write_arrays(
        path,
        plain=np.array(json.dumps(plain)),
        **{f"list_{name}": array for name, array in d.listed(simulation.listed_pairs()).items()},
        wall_sum=simulation.walls.sums,
        **near,
        **_moves(simulation),
        **_corners(simulation),
        **{f"corners_near_{name}": array for name, array in simulation.walls.listed_corners.items()},
        work=books.work,
        start_work=books.start_work,
        stations=simulation.stations.sums,
        **_pressed(simulation),
        **arrays,
    )


def _pressed(simulation: NativeSimulation) -> dict[str, np.ndarray]:
    """Forces on stretches of outlines: of the open window, and of those that have ended."""
    pressed, rows = simulation.walls.pressed, simulation.windows.pressed
    if pressed is None:
        return {}
    return {
        "pressed_sums": pressed.sums, "pressed_steps": np.array([step for step, _ in rows], np.int64),
        "pressed_rows": np.array([row for _, row in rows]).reshape(-1, pressed.sums.size),
    }  # fmt: skip


def _moves(simulation: NativeSimulation) -> dict[str, np.ndarray]:
    """State of moving walls that is no function of the step."""
    moves = simulation.walls.moves
    return {} if moves is None else {"moves_pushed": moves.pushed, "moves_listed": moves.listed}


def _corners(simulation: NativeSimulation) -> dict[str, np.ndarray]:
    """Memory of the corners of bodies and walls."""
    bodies = simulation.walls.bodies
    if bodies is None:
        return {}
    return {f"corners_{name}": getattr(bodies.discs, name) for name in ("partner", "sigma", "spring", "roll")}


def load_state(scene: Scene, path: Path, *, ledger: bool = True, loops: Loops | None = None) -> NativeSimulation:
    """The simulation that `save_state` wrote, made from the same scene with the same `ledger`; `loops` as there.

    Raises
    ------
    ResumeError
        The file is no such state: it was damaged, or made up.
    """
    with foreign(ResumeError, f"{path}: is no state that a run has saved", "start a new run"):
        return _loaded(scene, path, ledger, loops)


def _loaded(scene: Scene, path: Path, ledger: bool, loops: Loops | None) -> NativeSimulation:
    simulation = NativeSimulation(scene, ledger=ledger, loops=loops)
    stored = read_arrays(path)
    plain = Plain.model_validate_json(str(stored["plain"]))
    if 8 * plain.n > path.stat().st_size:
        raise ValueError(f"it is too small for {plain.n} discs")
    for name in COUNTS:
        setattr(simulation, name, getattr(plain, name))
    _load_discs(simulation.discs, plain.n, stored)
    simulation.walls.take_away(simulation.step)
    books, windows = simulation.books, simulation.windows
    books.work[:], books.start_work[:] = stored["work"], stored["start_work"]
    simulation.walls.sums[:] = stored["wall_sum"]
    for name, array in (_moves(simulation) | _corners(simulation)).items():
        array[:] = stored[name]
    simulation.walls.put(**{name: stored[f"near_{name}"] for name in simulation.walls.listed})
    simulation.walls.put_corners({name: stored[f"corners_near_{name}"] for name in simulation.walls.listed_corners})
    simulation.walls.require_lists(plain.n)
    simulation.stations.sums[:] = stored["stations"]
    if plain.exchanged.keys() != books.exchanged.keys():
        raise ValueError("its energy balance has other terms")
    books.exchanged, books.start = plain.exchanged, EnergyNow(*plain.start_energy)
    books.start_fallen = plain.start_fallen
    windows.begin = plain.window_begin
    windows.sums = {name: np.array(row) for name, row in plain.window_sums.items()}
    windows.forces = [(step, name, *values) for step, name, *values in plain.forces]  # type: ignore[misc]
    windows.bodies = [(step, name, tuple(values)) for step, name, values in plain.bodies]
    if simulation.walls.pressed is not None:
        simulation.walls.pressed.sums[:] = stored["pressed_sums"]
        windows.pressed = list(zip(stored["pressed_steps"].tolist(), stored["pressed_rows"], strict=True))
    simulation.gates.areas = plain.gates
    boundaries = simulation.boundaries
    for states, counts in ((boundaries.rows, plain.rows), (boundaries.pours, plain.pours)):
        for state, count in zip(states, counts, strict=True):
            state.entered = count
    boundaries.rng.bit_generator.state = plain.random
    inserted, removed, _, sized = plain.traffic
    ids = simulation.discs.ids[: plain.n]
    if not (sized <= inserted == removed + plain.n and (ids >= 1).all() and ids.max(initial=0) <= inserted):
        raise ValueError(f"it has {plain.n} discs of {inserted}, of which {removed} have left")
    boundaries.inserted, boundaries.removed, boundaries.sized = inserted, removed, sized
    return simulation


def _load_discs(discs: DiscArrays, n: int, stored: Mapping[str, np.ndarray]) -> None:
    while discs.room < n + 1:
        discs.grow()
    discs.n = n
    for name in discs.columns:
        held = getattr(discs, name)[:n]
        array = stored[name]
        if array.shape != held.shape or array.dtype != held.dtype:
            raise ValueError(f"{name}: {array.shape} {array.dtype} in place of {held.shape} {held.dtype} numbers")
        held[:] = stored[name]
    names = ("start", "discs", *(("owner", "shift") if discs.period is not None else ()))
    discs.put_list(**{name: stored[f"list_{name}"] for name in names})


def fingerprint(discs: DiscArrays) -> str:
    """SHA-256 of a state: ids, places, velocities and spins of all discs as they are in memory, in the order of ids.

    Numbers are float64, little-endian, without minus zero; velocities and spins are those between two steps. A page
    that computes a run again has the same (``live/again.js``).
    """
    order = np.argsort(discs.ids[: discs.n])
    columns = [discs.ids, discs.x, discs.y, discs.vx, discs.vy, *([] if discs.omega is None else [discs.omega])]
    parts = [(one[: discs.n][order].astype("<f8") + 0.0).tobytes() for one in columns]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def ended_of(simulation: NativeSimulation) -> DiscsAtTime:
    """The state of a simulation that is between two steps, from which another run goes on.

    The order in memory and the lists are there too: they decide the order of sums.
    """
    d, scene = simulation.discs, simulation.scene
    n, still = d.n, np.zeros(d.n)
    vx, vy = velocities(scene, d)
    columns = {
        **{"id": d.ids[:n], "x": d.x[:n], "y": d.y[:n], "vx": vx, "vy": vy},
        "spin": still if d.omega is None else spin(scene, d),
        **{"half_vx": d.vx[:n], "half_vy": d.vy[:n], "half_spin": still if d.omega is None else d.omega[:n]},
        "diameter": still + scene.diameter if d.radius is None else 2.0 * d.radius[:n],
    }
    slots = (d.partner[:n], d.sigma[:n], d.spring[:n], d.roll[:n]) if d.partner is not None else None
    bed = np.zeros(n, bool) if scene.fixed is None else scene.fixed.holds(d.ids[:n])
    rows = np.lexsort((d.ids[:n], bed))  # fixed discs come last in another run
    held = {"order": np.argsort(rows), **{name: getattr(d, name)[:n] for name in BITS if name in d.columns}}
    own = np.empty(n, [(name, array.dtype) for name, array in held.items()])  # one array: each costs time in the file
    for name, array in held.items():
        own[name] = array
    exact = {f"list_{name}": array for name, array in d.listed(simulation.listed_pairs()).items()}
    exact |= {"discs": own, "skin": np.array(simulation.skin), "period": np.array(d.period or 0.0)}
    late_rows = rows[n - int(bed.sum()) :]
    exact |= {
        "fixed": np.column_stack([d.x[:n], d.y[:n]])[late_rows],
        "fixed_diameters": columns["diameter"][late_rows],
    }
    return ended(scene, simulation.step, columns, slots, exact, _pushed(simulation))


def _pushed(simulation: NativeSimulation) -> PushedWalls:
    """Walls whose pose is state, as they are now."""
    scene, walls, bodies = simulation.scene, simulation.walls, simulation.walls.bodies
    rows: dict[str, dict[str, Any]] = {}
    if walls.moves is None:
        return PushedWalls()
    for number in np.flatnonzero(walls.moves.moving >= WallMotion.LOADED).tolist():
        name, row = walls.names[number], walls.moves.pushed[number]
        looked = simulation.gates.looked(name, simulation.step)
        rows[name] = {
            "released": row[PushedColumns.PHASE] == Phase.HAS_MOVED,
            "place": row[PushedColumns.PLACE], "speed": walls.moves.now[number, PlacedColumns.CENTRED],
            "half": row[PushedColumns.SPEED], "before": row[PushedColumns.BEFORE],
            "force": row[PushedColumns.FORCE], "listed": walls.moves.listed[number], **looked,
        }  # fmt: skip
    d = None if bodies is None else bodies.discs
    slots = None if d is None or scene.springs is None else (d.partner, d.sigma, d.spring, d.roll)
    return pushed_walls(scene, rows, slots)
