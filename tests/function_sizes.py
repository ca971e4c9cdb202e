# SPDX-License-Identifier: GPL-2.0-or-later
"""Functions of C++ and JavaScript: their names, lines of code and parameters, by the braces of the text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

NOISE = re.compile(
    r'R"\((?:.|\n)*?\)"|//[^\n]*|/\*(?:.|\n)*?\*/'
    r'|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|`(?:\\.|[^`\\])*`'
)
PREPROCESSOR = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
NO_FUNCTION = {"if", "for", "while", "switch", "catch", "return", "else", "do", "try", "constexpr"}
QUALIFIERS = re.compile(r"const|noexcept|override|final|->|:|mutable|\[\[|=>")
"""What may stand between the parameters of a function and its body."""


class Shape(NamedTuple):
    """A function: its name, lines of code and number of parameters."""

    name: str
    lines: int
    parameters: int


def bare(text: str) -> str:
    """The text without comments and preprocessor, with empty strings; its lines stay."""
    kept = NOISE.sub(lambda m: ("" if m[0].startswith("/") else '""') + "\n" * m[0].count("\n"), text)
    return PREPROCESSOR.sub(lambda m: "\n" * m[0].count("\n"), kept)


class Span(NamedTuple):
    """Where a function stands: its first and last line, from 1, and its shape."""

    first: int
    last: int
    shape: Shape


def functions(text: str) -> Iterator[Shape]:
    """Functions of a file, in the order of their ends; those inside others count for both."""
    return (span.shape for span in spans(text))


def spans(text: str) -> Iterator[Span]:
    """Functions of a file, and where each stands, in the order of their ends."""
    text = bare(text)
    begun: list[tuple[int, str]] = []
    last = 0
    for found in re.finditer(r"[{};]", text):
        at = found.start()
        head = text[last:at]
        if found[0] == ";" and head.count("(") > head.count(")"):
            continue  # of a for
        last = at + 1
        if found[0] == "{":
            begun.append((at - len(head.lstrip()), head))
        elif found[0] == "}" and begun:
            start, head = begun.pop()
            if (signature := _signature(head)) is not None:
                lines = sum(bool(line.strip()) for line in text[start : at + 1].split("\n"))
                first, end = text.count("\n", 0, start) + 1, text.count("\n", 0, at) + 1
                yield Span(first, end, Shape(signature[0], lines, signature[1]))


def _signature(head: str) -> tuple[str, int] | None:
    """Name and number of parameters of the function whose body follows; None where none begins."""
    head = re.sub(r"^\s*(?:public|private|protected)\s*:", "", head).strip()
    opened = head.find("(")
    name = re.search(r"(operator\s*\S+|[\w$:~]+)$", head[:opened].rstrip()) if opened >= 0 else None
    if name is None or name[1] in NO_FUNCTION:
        return None
    depth = 0
    for closed in range(opened, len(head)):
        depth += {"(": 1, ")": -1}.get(head[closed], 0)
        if depth == 0:
            break
    after = head[closed + 1 :].strip()
    if after and not QUALIFIERS.match(after):
        return None
    return name[1], _count(head[opened + 1 : closed])


def _count(parameters: str) -> int:
    depth, count = 0, 0
    for character in parameters:
        depth += character in "(<[{"
        depth -= character in ")>]}"
        count += character == "," and depth == 0
    return count + 1 if parameters.strip() not in ("", "void") else 0
