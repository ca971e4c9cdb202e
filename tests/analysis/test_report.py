# SPDX-License-Identifier: GPL-2.0-or-later
"""The report: one file, no network, safe text, small enough, whatever the summary lacks."""

# ruff: noqa: RUF001  (minus signs and dashes as the page shows them)
import base64
import hashlib
import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from made_up import numbers
from number_text import numbers_in

from lammps_jump.analysis.jump.found import Jump
from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.report.page import SCRIPTS, Curve, Player, Section, Table, Text, render, text
from lammps_jump.analysis.report.run import LARGEST, write_report
from lammps_jump.analysis.statistics import Mean
from lammps_jump.analysis.tables import ONE_DUMP, ONE_RUN, rows_of, sure, table, tiles, together
from lammps_jump.analysis.verdicts import verdict
from lammps_jump.cli.progress import ending
from lammps_jump.errors import DumpError

VOID = {"meta", "link", "img", "br", "!doctype"}


class Balance(HTMLParser):
    """Collects sources and what is not closed."""

    def __init__(self):
        super().__init__()
        self.open, self.sources, self.wrong, self.attributes = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.attributes += [name for name, _ in attrs]
        self.sources += [value for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)


def page(path):
    content = path.read_text(encoding="utf-8")
    parser = Balance()
    parser.feed(content)
    assert (parser.open, parser.wrong) == ([], [])
    assert all(source.startswith(("data:", "#part")) for source in parser.sources)
    assert "http://" not in content
    assert "https://" not in content
    return content


def picture(path, size=8):
    from PIL import Image

    path.parent.mkdir(exist_ok=True)
    noise = np.random.default_rng(1).integers(0, 255, (size, size, 3), dtype=np.uint8)
    Image.fromarray(noise).save(path)


def test_empty_summary(tmp_path):
    content = page(write_report(tmp_path, {}))
    assert "How to repeat it" in content
    assert "viewport" in content


def test_everything_inside_one_file(tmp_path):
    picture(tmp_path / "figures" / "depth_profile.png")
    picture(tmp_path / "figures" / "of_my_own.png")
    (tmp_path / "animation.mp4").write_bytes(b"\0\0\0\x20ftypisom, not really a film")
    summary = {
        "name": "quick_jump",
        "status": "complete",
        "warnings": ["the step is near its limit"],
        "coefficients": {"mass": 40.0, "stiffness": 2.56e7},
        "skipped": ["friction: μ = 0"],
        "versions": {"numpy": "2.0"},
        "wall_seconds": {"build": 0.1, "run": 3.0, "analysis": None},
        "discs": {"inserted": 1234, "present": 1200, "removed": 34, "lost": 0},
        "front": {"position": None, "reason": "no frame holds a disc"},
        "energy": {"initial": 5760.0, "final": 5759.0, "max_deviation": 2e-4, "drift": -1e-5, "conservative": True},
    }
    content = page(write_report(tmp_path, summary, "name: quick_jump\n"))
    for expected in ("near its limit", "2.56&thinsp;×&thinsp;10<sup>7</sup>", "friction: μ = 0", "video/mp4",
                     "no frame holds a disc", "0.0200 %", "case.yaml", "1234 inserted"):  # fmt: skip
        assert expected in content, expected
    assert content.count("data:image/png") == 2


def tiles_of(content):
    """Label, value, and all behind it, of each number at the top."""
    found = re.findall(r"<div><dt>(.*?)</dt><dd><b>(.*?)</b>(.*?)</div>", content)
    return {label: (value, re.sub("<[^>]*>", "|", rest)) for label, value, rest in found}


def made_jump(**given):
    jump = {key: None for key in numbers(Jump("", ""))} | {"momentum_terms": None, "y2_error": None}
    jump |= {"verdict": "jump", "reason": "it moves", "headline": "Compare this - with that.", "share_found": 0.94}
    return jump | given


