# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy budget of a jump between two stations that move with its front, from frames.

What comes in less what goes out (carried by discs, and handed on by contacts) less what is stored in between is what
the dashpots take (docs/theory.md).
"""
# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)

from __future__ import annotations

from collections.abc import Mapping
from ctypes import POINTER
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.analysis.contacts import touching
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.jump.found import Budget, Jump, MeasuredJump
from lammps_jump.analysis.jump.frame import along_stream, growth_rate, move_along
from lammps_jump.analysis.profiles import bin_edges
from lammps_jump.analysis.report.page import Section, Table, Text
from lammps_jump.analysis.statistics import Mean, as_fields, mean_of
from lammps_jump.core.law import jump_law
from lammps_jump.core.library import INTEGER, INTEGERS, REAL, REALS, entry
from lammps_jump.dump.frame import Frame
from lammps_jump.scene.motion import way
from lammps_jump.units import from_summary, shown, sure_of

if TYPE_CHECKING:
    import xarray as xr

ROUNDS = 4
"""Rounds in which the velocity of the half step is rebuilt: dashpots then equal the engine's ledger within 1e-4."""
FIELDS = ("mass", "discharge", "momentum", "energy", "flux", "power", "thrust", "elastic", "elastic_flux", "dashpots")
"""Sums over the discs and contacts of a bin, over its width and the density."""
ODD = ("discharge", "flux", "power", "elastic_flux")
"""Sums that change their sign with the direction of x."""


_contact_fields = entry(
    "jump_contact_fields", n=INTEGER, laws=POINTER(jump_law), which=INTEGERS, first=INTEGERS, second=INTEGERS, x=REALS,
    state=REALS, discs=INTEGER, contact=REALS, rounds=INTEGER, low=REAL, width=REAL, bins=INTEGER, fields=REALS,
)  # fmt: skip
"""Adds power, thrust, elastic energy, its flux and dissipation of contacts to rows 5 to 9 of the fields."""


class EnergyFluxes:
    """Collects the `FIELDS` of each frame over (time, x), laboratory frame.

    ``energy`` is kinetic and gravitational energy, ``flux`` is carried by discs, ``power`` is the power of contact
    forces through vertical planes, F·(v_i + v_j)/2, ``dashpots`` what dashpots dissipate.
    """

    def __init__(self, flow: Flow, contacts: object = None):
        self.flow, self.edges = flow, bin_edges(flow.x_range, flow.bin_width)
        self.known = flow.knows_contacts and not no_budget(flow) and flow.time_step > 0 and flow.gravity > 0
        # LAMMPS' dashpots act with the velocity of the half step, the thesis' with that of the step
        self.rounds = ROUNDS if flow.scene.integrator == "velocity_verlet" else 0
        self._times: list[float] = []
        self._kept: list[np.ndarray] = []

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        if not self.known:
            return
        flow, low, width = self.flow, float(self.edges[0]), float(self.edges[1] - self.edges[0])
        bins = len(self.edges) - 1
        x, y, u, v = (np.ascontiguousarray(values, float) for values in (frame.x, frame.y, frame.vx, frame.vy))
        mass = flow.scene.mass * flow.relative_masses(frame)
        fields = np.zeros((len(FIELDS), bins))
        place = np.floor((x - low) / width).astype(int)
        inside = (place >= 0) & (place < bins)
        height = y - np.nan_to_num(flow.bed_height(x, time))
        energy = 0.5 * (u * u + v * v) + flow.gravity * height - flow.scene.gravity[0] * x
        for row, amount in enumerate((np.ones_like(u), u, u * u, energy, energy * u)):
            fields[row] = np.bincount(place[inside], (mass * amount)[inside], bins)
        # the discs are followed by one that never moves: the walls
        weight = np.multiply.outer(flow.scene.gravity, mass)
        state = np.pad([u, v, 0.5 * flow.time_step / mass, *weight], [(0, 0), (0, 1)])
        pairs = touching(frame, flow)
        which, first, second = (part.astype(np.int64) for part in (pairs.law, pairs.first, pairs.second))
        _contact_fields(
            n=len(first), laws=flow.laws, which=which, first=first, second=second, x=x, state=state, discs=frame.n + 1,
            contact=np.array(pairs[2:6], float), rounds=self.rounds, low=low, width=width, bins=bins, fields=fields,
        )  # fmt: skip
        self._times.append(time)
        self._kept.append(fields / (width * flow.scene.density))

    def result(self) -> xr.Dataset | None:
        """The fields of all frames; None where contacts are not known or rub, or bodies move: none of it is counted."""
        if not self.known:
            return None
        import xarray as xr  # 0.3 s

        kept = np.reshape(self._kept, (len(self._kept), len(FIELDS), -1))
        middles = 0.5 * (self.edges[1:] + self.edges[:-1])
        data = {name: (("time", "x"), kept[:, k]) for k, name in enumerate(FIELDS)}
        return xr.Dataset(data, {"time": self._times, "x": middles})


