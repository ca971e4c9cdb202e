# SPDX-License-Identifier: GPL-2.0-or-later
"""Text of a case, of a file name and of a folder that was handed on is data in every place where it is written."""

from __future__ import annotations

import csv
import io
import json
import re
import subprocess
import unicodedata
from dataclasses import replace
from functools import partial
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from children import LIMIT
from hypothesis import example, given
from hypothesis import strategies as st
from made_up import disc_frame, flow_context, without_analysis

import lammps_jump as lj
from lammps_jump import quoting
from lammps_jump.analysis import pipeline
from lammps_jump.analysis.draw.style import drawing
from lammps_jump.analysis.report.run import write_report
from lammps_jump.cli.app import PatientStream
from lammps_jump.dump.exports import write_table
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import CaseError
from lammps_jump.runs import results
from lammps_jump.runs.view import case_html
from lammps_jump.script.assemble import data_text, molecule_text, script_text
from lammps_jump.script.job import job_text

pytestmark = pytest.mark.fault("text as a command")

CASE = {
    "discs": {"diameter": 0.2},
    "contact": {"restitution": 0.5, "impact_speed": 5},
    "domain": {"x": [0, 4], "y": [-1, 4]},
    "walls": [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
    "initial": [{"kind": "list", "positions": [[1, 0.5], [2, 0.5]]}],
    "probes": {"forces": ["floor"]},
    "run": {"duration": 0.02, "output_interval": 0.01},
}
ATTACKS = (
    "x\nshell touch PWNED",
    "x\r\nshell touch PWNED",
    "x\rshell touch PWNED",
    "x\x85shell touch PWNED\u2028shell touch PWNED",
    'x """\nshell touch PWNED',
    "x & \nshell touch PWNED",
    "${x} $(shell touch PWNED) `touch PWNED`",
    "'; touch PWNED; '\n#SBATCH --wrap='touch PWNED'",
    "<script>touch('PWNED')</script><img src=x onerror=alert(1)>",
    "=cmd|'/c touch PWNED'!A1",
    "\x1b]0;PWNED\x07\x9b2J",
    "$x^{2$ \\frac{",
    "\u202eDENWP",
    "\ud800",
)
ALPHABET = st.characters(codec=None) | st.sampled_from(list("\n\r\"'&$#`;<>=@\\\x00\x1b\x9b\u2028\u202e\ud800"))
TEXTS = st.text(ALPHABET, max_size=60) | st.sampled_from(ATTACKS)


def any_text(test):
    """Run a test with made-up texts, and with every attack."""
    for attack in ATTACKS:
        test = example(attack)(test)
    return given(TEXTS)(test)


def scene_called(name: str, description: str):
    """A scene with texts that no case would have."""
    return replace(lj.load_case(CASE | {"name": "a"}).scene(), name=name, description=description)


# --- what a case takes


@any_text
def test_a_description_is_one_line_of_printable_text_or_refused(text):
    try:
        case = lj.load_case(CASE | {"name": "a", "description": text})
    except CaseError as error:
        assert "description" in str(error) and "\n" not in str(error)
        assert any(unicodedata.category(letter)[0] in "CZ" for letter in text) or len(text) > 500
        return
    found = case.fields.description
    assert found.splitlines() in ([], [found]) and not any(map(quoting.is_hidden, found))
    assert found.split() == text.split(), "nothing but line breaks and spaces is changed"
    assert lj.load_case(CASE | {"name": "a", "description": found}).fields.description == found


@any_text
def test_names_are_letters_and_digits_or_refused(text):
    walls = [dict(CASE["walls"][0], name=text)]
    for changed in ({"name": text}, {"walls": walls, "probes": {}}, {"probes": {"forces": [text]}}, {text: 1}):
        try:
            scene = lj.load_case(CASE | {"name": "a"} | changed).scene()
        except CaseError as error:
            assert str(error)
        else:
            names = (scene.name, *scene.probes, *(one.wall.name for one in scene.walls))
            assert all(re.fullmatch("[A-Za-z0-9_.-]+", name) for name in names)


def test_an_honest_description_of_two_lines_is_folded(tmp_path):
    (tmp_path / "Прыжок 1.yaml").write_text(
        json.dumps(CASE)[:-1] + ', "description": "a jet of 10 m/s,\\n  0.6 m deep · naïve\\n"}', encoding="utf-8"
    )
    case = lj.load_case(tmp_path / "Прыжок 1.yaml")
    assert case.fields.description == "a jet of 10 m/s, 0.6 m deep · naïve"
    assert case.name == "1"


@pytest.mark.parametrize("length, good", [(500, True), (501, False)])
def test_a_description_has_at_most_500_characters(length, good):
    changed = CASE | {"name": "a", "description": length * "x"}
    if good:
        lj.load_case(changed)
    else:
        with pytest.raises(CaseError, match="501 characters; at most 500"):
            lj.load_case(changed)


@pytest.mark.parametrize("code", ["D800", "202E", "2066", "001B", "0085", "2028", "0000", "007F"])
def test_what_cannot_be_printed_is_refused_with_its_place(tmp_path, code):
    (tmp_path / "case.yaml").write_text(json.dumps(CASE | {"name": "a"})[:-1] + f', "description": "ab\\u{code}"}}')
    with pytest.raises(CaseError, match=rf"case.yaml:1: description: character 3 is U\+{code}"):
        lj.load_case(tmp_path / "case.yaml")


# --- one writer a target


@any_text
def test_lammps_files_hold_it_as_a_comment(text):
    plain, scene = scene_called("a", ""), scene_called(text, text)
    script = script_text(scene, header=(text,)).splitlines()
    assert [line for line in script if not line.startswith("#")] == [
        line for line in script_text(plain, header=("",)).splitlines() if not line.startswith("#")
    ]
    files = (*script, *"".join(data_text(scene)).splitlines(), *molecule_text(scene).splitlines())
    assert len(files) == len(script) + len(("".join(data_text(plain)) + molecule_text(plain)).splitlines())
    first = (script[0], script[1], next(data_text(scene)).split("\n")[0], molecule_text(scene).split("\n")[0])
    for line in first:
        assert line.isascii() and line.isprintable() and not set("&$\"'") & set(line)


@any_text
def test_a_job_file_holds_it_as_a_word(text):
    plain, job = job_text(scene_called("a", ""), 2).splitlines(), job_text(scene_called(text, text), 2).splitlines()
    assert [line for line in job if "--job-name" not in line] == [line for line in plain if "--job-name" not in line]
    (name,) = [line.partition("=")[2] for line in job if "--job-name" in line]
    assert re.fullmatch("[A-Za-z0-9_.-]+", name)


class Page(HTMLParser):
    """Tags and their attributes of a page."""

    def __init__(self, text: str):
        super().__init__()
        self.tags: list[tuple[str, tuple[str, ...]]] = []
        self.policy = ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        """Note a tag."""
        self.tags.append((tag, tuple(name for name, _ in attributes)))
        if ("http-equiv", "Content-Security-Policy") in attributes:
            self.policy = dict(attributes)["content"]


def test_pages_hold_it_as_text(tmp_path):
    def page(text: str) -> Page:
        summary = {
            "name": text, "description": text, "status": text or "complete", "message": text, "engine": text,
            "kernel": text, "warnings": [text], "skipped": [text], "versions": {text: text},
            "discs": {text: 1}, "wall_seconds": {text: 1.0}, "force": {text: {"peak": 1.0}},
        }  # fmt: skip
        path = write_report(tmp_path, summary, text)
        return Page(path.read_text(encoding="utf-8", errors="surrogatepass"))

    plain = page("a")
    assert "script" not in {tag for tag, _ in plain.tags}
    assert plain.policy.startswith("default-src 'none'; img-src data:") and "script-src" not in plain.policy
    for attack in ATTACKS:
        assert page(attack).tags == plain.tags, attack
        shown = Page(case_html(attack, scene_called(attack, attack)))
        assert shown.tags == Page(case_html("a", scene_called("a", "a"))).tags


@any_text
def test_tables_hold_no_formula(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("table") / "table.csv"
    write_table({text: [text, "-1"], f"{text}2": [1.0, -2.0]}, path)
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[1][1] == "1" and rows[2] == ["-1", "-2"]
    for cell in (*rows[0], rows[1][0]):
        try:
            float(cell)
        except ValueError:
            assert not cell.lstrip().startswith(("=", "+", "-", "@")), cell


def test_figures_show_it_as_it_is():
    for attack in ATTACKS:
        flow = flow_context(domain=((0, 1), (0, 1)), x_range=(0, 1), name=attack)
        with drawing(2, 1) as (figure, axes):
            axes.set_title(flow.title)
            figure.canvas.draw()  # a formula that is none would raise


@any_text
def test_a_terminal_is_not_commanded(text):
    sent = io.StringIO()
    stream = PatientStream(sent)
    print(text, file=stream)
    assert all(letter in "\n\t\u200c\u200d" or not quoting.is_hidden(letter) for letter in sent.getvalue())
    assert stream.trouble is None
    sent.getvalue().encode("utf-8")


# --- the whole way


def test_an_attack_in_a_description_makes_no_file(tmp_path, monkeypatch):
    """Every attack that a case takes, run by LAMMPS; the others are refused before anything is written."""
    (tmp_path / "case.yaml").write_text(json.dumps(CASE | {"name": "a"}))
    without_analysis(monkeypatch)  # pages and figures have tests of their own
    taken = 0
    for number, attack in enumerate(ATTACKS):
        try:
            case = lj.load_case(tmp_path / "case.yaml", {"description": attack})
        except CaseError:
            continue
        taken += 1
        run = case.run(tmp_path / f"run{number}", kernel="stock")
        assert run.status == "complete" and run.result.steps == case.scene().steps
    assert taken >= 5
    assert not list(tmp_path.rglob("PWNED"))


def test_an_attack_in_a_file_name_makes_no_file(tmp_path, monkeypatch):
    monkeypatch.setattr(pipeline, "analyse", partial(pipeline.analyse, pictures=pipeline.Pictures("none")))
    for number, attack in enumerate(attack.replace("/", "_") for attack in ATTACKS if attack != "\ud800"):
        folder = tmp_path / str(number)
        folder.mkdir()
        path = folder / f"{attack.replace('.', '_')}.lammpstrj"
        x = np.arange(0.1, 2, 0.2)
        with DumpWriter(path, ("id", "x", "y", "vx", "vy")) as out:
            for step in range(4):
                frame = disc_frame(x + 0.01 * step, 0 * x + 0.1, 1.0, box=[(0, 3), (0, 1)], step=step, time=0.1 * step)
                out.write_frame(frame)
        results.analyse_dump(path, None, results.AnalysisInputs(0.2), folder / "out")
        assert (folder / "out" / "summary.json").is_file()
    assert not list(tmp_path.rglob("PWNED"))


def test_a_job_file_with_an_attack_is_read_as_one_word(tmp_path):
    for attack in ATTACKS:
        head = job_text(scene_called(attack, attack), 1).split("\n#SBATCH --nodes")[0]
        subprocess.run(["bash", "-c", head], cwd=tmp_path, check=True, timeout=LIMIT)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "name", [*(name for name in ATTACKS if name.isprintable()), "--help.yaml", "-x", "a b", "~", "a'b", "$HOME", "*"]
)
def test_a_command_that_is_told_means_the_same_path(tmp_path, name):
    """What a shell makes of it are the words again, and no path is taken for an option."""
    told = quoting.typed("run", Path(name), "--resume")
    shown = subprocess.run(["bash", "-c", f"printf '%s\\0' {told}"], capture_output=True, cwd=tmp_path, timeout=LIMIT)
    program, command, path, option = shown.stdout.decode().split("\0")[:-1]
    assert (program, command, option) == ("lammps-jump", "run", "--resume")
    assert Path(path) == Path(name) and not path.startswith("-") and not list(tmp_path.iterdir())
