# SPDX-License-Identifier: GPL-2.0-or-later
"""Text of users and of files that were handed on: what is taken, and one writer for each place where it is written."""

from __future__ import annotations

import re
import shlex
import unicodedata
from pathlib import Path
from typing import Any

PROGRAM = "lammps-jump"
LONGEST = 500
"""Characters of a text field of a case."""
MOST_ECHOED = 200
"""Characters of a value in a message."""
LONGEST_NAME = 64
"""Characters of a name."""
JOINERS = "\u200c\u200d"
"""Characters without a shape that some scripts and pictographs need."""
IN_COMMENT = str.maketrans({"&": "+", "$": "S", '"': "`", "'": "`"})
"""Characters that continue a line, begin a variable or open a quotation in LAMMPS."""


def one_line(text: str) -> str:
    """A text with its line breaks folded to spaces.

    Raises
    ------
    ValueError
        A character that is not printable (controls, those that turn the direction, halves of pairs), or a long text.
    """
    text = re.sub(r"\s*\r?\n\s*", " ", text).strip(" ")
    for place, letter in enumerate(text, 1):
        if is_hidden(letter):
            raise ValueError(
                f"character {place} is U+{ord(letter):04X}, which cannot be printed; one line of printable text is "
                "allowed: delete it"
            )
    if len(text) > LONGEST:
        raise ValueError(f"has {len(text)} characters; at most {LONGEST} are allowed: shorten it")
    return text


def is_hidden(letter: str) -> bool:
    """Tells whether a character is not a visible one: control, format, surrogate, line separator."""
    return unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp") and letter not in JOINERS


def visible(text: str) -> str:
    """A text with a space in place of every character that cannot be printed."""
    return "".join(" " if is_hidden(letter) else letter for letter in text)


def plain_name(text: str) -> str:
    """A name of letters, digits, ``_``, ``.`` and ``-``, which means nothing special anywhere."""
    kept = re.sub(r"[^A-Za-z0-9_.-]", "_", text).lstrip("_.-")[:LONGEST_NAME]
    return kept or "case"


def lammps_comment(text: str) -> str:
    """A text for a comment or title line of a LAMMPS file: one line of ASCII that LAMMPS neither reads nor joins."""
    return " ".join(visible(text).encode("ascii", "replace").decode().translate(IN_COMMENT).split())


def shell_word(text: str) -> str:
    """A name as one word of a job file."""
    return shlex.quote(plain_name(text))


def typed(*words: str | Path) -> str:
    """A command of this program as one types it; a path that begins as an option does has its folder before it."""
    return shlex.join([PROGRAM, *map(as_word, words)])


def as_word(word: str | Path) -> str:
    """A path as a word of a command line, which is no option."""
    return f"./{word}" if isinstance(word, Path) and str(word).startswith("-") else str(word)


def echoed(value: object) -> str:
    """A value of the user's as a message shows it, with quotes: one line, at most `MOST_ECHOED` characters."""
    return shortened(repr(value[: 2 * MOST_ECHOED] if isinstance(value, str | list | tuple) else value))


def shortened(text: str) -> str:
    """A text for a message: one line, at most `MOST_ECHOED` characters."""
    text = visible(text[: 2 * MOST_ECHOED])
    return text if len(text) <= MOST_ECHOED else f"{text[: MOST_ECHOED - 1]}…"


def csv_cell(text: Any) -> Any:
    """A value for a cell; a text is one line, and a leading ``'`` keeps a spreadsheet from taking it for a formula."""
    if not isinstance(text, str):
        return text
    text = visible(text)
    if not text.lstrip().startswith(("=", "+", "-", "@")):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text


def figure_text(text: str) -> str:
    """A text for a figure: matplotlib takes no part of it for a formula."""
    return visible(text).replace("$", r"\$")


def terminal_text(text: str) -> str:
    """A text for the screen: an escape sequence is shown, not sent; line breaks and tabs stay."""
    return "".join(
        letter.encode("unicode_escape").decode() if is_hidden(letter) and letter not in "\n\t" else letter
        for letter in text
    )
