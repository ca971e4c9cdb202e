# SPDX-License-Identifier: GPL-2.0-or-later
"""A live page as a file: what it holds, what it refuses, what its security policy allows."""

from __future__ import annotations

import hashlib
import re
from base64 import b64decode, b64encode
from gzip import decompress

import numpy as np
import pytest
from made_up import INPUTS, call

import lammps_jump as lj
from lammps_jump.case import load_case
from lammps_jump.core import browser
from lammps_jump.engines.native.image import placed_image
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.folders import Marker, write_marker
from lammps_jump.live import from_times, live_page, prepare, run_again
from lammps_jump.live.page import MADE, RunAgain, require_place
from lammps_jump.live.prepare import WORD

pytestmark = pytest.mark.usefixtures("compiled_core")
JUMP = INPUTS / "quick_jump.yaml"
SMALL = {"discs.diameter": 0.5, "live": {"sill": {"path": "walls.sill", "move": "y", "range": [-0.5, 2]}}}


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A core for browsers of these sources, whatever its code."""
    monkeypatch.setattr(browser, "CODE", tmp_path / "core.wasm")
    monkeypatch.setattr(browser, "RECORD", tmp_path / "core.json")
    browser.write(b"\0asm of the tests")


def test_without_the_core_the_command_says_what_to_do(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(browser, "RECORD", tmp_path / "absent.json")
    status, out, err = call(monkeypatch, capsys, "live", JUMP, "--out", tmp_path / "page.html")
    assert (status, out) == (2, "") and "`make wasm`" in err and err.count("\n") == 1
    assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize("fault", ["code", "sources", "record"])
def test_a_core_that_is_damaged_or_of_other_sources_is_not_taken(made, monkeypatch, fault):
    assert browser.browser_core().code == b"\0asm of the tests"
    if fault == "code":
        browser.CODE.write_bytes(b"\0asm of the test")
    elif fault == "sources":
        browser.RECORD.write_text(browser.RECORD.read_text().replace('"sources": "', '"sources": "0'))
    else:
        browser.RECORD.write_text("[]")
    with pytest.raises(SetupError, match="make wasm"):
        browser.browser_core()


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("settled_bed", {"engine.kernel": "stock", "engine.name": "lammps"}, "engine.kernel: stock"),
        ("quick_jump", {"engine.ranks": 2}, "engine.ranks: 2"),
        ("dam_break", {"discs.diameter": 0.04}, "discs"),
    ],
)
def test_what_is_not_in_a_page_is_refused_in_one_line(name, changes, said):
    with pytest.raises(CaseError, match=f"{said}.* stock scripts, ranks, pours .* are not in it"):
        prepare(load_case(INPUTS / f"{name}.yaml", changes))


def test_a_pour_is_refused():
    pour = {"kind": "pour", "x": [1, 3], "y": [2, 4], "count": 10}
    with pytest.raises(CaseError, match="inflow: a pour"):
        prepare(load_case(INPUTS / "dam_break.yaml", {"inflow": pour}))


def test_a_page_is_one_file_that_runs_its_own_scripts_alone(made):
    flow = prepare(load_case(JUMP, {**SMALL, "description": "<script>alert(1)</script> & more"}))
    text = live_page(flow)
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', text)[1].replace("&#39;", "'")
    assert "default-src 'none'" in policy and "worker-src blob:" in policy and "'wasm-unsafe-eval'" in policy
    assert "unsafe-inline" not in policy and "'unsafe-eval'" not in policy and "http" not in policy
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    hashes = {f"'sha256-{b64encode(hashlib.sha256(one.encode()).digest()).decode()}'" for one in scripts}
    assert hashes == set(re.findall(r"'sha256-[^']+'", policy.partition("script-src")[2].partition(";")[0]))
    assert "<script>alert" not in text and "&lt;script&gt;alert(1)" in text
    assert not re.findall(r'(?:src|href)="(?!data:,)', text)
    assert decompress(b64decode(re.search(r'id="core">([^<]+)<', text)[1])) == b"\0asm of the tests"
    for word in ("sill raised by [m]", "Download case", 'role="status"', 'aria-label="What you can change"'):
        assert word in text


def test_a_page_takes_the_place_of_a_page_and_of_nothing_else(made, tmp_path, monkeypatch, capsys):
    page, other = tmp_path / "page.html", tmp_path / "mine.html"
    other.write_text("<!doctype html>\nmine")
    words = ("live", JUMP, "--set", "discs.diameter=0.5", "--set", "live={}", "--out")
    assert call(monkeypatch, capsys, *words, page)[:2] == (0, f"{page}\n")
    page.write_bytes(page.read_bytes()[:1000])
    assert call(monkeypatch, capsys, *words, page)[0] == 0 and page.read_bytes().endswith(b"</body></html>")
    status, _, err = call(monkeypatch, capsys, *words, other)
    assert status == 2 and "is not overwritten" in err and other.read_text() == "<!doctype html>\nmine"


def test_a_run_that_cannot_be_computed_again_is_told_why(made, tmp_path):
    run = lj.load_case(JUMP, {"discs.diameter": 0.5, "run.duration": 0.05, "engine.name": "native"}).run(
        tmp_path / "run"
    )
    again = run_again(run.folder)
    assert isinstance(again, RunAgain) and again.head["steps"] == run.scene.steps and len(again.head["checks"]) == 2
    summary = run.folder / "summary.json"
    summary.write_text(summary.read_text().replace('"status": "complete"', '"status": "interrupted"'))
    said = run_again(run.folder)
    assert "not complete (interrupted)" in said and said in live_page(prepare(load_case(JUMP, SMALL)), said)


@pytest.mark.long
def test_a_page_goes_on_from_a_run(made, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    changes = {"discs.diameter": 0.5, "run.duration": 0.1, "run.output_interval": 0.05, "engine.name": "native"}
    run = lj.load_case(JUMP, {**changes, "live": {}}).run("run")
    for begin, said in (("last", "at its end"), ("50 ms", "at t = 0.05 s"), ("0.041", "at t = 0.05 s")):
        status, _, err = call(monkeypatch, capsys, "live", "run", "--from", begin, "--out", "page.html")
        assert status == 0 and f"begins with the discs of the run run {said}" in err
    starts = from_times(run.case, run.folder, (0.041, 0.05, "last"))  # two are nearest to the same frame
    assert [one.time for one in starts] == pytest.approx([0.05, 0.1])
    page = live_page(starts)
    assert "run run at t = 0.05 s" in page and "run run at its end" in page
    flow = prepare(run.case.after(run, "last"))
    last = run.frames[-1]
    places = last.to_numpy("x", "y")[np.argsort(last.ids)]
    assert np.allclose(flow.simulation.positions, places, rtol=1e-9, atol=0.0)  # a dump has ten digits
    status, _, err = call(monkeypatch, capsys, "live", "run", "--from", "soon", "--out", "page.html")
    assert status == 2 and "write a time, such as 3.5" in err


def test_an_image_holds_no_memory_of_the_process(monkeypatch):
    """What numpy has not written is whatever stood there before."""
    images, empty = [], np.empty
    for junk in (1, 2):

        def full(*shape, of=junk, **kind):
            found = empty(*shape, **kind)
            return np.full(found.shape, of, found.dtype) if found.dtype.names is None else found

        monkeypatch.setattr(np, "empty", full)
        flow = prepare(load_case(JUMP, {**SMALL, "live": {}}))
        monkeypatch.setattr(np, "empty", empty)
        images.append(placed_image(flow.simulation, flow.target, WORD, flow.discs)[0])
    parts = [{place: bytes(data) for place, data in image.parts} for image in images]
    assert [place for place in parts[0] if parts[0][place] != parts[1][place]] == [0]  # the state: numbers of its list


@pytest.mark.long
def test_a_case_without_sliders_gets_a_sensible_set():
    jump = prepare(load_case(JUMP, {"discs.diameter": 0.5}))
    assert set(jump.sliders) == {"sill", "discharge", "restitution", "slope"}
    assert jump.case.fields.inflow.table == ((0.0, 0.6, 10.0),) and len(jump.stops["restitution"]) > 10
    assert set(prepare(load_case(JUMP, {"discs.diameter": 0.5, "live": {}})).sliders) == set()


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("quick_jump", SMALL),
        ("quick_jump", {"discs.diameter": 0.3}),
        ("drum", {}),
        ("caisson", {}),
        ("sluice_gate", {}),
    ],
)
def test_steps_do_not_depend_on_how_long_the_case_runs(name, changes):
    """A downloaded case runs for as long as the page has; step, frames and settling stay those of the page."""
    case = prepare(load_case(INPUTS / f"{name}.yaml", {"discs.diameter": 0.5, "live": {}, **changes})).case
    interval, found = case.fields.run.output_interval, set()
    for frames in (1, 3, 7, 59, 60, 100):
        scene = case.replace({"run.duration": frames * interval}).scene()
        assert scene.steps - scene.settle_steps == frames * scene.output_steps
        outlets = tuple(outlet.every_steps for outlet in scene.outlets)
        found.add((scene.time_step, scene.output_steps, scene.settle_steps, outlets))
    assert len(found) == 1


def test_no_file_of_a_run_is_replaced(tmp_path):
    """The files of a run are this program's own: `--out RUN/case.yaml` put the page in place of its case."""
    write_marker(tmp_path, Marker("run", ("case.yaml",), {}))
    (tmp_path / "case.yaml").write_text("name: run\n")
    with pytest.raises(SetupError, match="stands there already and is not overwritten"):
        require_place(tmp_path / "case.yaml")
    (tmp_path / "page.html").write_bytes(MADE)
    require_place(tmp_path / "page.html")
