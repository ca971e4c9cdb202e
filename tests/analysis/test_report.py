# SPDX-License-Identifier: GPL-2.0-or-later
"""The report: one file, no network, safe text, small enough, whatever the summary lacks."""

# ruff: noqa: RUF001  (minus signs and dashes as the page shows them)
import base64
import hashlib
import html
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from made_up import numbers
from number_text import numbers_in

from lammps_jump.analysis.jump.summary import Jump
from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.report.definitions import DEFINITIONS
from lammps_jump.analysis.report.headline import verdict
from lammps_jump.analysis.report.key_numbers import key_numbers
from lammps_jump.analysis.report.page import SCRIPTS, Curve, Player, Section, Table, Text, render, text
from lammps_jump.analysis.report.run import LARGEST, write_report
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
    assert all(source.startswith("data:") for source in parser.sources)
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
        "skipped": ["friction: ks = 0"],
        "versions": {"numpy": "2.0"},
        "wall_seconds": {"build": 0.1, "run": 3.0, "analysis": None},
        "discs": {"inserted": 1234, "present": 1200, "removed": 34, "lost": 0},
        "front": {"position": None, "reason": "no frame holds a disc"},
        "energy": {"initial": 5760.0, "final": 5759.0, "max_deviation": 2e-4, "drift": -1e-5, "conservative": True},
    }
    content = page(write_report(tmp_path, summary, "name: quick_jump\n"))
    for expected in ("near its limit", "2.56&thinsp;×&thinsp;10<sup>7</sup>", "friction: ks = 0", "video/mp4",
                     "no frame holds a disc", "0.0200 %", "case.yaml", "1\u202f234"):  # fmt: skip
        assert expected in content, expected
    assert content.count("data:image/png") == 2


def tiles(content):
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
    title = "A hydraulic jump. Its tail water is 3.8 % below Bélanger’s and its front moves upstream at 1.0 m/s.</h1>"
    assert content.index(title) < content.index("Compare this − with that.") < content.index('class="numbers"')
    assert tiles(content) == {
        "Sequent depth, by mass": ("5.000", " ± 0.04† m||Bélanger 5.2 m|"),
        "Velocity of the front": ("−1", " m/s|"),
        "Length of the jump": ("7", " m|"),
        "Peak force on the sill": ("4.20", " ± 0.3 kN/m||hydrostatic on its wetted face 2.1 kN/m|"),
    }
    sure = "± is one standard error within this run. † At least: one run cannot tell. Without ±: no error from one run;"
    assert sure in content
    assert "<summary>What these numbers mean</summary>" in content and "where a sharp step between" in content
    jump |= {"verdict": "no jump found"}
    content = page(write_report(tmp_path, {"name": "x", "jump": jump}))
    assert "<h1>No hydraulic jump.</h1>" in content
    assert tiles(content).keys() == {"Velocity of the front"}


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
    assert list(tiles(content))[-1] == "Mean force on the sill" and len(tiles(content)) == 5
    assert "Its tail water is 20 % above Bélanger’s and its front stands." in content


COLUMN = {"position": 30.0, "time": 5.0, "speed": 9.87, "column_base": 4.0, "ritter": {"front_speed": 21.7}}


@pytest.mark.parametrize(
    ("summary", "said"),
    [
        ({"front": {**COLUMN, "martin_moyce": {"aspect": 2.0}}}, "runs at 9.9 m/s; Ritter’s would run at 22 m/s."),
        ({"front": COLUMN}, "runs at 9.9 m/s."),
        ({"front": {"position": 30.0, "time": 5.0, "speed": None}}, "is at 30 m after 5 s."),
        ({"energy": {"conservative": True, "max_deviation": 0.012}}, "The energy stays within 1.2 % of"),
        ({"status": "failed", "message": "disc 7 is lost"}, "The run is failed."),
        ({"jump": {"verdict": "locked heap"}}, "No hydraulic jump: locked heap."),
        ({"jump": {"verdict": "marginal jump"}}, "Now and then a jump."),
        ({}, ""),
        ({"jump": {"verdict": "jump"}, "front": {"position": 30.0, "time": 5.0}}, "A hydraulic jump."),
    ],
)
def test_verdict_in_a_sentence(summary, said):
    assert said in verdict(summary)


def test_every_quantity_has_its_definitions():
    assert set(DEFINITIONS) == {*QUANTITIES, "stations", "water"}


def test_text_is_made_safe(tmp_path):
    summary = {"name": "<b>x</b>", "warnings": ["a < b & c"], "message": "<script>", "status": "failed"}
    content = page(write_report(tmp_path, summary, "description: <img src=http&>\n".replace("http", "x")))
    assert "&lt;b&gt;x" in content
    assert "a &lt; b &amp; c" in content


def test_large_pictures_become_small_and_the_page_stays_below_its_limit(tmp_path):
    for k in range(6):
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


def test_a_number_without_an_error_is_said_to_have_none():
    """Fronts, forces and energies of one run; the jump and the inflow have tests of their own."""
    moyce = dict.fromkeys(("aspect", "slope", "slope_of_table"), 3.0) | {"comparable": False}
    front = dict.fromkeys(("column_base", "column_depth", "position", "position_99", "column_height"), 4.0)
    front |= {"speed": 9.9, "arrival_time": None, "martin_moyce": moyce}
    force = {"structure": {"peak": 3e5, "peak_time": 4.4, "impulse": 2e5}}
    energy = dict.fromkeys(("initial", "final", "kinetic", "potential", "elastic"), 1.0)
    for key, found, said in (
        ("front", front, "One run has no errors for these numbers"),
        ("force", force, "one run has no error for a number without"),
        ("energy", energy, "exact for this run"),
    ):
        texts = [block.text for block in QUANTITIES[key].section(found).blocks if isinstance(block, Text)]
        assert said in " ".join(texts), key


def test_boxes_have_the_errors_of_both_numbers_and_say_what_one_run_cannot_tell():
    jump = {key: None for key in numbers(Jump("", ""))} | {"verdict": "jump", "length": 4.0, "length_error": 0.1}
    jump |= {"y2": 3.5, "y2_error": 0.02, "belanger_y2": 3.6, "belanger_y2_error": 0.03, "lower_bounds": ["y2"]}
    jump |= {"length_theory": 20.0, "length_theory_error": 0.1}
    summary = {"jump": jump}
    boxes, sure = key_numbers(summary)
    tail, length = boxes
    assert "† At least" in sure
    assert (tail.value, tail.error, tail.unit) == ("3.500", "0.02†", "m") and "3.600 ± 0.03 m" in tail.against
    assert length.unit == "m" and length.against == "thesis (4.27) 20.00 ± 0.1 m"
    assert "Without ±" not in sure
    assert "Without ±" in key_numbers({"jump": jump | {"length_error": None, "length_theory_error": None}})[1]
    assert key_numbers(summary | {"jump": jump | {"verdict": "locked heap"}})[0] == []
