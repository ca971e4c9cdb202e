# SPDX-License-Identifier: GPL-2.0-or-later
"""All generated parts of the site, written to ``docs/_made``; those of ``docs/reference`` stand in the source tree.

``python -m making.pages`` in ``docs`` writes the reference again (``make reference``).
"""

from __future__ import annotations

from pathlib import Path

from . import commands, fields, folder, gallery, measured, numbers, verdicts

REFERENCE = {
    "fields": fields.page, "commands": commands.page, "folder": folder.page, "numbers": numbers.page,
    "verdicts": verdicts.page,
}  # fmt: skip
"""Pages of ``docs/reference`` that are made from the program."""


def make(docs: Path) -> None:
    """Write what is new or has changed, so that Sphinx reads only that again."""
    made = docs / "_made"
    reference(docs)
    for path in sorted(measured.FOLDER.glob("*.json")):
        (made / "measured").mkdir(parents=True, exist_ok=True)
        write(made / "measured" / f"{path.stem}.md", measured.fragment(path.stem, place=made / "measured"))
    gallery.make(docs)


def reference(docs: Path) -> None:
    """Write the pages of the reference."""
    for name, page in REFERENCE.items():
        write(docs / "reference" / f"{name}.md", page())


def write(path: Path, text: str) -> None:
    """Write a text where it is not there yet."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


if __name__ == "__main__":
    reference(Path(__file__).parents[1])
