# SPDX-License-Identifier: GPL-2.0-or-later
"""Reports in Chromium: they load, play and seek, show what dump and summary hold, and nothing else acts in them.

`make browser` runs these tests, one for each scene of `inputs/` among them.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from chromium import PROGRAM, Page, chromium
from free_bodies import body
from made_up import SCENES, flow_context
from PIL import Image

from lammps_jump import load_case, open_run
from lammps_jump.analysis import report
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.profiles import FrameDiscs, OpenEnds, bin_discs
from lammps_jump.analysis.report import frames
from lammps_jump.analysis.report import page as page_of
from lammps_jump.analysis.report.frames import FramePacker
from lammps_jump.analysis.report.page import Boxes, PlayerChoice, Section, Slider, render
from lammps_jump.analysis.report.player import make_player
from lammps_jump.analysis.report.run import write_report
from lammps_jump.dump.exports import read_netcdf
from lammps_jump.dump.find import read_dump
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.walls import PoseFile
from lammps_jump.files import BODIES_HEADER
from lammps_jump.scene.motion import Motion, MovingWall, gate
from lammps_jump.scene.scene import InletRow, Outlet
from lammps_jump.scene.tracks import Rotate
from lammps_jump.scene.walls import Block, Box, Line, Polygon

INPUTS = Path(__file__).parents[2] / "inputs"
HOSTILE = '</script><img src=x onerror="hit = 1"><b>name</b>'
STATE = "(({time, playing, view, colour}) => ({time, playing, colour, scale: view.scale, x: view.x}))(players[0])"
AT_FRAME = """((k) => {
  const p = players[0], f = discsAt(p.run, p.run.times[k], p.found), cut = (a) => Array.from(a.subarray(0, f.own));
  const depth = massDepth(p.run, f, p.depth);
  return { id: cut(f.disc).map((k) => p.run.ids[k]), x: cut(f.x), y: cut(f.y), u: cut(f.u), v: cut(f.v),
           depth: [...depth], radius: cut(f.disc).map((k) => p.run.radii[p.run.shade[k]]) };
})"""

PIXEL = """((x, y) => {
  const p = players[0], at = [MARGIN.left + column(p, x), MARGIN.legend + row(p, y)];
  return String(p.context.getImageData(...at, 1, 1).data.slice(0, 3));
})"""

OVERLAPS = """(() => {
  const drawn = [], write = CanvasRenderingContext2D.prototype.fillText, found = [];
  for (const p of players) {
    const boxes = [];
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
      const wide = this.measureText(text).width, left = x - { left: 0, center: wide / 2, right: wide }[this.textAlign];
      boxes.push({ text, left, right: left + wide, top: y - 5, bottom: y + 5, end: p.sized.width });
    };
    draw(p);
    drawn.push(boxes);
  }
  CanvasRenderingContext2D.prototype.fillText = write;
  for (const svg of document.querySelectorAll("figure.curve svg")) {
    const end = svg.getBoundingClientRect().right;
    drawn.push([...svg.querySelectorAll("text")].map((one) => {
      const { left, right, top, bottom } = one.getBoundingClientRect();
      return { text: one.textContent, left, right, top: top + 2, bottom: bottom - 2, end };
    }));
  }
  for (const boxes of drawn) {
    boxes.forEach((a, k) => {
      if (a.left < -1 || a.right > a.end + 1) found.push(`${a.text} is cut`);
      for (const b of boxes.slice(k + 1)) {
        const apart = a.left >= b.right || b.left >= a.right || a.top >= b.bottom || b.top >= a.bottom;
        if (!apart) found.push(`${a.text} on ${b.text}`);
      }
    });
  }
  return found;
})()"""
"""Texts of curves and players that lie on each other or leave their picture."""

LARGEST = {"quick_jump": 700_000, "stable_jump": 3_000_000, "hydraulic_jump_graded": 3_000_000}
"""Bytes of the page of a scene."""

pytestmark = [pytest.mark.browser, pytest.mark.skipif(not PROGRAM, reason="Chromium is not installed")]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as running:
        yield running


def made_frames(count=6, radius=0.06):
    """Discs that come in from the left, fall over an edge and leave."""
    frames = []
    for k in range(count):
        ids = np.arange(1, 40 + 5 * k)[3 * k :]
        x, y = 0.2 * (40 + 5 * k - ids) - 0.1, 0.1 + 0.2 * (ids % 3)
        columns = {
            "id": ids,
            "x": x,
            "y": y,
            "vx": 0 * x + 2.0,
            "vy": np.sin(ids),
            "radius": radius + 0.001 * (ids % 40),
        }
        frames.append(make_frame(k, 0.5 * k, [[0, 10], [-2, 5]], columns))
    return frames


FLOOR = (Block("floor", (-1, 7), (-1, 0)),)


def made_report(folder, *, name="made-up", walls=FLOOR, timed=True, radius=0.06, **more):
    """A report of made-up frames and the summary in it."""
    inlet = InletRow(x=0.0, y=0.1, vx=2.0, vy=0.0, first_step=0, every_steps=1, clearance=0.2)
    flow = flow_context(
        domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=walls, name=name, sized=True, diameter=0.2, timed=timed,
        inlets=(inlet,), outlets=(Outlet("x", 9.0, "above", 1),), **more,
    )  # fmt: skip
    packer = FramePacker(flow)
    for frame in made_frames(radius=radius):
        packer.add(frame, frame.time)
    summary = {"name": name, "description": name, "discs": {"inserted": 64, "present": 49}, "warnings": [name]}
    (folder / "figures").mkdir()
    Image.new("RGB", (40, 20)).save(folder / "figures" / "snapshots.png")
    return write_report(folder, summary, "name: a\n", player=make_player(packer, folder))


@pytest.fixture
def made(browser, tmp_path):
    page = Page(browser, made_report(tmp_path))
    yield page
    page.close()


def key(page, name):
    for kind in ("keyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key=name, text=name if len(name) == 1 else "")


def key_code(page, name, code):
    """A key that the browser itself answers, such as an arrow in a list."""
    for kind in ("rawKeyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key=name, code=name, windowsVirtualKeyCode=code)


def mouse(page, kind, x, y, **more):
    page.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)


def place_of(page, name):
    """Middle of an element of the player."""
    box = f"document.querySelector('.player {name}').getBoundingClientRect()"
    return page.run(f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])({box})")


def click(page, x, y):
    for kind in ("mousePressed", "mouseReleased"):
        mouse(page, kind, x, y, button="left", clickCount=1)


def test_it_plays_and_seeks(made):
    made.run("times = []; document.addEventListener('time', ({detail}) => times.push(detail)); 0")
    assert made.run(STATE)["time"] == 0.0
    made.run("Object.assign(players[0], {playing: true, last: 1000}); 0")
    made.run("advance(players[0], 1300); setPlaying(players[0], false)")
    assert made.run("players[0].time") == pytest.approx(0.3)
    for name, time in (("End", 2.5), ("Home", 0.0), ("ArrowRight", 0.5), ("ArrowRight", 1.0), ("ArrowLeft", 0.5)):
        key(made, name)
        assert made.run("players[0].time") == time
    made.run("tell('seek', 1.23)")
    assert made.run("players[0].time") == 1.23 and "1.23 / 2.50 s" in made.run("document.body.innerText")
    assert made.run("times")[-1] == 1.23 and made.run("times").count(0.5) == 2
    key(made, "ArrowLeft")
    assert made.run("players[0].time") == 1.0
    click(made, *place_of(made, ".on"))
    assert made.run("players[0].time") == 1.5
    click(made, *place_of(made, ".play"))
    assert made.run("players[0].playing") is True
    click(made, *place_of(made, ".play"))
    assert made.run("players[0].playing") is False
    assert made.troubles() == []


def test_a_run_is_chosen_from_a_list(browser, tmp_path):
    """By the keyboard; the time stays, and what was asked for last is shown."""
    players = []
    for count in (6, 9, 4):
        packer = FramePacker(flow_context(domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=FLOOR, sized=True))
        for frame in made_frames(count):
            packer.add(frame, frame.time)
        players.append(make_player(packer, tmp_path))
    choice = PlayerChoice(players, ["Member 3", HOSTILE, "Member 7"], 1)
    path = tmp_path / "choice.html"
    path.write_text(render("made-up", [Section("", [choice])]))
    page = Page(browser, path)
    shown = "[players.length, players[0].run.times.length, players[0].time, Number(part(players[0], 'time').max)]"
    assert page.run(shown) == [1, 9, 0.0, 4.0]
    assert page.run("[...part(players[0], 'run').options].map((one) => one.text)") == ["Member 3", HOSTILE, "Member 7"]
    page.run("tell('seek', 2); part(players[0], 'run').focus()")
    page.run(
        "drawn = new Promise((done) => { layOut = (p) => p.run.times.length === 4 && done(moveView(p, 0, 0)); }); 0"
    )
    for name, code in (("ArrowUp", 38), ("ArrowDown", 40), ("ArrowDown", 40)):
        for kind in ("rawKeyDown", "keyUp"):
            page.call("Input.dispatchKeyEvent", type=kind, key=name, windowsVirtualKeyCode=code)
    page.run("drawn.then(() => null)")
    assert page.run(shown) == [1, 4, 1.5, 1.5]  # its end comes before the time
    page.run("[1, 0].forEach((run) => takeRun(players[0], run))")
    assert page.run(shown) == [1, 6, 1.5, 2.5] and page.run("typeof hit") == "undefined"
    assert page.troubles() == []
    page.close()


def test_a_list_of_long_names_is_no_wider_than_a_phone(browser, tmp_path):
    packer = FramePacker(flow_context(domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=FLOOR, sized=True))
    for frame in made_frames(4):
        packer.add(frame, frame.time)
    names = [f"friction coefficient {k}, restitution coefficient 0.5, start {k}" for k in (1, 2)]
    path = tmp_path / "choice.html"
    path.write_text(render("made-up", [Section("", [PlayerChoice([make_player(packer, tmp_path)] * 2, names, 0)])]))
    page = Page(browser, path, width=390, height=800, phone=True)
    assert page.run("document.documentElement.scrollWidth") == 390
    page.close()


def test_sliders_choose_the_run_of_a_point(browser, tmp_path):
    """By the keyboard: player, numbers and list go with them; where there is no run the page says so."""
    players = []
    for count in (6, 9, 4):
        packer = FramePacker(flow_context(domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=FLOOR, sized=True))
        for frame in made_frames(count):
            packer.add(frame, frame.time)
        players.append(make_player(packer, tmp_path))
    sides = [[Boxes([page_of.NumberBox(f"height {HOSTILE}", float(number))])] for number in range(3)]
    axes = [Slider("friction", ["0", "0.2"]), Slider(HOSTILE, ["1 m", HOSTILE])]
    choice = PlayerChoice(players, ["a", HOSTILE, "c"], 0, axes, [(0, 0), (0, 1), (1, 1)], sides)
    path = tmp_path / "choice.html"
    path.write_text(render("made-up", [Section("", [choice])]))
    page = Page(browser, path)
    shown = (
        "[players[0].run.times.length, part(players[0], 'run').selectedIndex, "
        "[...document.querySelectorAll('.of-run')].findIndex((one) => !one.hidden), "
        "[...document.querySelectorAll('.axes output')].map((one) => one.textContent), part(players[0], 'gone').hidden]"
    )

    def press(name, code, axis):
        page.run(f"document.querySelectorAll('.axis')[{axis}].focus()")
        for kind in ("rawKeyDown", "keyUp"):
            page.call("Input.dispatchKeyEvent", type=kind, key=name, windowsVirtualKeyCode=code)
        return page.run(shown)

    assert page.run(shown) == [6, 0, 0, ["0", "1 m"], True]
    assert press("ArrowRight", 39, 1) == [9, 1, 1, ["0", HOSTILE], True]
    assert press("ArrowRight", 39, 0) == [4, 2, 2, ["0.2", HOSTILE], True]
    assert press("ArrowLeft", 37, 1) == [4, 2, 2, ["0.2", "1 m"], False]  # no run there: the one before stays
    assert "0.2, 1 m" in page.run("part(players[0], 'gone').textContent")
    page.run("part(players[0], 'run').selectedIndex = 0; part(players[0], 'run').dispatchEvent(new Event('change'))")
    assert page.run(shown) == [6, 0, 0, ["0", "1 m"], True]  # the sliders go with the list
    assert page.run("players[0].time") == 0 and page.run("typeof hit") == "undefined" and page.troubles() == []
    page.close()


WIDGET = Path(report.__file__).parent / "widget.js"
HOST = """<!doctype html><body><div id="cell"></div><script type="application/json" id="page">%s</script>
<script type="module">%s
const heard = { custom: null, times: [] };
const model = {
  get: (name) => ({ title: "run", page: JSON.parse(document.getElementById("page").textContent) })[name],
  set: (name, value) => heard.times.push(value), save_changes: () => { heard.saved = true; },
  on: (name, act) => { heard.custom = act; }, off: () => { heard.custom = null; },
};
window.heard = heard;
window.end = render({ model, el: document.getElementById("cell") });
window.frameLoaded = new Promise((done) => { document.querySelector("iframe").onload = () => done(true); });
</script>"""


def test_a_player_in_a_notebook_tells_its_time(browser, tmp_path):
    """A stand-in for the model of Jupyter: the time comes out of the frame, and one that is asked for goes in."""
    packer = FramePacker(flow_context(domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=FLOOR, sized=True))
    for frame in made_frames():
        packer.add(frame, frame.time)
    inner = render("", [Section("", [make_player(packer, tmp_path)])], tab="run", embedded=True)
    path = tmp_path / "host.html"
    path.write_text(HOST % (json.dumps(inner).replace("<", "\\u003c"), WIDGET.read_text()))
    page = Page(browser, path)
    assert page.run("frameLoaded.then((one) => one)") is True
    listen = "addEventListener('message', ({ data }) => data.time === 1.5 && done(1))"
    page.run(f"told = new Promise((done) => {{ {listen}; }}); 0")
    page.run("heard.custom({ seek: 1.5 }); told.then(() => 0)")
    assert page.run("heard.times.at(-1)") == 1.5
    assert page.run("parseFloat(document.querySelector('iframe').style.height)") > 300
    page.run("end(); 0")
    assert page.run("heard.custom") is None
    page.close()


def test_it_plays_once_on_its_own_unless_still_pages_are_preferred(browser, tmp_path):
    path = made_report(tmp_path)
    assert Page(browser, path, still=True).run(STATE)["playing"] is False
    page = Page(browser, path, still=False)
    page.run("new Promise((done) => document.addEventListener('time', ({detail}) => detail >= 2.5 && done()))")
    state = page.run(STATE)
    assert (state["time"], state["playing"]) == (2.5, False)


def test_zoom_pan_and_the_values_of_a_disc(made):
    home = made.run(STATE)["scale"]
    key(made, "+")
    assert made.run(STATE)["scale"] == pytest.approx(1.5 * home)
    x, y = place_of(made, "canvas")
    before = made.run(STATE)["x"]
    mouse(made, "mousePressed", x, y - 80, button="left", clickCount=1)
    mouse(made, "mouseMoved", x + 60, y - 80, button="left", buttons=1)
    mouse(made, "mouseReleased", x + 60, y - 80, button="left", clickCount=1)
    assert made.run(STATE)["x"] == pytest.approx(before - 60 / (1.5 * home))
    key(made, "0")
    assert made.run(STATE)["scale"] == pytest.approx(home)
    left, top, wide = made.run(
        "(() => { const p = players[0], b = p.canvas.getBoundingClientRect();"
        " return [b.x + MARGIN.left + column(p, p.found.x[7]), b.y + MARGIN.legend + row(p, p.found.y[7]), p.wide] })()"
    )
    disc = made.run("({id: players[0].run.ids[players[0].found.disc[7]], x: players[0].found.x[7]})")
    mouse(made, "mouseMoved", left, top)
    tip = made.run("document.querySelector('.tip').innerText")
    assert f"disc {disc['id']}\nx {disc['x']:.2f}" in tip and "m/s" in tip and "diameter 0." in tip
    mouse(made, "mouseMoved", left + wide, top)
    assert made.run("document.querySelector('.tip').hidden") is True
    made.run(
        "(box => { box.value = 'age'; box.dispatchEvent(new Event('change')); })(document.querySelector('.colour'))"
    )
    assert made.run(STATE)["colour"] == "age" and made.troubles() == []


SAVED = "new Promise((done) => {{ save = (p, blob, ending) => done([blob.type, blob.size, ending]); {} }})"
MARKS = """[...document.querySelectorAll('figure.timed line.now[visibility=visible]')].map((line) =>
  [line.closest('figure').dataset.curve, Number(line.getAttribute('x1'))])"""
RECORDER = """MediaRecorder = class {
  constructor(stream, { mimeType }) { this.tracks = stream.getVideoTracks().length; this.kind = mimeType; }
  static isTypeSupported(kind) { return kind === "video/webm"; }
  start() { this.began = players[0].time; }
  stop() { this.ondataavailable({ data: new Blob(["film"]) }); this.onstop(); }
}; 0"""


def test_picture_is_saved(made):
    kind, size, ending = made.run(SAVED.format("savePicture(players[0]);"))
    assert (kind, ending) == ("image/png", "png") and size > 300
    assert made.troubles() == []


def test_film_is_recorded_to_the_end_or_to_the_second_press(made):
    made.run(RECORDER)  # what a real one has caught by then depends on the machine
    made.run("tell('seek', 2.4)")
    assert made.run(SAVED.format("saveFilm(players[0]);")) == ["video/webm", 4, "webm"]
    assert made.run("[players[0].time, players[0].playing, players[0].film]") == [2.5, False, None]
    made.run("part(players[0], 'film').click()")
    assert made.run("[part(players[0], 'film').textContent, players[0].film.tracks]") == ["Stop and save", 1]
    assert made.run(SAVED.format("part(players[0], 'film').click();")) == ["video/webm", 4, "webm"]
    assert made.run("part(players[0], 'film').textContent") == "Save film" and made.troubles() == []


def test_between_frames_discs_move_on_cubics_come_from_the_inlet_and_fall_out(made):
    found = made.run(
        "(() => { const f = discsAt(players[0].run, 0.25, players[0].found);"
        " return Array.from(f.disc.subarray(0, f.count), (k, i) => [players[0].run.ids[k], f.x[i], f.y[i]]) })()"
    )
    names = ("id", "x", "y", "vy")
    first, second = (
        {int(disc): rest for disc, *rest in zip(*(frame.columns[name] for name in names), strict=True)}
        for frame in made_frames()[:2]
    )
    seen = {disc: (x, y) for disc, x, y in found}
    q = made.run("players[0].run.q")
    for disc in first.keys() & second.keys():
        (xa, ya, va), (xb, yb, vb) = first[disc], second[disc]
        wanted = ((xa + xb) / 2, (ya + yb) / 2 + 0.5 / 8 * (va - vb))
        assert np.abs(np.subtract(seen[disc], wanted)).max() < 2 * q, disc
    entered = {disc for disc, (x, *_) in second.items() if disc not in first and x - 2.0 * 0.25 >= 0}
    left = {disc for disc, (x, *_) in first.items() if disc not in second and x + 2.0 * 0.25 <= 9.0}
    assert entered and left and seen.keys() == (first.keys() & second.keys()) | entered | left
    x, y, v = first[min(left)]
    assert np.allclose(seen[min(left)], (x + 0.5, y + v * 0.25 - 9.81 * 0.25**2 / 2), atol=0.02)


def test_a_disc_at_the_seam_of_a_periodic_channel_is_at_both_ends(browser, tmp_path):
    flow = flow_context(domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=(), periodic=True)
    packer = FramePacker(flow)
    for k, x in enumerate((9.6, 0.6, 9.95)):  # over the seam and back
        columns = {"id": [1, 2], "x": [x, 5.0], "y": [1.0, 1.0], "vx": [2.0 * (1, 0, -1)[k], 0.0], "vy": [0.0, 0.0]}
        columns = {name: np.array(values) for name, values in columns.items()}
        packer.add(make_frame(k, 0.5 * k, [[0, 10], [-2, 5]], columns), 0.5 * k)
    page = Page(browser, write_report(tmp_path, {"name": "a"}, "name: a\n", player=make_player(packer, tmp_path)))
    places = """((time) => { tell("seek", time); const f = players[0].found;
        return Array.from(f.x.subarray(0, f.count)) })"""
    q = page.run("players[0].run.q")
    # cubics through both places and velocities: half way, and a step / 8 times the change of speed ahead
    assert page.run(f"{places}(0.25)") == pytest.approx([0.1 + 2 * 0.5 / 8, 5.0], abs=2 * q)
    assert page.run(f"{places}(0.75)") == pytest.approx([0.275 + 2 * 0.5 / 8, 5.0], abs=2 * q)
    assert page.run(f"{places}(1)") == pytest.approx([9.95, 5.0, -0.05], abs=2 * q)
    assert page.run("players[0].found.own") == 2
    assert page.run("[...massDepth(players[0].run, players[0].found, players[0].depth)].map((d) => d > 0)") == [
        bin in (0, 4, 5, 9) for bin in range(10)
    ]
    paper = page.run(f"{PIXEL}(2, 3)")
    assert page.run(f"{PIXEL}(0.02, 1)") != paper != page.run(f"{PIXEL}(9.98, 1)")
    assert page.troubles() == []
    page.close()


@pytest.mark.parametrize("dark", [False, True])
def test_walls_discs_and_paper_have_their_colours(browser, tmp_path, dark):
    walls = (Box("box", (0, 8), (-1, 4)), Block("sill", (5, 6), (-1, 1)))
    page = Page(browser, made_report(tmp_path, walls=walls), dark=dark)
    paper, solid = ("20,23,27", "42,47,54") if dark else ("255,255,255", "236,237,240")
    assert [page.run(f"{PIXEL}({x}, {y})") for x, y in ((2, 3), (5.5, 0.9), (5.5, -1.1))] == [paper, solid, solid]
    disc = page.run(f"{PIXEL}(players[0].found.x[9], players[0].found.y[9])")
    assert disc in page.run("players[0].colours.map((c) => String(c))")
    assert page.troubles() == []


def test_walls_of_any_shape_move_with_the_time(browser, tmp_path):
    turning = Motion(kind=Rotate(rate=45.0, ease=0.0), about=(4.0, 2.0), time_step=0.01)
    walls = (
        MovingWall(Block("arm", (4, 6), (1.8, 2.2)), turning),
        Line("bed", points=((0, -0.5), (9, -0.5))),
        Polygon("weir", points=((7, 0), (9, 0), (8, 3))),
    )
    page = Page(browser, made_report(tmp_path, walls=walls, time_step=0.01))
    paper, solid = "255,255,255", "236,237,240"

    def colours(time, *places):
        page.run(f"tell('play', {{on: false}}); tell('seek', {time})")
        return [page.run(f"{PIXEL}({x}, {y})") for x, y in places]

    places = (5.5, 2.0), (4.0, 3.5), (8.0, 1.0), (7.1, 2.0)
    assert colours(0.0, *places) == [solid, paper, solid, paper]
    assert colours(2.0, *places) == [paper, solid, solid, paper]
    assert colours(1.0, (5.06, 3.06), (5.5, 2.0)) == [solid, paper]
    assert colours(1.25, (4.834, 3.247)) == [solid]  # between two frames, at 56 degrees
    below, above = colours(2.0, (8.95, -0.56), (8.95, -0.4))
    assert below == solid and above == paper
    assert page.troubles() == []


def test_a_body_that_is_pointed_at_tells_its_mass_speed_and_force(browser, tmp_path):
    (tmp_path / "walls.csv").write_text("time,wall,x,y,angle\n0,raft,0,0,0\n2.5,raft,2.5,0,0\n")
    rows = [f"{t:g},raft,{2.5 + t:g},3.5,0,{t:g},0,0,{300 * t:g},{-400 * t:g},0" for t in (0.0, 1.0, 2.0)]
    (tmp_path / "bodies.csv").write_text("\n".join([BODIES_HEADER, *rows, ""]))
    walls = *FLOOR, body(Block("raft", (2, 3), (3, 4)))
    page = Page(browser, made_report(tmp_path, walls=walls, poses=PoseFile(tmp_path / "walls.csv", ["raft"])))

    def tip(time, x, y):
        page.run(f"tell('play', {{on: false}}); tell('seek', {time})")
        left, top = page.run(
            "(() => { const p = players[0], b = p.canvas.getBoundingClientRect();"
            f" return [b.x + MARGIN.left + column(p, {x}), b.y + MARGIN.legend + row(p, {y})] }})()"
        )
        mouse(page, "mouseMoved", left, top)
        return page.run("(({hidden, innerText}) => hidden ? null : innerText)(document.querySelector('.tip'))")

    told = "raft\nmass 1000 kg/m\n{} m/s ({}, 0.00)\nforce of the discs {} N/m ({}, \u2212{})"
    assert tip(1.0, 3.4, 3.6) == told.format("1.00", "1.00", 500, 300, 400)
    assert tip(1.25, 3.7, 3.2) == told.format("1.25", "1.25", 625, 375, 500)  # between two frames
    assert tip(1.25, 2.1, 3.2) is None
    assert tip(2.5, 4.7, 3.2) == "raft\nmass 1000 kg/m"  # no row tells of this time
    assert page.troubles() == []


FELT = """(() => {
  const p = players[0], box = part(p, "felt"), told = part(p, "told"), panel = box.chart && box.chart.panels[0];
  return {
    shown: !box.hidden, title: box.hidden ? "" : box.querySelector("figcaption").firstChild.data,
    name: part(p, "thing").selectedOptions[0].text, lines: box.hidden ? [] : panel.lines.map(({ x, y }) => [x, y]),
    unit: panel && panel.y, told: told.hidden ? "" : told.textContent,
    drawn: box.querySelectorAll("svg > g path").length, now: !!box.querySelector("line.now[visibility=visible]"),
  };
})()"""


def click_at(page, x, y):
    """A click on a place of the drawing, m."""
    left, top = page.run(
        "(() => { const p = players[0], b = p.canvas.getBoundingClientRect();"
        f" return [b.x + MARGIN.left + column(p, {x}), b.y + MARGIN.legend + row(p, {y})] }})()"
    )
    click(page, left, top)
    return page.run(FELT)


def felt_report(tmp_path):
    """A report of made-up discs over a floor, a gate that is gone at 2 s and a body, with forces on two of them."""
    (tmp_path / "walls.csv").write_text("time,wall,x,y,angle\n0,raft,0,0,0\n2.5,raft,2.5,0,0\n")
    rows = [f"{t:g},raft,{2.5 + t:g},3.5,0,{t:g},0,0,{3 * t:g},{-4 * t:g},0" for t in (0.0, 1.0, 2.0)]
    (tmp_path / "bodies.csv").write_text("\n".join([BODIES_HEADER, *rows, ""]))
    felt = [f"{0.25 * k:g},{HOSTILE},{1000 * k},{-500 * k},0" for k in range(1, 11)]
    (tmp_path / "forces.csv").write_text("\n".join(["time,structure,fx,fy,moment", *felt, ""]))
    shut = gate(Block("lid", (8, 8.5), (0, 3)), 2000)
    walls = (*FLOOR, Block(HOSTILE, (5, 6), (1.5, 2.5)), shut, body(Block("raft", (2, 3), (3, 4))))
    poses = PoseFile(tmp_path / "walls.csv", ["raft"])
    return made_report(tmp_path, walls=walls, poses=poses, time_step=1e-3, density=1000.0)


def test_what_is_clicked_shows_its_force_against_time(browser, tmp_path):
    """Wall and body of their records, a disc of the velocities of the page; else the reason stands there."""
    page = Page(browser, felt_report(tmp_path))
    page.run("tell('seek', 1)")
    wall = click_at(page, 5.5, 2.2)
    assert (wall["title"], wall["name"], wall["unit"]) == (f"Force on {HOSTILE}, of the discs", HOSTILE, "Force [kN/m]")
    (time, along), (_, up) = wall["lines"]
    assert time == pytest.approx([0.25 * k for k in range(1, 11)]) and along == pytest.approx(range(1, 11))
    assert up == pytest.approx([-0.5 * k for k in range(1, 11)])
    assert wall["told"] == "Means over 0.25 s, every step counted." and wall["drawn"] == 2 and wall["now"]
    assert "force of the discs 4470 N/m (4000, \u22122000)" in page.run("part(players[0], 'tip').innerText")
    raft = click_at(page, 3.4, 3.6)
    assert (raft["title"], raft["unit"]) == ("Force on raft, of the discs", "Force [N/m]")
    assert raft["lines"] == [[[0, 1, 2], [0, 3, 6]], [[0, 1, 2], [0, -4, -8]]]
    assert not click_at(page, 3.4, 3.6)["shown"]  # a second click lets go
    floor = click_at(page, 4.0, -0.1)
    assert not floor["shown"] and floor["told"].startswith(
        "floor: No force on it was recorded: name it in probes.forces"
    )
    assert click_at(page, 8.2, 2.0)["name"] == "lid"
    page.run("tell('seek', 2.2)")
    assert click_at(page, 8.2, 2.0)["name"] == "Force on …"  # the gate is gone
    assert page.run("typeof hit") == "undefined" and page.troubles() == []


def test_the_force_of_a_disc_is_that_of_its_change_of_velocity(browser, tmp_path):
    """A disc that flies on is without force; one that stands bears its weight; one that is in one frame has none."""
    flow = flow_context(domain=((0, 10), (-2, 5)), x_range=(0, 10), walls=FLOOR, sized=False)
    packer, g = FramePacker(flow), flow.g
    for k in range(5):
        t = 0.1 * k
        columns = {
            "id": np.array([1, 2, 3][: 3 if k == 4 else 2]), "x": np.array([1.0, 3.0 + 2 * t, 6.0]),
            "y": np.array([0.1, 4 - 0.5 * g * t * t, 2.0]), "vx": np.array([0.0, 2.0, 0.0]),
            "vy": np.array([0.0, -g * t, 0.0]),
        }  # fmt: skip
        columns = {name: values[: len(columns["id"])] for name, values in columns.items()}
        packer.add(make_frame(k, t, [[0, 10], [-2, 5]], columns), t)
    page = Page(browser, write_report(tmp_path, {"name": "a"}, "name: a\n", player=make_player(packer, tmp_path)))
    page.run("tell('seek', 0.4)")
    weight, qv = flow.scene.mass * g, page.run("players[0].run.qv")
    for disc, force in ((0, weight), (1, 0.0)):
        page.run(f"pin(players[0], {disc})")
        found = page.run(FELT)
        (time, along), (_, up) = found["lines"]
        scale = 1000 if found["unit"] == "Force [kN/m]" else 1
        assert time == pytest.approx([0.05, 0.15, 0.25, 0.35])
        assert np.multiply(along, scale) == pytest.approx(np.zeros(4), abs=1e-9)
        rounded = flow.scene.mass * qv / 0.1  # half a quantum at either end
        assert np.multiply(up, scale) == pytest.approx(np.full(4, force), abs=rounded)
    page.run("pin(players[0], 2)")
    assert "it is in one frame alone" in page.run(FELT)["told"] and page.troubles() == []


def test_forces_are_reached_by_the_keyboard(browser, tmp_path):
    """From the list of walls; Enter on the drawing takes what is in its middle, Escape lets go."""
    page = Page(browser, felt_report(tmp_path))
    page.run("tell('seek', 1); part(players[0], 'thing').focus()")
    assert page.run("[...part(players[0], 'thing').options].map((one) => one.text)") == [
        "Force on …", "floor", HOSTILE, "raft", "lid",
    ]  # fmt: skip
    for _ in range(2):
        key_code(page, "ArrowDown", 40)
    assert page.run(FELT)["name"] == HOSTILE and page.run(FELT)["shown"]
    page.run("part(players[0], 'play').focus()")
    key(page, "Escape")
    assert page.run(FELT)["shown"] is False and page.run(FELT)["name"] == "Force on …"
    page.run("players[0].canvas.focus(); players[0].view.hand = true")
    key(page, "Enter")
    assert page.run("players[0].pinned") and page.run(FELT)["told"]
    assert page.run("typeof hit") == "undefined" and page.troubles() == []


def test_nothing_but_the_page_itself_acts_in_it(browser, tmp_path):
    page = Page(browser, made_report(tmp_path, name=HOSTILE))
    assert page.troubles() == []
    assert page.run("typeof hit") == "undefined" and page.run("document.querySelector('img[src=x], body b b')") is None
    assert HOSTILE in page.run("document.querySelector('.name').textContent")
    attacks = (
        "document.body.insertAdjacentHTML('beforeend', '<img src=x onerror=\"hit = 1\">')",
        "document.body.append(Object.assign(document.createElement('script'), {textContent: 'hit = 1'}))",
        "document.body.insertAdjacentHTML('beforeend', '<p style=\"color: red\" class=red>x</p>')",
        "document.body.append(Object.assign(new Image(), {src: 'http://127.0.0.1:9/a.png'}))",
    )
    for attack in attacks:
        page.run(f"{attack}; 0")
    assert page.run("fetch('http://127.0.0.1:9/').then(() => 'sent', () => 'blocked')") == "blocked"
    assert page.run("typeof hit") == "undefined"
    assert page.run("getComputedStyle(document.querySelector('.red')).color") != "rgb(255, 0, 0)"
    assert sum("Content Security Policy" in text for text in page.troubles()) >= 4


def test_without_scripts_the_pictures_stand(browser, tmp_path):
    page = Page(browser, made_report(tmp_path), scripts=False)
    root = page.call("DOM.getDocument")["root"]["nodeId"]
    picture = page.call("DOM.querySelector", nodeId=root, selector="details.still[open] img")["nodeId"]
    assert page.call("DOM.getBoxModel", nodeId=picture)["model"]["height"] >= 1
    player = page.call("DOM.querySelector", nodeId=root, selector=".player[hidden]")["nodeId"]
    with pytest.raises(RuntimeError, match="box model"):
        page.call("DOM.getBoxModel", nodeId=player)


def test_a_dump_without_times_plays_by_steps(browser, tmp_path):
    page = Page(browser, made_report(tmp_path, timed=False))
    page.run("Object.assign(players[0], {playing: true, last: 1000}); 0")
    page.run("advance(players[0], 1100); setPlaying(players[0], false)")
    assert page.run("players[0].time") == pytest.approx(0.5)  # steps are 0.5 apart, ten of them a second
    assert "/ 3 steps" in page.run("document.body.innerText")
    assert page.troubles() == []


@pytest.mark.parametrize(("most", "said"), [(50, " % of them are shown."), (12, "as large as all that it stands for.")])
def test_thinned_discs_stand_for_all(browser, tmp_path, monkeypatch, most, said):
    monkeypatch.setattr(frames, "MOST_DISCS", most)
    page = Page(browser, made_report(tmp_path))
    assert said in page.run("document.querySelector('.thin').innerText")
    own = "p.run.radii[p.run.shade[p.found.disc[0]]]"
    share, drawn, own = page.run(f"((p) => [p.run.share, radiusOf(p, 0), {own}])(players[0])")
    assert drawn == pytest.approx(own if share > 0.5 else own / share**0.5)
    assert page.troubles() == []


CHOOSE = """((list) => {{ list.value = '{}'; list.dispatchEvent(new Event('change')); }})(part(players[0], 'colour'))"""
OFFERED = "[...part(players[0], 'colour').options].filter((one) => !one.disabled).map((one) => one.value)"


def test_colour_by_pressure(browser, tmp_path):
    """Between the middles of cells and between frames the pressure goes in straight lines; the tip has it."""
    path = made_report(tmp_path, stiffness=1e5, radius=0.09)
    page = Page(browser, path)
    assert page.run(OFFERED) == ["speed", "size", "age", "pressure"] and page.run(STATE)["colour"] == "speed"
    about, levels = page.run("[players[0].run.map, Array.from(players[0].run.levels)]")
    columns, rows = about["counts"]
    stored = about["unit"] * np.array(levels, float).reshape(-1, rows, columns) ** 2
    assert stored.shape[0] == 6 and 0 < about["top"] <= stored.max()
    page.run("tell('seek', 1.25); " + CHOOSE.format("pressure"))
    now = (stored[2] + stored[3]) / 2
    row, column = np.unravel_index(now.argmax(), now.shape)
    x, y = (about["low"][axis] + about["sides"][axis] * (cell + 1) for axis, cell in ((0, column), (1, row)))
    corner = np.pad(now, ((0, 1), (0, 1)))[row : row + 2, column : column + 2].mean()
    assert page.run(f"valueAt(players[0].run.map, players[0].values, {x}, {y})") == pytest.approx(corner)
    page.run("pick(players[0], players[0].found.disc[20])")
    told = page.run("short(mapValue(players[0], 20))")
    assert f"pressure around it {told} Pa" in page.run("document.querySelector('.tip').innerText")
    colour = page.run("String(players[0].colours[shadeOf(mapValue(players[0], 20), ...colourRange(players[0]), true)])")
    assert page.run(f"{PIXEL}(players[0].found.x[20], players[0].found.y[20])") == colour
    assert page.troubles() == []


def test_many_discs_are_shown_as_packing(browser, tmp_path, monkeypatch):
    monkeypatch.setattr(frames, "MANY", 40)
    monkeypatch.setattr(frames, "MOST_DISCS", 12)
    page = Page(browser, made_report(tmp_path, walls=()))
    assert page.run(STATE)["colour"] == "packing" and "packing" in page.run(OFFERED)
    assert "it shows the share of area that they cover. In other colours" in page.run(
        "document.querySelector('.thin').innerText"
    )
    about, cells = page.run("[players[0].run.map, players[0].values.map((value) => value)]")
    fullest = int(np.argmax(list(cells.values())))
    row, column = divmod(fullest, about["counts"][0])
    x, y = (about["low"][axis] + about["sides"][axis] * (cell + 0.5) for axis, cell in ((0, column), (1, row)))
    top = "players[0].run.map.top"
    colour = page.run(f"String(players[0].colours[shadeOf(players[0].values[{fullest}], 0, {top})])").split(",")
    shown = page.run(f"{PIXEL}({x}, {y})").split(",")
    assert max(abs(int(a) - int(b)) for a, b in zip(shown, colour, strict=True)) <= 3
    assert page.run("discUnder(players[0], [300, 100])") is None
    page.run(CHOOSE.format("speed"))
    assert page.run("discUnder(players[0], [MARGIN.left + column(players[0], players[0].found.x[0]),"
                    " MARGIN.legend + row(players[0], players[0].found.y[0])])") is not None  # fmt: skip
    assert page.troubles() == []


def test_phone(browser, tmp_path):
    page = Page(browser, made_report(tmp_path), width=390, height=800, scale=2, phone=True)
    assert page.run("document.documentElement.scrollWidth") == 390
    assert page.run("document.querySelector('canvas').getBoundingClientRect().bottom") < 800  # on the first screen
    state = page.run(STATE)
    assert state["scale"] >= 2 * page.run("players[0].whole")
    key(page, "0")
    assert page.run(STATE)["scale"] == pytest.approx(page.run("players[0].whole"))
    page.run("layOut(players[0])")  # as for another size
    assert page.run(STATE)["scale"] == pytest.approx(page.run("players[0].whole"))
    assert page.troubles() == []


def depth_at(frame, scene, bins):
    """Mass depth of each bin in a frame beside an inlet, m, of the discs where they are: profiles have means there."""
    flow, low, width = from_scene(scene), bins["low"], bins["width"]
    discs = FrameDiscs.of(frame.x, frame.y, frame.vx, frame.vy, flow.radii(frame), flow.relative_masses(frame))
    ways = OpenEnds.of(flow).ways(discs.x, np.zeros(frame.n))
    return bin_discs(discs, low, width, bins["count"], ways)[0][0] * scene.diameter**2 / width


def read_back(page, folder):
    """Compare what the page holds with the dump and with the profiles."""
    times = page.run("players[0].run.times")
    q, qv, sizes = (page.run(f"players[0].run.{name}") for name in ("q", "qv", "radii.length"))
    profiles, scene = read_netcdf(folder / "profiles.nc"), open_run(folder).scene
    frames = {frame.time: frame.sorted() for frame in read_dump(folder)}
    assert len(times) <= 400 and set(times) <= set(frames)
    for k in range(0, len(times), max(1, len(times) // 20)):
        frame, found = frames[times[k]], page.run(f"{AT_FRAME}({k})")
        assert found["id"] == frame.ids.tolist()
        for name, column, quantum in (("x", "x", q), ("y", "y", q), ("u", "vx", qv), ("v", "vy", qv)):
            wrong = np.abs(np.array(found[name]) - frame.columns[column])
            if name == "x" and (seam := page.run("players[0].run.seam")):  # engines let discs run on over the seam
                wrong = np.minimum(wrong, np.abs(wrong - (seam[1] - seam[0])))
            assert (wrong <= (0.5 + 1e-4) * quantum).all(), (name, times[k])
        depth = profiles["mass_depth"].sel(time=times[k], method="nearest").values
        if scene.inlets:
            depth = depth_at(frame, scene, page.run("players[0].run.bins"))
        assert np.allclose(found["depth"], depth, atol=0.02 * max(depth.max(), 0.1)), times[k]
        if sizes > 1 and k:  # a disc that has just come in may not have its own size yet
            known = np.isin(frame.ids, frames[times[k - 1]].ids)
            assert np.allclose(np.array(found["radius"])[known], frame.radii[known], rtol=0, atol=1e-3 * q * 128)


def numbers_agree(page, summary):
    """The numbers at the top are those of the summary."""
    plain = [value for value in flat(summary) if isinstance(value, float | int) and value is not True]
    shown = page.run(
        "[...document.querySelectorAll('.numbers b')].map((b) => [b.textContent, b.parentElement.textContent])"
    )
    assert 2 <= len(shown) <= 5
    for text, around in shown:
        value = float(text.replace("\u2212", "-").replace("\u202f", ""))
        cut = "±" in around and "." not in text  # to two digits of its error: 8020 ± 110
        digits = len(text.partition(".")[2]) - (len(text) - len(text.rstrip("0")) if cut else 0)
        near = [one for one in plain for scale in (1, 1e-3, 100) if abs(one * scale - value) <= 0.51 * 10**-digits]
        assert near, text


def curves_agree(page, folder):
    """The page draws what is in ``curves.json``, to five digits of the largest number of a line."""
    stored = json.loads((folder / "curves.json").read_text())
    shown = {chart["title"]: chart for chart in page.run("pageData.curves")}
    for chart in stored.values():
        for panel, drawn in zip(chart.get("panels", ()), shown[chart["title"]].get("panels", ()), strict=True):
            for line, seen in zip(panel["lines"], drawn["lines"], strict=True):
                for key in line.keys() & {"x", "y", "error"}:
                    wanted, found = (np.array(side[key], float) for side in (line, seen))
                    within = 1e-4 * np.nanmax(np.abs(wanted), initial=0)
                    assert np.allclose(found, wanted, rtol=0, atol=0.51 * within, equal_nan=True)


def flat(found):
    values = found.values() if isinstance(found, dict) else found if isinstance(found, list) else None
    return [found] if values is None else [one for value in values for one in flat(value)]


def test_the_front_is_in_view_and_zoomed_on(browser, tmp_path):
    page = Page(browser, made_report(tmp_path), width=390, height=800, phone=True)
    within = "Math.abs(frontPlace(players[0])[0] - players[0].view.x) <= players[0].wide / players[0].view.scale / 2"
    for time in (0, 1, 2):
        assert page.run(f"tell('seek', {time}); {within}")
    page.run("tell('seek', 1)")
    key(page, "+")
    key(page, "+")
    assert page.run("players[0].view.x") == pytest.approx(page.run("frontPlace(players[0])[0]"))
    page.run("moveView(players[0], 30, 0)")
    at = page.run("players[0].view.x")
    key(page, "+")
    assert page.run("players[0].view.x") == pytest.approx(at)  # moved by hand: it stays there
    page.close()


def overlaps(browser, path):
    """Texts that lie on each other or are cut, at the begin, middle and end, on a desktop and on a phone."""
    found = []
    for width in (1280, 390):
        page = Page(browser, path, width=width, height=900, phone=width == 390)
        for share in (0, 0.5, 1):
            found += page.run(f"tell('seek', {share} * players[0].end); {OVERLAPS}")
        page.close()
    return sorted(set(found))


@pytest.mark.long
@pytest.mark.parametrize("scene", [path.stem for path in SCENES])
def test_report_of_a_scene(browser, tmp_path, scene):
    folder = tmp_path / scene
    load_case(INPUTS / f"{scene}.yaml").run(folder)
    page = Page(browser, folder / "report.html")
    assert page.troubles() == []
    read_back(page, folder)
    numbers_agree(page, json.loads((folder / "summary.json").read_text()))
    end, marks = page.run("players[0].end"), []
    for share in (0.5, 0.7):
        page.run(f"tell('seek', {share * end})")
        assert page.run("players[0].time") == pytest.approx(share * end)
        marks.append(page.run(MARKS))
    before, after = (dict(map(tuple, found)) for found in marks)
    both = before.keys() & after.keys()
    timed = page.run("document.querySelectorAll('figure.timed').length")
    assert bool(both) == bool(timed)
    assert all(before[curve] < after[curve] for curve in both)  # the linked curves show the time
    text = page.run("document.getElementById('frames0').textContent")
    rows = page.run("players[0].run.rows")
    # both velocities and both rests of a position: bits that no frame before tells, most where frames are far apart
    assert len(text) <= 3.0 * rows + 20_000
    size = (folder / "report.html").stat().st_size
    assert size - len(text) <= 400_000 and size <= LARGEST.get(scene, size)
    curves_agree(page, folder)
    assert page.troubles() == []
    assert overlaps(browser, folder / "report.html") == []
    words = page.run(
        "[...document.querySelectorAll('p, .verdict, .warn li')].map((p) => p.innerText.split(' ').length)"
    )
    assert max(words) <= 60
    page.close()
