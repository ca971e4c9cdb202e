# SPDX-License-Identifier: GPL-2.0-or-later
"""Takes the pictures of the page of `open` for docs/howto/page.md, in Chromium: ``make figures``."""

from __future__ import annotations

import io
import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from chromium import PROGRAM, Address, Page, chromium  # noqa: E402
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


def main() -> None:
    """Open a case, make an error, mend it, run it, and look at the run."""
    if PROGRAM is None:
        sys.exit("pictures of the page need Chromium (Debian's package chromium)")
    with TemporaryDirectory() as place, chromium(Path(place) / "profile") as browser:
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