def energy_budget(fields: xr.Dataset | None, result: Jump) -> Budget | None:
    """Budget between the stations that the case names, else the middles of the stretches of the states of a jump.

    Parameters
    ----------
    fields : xarray.Dataset or None
        Of `EnergyFluxes`; None where they are not known.
    result : Jump
    """
    if fields is None or not isinstance(result, MeasuredJump):
        return None
    budget = _budget_of_jump(fields, result)
    return None if budget is None or moved_between(result.flow, budget) else budget


def moved_between(flow: Flow, budget: Budget) -> str:
    """Name of a wall that moves between the stations of a budget, on its way of the window; empty where none does."""
    margin, moved = flow.scene.largest, budget.speed * (budget.window[1] - budget.window[0])
    low, high = budget.x[0] + min(0.0, moved) - margin, budget.x[1] + max(0.0, moved) + margin
    for one in flow.scene.walls:
        if one.motion.kind is not None:
            (left, right), _ = way(one, *budget.window)
            if left < high and right > low:
                return one.wall.name
    return ""


def _budget_of_jump(fields: xr.Dataset, result: MeasuredJump) -> Budget | None:
    """Budget of a jump, whatever moves between the stations."""
    stations, time, sign = result.flow.scene.stations, result.track.time, result.direction
    if stations is None:
        return budget_between(fields, result, (result.upstream.middle, result.downstream.middle))
    first, last = (result.flow.scene.time(step) for step in (stations.first_step, stations.last_step))
    half = 0.5 * float(np.diff(time).min())
    used, speed = (time > first - half) & (time < last + half), sign * stations.speed
    start = min(sign * x for x in stations.x) - speed * first  # of the station upstream, along the stream
    budget = budget_between(fields, result, (0.0, stations.x[1] - stations.x[0]), (start, speed), used)
    front = result.motion.turned(sign)
    off = front.start - start + (front.speed - speed) * 0.5 * (first + last)  # the front, half-way
    return budget and replace(budget, start=budget.start - off, stop=budget.stop - off)


