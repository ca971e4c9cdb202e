# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy between two stations for page and screen: the ledger of every step, and frames beside it."""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lammps_jump.analysis.jump.found import Budget
from lammps_jump.analysis.report.page import Section, Table, Text
from lammps_jump.units import from_summary, shown, sure_of

DEFINITIONS = """\
carried     m [((u − c)² + v²)/2 + g y] of each disc that crosses a station; c is the velocity of the stations
contacts    F · [(v_i + v_j)/2 − c] of each contact that a station cuts;  walls: −c times their force along x
stored      change of kinetic and gravitational energy between the stations
lost        what dashpots and friction take: every contact between the stations, those that a station cuts by half
left over   elastic energy stored and carried away, and the error of its integration
frames      the same from the frames, where nothing rubs; elastic energy is in carried and stored there
"""
"""What the numbers of its section mean."""
ROWS = {
    "carried": "Carried by discs, in less out [m]",
    "contacts": "Handed on by contacts, in less out [m]",
    "walls": "Handed on by walls, in the stations' frame [m]",
    "storage": "Stored between the stations [m]",
    "dashpots": "Taken by dashpots [m]",
    "friction": "Taken by friction [m]",
    "lost": "Head lost [m]",
    "residual": "In less stored, less lost [m]",
}
"""Heads of a budget, by their keys."""
FRAME_ERRORS = {"lost": "inflow"}
"""Number of a budget from frames whose error is also that of another one."""


def place(ledger: Mapping[str, Any]) -> str:
    """The stations in words."""
    numbers = {key: ledger[f"stations_{key}"] for key in ("left", "right", "begin", "end", "speed", "discharge")}
    text = (
        "x = {left:z.2f} and {right:z.2f} m at t = {begin:z.3g} s, which move at {speed:+z.3f} m/s until {end:z.3g} s; "
        "{discharge:z.2f} m²/s flow through them"
    )
    return text.format(**numbers).replace("-", "−")


def line(summary: Mapping[str, Any]) -> str:
    """Line of the screen; empty where the case names no stations."""
    ledger = summary.get("ledger") or {}
    if ledger.get("stations_lost") is None:
        return ""
    lost, rest = (_metres(ledger[f"stations_{key}"]) for key in ("lost", "residual"))
    return f"stations: head lost {lost} m (every step counted, {rest} m left over) between {place(ledger)}"


def section(summary: Mapping[str, Any]) -> Section | None:
    """The budget of the ledger, and that from frames between the same stations; None where none was asked for."""
    ledger = summary.get("ledger") or {}
    if ledger.get("stations_lost") is None:
        return None
    found = (summary.get("jump") or {}).get("budget")
    frames = from_summary(Budget, found) if found else None
    rows = [(words, _metres(ledger[f"stations_{key}"]), _of_frames(frames, key)) for key, words in ROWS.items()]
    text = f"Energy between stations at {place(ledger)}. Heads are energies over g and the mass that came in."
    if frames is None:
        text += " Frames give no budget here: there is no jump, a wall moves between them, or friction takes energy."
    return Section(
        "Energy between stations",
        [Table(rows, ("", "ledger, exact for this run", "from frames")), Text(text)],
    )


def _metres(head: float) -> str:
    return f"{round(head, 3) + 0.0:z.3f}".replace("-", "−")


def _of_frames(budget: Budget | None, key: str) -> str:
    value, error = getattr(budget, key, None), sure_of(budget, FRAME_ERRORS.get(key, key)).value
    return shown(value, error=error, alone=True).replace("-", "−")
