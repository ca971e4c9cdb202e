# SPDX-License-Identifier: GPL-2.0-or-later
"""Which pages there are for what was opened."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from threading import Lock
from typing import Any

from .assets import HERE, asset, html
from .case_file import CaseFile
from .look import look
from .server import Pages, Refused, Reply, answer


def pages_of(path: Path) -> Pages:
    """The pages of a case file.

    Raises
    ------
    CaseError
        There is no such file.
    """
    return CasePages(path)


class CasePages:
    """The page of a case file: its text, what `look` finds in it, and its run."""

    def __init__(self, path: Path):
        self.file = CaseFile(path)
        self._looking = Lock()  # one look at a time is soonest done

    def get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        """The page, its files, and the text as it is now."""
        if path == "":
            return html(HERE / "case.html")
        if path == "file":
            found = self.file.read()
            same = found.key == query.get("key")
            return answer({"name": str(self.file.shown), "key": found.key, "text": None if same else found.text})
        return asset(path)

    def post(self, path: str, asked: Mapping[str, Any]) -> Reply | None:
        """Look at a text, or save it."""
        if path == "look":
            with self._looking:
                return answer(look(text_of(asked, "text"), self.file.path, number_of(asked, "wide")))
        if path == "save":
            saved = self.file.save(text_of(asked, "text"), text_of(asked, "key"))
            if saved is None:
                return answer({"changed": True, **self.file.read()._asdict()}, 409)
            return answer({"key": saved.key})
        return None


def text_of(asked: Mapping[str, Any], name: str) -> str:
    """A text that a page sends.

    Raises
    ------
    Refused
        Something else, or a text that no file can hold.
    """
    value = asked.get(name)
    if not isinstance(value, str) or "\x00" in value:
        raise Refused(400, f"{name} is no text")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise Refused(400, f"{name} holds half of a letter") from None
    return value.replace("\r\n", "\n")


def number_of(asked: Mapping[str, Any], name: str) -> int:
    """A whole number that a page sends; Refused for something else."""
    value = asked.get(name)
    if not isinstance(value, int) or isinstance(value, bool):
        raise Refused(400, f"{name} is no whole number")
    return value