def test_the_verdict_stands_at_the_top_and_its_numbers_have_errors_and_a_comparison(tmp_path):
    jump = made_jump(speed=-1.0, speed_error=None, y2=5.0, y2_error=0.04, at="tail water")
    jump |= {"belanger_y2": 5.2, "belanger_deviation": -0.038, "length": 7.0, "lower_bounds": ["y2"]}
    force = {"sill": {"peak": 4200.0, "peak_error": 300.0, "hydrostatic": 2100.0, "mean_fx": 1.0}}
    content = page(write_report(tmp_path, {"name": "x", "jump": jump, "force": force}))
    title = (
        "A hydraulic jump. Its sequent depth is 3.8 % below Bélanger’s and its front moves upstream at 1.0 m/s.</h1>"
    )
    assert content.index(title) < content.index('class="numbers"') < content.index(ONE_RUN)
    assert "Compare this" not in content.partition("<pre>")[0]
    assert tiles_of(content) == {
        "Sequent depth": ("5.000", " ± at least 0.040 m||Bélanger 5.20 m, −3.8 %|"),
        "Front velocity": ("−1.00", " m/s|"),
        "Jump length": ("7.00", " m|"),
        "Peak Fx, sill, 0.05 s mean": ("4.20", " ± 0.30 kN/m||hydrostatic 2.10 kN/m, +100 %|"),
    }
    errors = content.partition(">Errors within this run</h2>")[2].partition("<h2")[0]
    assert "Sequent depth, by mass [m]" in errors and "at least 0.040" in errors and "sill: Peak force [kN/m]" in errors
    assert "<summary>What these numbers mean</summary>" in content and "where a sharp step between" in content
    jump |= {"verdict": "drowned inlet"}
    content = page(write_report(tmp_path, {"name": "x", "jump": jump}))
    assert "<h1>No hydraulic jump: drowned inlet.</h1>" in content
    assert tiles_of(content).keys() == {"Front velocity"}


def test_a_steady_stream_has_a_mean_force_and_at_most_five_numbers(tmp_path):
    error = {"y2_error": 0.1, "froude_error": 0.01, "speed_error": 0.9}
    jump = made_jump(y2=3.0, at="tail water", froude=4.0, speed=1.0, length=5.0, **error)
    jump |= {"belanger_y2": 3.5, "belanger_deviation": 0.2}
    force = {name: {"mean_fx": 1e3, "mean_fx_error": 10.0, "peak": 5.0} for name in ("sill", "gate")}
    summary = {"name": "x", "jump": jump, "force": force, "inflow": {"delivered": 6.0}, "discs": {"inserted": 5}}
    (tmp_path / "figures").mkdir()
    section = "lammps_jump.analysis.report.run.QUANTITIES"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(section, {})  # the sections want the whole of it
        content = page(write_report(tmp_path, summary))
    assert list(tiles_of(content))[-1] == "Mean Fx, sill" and len(tiles_of(content)) == 5
    assert "Its sequent depth is 20 % above Bélanger’s and its front stands." in content


COLUMN = {"position": 30.0, "time": 5.0, "speed": 9.87, "column_base": 4.0, "ritter": {"front_speed": 21.7}}


RITTER = {"front_speed": 21.7, "valid_until": 0.37}
WATER_COLUMN = {**COLUMN, "ritter": RITTER, "martin_moyce": {"aspect": 2.0}}


@pytest.mark.parametrize(
    ("summary", "said"),
    [
        ({"front": {**WATER_COLUMN, "time": 0.3}}, "runs at 9.9 m/s; Ritter’s would run at 22 m/s."),
        ({"front": WATER_COLUMN}, "runs at 9.9 m/s."),
        ({"front": COLUMN}, "runs at 9.9 m/s."),
        ({"front": {"position": 30.0, "time": 5.0, "speed": None}}, "is at 30 m after 5 s."),
        ({"energy": {"conservative": True, "max_deviation": 0.012}}, "The energy stays within 1.2 % of"),
        ({"status": "failed", "message": "disc 7 is lost"}, "The run failed."),
        ({"jump": {"verdict": "no jump found"}, "inflow": {}}, "No hydraulic jump."),
        ({"jump": {"verdict": "locked heap"}}, "No hydraulic jump: locked heap."),
        ({"jump": {"verdict": "marginal jump"}}, "Now and then a jump."),
        ({}, ""),
        ({"jump": {"verdict": "jump"}, "front": {"position": 30.0, "time": 5.0}}, "A hydraulic jump."),
    ],
)
def test_verdict_in_a_sentence(summary, said):
    assert said in verdict(summary)


