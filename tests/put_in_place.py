# SPDX-License-Identifier: GPL-2.0-or-later
"""What tests put in the place of a file or folder, and how they see that it stays."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LIMIT = 300
"""Seconds after which a command hangs; nothing else depends on them."""
MINE = b"precious"


def put(fault: str, place: Path) -> None:
    """Put something into a place; it needs to be gone."""
    if fault == "folder" or "folder of" in fault or fault == "empty folder":
        place.mkdir()
        for name in ("case.yaml", "summary.json", "dump.lammpstrj", "curves.json", "profiles.nc", "report.html"):
            if fault == "folder of pipes":
                os.mkfifo(place / name)
            elif fault == "folder of links":
                (place / name).symlink_to("/dev/zero")
    elif fault == "pipe":
        os.mkfifo(place)
    elif fault in ("endless", "dangling"):
        place.symlink_to("/dev/zero" if fault == "endless" else "nowhere/at/all")
    elif fault == "huge":
        place.touch()
        os.truncate(place, 3_000_000_000)
    elif fault != "absent":
        texts = {"empty": b"", "garbage": b"\x00\x01: [}", "brackets": 100_000 * b"[", "Latin-1": b"name: caf\xe9,1\n"}
        (place.parent if fault == "below a file" else place).write_bytes(texts.get(fault, MINE))


def look(place: Path) -> tuple:
    """What stands at a place."""
    if place.is_symlink():
        return "link", os.readlink(place)
    if place.is_file():
        with place.open("rb") as file:
            return "file", place.stat().st_size, file.read(100)
    return "folder" if place.is_dir() else "other", sorted(place.rglob("*")) if place.is_dir() else ()


@contextmanager
def ends_a_hang() -> Iterator[None]:
    """End the block where a command waits for ever."""

    def hangs(*_) -> None:
        raise AssertionError("the command hangs")

    handler = signal.signal(signal.SIGALRM, hangs)
    signal.alarm(LIMIT)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
