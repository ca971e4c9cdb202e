# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes a live page: one file with the core, the image of the scene, what scripts need to know, and the scripts.

Its policy names the hashes of its own scripts and allows WebAssembly. The thread that computes is in the page, too.
No network is used. Words of the case stay text.

Of a finished run the page holds the start and hashes, computes the run again, and holds it against what was stored. Ten
frames of the dump are compared to the digits that it has; states at the same times and the end to the last bit. Only
the native engine repeats its runs on every system. LAMMPS sums in another order: of its runs the page tells how far
they part.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from ctypes import sizeof
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from lammps_jump.analysis.draw.chart import Chart, Panel, Trace
from lammps_jump.analysis.draw.painter import disc_speeds, seen, top_of
from lammps_jump.analysis.report import page
from lammps_jump.analysis.report.frames import FramePacker
from lammps_jump.analysis.report.page import Player
from lammps_jump.analysis.report.player import about_run
from lammps_jump.case import ReadCase
from lammps_jump.case.fields import LiveSlider
from lammps_jump.case.inflow import RowsInflow
from lammps_jump.core.browser import BrowserCore, browser_core
from lammps_jump.core.columns import PlacedColumns, TrackRowColumns
from lammps_jump.dump.ended import read_ended
from lammps_jump.dump.find import forces_in, read_dump
from lammps_jump.dump.frame import Frame, ten_indices
from lammps_jump.engines.native import NativeSimulation, take_frame
from lammps_jump.engines.native.bound import jump_events, jump_inlet, jump_state
from lammps_jump.engines.native.image import image_of, narrowed
from lammps_jump.errors import SetupError
from lammps_jump.files import END_FILE, plain, read_start, text_of, write_text, writes
from lammps_jump.folders import require_replaceable
from lammps_jump.physics.elementary import power
from lammps_jump.physics.inlet import seed_factors
from lammps_jump.physics.jump import sequent_depth
from lammps_jump.runs.results import flow_of, player_of
from lammps_jump.runs.summary import read_summary
from lammps_jump.scene.walls import Interval, Wall, parts_of

from .prepare import WORD, LiveFlow, LiveStart

DIGITS = {"text": 10, "gz": 10, "binary": 17}
"""Significant digits of a number in a dump."""
OF_THE_END = ("x", "y", "half_vx", "half_vy")
"""Numbers of a disc at the end, in the order of their hash."""


MOST_COMPARED = 2_000
"""Discs of a frame of LAMMPS whose places are compared."""


@dataclass(frozen=True)
class RunAgain:
    """A run that can be computed again.

    Attributes
    ----------
    image : bytes
        The scene at its start.
    head : dict
        Of a run of the native engine ``checks``: step and hash of each frame, and of the state then, where the run kept
        one; ``end``: hash of the end; ``digits`` of a number of a frame. Of one of LAMMPS ``frames``: step, ids and
        places of discs.
    """

    image: bytes
    head: dict[str, Any]


@dataclass(frozen=True)
class Recorded:
    """A finished run as a page shows it next to a flow that goes on from it.

    Attributes
    ----------
    player : Player
        Its frames.
    forces : dict
        Of each wall whose force was recorded: times, s, and force along x, N/m.
    """

    player: Player
    forces: dict[str, tuple[np.ndarray, np.ndarray]]


def recorded_run(folder: Path, player: Player | None = None) -> Recorded | None:
    """A run folder as it was recorded; None where no frame holds a disc. `player` is its own, where it is made."""
    player = player or player_of(ReadCase.load(folder), folder)
    if player is None:
        return None
    return Recorded(player, {name: (one.time, one.fx) for name, one in forces_in(folder).items()})


