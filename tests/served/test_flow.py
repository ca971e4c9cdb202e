# SPDX-License-Identifier: GPL-2.0-or-later
"""The live page of a text that is being written: at an address of its own, with a policy that lets it compute."""

from __future__ import annotations

import pytest
from made_up import INPUTS

from lammps_jump import served
from lammps_jump.core import browser
from lammps_jump.errors import JumpError
from lammps_jump.served.look import flow_page
from lammps_jump.served.server import FOREIGN, LIVE

pytestmark = pytest.mark.usefixtures("compiled_core")


@pytest.fixture
def made(tmp_path, monkeypatch):
    monkeypatch.setattr(browser, "CODE", tmp_path / "core.wasm")
    monkeypatch.setattr(browser, "RECORD", tmp_path / "core.json")
    browser.write(b"\0asm of the tests")


def text_of_case(**changes: str) -> str:
    text = (INPUTS / "quick_jump.yaml").read_text().replace("diameter: 0.15", "diameter: 0.5")
    return text + "".join(f"{key}: {value}\n" for key, value in changes.items())


def test_the_page_of_a_text_has_no_sliders_that_take_long(made, tmp_path):
    page = flow_page(text_of_case(), tmp_path / "case.yaml")
    assert 'data-name="sill"' in page and 'data-name="restitution"' not in page
    with pytest.raises(JumpError, match="unknown field"):
        flow_page(text_of_case(walk="1"), tmp_path / "case.yaml")


def test_a_page_is_answered_once_it_is_asked_for_and_four_are_kept(tmp_path, monkeypatch):
    path = tmp_path / "case.yaml"
    path.write_text(text_of_case())
    pages = served.pages_of(path)
    monkeypatch.setattr(pages._bounded, "run", lambda work: f"page of {len(work.call.args[0])} letters")
    made = [pages.post("flow", {"text": number * "x", "page": "a"}) for number in range(6)]
    tokens = [reply.body.decode().split("/")[1] for reply in made]
    assert [pages.alone(token) is not None for token in tokens] == [False, False, True, True, True, True]
    shown = pages.alone(tokens[-1])
    assert shown.body == b"page of 5 letters" and shown.policy == LIVE and pages.alone("") is None
    pages.close()


def test_it_may_compute_in_a_thread_of_its_own_and_no_more_than_a_report():
    more = set(LIVE.replace(";", "").split()) - set(FOREIGN.replace(";", "").split())
    assert more == {"worker-src", "'wasm-unsafe-eval'"}
    assert "allow-same-origin" not in LIVE
