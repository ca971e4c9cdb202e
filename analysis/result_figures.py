"""Which figures a run gets, and the figures of the front and the energy: the measurement with the theory beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.snapshots import snapshots
from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, depth_profile, new_figure, save, style, xt_map
from lammps_jump.dump.read import open_dump
from lammps_jump.errors import DumpError
from lammps_jump.physics import jump as theory
from lammps_jump.physics import measured as reference_data

from .energy import EnergyHistory
from .flow import Flow
from .front import FrontHistory, dimensionless
from .passes import Gathered

MARKERS = {"color": BLACK, "ls": "none", "mfc": "white", "ms": 4}


def draw_all(gathered: Gathered, shown: dict, folder: Path, dump: Path) -> list[str]:
    """Draw every figure that the results call for into `folder`; returns their names relative to its parent."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DumpError(f"{folder}: cannot be made ({error.strerror}); name another folder.") from error
    written = []
    for name, draw in _wanted(gathered, shown, dump).items():
        figure = draw()
        if figure is None:
            continue
        written.append(f"{folder.name}/{save(figure, folder / name).name}")
    return written


def _wanted(gathered: Gathered, shown: dict, dump: Path) -> dict[str, Callable[[], Figure | None]]:
    profiles, flow = gathered.profiles, gathered.flow
    # a picture has a thousand rows of pixels at most: long records are thinned for the maps
    thinned = profiles.isel(time=slice(None, None, max(1, profiles.sizes["time"] // 600)))
    jump = shown.get("jump")
    lines: dict[str, float] = {}
    marks: dict[str, float] = {}
    track = None
    if jump is not None:
        from lammps_jump.analysis.jump.summary import inflow_theory, summarise_jump

        inflow, found = inflow_theory(flow), summarise_jump(jump)
        if inflow:
            lines[f"inflow y₁ = {inflow['depth']:.3g} m"] = inflow["depth"]
            lines[f"Bélanger of the inflow y₂ = {inflow['belanger_y2']:.3g} m"] = inflow["belanger_y2"]
        if jump.upstream is not None:
            marks = {"toe": found["toe"], "end": found["end"]}
        if jump.track is not None and jump.track.found.any():
            good = jump.track.found
            track = (jump.direction * jump.track.toe[good], jump.track.time[good])
    wanted: dict[str, Callable[[], Figure | None]] = {
        "depth_profile.png": lambda: depth_profile(profiles, flow, lines=lines, marks=marks),
        "depth_map.png": lambda: xt_map(thinned, toe=track),
        "snapshots.png": lambda: snapshots(open_dump(dump), flow),
    }
    if jump is not None:
        from .jump import figures as jump_figures

        wanted["jump_track.png"] = lambda: jump_figures.track_figure(jump)
        wanted["jump_frame.png"] = lambda: jump_figures.frame_figure(jump)
        wanted["jump_balance.png"] = lambda: jump_figures.balance_figure(jump)
        wanted["energy_head.png"] = lambda: jump_figures.head_figure(profiles, jump)
    if gathered.front is not None:
        wanted["front.png"] = lambda: front_figure(gathered.front, flow)
        wanted["martin_moyce.png"] = lambda: martin_moyce_figure(gathered.front, flow)
    if gathered.energy is not None:
        wanted["energy.png"] = lambda: energy_figure(gathered.energy, flow)
    if "force" in shown:
        from .forces import figures as force_figures

        wanted["forces.png"] = lambda: force_figures.history_figure(shown["force"])
        wanted["impulse.png"] = lambda: force_figures.impulse_figure(shown["force"])
        wanted["reflected_wave.png"] = lambda: force_figures.reflected_figure(shown["force"], thinned)
    return wanted


def front_figure(history: FrontHistory, flow: Flow) -> Figure | None:
    """Front, column height and surface speed against time; Ritter's front while it holds."""
    good = np.isfinite(history.bulk)
    if not good.any():
        return None
    base, depth = history.column
    gravity = -flow.scene.gravity[1]
    with style():
        figure, (upper, middle, lower) = new_figure(7.2, 6.4, 3, 1, sharex=True, height_ratios=[1.5, 1, 1])
        upper.plot(history.time, history.bulk, color=BLUE, label="bulk front")
        upper.plot(history.time, history.quantile, color=GOLD, ls="--", label="99 % of the discs")
        if gravity > 0 and depth > 0:
            limit = theory.ritter_wall_time(base, depth, gravity)
            t = np.linspace(0, max(min(limit, history.time.max()), 1e-9), 20)
            label = f"Ritter, until its wave meets the back wall (t = {limit:.2g} s)"
            upper.plot(t, base + 2 * t * np.sqrt(gravity * depth), color=BLACK, ls=":", label=label)
        upper.set_ylabel("Distance from\nthe back wall [m]")
        upper.set_title(f"{flow.scene.name}: front and column")
        upper.legend()
        middle.plot(history.time, history.height, color=BLUE)
        middle.set_ylabel("Column at the\nback wall [m]")
        middle.set_ylim(bottom=0)
        lower.plot(history.time, history.top_speed, color=BLUE, label="surface, mean")
        lower.plot(history.time, history.tip_speed, color=GOLD, ls="--", label="tip (last 5 d)")
        lower.axhline(0, color=GREY, lw=0.8)
        lower.set_ylabel("Velocity u [m/s]")
        lower.set_xlabel("Time t [s]")
        lower.legend()
    return figure


def martin_moyce_figure(history: FrontHistory, flow: Flow) -> Figure | None:
    """Front and column height in Martin & Moyce's variables with their measurements beside them."""
    gravity = -flow.scene.gravity[1]
    base, depth = history.column
    if not np.isfinite(history.bulk).any() or gravity <= 0 or not base > 0 or not depth > 0:
        return None
    from .front import free_length

    values = dimensionless(history, gravity)
    live = history.time >= 0
    if live.sum() < 2:
        return None
    free = free_length(flow, history) / base
    with style():
        figure, (left, right) = new_figure(8.4, 3.8, 1, 2)
        front, tall = reference_data.MARTIN_MOYCE_FRONT, reference_data.MARTIN_MOYCE_HEIGHT
        left.plot(values["T"][live], values["Z"][live], color=BLUE, label="bulk front")
        left.plot(values["T"][live], values["Z99"][live], color=GOLD, ls="--", label="99 % of the discs")
        left.plot(front.x, front.y, marker="o", label="Martin & Moyce 1952, n² = 2", **MARKERS)
        left.set_xlim(0, min(values["T"].max(), 5))
        left.set_ylim(1, max(5.0, 1.08 * min(free, 6)))
        if free < left.get_ylim()[1]:
            left.axhline(free, color=GREY, ls="-.", lw=1)
            left.annotate("first obstacle", (0.02, free), (0, 2), xycoords=("axes fraction", "data"),
                          textcoords="offset points", fontsize=8, color=GREY)  # fmt: skip
        left.set_xlabel("T = n t √(g/a)")
        left.set_ylabel("Z = front / a")
        left.legend(loc="lower right")
        left.set_title(f"n² = H/a = {depth / base:.3g} here")
        right.plot(values["tau"][live], values["h"][live], color=BLUE, label="column")
        right.plot(tall.x, tall.y, marker="o", label="Martin & Moyce 1952, n² = 2", **MARKERS)
        right.set_xlim(0, min(values["tau"].max(), 5.5))
        right.set_ylim(0, 1.05)
        right.set_xlabel("τ = t √(g/a)")
        right.set_ylabel("h / H")
        right.legend()
    return figure


def energy_figure(history: EnergyHistory, flow: Flow) -> Figure | None:
    """Parts of the energy against time; where nothing dissipates the deviation from the start below."""
    if not len(history.time):
        return None
    total = history.total
    conservative = flow.conservative and history.same_discs and total[0] != 0
    with style():
        figure, axes = new_figure(7.2, 5.2 if conservative else 3.6, 2 if conservative else 1, 1, sharex=True)
        upper = axes[0] if conservative else axes
        scale, unit = (1e6, "MJ/m") if total.max() > 1e6 else (1e3, "kJ/m") if total.max() > 1e4 else (1.0, "J/m")
        upper.plot(history.time, total / scale, color=BLACK, label="total")
        upper.plot(history.time, history.kinetic / scale, color=BLUE, ls="--", label="kinetic")
        if np.any(history.potential):
            upper.plot(history.time, history.potential / scale, color=GOLD, ls="-.", label="potential (y = 0)")
        if np.any(history.rotational):
            upper.plot(history.time, history.rotational / scale, color=GREY, ls="-", lw=1, label="spin")
        if history.elastic is not None:
            upper.plot(history.time, history.elastic / scale, color=RED, ls=":", label="elastic")
        upper.set_ylabel(f"Energy [{unit}]")
        upper.set_title(f"{flow.scene.name}: energy of the discs")
        upper.legend(ncols=2)
        if conservative:
            axes[1].plot(history.time, 100 * (total / total[0] - 1), color=BLUE)
            axes[1].axhline(0, color=GREY, lw=0.8)
            axes[1].set_ylabel("Deviation from\nthe start [%]")
        (axes[1] if conservative else axes).set_xlabel("Time t [s]")
    return figure
