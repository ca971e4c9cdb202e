# SPDX-License-Identifier: GPL-2.0-or-later
"""Takes the pictures of pages in Chromium: of `open` for docs/howto/page.md, of a report for README: ``make figures``.

The picture of the report is of the one that the gallery keeps, and carries its numbers, which a test compares.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from PIL.PngImagePlugin import PngInfo

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from chromium import PROGRAM, Address, Chromium, Page, chromium  # noqa: E402
from serving import serving  # noqa: E402

SCENE = "quick_jump"
SIZE = {"width": 1280, "height": 720}
COLOURS = 128
"""Of a stored picture, which git keeps for good."""
UNTIL = "new Promise((done) => {{ const look = () => (({what}) ? done(1) : setTimeout(look, 50)); look(); }})"


def take(page: Page, name: str) -> None:
    """Keep a picture of what is seen."""
    with TemporaryDirectory() as folder:
        data = page.picture(Path(folder) / name).read_bytes()
    Image.open(io.BytesIO(data)).convert("RGB").quantize(COLOURS).save(HERE / name, optimize=True)


NUMBERS = "[...document.querySelectorAll('.first h1, .numbers > div')].map((one) => one.innerText)"
"""Verdict and boxes of a report as they are read."""


def take_report(browser: Chromium) -> None:
    """Keep a picture of the report that the gallery keeps, with its numbers in the text of the file."""
    page = Page(browser, ROOT / "docs" / "stored" / f"{SCENE}.html", width=1280, height=1000)
    page.run("tell('seek', 0.7 * players[0].end)")
    take(page, "report.png")
    told = PngInfo()
    told.add_text("numbers", json.dumps(page.run(NUMBERS)))
    with Image.open(HERE / "report.png") as picture:
        picture.save(HERE / "report.png", optimize=True, pnginfo=told)


def main() -> None:
    """Open a case, make an error, mend it, run it, and look at the run."""
    if PROGRAM is None:
        sys.exit("pictures of the page need Chromium (Debian's package chromium)")
    with TemporaryDirectory() as place, chromium(Path(place) / "profile") as browser:
        take_report(browser)
        os.chdir(place)
        shutil.copy(ROOT / "inputs" / f"{SCENE}.yaml", "jump.yaml")
        with serving(Path("jump.yaml")) as server:
            page = Page(browser, Address(server.address), **SIZE)
            page.run(UNTIL.format(what="document.querySelector('#drawing .sketch') && !byId('go').disabled"))
            page.run("document.querySelector('.dot[title^=\"sill, upper left\"]').focus()")
            take(page, "open_case.png")
            page.run("editor.replace(editor.text.replace('kind: block', 'kind: blok'))")
            page.run(UNTIL.format(what="byId('error').textContent"))
            page.run("byId('error').querySelector('button').click()")
            take(page, "open_error.png")
            page.run("editor.back()")
            page.run(UNTIL.format(what="!byId('error').textContent && file.saved === editor.text"))
            page.run("byId('go').click()")
            page.run(UNTIL.format(what="document.querySelector('#run')"))
            run = Page(browser, Address(server.address + "run/0/"), width=1280, height=1000)
            run.run(UNTIL.format(what="byId('state').textContent.includes('complete')"))
            run.run("tell('seek', 0.7 * players[0].end)")
            take(run, "open_run.png")


if __name__ == "__main__":
    main()
