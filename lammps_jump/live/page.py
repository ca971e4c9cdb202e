# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes a live page: one file with the core, the image of the scene, what scripts need to know, and the scripts.

Its policy names the hashes of its own scripts and allows WebAssembly. The thread that computes is in the page, too.
No network is asked for anything. Words of the case stay text.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from contextlib import suppress
from ctypes import sizeof
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from lammps_jump.analysis.draw.chart import Chart, Panel, Trace
from lammps_jump.analysis.draw.scope import disc_speeds, seen, top_of
from lammps_jump.analysis.report import page
from lammps_jump.analysis.report.frames import FramePacker
from lammps_jump.analysis.report.player import about_run
from lammps_jump.case.parts.inflow import RowsInflow
from lammps_jump.case.parts.live import LiveSlider
from lammps_jump.core.browser import BrowserCore, browser_core
from lammps_jump.core.columns import PlacedColumns, TrackRowColumns
from lammps_jump.engines.native.bound import jump_events, jump_inlet, jump_state
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.engines.native.image import image_of, narrowed
from lammps_jump.errors import SetupError
from lammps_jump.files import plain, read_start, text_of, write_text, writes
from lammps_jump.folders import require_replaceable
from lammps_jump.physics.elementary import power
from lammps_jump.physics.inlet import seed_factors
from lammps_jump.physics.jump import sequent_depth
from lammps_jump.runs.results import flow_of

from .again import RunAgain
from .prepare import LiveFlow
from .words import WORD

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
"""Radii that are told apart."""
SECONDS_TO_TURN = 1.0
"""In which the discharge goes through its range."""
UNITS = {"contact.friction": "", "contact.restitution": "", "gravity": "m/s²", "slope": "°", "inflow": "m²/s"}
PARTS = 200
"""Places of a slider."""


def live_page(flow: LiveFlow, again: RunAgain | str = "") -> str:
    """The page of a flow; with a run, it also computes that again, or says why it does not.

    Raises
    ------
    SetupError
        The core for browsers is not there.
    """
    core = browser_core()
    head = head_of(flow, core)
    if isinstance(again, RunAgain):
        head["again"] = again.head
    style = Markup(text_of(Path(page.__file__).parent / "page.css") + text_of(HERE / "live.css"))
    worker = "\n".join(text_of(HERE / name) for name in COMPUTING)
    scripts = [Markup(text_of(Path(page.__file__).parent / name)) for name in DRAWING]
    scripts.append(Markup(f'"use strict";\nconst COMPUTING = {page.as_json(worker)};\n'))
    scripts += [Markup(text_of(HERE / name)) for name in SHOWING]
    policy = page.policy(style, scripts).replace("script-src ", "worker-src blob:; script-src 'wasm-unsafe-eval' ")
    charts = charts_of(head)
    return _template().render(
        title=flow.case.name,
        description=flow.case.fields.description,
        policy=policy,
        style=style,
        scripts=scripts,
        data=page.as_json({"players": [], "curves": charts}),
        sliders=head["sliders"],
        charts=charts,
        colours=["speed", *(["size"] if flow.simulation.scene.sizes is not None else [])],
        notes=flow.notes,
        again=_about_again(again),
        core=_packed(core.code),
        image=_packed(image_of(flow.simulation, flow.target, WORD, flow.discs)),
        head=_packed(json.dumps(plain(head), allow_nan=False, separators=(",", ":")).encode()),
    )


def _about_again(again: RunAgain | str) -> dict[str, str] | None:
    """Facts of a run that is computed again, for the template."""
    if isinstance(again, RunAgain):
        return {"image": _packed(again.image), "reason": ""}
    return {"image": "", "reason": again} if again else None


def require_place(path: Path) -> None:
    """SetupError where something stands at a path that is no live page."""
    with suppress(OSError):  # a link, no regular file, or nothing
        if not path.is_symlink() and read_start(path, len(MADE)) == MADE:
            return
    require_replaceable(path.parent, path.name)


def write_page(flow: LiveFlow, path: Path, again: RunAgain | str = "") -> Path:
    """Write the page of a flow, as of `live_page`, in place of a live page that stands there.

    Raises
    ------
    SetupError
        Something else stands there, the file cannot be written, or the core for browsers is not there.
    """
    require_place(path)
    text = live_page(flow, again)
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
        "about": about(flow),
        "case": yaml.safe_load(case.to_yaml()),
    }