def test_every_quantity_tells_all_of_itself():
    for name, quantity in QUANTITIES.items():
        assert quantity.name == name and quantity.title and quantity.definitions.strip()
        assert all(quantity.meaning(wanted)[0] for wanted in quantity.headline)
    assert len({name for quantity in QUANTITIES.values() for name in quantity.captions}) > 15


def test_text_is_made_safe(tmp_path):
    summary = {"name": "<b>x</b>", "warnings": ["a < b & c"], "message": "<script>", "status": "failed"}
    content = page(write_report(tmp_path, summary, "description: <img src=http&>\n".replace("http", "x")))
    assert "&lt;b&gt;x" in content
    assert "a &lt; b &amp; c" in content


def test_large_pictures_become_small_and_the_page_stays_below_its_limit(tmp_path):
    for k in range(3):
        picture(tmp_path / "figures" / f"noise{k}.png", 900)
    (tmp_path / "animation.mp4").write_bytes(b"\0\0\0\x20ftypisom" + bytes(4_000_000))
    path = write_report(tmp_path, {"name": "big"})
    content = page(path)
    assert path.stat().st_size < LARGEST
    assert "data:image/webp" in content
    assert re.search(r"beside it in the run folder: .*animation\.mp4", content)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (None, "–"),
        (True, "yes"),
        (-1.5, "−1.5"),
        (0.0, "0"),
        (12345, "12\u202f345"),
        ("a&b", "a&amp;b"),
        (1.23456, "1.235"),
    ],
)
def test_text_of_values(value, shown):
    assert text(value) == shown


def test_table_aligns_numbers_with_their_heads():
    made = render("", [Section("", [Table([("depth", 1.5), ("none", None)], ("", "value"))])])
    assert '<th class="n">value</th>' in made
    assert made.count('<td class="n">') == 2


def test_place_that_cannot_be_written(tmp_path):
    with pytest.raises(DumpError, match="cannot be written"):
        write_report(tmp_path / "missing", {})


HOSTILE = '</script><img src=x onerror="alert(1)"><!--'


def test_only_its_own_style_and_scripts_may_act_in_a_page():
    made = render(HOSTILE, [Section(HOSTILE, [Curve(HOSTILE, {"name": HOSTILE}), Player({"name": HOSTILE}, "AAAA")])])
    policy = html.unescape(re.search(r'Content-Security-Policy" content="([^"]*)"', made)[1])
    own = re.findall(r"<(style|script)>(.*?)</\1>", made, re.DOTALL)
    assert [kind for kind, _ in own] == ["style", *["script"] * len(SCRIPTS)]
    for _, inside in own:
        assert f"'sha256-{base64.b64encode(hashlib.sha256(inside.encode()).digest()).decode()}'" in policy
    assert "unsafe" not in policy and "default-src 'none'" in policy
    assert HOSTILE not in made and "<img" not in made
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', made, re.DOTALL)[1])
    assert data == {"players": [{"name": HOSTILE}], "curves": [{"name": HOSTILE}]}
    assert '<script type="text/plain" id="frames0">AAAA</script>' in made
    parser = Balance()
    parser.feed(made)
    assert not [name for name in parser.attributes if name == "style" or name.startswith("on")]


