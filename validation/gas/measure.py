# SPDX-License-Identifier: GPL-2.0-or-later
"""A gas of discs in a box that is periodic both ways: how it cools, and its pressure."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import numpy as np

from lammps_jump.case import load_case
from lammps_jump.studies.fluid.cell import KINETIC, LX, LY, SXX, SYY, Cell, FluidDiscs, discs_of

CASE = Path(__file__).with_name("gas.yaml")
CONTACT_SHARE = 0.01
"""Time of a contact over the mean time between two."""
CONTACT = 2.2
"""Time of a contact over d / (d sqrt(k/m)): pi / sqrt(2)."""


def collision_rate(packing: float) -> float:
    """Collisions of a disc in the time d / sqrt(T/m), by Enskog's theory with Henderson's contact value."""
    density = 4.0 * packing / pi
    at_contact = (1.0 - 7.0 * packing / 16.0) / (1.0 - packing) ** 2
    return 2.0 * sqrt(pi) * density * at_contact


def thermal_speed(discs: FluidDiscs, packing: float) -> float:
    """sqrt(T/m) at which contacts take `CONTACT_SHARE` of the time between them, m/s."""
    return CONTACT_SHARE / CONTACT / collision_rate(packing) * discs.signal_speed


def gas_cell(discs: FluidDiscs, packing: float, count: int, seed: int, collisions: float) -> tuple[Cell, float]:
    """An elastic gas after some collisions a disc, without mean velocity, and its thermal speed, m/s."""
    cell = Cell(discs, count, seed, packing=packing)
    speed = thermal_speed(discs, packing)
    random = np.random.default_rng(seed + 1000)
    for v in (cell.swarm.vx, cell.swarm.vy):
        v[:] = random.normal(0.0, speed, count)
    cell.stop()
    cell.advance(collisions * discs.diameter / speed / collision_rate(packing), 1)
    return cell, speed


def cooling(time: np.ndarray, energy: np.ndarray, begin: float, end: float) -> float:
    """1 / tau of Haff's law from a straight line through sqrt(E0 / E) = 1 + t / tau between two times."""
    chosen = (time > begin) & (time < end)
    return float(np.polyfit(time[chosen], np.sqrt(energy[0] / energy[chosen]), 1)[0])


def cools(packing: float, count: int, starts: int, restitution: float = 0.9, last: float = 3.0) -> dict:
    """Rate of cooling over that of Enskog's theory, for each start, between 0.2 and `last` tau; the last curve."""
    elastic = discs_of(load_case(CASE, {"contact.restitution": 1}))
    discs = discs_of(load_case(CASE, {"contact.restitution": restitution}))
    rates, rows = [], 200
    for seed in range(1, starts + 1):
        cell, speed = gas_cell(elastic, packing, count, seed, 20.0)
        cell.discs = discs
        tau = 4.0 / (1.0 - restitution**2) * discs.diameter / speed / collision_rate(packing)
        energy = cell.advance(last * tau, rows)[:, KINETIC]
        time = (np.arange(rows) + 0.5) * last / rows
        rates.append(cooling(time, energy, 0.2, last))
    return {"rates": rates, "time": time, "energy": energy / energy[0]}


def presses(packing: float, count: int, starts: int, collisions: float) -> dict:
    """Z = P A / (N T) of an elastic gas, for each start."""
    discs = discs_of(load_case(CASE, {"contact.restitution": 1}))
    found = []
    for seed in range(1, starts + 1):
        cell, speed = gas_cell(discs, packing, count, seed, 20.0)
        record = cell.advance(collisions * discs.diameter / speed / collision_rate(packing), 20)
        area = float(cell.box[LX] * cell.box[LY])
        pressure = 0.5 * (record[:, SXX] + record[:, SYY])
        found.append(float(np.mean(pressure) * area / np.mean(record[:, KINETIC])))
    return {"z": found}