def budget_between(
    fields: xr.Dataset,
    result: MeasuredJump,
    stations: tuple[float, float],
    line: tuple[float, float] | None = None,
    used: np.ndarray | None = None,
) -> Budget | None:
    """Budget between two stations, m from the front; other parameters as of `energy_budget`.

    Parameters
    ----------
    line : (float, float), optional
        Place along the stream at t = 0 (m) and speed (m/s) of another moving origin than the front.
    used : ndarray of bool, shape (frames,), optional
        Other frames than those of the window that have a jump.
    """
    sign, front = result.direction, result.motion.turned(result.direction)
    begin, c = line or (front.start, front.speed)
    stream = along_stream(fields.isel(time=result.used if used is None else used), sign, ODD)
    time = stream.time.values
    fronts = begin + c * time
    moving = move_along(stream, fronts, np.full(len(time), np.inf))
    a = moving.fields
    energy = a["energy"] - c * a["discharge"] + 0.5 * c * c * a["mass"]
    carried = a["flux"] - c * a["momentum"] + 0.5 * c * c * a["discharge"] - c * energy
    carried = carried + a["elastic_flux"] - c * a["elastic"]
    power = a["power"] - c * a["thrust"]
    through = a["discharge"] - c * a["mass"]
    scale = result.flow.gravity * float(np.nanmean(moving.at(stations[0], through)))
    discs, contacts = (
        (moving.at(stations[0], values) - moving.at(stations[1], values)) / scale for values in (carried, power)
    )
    # in the frame of the front, gravity along the bed works at the speed against it; the rest is in the potential
    pull = sign * result.flow.scene.gravity[0] * c
    discs = discs - pull * moving.integral(a["mass"], *stations) / scale
    loss = moving.integral(a["dashpots"], *stations) / scale
    net, taken, scatter = mean_of(discs + contacts), mean_of(loss), mean_of(discs + contacts - loss).error
    storage = growth_rate(time, moving.integral(energy + a["elastic"], *stations) / scale)
    if not np.isfinite([net.value, taken.value]).all():
        return None
    places = [sign * float(fronts[0] + station) for station in stations]
    return Budget(
        start=stations[0] - result.mass_toe,
        stop=stations[1] - result.mass_toe,
        x=(min(places), max(places)),
        speed=sign * c,
        window=(float(time[0]), float(time[-1])),
        discharge=scale / result.flow.gravity,
        carried=float(np.nanmean(discs)),
        contacts=float(np.nanmean(contacts)),
        storage=storage,
        lost=net.value - storage,
        **as_fields(inflow=net, dashpots=taken, residual=Mean(net.value - storage - taken.value, scatter)),
        frames=int(np.isfinite(discs).sum()),
    )


def no_budget(flow: Flow) -> str:
    """Why frames give no budget, as a sentence; empty where another reason than friction or bodies holds."""
    pushed = any(motion.is_pushed for _, motion in flow.scene.walls)
    if not flow.knows_contacts or not (flow.scene.rubs or pushed):
        return ""
    cause = (
        "friction is not counted there" if flow.scene.rubs else "the work of what the discs push is not counted there"
    )
    return f"Frames give no head lost: {cause}. The native engine counts it at every step (probes.stations)."


def why_none(fields: xr.Dataset | None, result: Jump) -> str:
    """Why there is no budget of a jump, as a sentence; empty where its stations are not in the frames."""
    if fields is None or not isinstance(result, MeasuredJump):
        return no_budget(result.flow) if isinstance(result, MeasuredJump) else ""
    budget = _budget_of_jump(fields, result)
    name = moved_between(result.flow, budget) if budget else ""
    return name and (
        f"Frames give no head lost: wall '{name}' moves between the stations, and its work is not counted there. "
        "The native engine counts it at every step (probes.stations)."
    )


DEFINITIONS = """\
carried     m [((u − c)² + v²)/2 + g y] of each disc that crosses a station; c is the velocity of the stations
contacts    F · [(v_i + v_j)/2 − c] of each contact that a station cuts;  walls: −c times their force along x
stored      change of kinetic and gravitational energy between the stations
lost        what dashpots and friction take: every contact between the stations, those that a station cuts by half
left over   elastic energy stored and carried away, and the error of its integration
frames      the same from the frames, where nothing rubs; elastic energy is in carried and stored there
"""
"""Meaning of the numbers of its section."""
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
    """Budget of the ledger, with that of the frames between the same stations; None without stations."""
    ledger = summary.get("ledger") or {}
    if ledger.get("stations_lost") is None:
        return None
    budget = (summary.get("jump") or {}).get("budget")
    frames = from_summary(Budget, budget) if budget else None
    rows = [(words, _metres(ledger[f"stations_{key}"]), _of_frames(frames, key)) for key, words in ROWS.items()]
    text = f"Energy between stations at {place(ledger)}. Heads are energies over g and the mass that came in."
    if frames is None:
        text += " Frames give no budget here: there is no jump, a wall moves between them, or friction takes energy."
    return Section(
        "Energy between stations", [Table(rows, ("", "ledger, exact for this run", "from frames")), Text(text)]
    )


def _metres(head: float) -> str:
    return f"{round(head, 3) + 0.0:z.3f}".replace("-", "−")


def _of_frames(budget: Budget | None, key: str) -> str:
    value, error = getattr(budget, key, None), sure_of(budget, FRAME_ERRORS.get(key, key)).value
    return shown(value, error=error, alone=True).replace("-", "−")