def test_long_lists_of_curves_stand_apart_with_five_digits():
    lists = [[0.01 * k for k in range(300)], [None, -1.25e6, *map(float, range(40)), None], [0.0] * 25]
    data = {"title": "t", "panels": [{"lines": [{"x": lists[0], "y": lists[1]}], "short": [0.5, 1.0]}, {"z": lists[2]}]}
    made = render("", [Section("", [Curve("c", data)])])
    kept = json.loads(re.search(r'id="data">(.*?)</script>', made, re.DOTALL)[1])["curves"][0]
    told = re.search(r'id="numbers">(.*?)</script>', made, re.DOTALL)[1]
    assert kept["panels"][0]["short"] == [0.5, 1.0] and len(told) < 400
    number, whole, step = numbers_in(told), 0, 0
    line = kept["panels"][0]["lines"][0]
    for wanted, found in zip(lists, (line["x"], line["y"], kept["panels"][1]["z"]), strict=True):
        assert found["count"] == len(wanted)
        for value in wanted:
            step = number(abs(step).bit_length())
            whole += step
            unit = 10.0 ** -found["decimals"]
            assert whole == -(2**30) if value is None else abs(whole * unit - value) <= 0.5001 * unit


def test_page_without_anything_to_draw_has_no_script():
    assert "<script" not in render("plain", [Section("", [Text("words")])])


JUMP = {key: None for key in numbers(Jump("", ""))} | {"verdict": "jump", "length": 4.0, "length_error": 0.1}
JUMP |= {"y2": 3.5, "y2_error": 0.02, "belanger_y2": 3.6, "belanger_deviation": -0.028, "speed": -0.634}
JUMP |= {"at": "tail water", "length_theory": 20.0, "length_usbr": 19.0, "head_lost": 2.8, "head_lost_theory": 2.6}
JUMP |= {"mass": {"speed_from_mass": -0.63}}


def test_one_run_has_no_error_bars_and_starts_have_one_interval():
    """Mean and half interval as the caller takes them: here of two values, half their distance."""
    one = rows_of([{"jump": JUMP}])
    assert [row.numbers() for row in one] == [
        ("3.50 m", "Bélanger 3.60 m", "−2.8 %"),
        ("−0.634 m/s", "by continuity −0.630 m/s", "−0.004 m/s"),
        ("4.00 m", "water 20.0 m", "−80 %"),
        ("4.00 m", "USBR 19.0 m", "−79 %"),
        ("2.80 m", "Bélanger 2.60 m", "+7.7 %"),
    ]
    assert sure({}) == ONE_RUN and sure({"given": {}}) == ONE_DUMP
    starts = [{"jump": JUMP | {"y2": 3.45}}, {"jump": JUMP | {"y2": 3.55}}]
    mean = lambda values: Mean(sum(values) / 2, abs(values[1] - values[0]) / 2 if len(values) > 1 else float("nan"))  # noqa: E731
    several = rows_of(starts, mean)
    assert several[0].numbers() == ("3.500 ± 0.050 m", "Bélanger 3.60 m", "−2.8 ± 1.4 %")
    box = tiles(several)[0]
    assert (box.value, box.error, box.unit) == ("3.500", "0.050", "m")
    found = together([*starts, {"jump": JUMP | {"verdict": "locked heap"}}], mean)
    assert found["starts"] == (2, 3) and found["jump"]["y2_error"] == pytest.approx(0.05)
    assert verdict(found).startswith("A hydraulic jump in 2 of 3 starts. Its sequent depth")
    assert [row.measured.value for row in rows_of([{"jump": JUMP | {"verdict": "locked heap"}}])] == [-0.634]


@pytest.mark.parametrize("width", [100, 80])
def test_the_end_of_a_run_is_twelve_lines(width):
    rows = rows_of([{"jump": JUMP, "force": {"a_wall_with_a_rather_long_name": {"peak": 1e5, "hydrostatic": 2e4}}}])
    said = "A hydraulic jump that still fills the channel. Its depth is 18 % below Bélanger’s. Its front moves up."
    about, notes = [ONE_RUN, "time: 12.9 s run"], ["word " * 60, "another"]
    lines = ending(said, rows, about, Path("runs/x y"), notes, width)
    assert len(lines) <= 12 and max(map(len, lines)) <= width
    assert lines[-2:] == ["2 notes on the page", "page: lammps-jump show 'runs/x y'"]
    assert ending("", rows, about, None, ["short"], width)[-1] == "note: short"
    assert len(table(rows, width)) == 6 and table(rows, width)[0].split() == ["measured", "theory", "difference"]