def run_again(folder: Path) -> RunAgain | str:
    """A run folder as a page computes it again, or the reason why it does not.

    Raises
    ------
    JumpError
        Files of the run that cannot be read.
    """
    summary, case = read_summary(folder), ReadCase.load(folder)
    status = summary.get("status", "it has no summary")
    if status != "complete":
        return f"The run is not complete ({status}), so that there is no end to hold it against."
    scene = case.scene()
    image = image_of(NativeSimulation(scene, ledger=False), scene.steps, WORD)
    head = {"steps": scene.steps, "timeStep": scene.time_step}
    frames = list(read_dump(folder))
    chosen = [frames[index] for index in ten_indices(len(frames))]
    if summary["engine"] == "lammps":
        period = scene.domain[0][1] - scene.domain[0][0] if scene.periodic else None
        about = {"frames": [_places(frame) for frame in chosen], "diameter": scene.diameter, "period": period}
        return RunAgain(image, {**head, **about})
    digits = DIGITS[case.fields.run.dump_format]
    states = {step: text for step, text in summary.get("states", ())}
    checks = []
    for frame in chosen:
        order = np.argsort(frame.ids)
        places = _hash(frame.ids[order], *(one[order] for one in (frame.x, frame.y)))
        checks.append([frame.step, places, states.get(frame.step)])
    discs = read_ended(folder / END_FILE).discs
    end = _hash(discs["id"], *(discs[name] for name in OF_THE_END))
    fixed = (scene.fixed.first, scene.fixed.last) if scene.fixed else None
    return RunAgain(image, {**head, "checks": checks, "end": end, "digits": digits, "fixed": fixed})