def fields() -> dict[str, dict[str, int]]:
    """Offsets of the fields of structs of the core, as a browser has them, and the size of an inlet."""
    found = {}
    for name, struct in (("state", jump_state), ("events", jump_events), ("inlet", jump_inlet)):
        narrow = narrowed(struct, WORD)
        found[name] = {field: getattr(narrow, field).offset for field, *_ in struct._fields_}
    return found | {"inlet": found["inlet"] | {"size": sizeof(narrowed(jump_inlet, WORD))}}


def _slider(flow: LiveFlow, name: str, one: LiveSlider) -> dict[str, Any]:
    """A slider, as scripts and template have it."""
    low, high = one.range
    step = float(f"{(high - low) / PARTS:.1g}")
    found: dict[str, Any] = {"name": name, "low": low, "high": high, "step": step}
    if one.wall:
        walls = [wall.name for wall, _ in flow.simulation.scene.walls]
        unit = "°" if one.move == "turn" else "m"
        axis = ("x", "y", "turn").index(one.move or "x")
        return {**found, "kind": "wall", "wall": walls.index(one.wall), "axis": axis, "rate": one.rate, "value": 0.0,
                "unit": unit, "label": f"{one.wall} {('moved along x', 'raised', 'turned')[axis]} by"}  # fmt: skip
    unit, label = UNITS[one.path], name if one.path != "inflow" else "discharge"
    if one.path == "inflow":
        depth, speed = flow.case.fields.inflow.over(0.0, 0.0)  # type: ignore[union-attr]
        value = round(depth * speed, 6)
        return {**found, "kind": "inflow", "rate": (high - low) / SECONDS_TO_TURN, "value": value, "unit": unit,
                "low": min(low, value), "high": max(high, value), "label": label}  # fmt: skip
    stops = [vars(stop) for stop in flow.stops[name]]
    return {**found, "kind": "number", "path": one.path, "value": float(flow.case[one.path]), "unit": unit,
            "label": label, "stops": stops}  # fmt: skip


def _inflow(flow: LiveFlow) -> dict[str, Any] | None:
    """Numbers by which scripts let discs in against time: see `physics.hydrograph.entries_of_rows`."""
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
    asked = {*scene.probes, *(wall.name for wall, _ in scene.bodies), *(one.wall for one in flow.sliders.values())}
    return [number for number, (wall, _) in enumerate(scene.walls) if wall.name in asked]


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
    scene, asked = flow.simulation.scene, flow_of(flow.case)
    packer = FramePacker(asked, maps=False)
    frame = take_frame(flow.simulation)
    packer.add(frame, scene.time(flow.simulation.step))
    found = about_run(packer, HERE)
    radii = 0.5 * np.linspace(scene.smallest, scene.largest, SHADES if scene.largest > scene.smallest else 1)
    x, (low, high) = seen(packer.sample(), asked)
    high += max([0.0, *(one.range[1] for one in flow.sliders.values() if one.move == "y")])
    fastest = max(top_of([disc_speeds(frame)]), _fall(high - low, scene.gravity))
    return {**found, "seen": (x, (low, high)), "fastest": float(f"{fastest:.2g}"), "radii": radii, "share": 1.0,
            "map": None, "q": 1.0, "qv": 1.0, "numbers": _numbers(flow)}  # fmt: skip


def _fall(height: float, gravity: tuple[float, float]) -> float:
    """Speed of a fall from half of a height, m/s."""
    return float(np.sqrt(np.hypot(*gravity) * height))


def _numbers(flow: LiveFlow) -> Mapping[str, int]:
    """Number of each wall in the core by its name."""
    return {wall.name: number for number, (wall, _) in enumerate(flow.simulation.scene.walls)}


def charts_of(head: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Curves that the page goes on with: force on walls, and the front, against the time of the flow."""
    names = [head["walls"][number] for number in head["forces"]]
    looks = ("first", "second", "third", "sum")
    lines = [(name, looks[k % len(looks)]) for k, name in enumerate(names)]
    found = [_chart("Force of the discs on walls, along x", "Force F_x [kN/m]", lines)] if names else []
    return [*found, _chart(head["front"]["title"], "Place x [m]", [("", "first")])]


def _chart(title: str, y: str, lines: list[tuple[str, str]]) -> dict[str, Any]:
    none = np.empty(0)
    panel = Panel(y, [Trace(label, none, none, look) for label, look in lines])
    return Chart(title, "Time of the flow t [s]", [panel]).plain