def test_flows_without_a_jump_have_rows_of_their_own():
    front = {"position": 32.8, "time": 5.0, "speed": 10.2, "arrival_time": 2.4, "martin_moyce": {"aspect": 3.0}}
    front["ritter"] = RITTER
    force = {"back": {"peak": -4.5e5, "hydrostatic": 7.0e5}}
    rows = rows_of([{"front": front, "force": force}])
    assert [row.label for row in rows] == [
        "front after 5 s", "mean speed of the front", "peak Fx, back, 0.05 s mean", "arrival at the first obstacle",
    ]  # fmt: skip
    assert [row.off() for row in rows] == ["", "", "−36 %", ""]  # Ritter's front holds for 0.37 s
    assert rows_of([{"front": {**front, "arrival_time": 0.3}}])[1].off() == "−53 %"
    energy = {"conservative": True, "max_deviation": 0.012, "drift": -0.003, "initial": 5760.0, "final": 5705.0}
    energy |= {"kinetic": 5705.0, "potential": 0.0}
    box = rows_of([{"energy": energy}])
    assert len(box) == 5 and box[0].numbers() == ("1.20 %", "exact: 0", "") and box[2].off() == "−1.0 %"
    assert rows_of([{"energy": energy | {"conservative": False}}]) == []


def test_forces_are_named_by_their_component():
    """Water at rest is no theory of a force along y, and what nothing touched has no number at the top."""
    bed = {"component": "fy", "peak": -6.5e5, "hydrostatic": None, "mean_fx": -6.6e3, "mean_fy": -5.2e5}
    sill = {"component": "fx", "peak": 6.9e4, "hydrostatic": 5.9e3, "mean_fx": 1.9e4, "mean_hydrostatic": 1.8e4}
    dry = {"component": None, "peak": 0.0, "mean_fx": 0.0, "mean_fy": 0.0, "reason": "nothing touched it"}
    force = {"bed": bed, "sill": sill | {"mean_fy": -2e3}, "dry": dry}
    assert [row.label for row in rows_of([{"force": force}])] == [
        "peak Fy, bed, 0.05 s mean", "peak Fx, sill, 0.05 s mean",
    ]  # fmt: skip
    stream = rows_of([{"force": force, "inflow": {"asked": None}}])
    assert [(row.label, row.words) for row in stream] == [("mean Fx, sill", "hydrostatic"), ("mean Fy, bed", "")]


def test_evidence_has_contents_and_tables_before_prose(tmp_path):
    front = dict.fromkeys(("column_base", "column_depth", "position", "speed"), 4.0) | {"position_99": 5.0}
    front |= dict.fromkeys(("column_height", "arrival_time"))
    content = page(write_report(tmp_path, {"name": "x", "front": front, "coefficients": {"mass": 4.0}}, "name: x\n"))
    listed = re.findall(r'<a href="#(part\d)">(.*?)</a>', content)
    assert listed == re.findall(r'<h2 id="(part\d)">(.*?)</h2>', content) and len(listed) == 3
    for section in content.split("<h2")[1:]:
        assert "<table" not in section.partition("<p>")[2]


def test_a_comparison_that_is_far_off_does_not_apply():
    jump = made_jump(y2=3.0, at="tail water", speed=0.0, length=5.0, head_lost=2.5, head_lost_theory=0.1)
    jump |= {"belanger_y2": 3.5, "belanger_deviation": -0.14, "verdict": "jump", "length_theory": 5.0}
    rows = {row.path: row for row in rows_of([{"jump": jump}])}
    assert rows["jump.y2"].off() == "−14 %" and rows["jump.y2"].reason() == ""
    assert rows["jump.head_lost"].off() == "does not apply"
    assert rows["jump.head_lost"].reason() == (
        "Head lost in the jump: Bélanger 0.100 m does not apply, because it is of one jump on a level bed, with "
        "hydrostatic pressure on both sides; measured is 25 times as much."
    )
    box = next(box for box in tiles(list(rows.values())) if box.label == "Head lost in the jump")
    assert box.against == ""
