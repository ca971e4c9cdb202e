# SPDX-License-Identifier: GPL-2.0-or-later
"""Live pages in Chromium: they run from a file, controls have names, what was seen is the native run."""

from __future__ import annotations

import base64
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from chromium import PROGRAM, Address, Chromium, Page, chromium
from live_flows import lacking_core, native
from made_up import INPUTS
from serving import serving

from lammps_jump import load_case
from lammps_jump.live import from_times, live_page, live_part, prepare, run_again, with_fewer, write_page

pytestmark = [
    pytest.mark.browser,
    pytest.mark.usefixtures("compiled_core"),
    pytest.mark.skipif(not PROGRAM, reason="Chromium is not here"),
    pytest.mark.skipif(bool(lacking_core()), reason=lacking_core() or "the core is here"),
]
SLIDERS = {
    "sill": {"path": "walls.sill", "move": "y", "range": [-0.5, 2]},
    "discharge": {"path": "inflow", "range": [4, 8]},
}
STATE = """(async () => {
  play(false);
  const tables = await asked("tables"), state = await asked("state");
  let text = "";
  for (const byte of state) text += String.fromCharCode(byte);
  return [tables.step - live.head.start, btoa(text), caseText(live.head, tables)];
})()"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as found:
        yield found


def written(name: str, folder: Path, **changes: object) -> Path:
    path = folder / f"{name}.html"
    path.write_text(live_page(prepare(load_case(INPUTS / f"{name}.yaml", changes))))
    return path


def until(page: Page, condition: str) -> None:
    """Wait in the page for a condition, as its own clock goes; each picture looks again."""
    page.run(
        f"new Promise((go) => {{ const look = () => (({condition}) ? go() : requestAnimationFrame(look)); look(); }})"
    )


def slide(page: Page, name: str, value: float) -> None:
    page.run(
        f"""{{ const slider = document.querySelector("[data-name='{name}']"); slider.value = {value};
        slider.dispatchEvent(new Event("input")); }}"""
    )


def differing(one: bytes, two: bytes) -> int:
    if len(one) != len(two):
        return max(len(one), len(two))
    return int((np.frombuffer(one, "u1") != np.frombuffer(two, "u1")).sum())


def test_what_was_seen_is_the_native_run_of_the_downloaded_case(browser, tmp_path):
    """The sill goes up and the discharge down while the flow runs in real time."""
    path = written("quick_jump", tmp_path, **{"discs.diameter": 0.3, "live": SLIDERS})
    page = Page(browser, path, still=False)
    until(page, "live.last && live.last.time > 0.1")
    slide(page, "sill", 1.5)
    until(page, "live.last.time > 0.5")
    slide(page, "discharge", 4.5)
    until(page, "live.last.time > 1.2")
    steps, state, text = page.run(STATE)
    assert page.troubles() == [] and steps > 1000
    assert "raised by" in page.run("document.querySelector('.axes').textContent")
    assert differing(base64.b64decode(state), native(text, steps)) == 0
    page.close()


@pytest.mark.parametrize("name", ["stable_jump", "quick_jump", "dam_break", "heap", "caisson", "drum", "tailgate"])
def test_2000_steps_have_the_bits_of_the_native_engine(browser, tmp_path, name):
    page = Page(browser, written(name, tmp_path, live={}))
    until(page, "live.last")
    page.run("live.worker.postMessage({ act: 'step', steps: 2000 })")
    until(page, "live.last.step - live.head.start === 2000")
    steps, state, text = page.run(STATE)
    assert steps == 2000 and page.troubles() == []
    assert differing(base64.b64decode(state), native(text, 2000)) == 0
    page.close()


def test_step_start_and_sliders_by_the_keyboard(browser, tmp_path):
    page = Page(browser, written("quick_jump", tmp_path, **{"discs.diameter": 0.5, "live": SLIDERS}))
    until(page, "live.last")

    def press(key: str, code: str, number: int) -> None:
        for kind in ("keyDown", "keyUp"):
            page.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, windowsVirtualKeyCode=number, text=key)

    press(".", "Period", 190)
    until(page, "live.last.step === 1")
    page.run("document.querySelector(\"[data-name='sill']\").focus()")
    page.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowRight", code="ArrowRight", windowsVirtualKeyCode=39)
    assert page.run("document.activeElement.getAttribute('aria-valuetext')") == "0.01 m"
    page.run("document.activeElement.blur(), oneStep()")
    until(page, "live.last.step === 2")
    assert page.run("document.querySelector('.clock').textContent").endswith("step 2")  # of the picture that is shown
    page.run("byClass('again').click()")
    until(page, "live.last.step === 0")
    assert page.troubles() == []
    page.close()


@pytest.mark.parametrize("width", [390, 1440])
def test_every_control_has_a_name_and_nothing_is_wider_than_the_screen(browser, tmp_path, width):
    path = written("drum", tmp_path)
    page = Page(browser, path, width=width, phone=width < 500)
    until(page, "live.last")
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    controls = [one for one in nodes if one["role"]["value"] in ("button", "slider", "combobox", "link")]
    assert len(controls) >= 10 and all(one["name"]["value"] for one in controls)
    sliders = [one for one in controls if one["role"]["value"] == "slider"]
    assert [one["name"]["value"].split(" ")[0] for one in sliders] == ["friction", "restitution", "slope"]
    assert page.run("document.documentElement.scrollWidth <= innerWidth")
    assert page.troubles() == []
    page.close()


def test_a_run_is_computed_again_and_where_it_parts_is_told(browser, tmp_path):
    """A jet and a rough bed; then one digit of the dump is another."""
    said = []
    for name, changes in (
        ("quick_jump", {"discs.diameter": 0.3, "run.duration": 0.4}),
        ("heap", {"run.duration": 0.06}),
    ):
        run = load_case(INPUTS / f"{name}.yaml", {"engine.name": "native", **changes}).run(tmp_path / name)
        path = write_page(prepare(run.case.replace({"live": {}})), tmp_path / f"{name}.html", run_again(run.folder))
        said.append(_verified(browser, path))
        dump = run.folder / "dump.lammpstrj"
        lines = dump.read_text().split("\n")
        lines[-2] = lines[-2].replace("1", "2", 2)
        dump.write_text("\n".join(lines))
        said.append(
            _verified(browser, write_page(prepare(run.case.replace({"live": {}})), path, run_again(run.folder)))
        )
        assert said[-1].startswith(f"They part: the first frame that differs is at step {run.scene.steps}, ")
        assert said[-2].startswith(f"The same {run.scene.steps:,} steps, to the last bit: the end and the states at ")


def test_of_a_run_of_lammps_the_page_tells_how_far_it_parts(browser, tmp_path):
    """The compiled styles follow to 1e-9 diameters over the first frame of a jet; a binary dump has all digits."""
    changes = {
        "discs.diameter": 0.3,
        "run.duration": 0.2,
        "run.output_interval": 0.02,
        "engine.kernel": "compiled",
        "run.dump_format": "binary",
    }
    run = load_case(INPUTS / "quick_jump.yaml", {**changes, "engine.name": "lammps"}).run(tmp_path / "run")
    path = write_page(prepare(run.case.replace({"live": {}})), tmp_path / "far.html", run_again(run.folder))
    said = _verified(browser, path)
    parts = re.findall(r"t = ([\d.]+) s: ([\d.e-]+) ", said)
    assert len(parts) == 10 and parts[0][0] == "0.0000" and float(parts[0][1]) == 0.0 and float(parts[1][1]) < 1e-9
    assert "in another order" in said and "not in both" not in said


def _verified(browser: Chromium, path: Path) -> str:
    page = Page(browser, path)
    until(page, "live.last")
    page.run("byClass('verify').click()")
    until(page, "/same|part|ended|cannot|distance/.test(byClass('verified').textContent)")
    assert page.troubles() == []
    found = page.run("byClass('verified').textContent")
    page.close()
    return found


def test_open_runs_the_flow_of_the_text_while_it_is_written(browser, tmp_path):
    path = tmp_path / "jump.yaml"
    path.write_text((INPUTS / "quick_jump.yaml").read_text().replace("diameter: 0.15", "diameter: 0.5"))
    with serving(path) as server:
        page = Page(browser, Address(server.address))
        until(page, "document.querySelector('#derived table')")
        page.run("byId('flow').click()")
        until(page, "document.querySelector('#flow-place iframe')")
        first = page.run("document.querySelector('#flow-place iframe').src")
        page.run("editor.replace(editor.text.replace('y: [-5, 1]', 'y: [-5, 1.5]'))")
        until(page, f"document.querySelector('#flow-place iframe').src !== {first!r}")
        page.run("byId('flow').click()")
        assert page.run("byId('flow-place').children.length") == 0
        assert [one for one in page.troubles() if not one.startswith("asks for http://127.0.0.1")] == []
        page.close()


def test_a_page_without_webassembly_says_so(browser, tmp_path):
    path = written("quick_jump", tmp_path, **{"discs.diameter": 0.5, "live": {}})
    broken = tmp_path / "broken.html"
    shutil.copy(path, broken)
    broken.write_text(broken.read_text().replace("&#39;wasm-unsafe-eval&#39; ", ""))
    page = Page(browser, broken)
    until(page, "byClass('told').textContent")
    assert page.run("byClass('told').textContent").startswith("The page cannot compute here: ")
    page.close()


FRAME = "document.querySelector('.live-place iframe').contentWindow"
"""The live page in the frame of a report."""


@pytest.fixture(scope="module")
def jump(tmp_path_factory):
    """A short coarse jump of the native engine."""
    changes = {"discs.diameter": 0.5, "run.duration": 0.4, "run.output_interval": 0.05, "engine.name": "native"}
    case = load_case(INPUTS / "quick_jump.yaml", {**changes, "live": SLIDERS})
    return case.run(tmp_path_factory.mktemp("jump") / "run")


@pytest.mark.parametrize("width", [390, 1440])
def test_a_report_goes_on_from_one_of_its_moments_and_shows_both_branches(browser, jump, tmp_path, width):
    """What was done there is a case that begins from the run, with the bits of what was seen."""
    starts = from_times(jump.case, jump.folder, [0.1, 0.3])
    page = Page(
        browser,
        jump.report(tmp_path / "report.html", live=live_part(jump.folder, starts)),
        width=width,
        phone=width < 500,
    )
    page.run("tell('seek', 0.05), document.querySelector('.here').click()")
    assert page.run("document.querySelector('.told-live').textContent").startswith("The page can go on from t = 0.1 s")
    page.run("tell('seek', 0.25), document.querySelector('.here').click()")
    until(page, f"document.querySelector('.live-place iframe') && {FRAME}.document.querySelector('#was:not([hidden])')")
    assert page.run("players[0].time") == 0.1
    assert page.run(f"{FRAME}.document.querySelector('.clock').textContent") == "t = 0.100 s, step 0"
    legends = page.run(f"[...{FRAME}.document.querySelectorAll('.legend')].map((one) => one.textContent)")
    assert legends == ["sillsill, as it was", "hereas it was", "hereas it was"]
    got = page.run(
        f"""(async () => {{
        const frame = {FRAME}, sill = frame.document.querySelector("[data-name='sill']");
        sill.value = 1.5;
        sill.dispatchEvent(new Event("input"));
        frame.document.querySelector(".step").click();
        const text = new Promise((go) => {{ frame.save = go; }});
        frame.document.querySelector(".download").click();
        const state = await frame.asked("state");
        return [await text, btoa(Array.from(state, (one) => String.fromCharCode(one)).join(""))];
        }})()"""
    )
    state = base64.b64decode(got[1])
    assert state[:8] == (1).to_bytes(8, "little") and str(jump.folder) in got[0]
    assert differing(state, native(got[0], 1)) == 0
    assert page.run("document.documentElement.scrollWidth <= innerWidth") and page.troubles() == []
    page.close()


def test_open_goes_on_from_the_frame_that_is_shown(browser, jump):
    with serving(jump.folder) as server:
        page = Page(browser, Address(server.address))
        until(page, "players.length && players[0].run.times.length === 9 && !byId('differently').parentElement.hidden")
        page.run("tell('seek', 0.2), byId('differently').click()")
        until(page, "parseInt(document.querySelector('#differently-place iframe')?.style.height) > 900")
        assert [one for one in page.troubles() if not one.startswith("asks for http://127.0.0.1")] == []
        page.close()


def test_a_phone_begins_with_fewer_discs_and_may_have_all(browser, tmp_path):
    case = load_case(INPUTS / "quick_jump.yaml", {"discs.diameter": 0.11, "live": SLIDERS})
    path = write_page(with_fewer(case, prepare(case)), tmp_path / "few.html")
    for width, number in ((1440, "0"), (390, "1")):
        page = Page(browser, path, width=width, phone=width < 500)
        until(page, "live.last")
        few, all_ = (int(text.split(" ")[0].replace(",", "")) for text in reversed(page.run(LABELS)))
        assert page.run("byClass('begin').value") == number and few < 0.5 * all_
        assert page.run("live.last.ids.length") == (few if number == "1" else all_)
        other = str(1 - int(number))
        page.run(f"byClass('begin').value = '{other}', byClass('begin').dispatchEvent(new Event('change'))")
        until(page, f"live.last && live.last.ids.length === {all_ if number == '1' else few}")
        assert page.troubles() == []
        page.close()


LABELS = "[...byClass('begin').options].map((one) => one.textContent)"
