# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands, Python and numbers of tutorials and how-to pages, and the notebook; run with ``make docs-test``.

Blocks of a page are run in their order in one folder: ``sh`` by the shell, ``python`` in one namespace. ``yaml`` whose
first line is a comment with a name is written to that file. A ``text`` block is what the block before it prints:
each of its lines is found there, with numbers within 3 %. Blocks of another language, as ``console``, are not run.
"""

import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import ezdxf
import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [DOCS / "tutorial.md", *sorted(DOCS.glob("howto/*.md"))]
BLOCK = re.compile(r"^```(sh|python|yaml|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
WITHIN = 0.03
"""Share by which a printed number may differ: chaos makes a jump of other processors another draw, 1 to 2 % off."""


def drawings() -> None:
    """Write the files that the page on drawings takes for granted."""
    document = ezdxf.new("R2010")
    document.units = ezdxf.units.M
    document.layers.add("bed level")
    bed = [(0, 0, 0), (10, 0, 0), (20, -1, 0), (25, -1, -0.4), (28, -1, 0), (30, -1, 0)]
    document.modelspace().add_lwpolyline(bed, format="xyb", dxfattribs={"layer": "bed level"})
    document.saveas("weir.dxf")
    shutil.copy("inputs/dam_break.yaml", "my_case.yaml")
    Path("river.csv").write_text("chainage (m),level (m)\n0,102.5\n40,102.1\n")
    shape = '<path id="dam" d="M0 50 L40 50 L50 20 L55 50 L100 50"/>'
    Path("section.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">{shape}</svg>'
    )


TAKEN_FOR_GRANTED = {"drawings": drawings}
"""What writes the files that a page does not make itself."""


@pytest.fixture
def place(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "inputs", tmp_path / "inputs")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def in_shell(text: str) -> str:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-e", "-c", text], env={**os.environ, "PATH": path, "COLUMNS": "200"}, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def in_python(text: str, namespace: dict) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(text, "page", "exec"), namespace)
    plt.close("all")
    return printed.getvalue()


def assert_printed(said: str, printed: str) -> None:
    """Each line of `said` is among those `printed`, numbers nearly."""
    for line in filter(None, map(str.strip, said.splitlines())):
        if line == "…":
            continue
        same = [one for one in printed.splitlines() if NUMBER.sub("#", one).split() == NUMBER.sub("#", line).split()]
        numbers = [float(one) for one in NUMBER.findall(line)]
        close = [one for one in same if [float(x) for x in NUMBER.findall(one)] == pytest.approx(numbers, rel=WITHIN)]
        assert close, f"{line!r} is not among\n{printed}"


@pytest.mark.docs
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page(page, place):
    printed, namespace = "", {}
    TAKEN_FOR_GRANTED.get(page.stem, lambda: None)()
    for language, text in BLOCK.findall(page.read_text()):
        if language == "sh":
            printed = in_shell(text)
        elif language == "python":
            printed = in_python(text, namespace)
        elif language == "yaml" and (name := re.match(r"# (\S+\.yaml)\n", text)):
            (place / name[1]).write_text(text)
        elif language == "text":
            assert_printed(text, printed)


@pytest.mark.docs
def test_notebook(place):
    cells = json.loads((DOCS / "notebooks" / "first_jump.ipynb").read_text())["cells"]
    namespace: dict = {}
    printed = "".join(in_python("".join(cell["source"]), namespace) for cell in cells if cell["cell_type"] == "code")
    assert "jump" in printed


def test_lines_are_compared_with_their_numbers():
    assert_printed("depth 3.2 m", "found\ndepth   3.25 m")
    with pytest.raises(AssertionError):
        assert_printed("depth 3.2 m", "depth 3.5 m")