def _places(frame: Frame) -> dict[str, Any]:
    """Step, ids and places of discs of a frame, every n-th of many, as base64 of int32 and float64."""
    order = np.argsort(frame.ids)[:: -(-frame.n // MOST_COMPARED) or 1]
    columns = (frame.ids.astype("<i4"), frame.x.astype("<f8"), frame.y.astype("<f8"))
    ids, x, y = (base64.b64encode(one[order].tobytes()).decode() for one in columns)
    return {"step": frame.step, "ids": ids, "x": x, "y": y}


def _hash(*columns: np.ndarray) -> str:
    """SHA-256 of columns as float64, little-endian, one after the other."""
    return hashlib.sha256(b"".join((column.astype("<f8") + 0.0).tobytes() for column in columns)).hexdigest()


HERE = Path(__file__).parent
DRAWING = ("frames.js", "discs.js", "view.js", "pointer.js", "curves.js")
"""Scripts of the report that the page has too."""
COMPUTING = ("core.js", "moves.js", "again.js", "worker.js")
"""Scripts of the thread that computes."""
SHOWING = ("download.js", "show.js")
MADE = b"<!doctype html><!-- live page of lammps-jump -->"
"""A live page begins so."""
TICK = 0.02
"""Flow between two looks at the sliders, s; more where steps are long."""
STEPS_A_TICK = 20
MOST_ROWS, MOST_TIMES = 5_000, 1_000
"""Rows of a table of motion and of an inflow that a page makes; the case has no room for more of the latter."""
SHADES = 64
"""Radii that are distinguished."""
SECONDS_TO_TURN = 1.0
"""In which the discharge goes through its range."""
UNITS = {"contact.friction": "", "contact.restitution": "", "gravity": "m/s²", "slope": "°", "inflow": "m²/s"}
PARTS = 200
"""Places of a slider."""
BEFORE = 2.0
"""Diameters from a wall to where the depth before it is taken."""
AS_IT_WAS = ("theory", "third", "sum")
"""Looks of the curves of a recorded run."""


def live_page(
    flow: LiveFlow | Sequence[LiveStart], again: RunAgain | str = "", recorded: Recorded | None = None
) -> str:
    """The page of a flow, or of one that has several starts.

    Parameters
    ----------
    flow : LiveFlow or sequence of LiveStart
        All starts have the sliders of the first.
    again : RunAgain or str
        A run that the page also computes again, or why it does not.
    recorded : Recorded, optional
        The run that the starts are moments of: it is drawn next to the flow, at the same time.

    Raises
    ------
    SetupError
        The core for browsers is not there.
    """
    core = browser_core()
    starts = [LiveStart("", flow)] if isinstance(flow, LiveFlow) else list(flow)
    first = starts[0].flow
    heads = [head_of(one.flow, core) | {"time": one.time, "few": one.few} for one in starts]
    head = heads[0]
    if isinstance(again, RunAgain):
        head["again"] = again.head
    charts, head["charts"] = charts_of(first, head, recorded)
    style, scripts = live_style(), live_scripts()
    return _template().render(
        title=first.case.name,
        description=first.case.fields.description,
        policy=page.policy([style], scripts, computes=True),
        style=style,
        scripts=scripts,
        data=page.as_json({"players": [recorded.player.header] if recorded else [], "curves": charts}),
        sliders=head["sliders"],
        charts=charts,
        colours=["speed", *(["size"] if first.simulation.scene.sizes is not None else [])],
        notes=dict.fromkeys(note for one in starts for note in one.flow.notes),
        again=_about_again(again),
        core=_packed(core.code),
        labels=[one.label for one in starts],
        images=[_packed(image_of(one.flow.simulation, one.flow.target, WORD, one.flow.discs)) for one in starts],
        heads=[_packed(json.dumps(plain(one), allow_nan=False, separators=(",", ":")).encode()) for one in heads],
        recorded=recorded,
        frames=page.packed(recorded.player.frames) if recorded and recorded.player.frames else "",
    )


def live_part(folder: Path, starts: Sequence[LiveStart]) -> page.LivePage:
    """A live page of a run from some of its moments on, for a frame of its report: `Run.report`.

    Raises
    ------
    JumpError
        As of `run_again` and `live_page`.
    """
    recorded = recorded_run(folder)
    shared = recorded and replace(recorded, player=recorded.player._replace(frames=""))
    text = live_page(starts, run_again(folder), shared)
    return page.LivePage(_packed(text.encode()), [one.time for one in starts], live_style(), live_scripts())


def live_style() -> Markup:
    """The style of a live page."""
    return Markup(text_of(Path(page.__file__).parent / "page.css") + text_of(HERE / "live.css"))


def live_scripts() -> list[Markup]:
    """Scripts of a live page, in their order."""
    worker = "\n".join(text_of(HERE / name) for name in COMPUTING)
    scripts = [Markup(text_of(Path(page.__file__).parent / name)) for name in DRAWING]
    scripts.append(Markup(f'"use strict";\nconst COMPUTING = {page.as_json(worker)};\n'))
    return [*scripts, *(Markup(text_of(HERE / name)) for name in SHOWING)]


def _about_again(again: RunAgain | str) -> dict[str, str] | None:
    """Facts of a run that is computed again, for the template."""
    if isinstance(again, RunAgain):
        return {"image": _packed(again.image), "reason": ""}
    return {"image": "", "reason": again} if again else None


def require_place(path: Path) -> None:
    """SetupError where something exists at a path that is no live page."""
    with suppress(OSError):  # a link, no regular file, or nothing
        if not path.is_symlink() and read_start(path, len(MADE)) == MADE:
            return
    if os.path.lexists(path):  # the files of a run are this program's, but no live page takes their place
        raise SetupError(f"{path}: stands there already and is not overwritten; delete it, or name another with --out")
    require_replaceable(path.parent, path.name)


def write_page(
    flow: LiveFlow | Sequence[LiveStart], path: Path, again: RunAgain | str = "", recorded: Recorded | None = None
) -> Path:
    """Writes the page of `live_page`, in place of a live page that is there.

    Raises
    ------
    SetupError
        Something else is there, the file cannot be written, or the core for browsers is not there.
    """
    require_place(path)
    text = live_page(flow, again, recorded)
    with writes(path, SetupError):
        return write_text(path, text)


def _packed(data: bytes) -> str:
    """Bytes as text: gzip, base64."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()


@lru_cache(maxsize=1)
def _template() -> Template:
    loader = FileSystemLoader(HERE)
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("live.html.j2")


def head_of(flow: LiveFlow, core: BrowserCore) -> dict[str, Any]:
    """Facts of the flow for the scripts of a page."""
    scene, case = flow.simulation.scene, flow.case
    tick = max(TICK, float(f"{STEPS_A_TICK * scene.time_step:.2g}"))
    return {
        "name": case.name,
        "core": {"sha256": core.sha256, "compiler": core.compiler},
        "timeStep": scene.time_step,
        "start": scene.settle_steps,
        "target": flow.target,
        "tick": tick,
        "frame": case.fields.run.output_interval,
        "mostRows": MOST_ROWS,
        "mostTimes": MOST_TIMES,
        "trackWidth": TrackRowColumns.width(),
        "placedWidth": PlacedColumns.width(),
        "fields": fields(),
        "walls": [wall.name for wall, _ in scene.walls],
        "sliders": [_slider(flow, name, one) for name, one in flow.sliders.items()],
        "inflow": _inflow(flow),
        "forces": _felt(flow),
        "front": _front(flow),
        "depthAt": _depth_at(flow),
        "about": about(flow),
        "case": yaml.safe_load(case.to_yaml()),
    }


def fields() -> dict[str, dict[str, int]]:
    """Offsets of the fields of structs of the core, as a browser has them, and the size of an inlet."""
    by_name = {}
    for name, struct in (("state", jump_state), ("events", jump_events), ("inlet", jump_inlet)):
        narrow = narrowed(struct, WORD)
        by_name[name] = {field: getattr(narrow, field).offset for field, *_ in struct._fields_}
    return by_name | {"inlet": by_name["inlet"] | {"size": sizeof(narrowed(jump_inlet, WORD))}}


def _slider(flow: LiveFlow, name: str, one: LiveSlider) -> dict[str, Any]:
    """A slider, as scripts and template have it."""
    low, high = one.range
    step = float(f"{(high - low) / PARTS:.1g}")
    entry: dict[str, Any] = {"name": name, "low": low, "high": high, "step": step}
    if one.wall:
        walls = [wall.name for wall, _ in flow.simulation.scene.walls]
        unit = "°" if one.move == "turn" else "m"
        axis = ("x", "y", "turn").index(one.move or "x")
        return {**entry, "kind": "wall", "wall": walls.index(one.wall), "axis": axis, "rate": one.rate, "value": 0.0,
                "unit": unit, "label": f"{one.wall} {('moved along x', 'raised', 'turned')[axis]} by"}  # fmt: skip
    unit, label = UNITS[one.path], name if one.path != "inflow" else "discharge"
    if one.path == "inflow":
        depth, speed = flow.case.fields.inflow.over(0.0, 0.0)  # type: ignore[union-attr]
        value = round(depth * speed, 6)
        return {**entry, "kind": "inflow", "rate": (high - low) / SECONDS_TO_TURN, "value": value, "unit": unit,
                "low": min(low, value), "high": max(high, value), "label": label}  # fmt: skip
    stops = [vars(stop) for stop in flow.stops[name]]
    return {**entry, "kind": "number", "path": one.path, "value": float(flow.case[one.path]), "unit": unit,
            "label": label, "stops": stops}  # fmt: skip


def _inflow(flow: LiveFlow) -> dict[str, Any] | None:
    """Numbers by which scripts let discs in against time: see `physics.inlet.entries_of_rows`."""
    scene, inflow = flow.simulation.scene, flow.case.fields.inflow
    if not isinstance(inflow, RowsInflow) or not any(one.path == "inflow" for one in flow.sliders.values()):
        return None
    rows = len(scene.inlets)
    exponent = 1.0 / 7.0 if inflow.profile == "power_law" else 0.0
    shape = np.array([power(i + 0.5, exponent) for i in range(rows)])
    shares = shape / np.cumsum(shape)[-1]
    graph = inflow.hydrograph
    return {
        "depth": graph.depths[0], "speed": graph.speeds[0], "shares": shares, "relative": rows * shares,
        "factors": seed_factors(rows, flow.case.fields.run.seed),
        "meanSquare": scene.sizes.mean_square if scene.sizes is not None else scene.diameter**2,
        "timeStep": scene.time_step, "start": scene.settle_steps,
    }  # fmt: skip


def _felt(flow: LiveFlow) -> list[int]:
    """Numbers of the walls whose force is shown."""
    scene = flow.simulation.scene
    requested = {*scene.probes, *(wall.name for wall, _ in scene.bodies), *(one.wall for one in flow.sliders.values())}
    return [number for number, (wall, _) in enumerate(scene.walls) if wall.name in requested]


def _front(flow: LiveFlow) -> dict[str, Any]:
    """Front: of a jump where the mass depth comes to a level, m; else that of the discs."""
    inflow, g = flow.case.fields.inflow, float(np.hypot(*flow.simulation.scene.gravity))
    if isinstance(inflow, RowsInflow) and g > 0 and flow.case.fields.analysis.jump:
        depth, speed = inflow.over(0.0, 0.0)
        if speed > np.sqrt(g * depth):
            level = 0.5 * (depth + sequent_depth(speed, depth, g))
            return {"level": level, "title": f"Front of the jump: the mass depth first comes to {level:.3g} m"}
    return {"level": None, "title": "Front of the discs: 98 % of them are before it"}


def about(flow: LiveFlow) -> dict[str, Any]:
    """Facts of the run for the drawing modules."""
    scene, wanted_flow = flow.simulation.scene, flow_of(flow.case)
    packer = FramePacker(wanted_flow, maps=False)
    frame = take_frame(flow.simulation)
    packer.add(frame, scene.time(flow.simulation.step))
    description = about_run(packer, HERE)
    radii = 0.5 * np.linspace(scene.smallest, scene.largest, SHADES if scene.largest > scene.smallest else 1)
    x, (low, high) = seen(packer.sample(), wanted_flow)
    high += max([0.0, *(one.range[1] for one in flow.sliders.values() if one.move == "y")])
    fastest = max(top_of([disc_speeds(frame)]), _fall(high - low, scene.gravity))
    return {**description, "seen": (x, (low, high)), "fastest": float(f"{fastest:.2g}"), "radii": radii, "share": 1.0,
            "map": None, "q": 1.0, "qv": 1.0, "numbers": _numbers(flow)}  # fmt: skip


def _fall(height: float, gravity: tuple[float, float]) -> float:
    """Speed of a fall from half of a height, m/s."""
    return float(np.sqrt(np.hypot(*gravity) * height))


def _numbers(flow: LiveFlow) -> Mapping[str, int]:
    """Number of each wall in the core by its name."""
    return {wall.name: number for number, (wall, _) in enumerate(flow.simulation.scene.walls)}


def _depth_at(flow: LiveFlow) -> float | None:
    """Place whose depth is a curve, m: before the first wall that a slider moves, else the middle; None: no gravity."""
    scene, case = flow.simulation.scene, flow.case
    if not np.hypot(*scene.gravity):
        return None
    low, high = flow_of(case).x_range
    moved = [one.wall for one in flow.sliders.values() if one.wall]
    corners = [part for wall, _ in scene.walls if wall.name in moved[:1] for part in outlines_of(wall, scene.domain)]
    place = min((float(part[:, 0].min()) for part in corners), default=np.nan) - BEFORE * scene.diameter
    return float(f"{place if low < place < high else 0.5 * (low + high):.4g}")


def outlines_of(wall: Wall, domain: tuple[Interval, Interval]) -> list[np.ndarray]:
    """Outlines and lines of a wall within a domain, m."""
    outlines, lines = parts_of(wall, *domain)
    return [*outlines, *lines]


def charts_of(
    flow: LiveFlow, head: Mapping[str, Any], recorded: Recorded | None = None
) -> tuple[list[dict[str, Any]], dict[str, dict[str, int]]]:
    """Curves that the page goes on with against the time of the flow: force on walls, front, depth at a place.

    Behind its own lines a chart has those of a recorded run: of its forces, and empty ones of what the page finds in
    its frames. Beside them come, by name, the places of the charts and how many lines of each are the page's own.
    """
    names = [head["walls"][number] for number in head["forces"]]
    looks = ("first", "second", "third", "sum")
    lines = [(name, looks[k % len(looks)]) for k, name in enumerate(names)]
    felt = recorded.forces if recorded else {}
    was = [
        Trace(f"{name}, as it was", felt[name][0], felt[name][1] / 1000, AS_IT_WAS[k % len(AS_IT_WAS)])
        for k, name in enumerate(name for name in names if name in felt)
    ]
    one = [("here", "first")] if recorded else [("", "first")]
    empty = [Trace("as it was", np.empty(0), np.empty(0), AS_IT_WAS[0])] if recorded else []
    charts = {}
    if names:
        charts["force"] = _chart("Force of the discs on walls, along x", "Force F_x [kN/m]", lines, was)
    charts["front"] = _chart(head["front"]["title"], "Place x [m]", one, empty)
    if (place := head["depthAt"]) is not None:
        charts["depth"] = _chart(f"Depth by mass at x = {place:z.4g} m", "Depth [m]", one, empty)
    own = len(lines)
    places = {name: {"number": k, "own": own if name == "force" else 1} for k, name in enumerate(charts)}
    return list(charts.values()), places


def _chart(title: str, y: str, lines: list[tuple[str, str]], more: Sequence[Trace] = ()) -> dict[str, Any]:
    none = np.empty(0)
    panel = Panel(y, [*(Trace(label, none, none, look) for label, look in lines), *more])
    return Chart(title, "Time of the flow t [s]", [panel]).plain
