# SPDX-License-Identifier: GPL-2.0-or-later
"""Shared by benchmarks whose variants take turns on one case: the command line, the store of pieces, the page."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import lammps_jump as lj
from lammps_jump.analysis.tables import paragraphs
from lammps_jump.errors import JumpError
from lammps_jump.files import plain
from lammps_jump.provenance import machine
from lammps_jump.studies.points import held_folder
from lammps_jump.sweeps import Results, Say, Store, all_versions

Calls = Mapping[str, Callable[[], Any]]
Measure = Callable[..., Results]
Page = Callable[[Results, Path], list[str]]
Item = TypeVar("Item")
Found = TypeVar("Found")
FOLDER = Path("runs") / "bench"


def in_turn(items: Sequence[Item], rounds: int, make: Callable[[Item, int], Found]) -> dict[Item, list[Found]]:
    """Return what `make(item, round)` finds: every item once before any again, forwards and backwards in turn.

    Times of the items can so be compared on a busy machine.
    """
    found: dict[Item, list[Found]] = {item: [] for item in items}
    for number in range(rounds):
        for item in items if number % 2 == 0 else reversed(items):
            found[item].append(make(item, number))
    return found


def timed_in_turn(
    calls: Calls, rounds: int, store: Store, identity: object, say: Say, told: str
) -> dict[str, list[Any]]:
    """Return what the calls find, by name, kept in the store; `told` is the line on a round, {0} what it found."""

    def timed(name: str, turn: int) -> Any:
        found = store.piece(f"{name} {turn} {identity} {all_versions()}", calls[name])
        say(f"  {turn + 1}/{rounds} {name}: {told.format(found)}")
        return found

    return in_turn(list(calls), rounds, timed)


def run_part(
    case: lj.Case, name: str, measure: Measure, page: Page, *, out: Path | None = None, quick: bool = False,
    fresh: bool = False, say: Say = print,
) -> str:  # fmt: skip
    """Measure, write ``<name>.json`` and the page ``<name>.md``, and return the page; what is stored is kept.

    Parameters
    ----------
    case : Case
    name : str
        Stem of both files.
    measure : callable(case, store, quick=, say=) -> dict
    page : callable(data, folder) -> list of str
        Paragraphs; may draw into the folder.
    out : Path, optional
        Folder; default ``runs/bench/<name of the case>``.
    quick, fresh : bool
        Few and short runs; measure again what is stored.
    say : callable
        Takes one line of progress.
    """
    folder = out or FOLDER / case.name
    with held_folder(folder, "bench"):
        store = Store(folder / f"{name}.json", fresh=fresh)
        store.data |= plain(measure(case, store, quick=quick, say=say)) | {"case": case.name, "machine": machine()}
        store.save()
        return store.finish(paragraphs(*page(store.data, folder)))


def main(about: str, name: str, measure: Measure, page: Page) -> int:
    """Read the command line, measure and print the page; the exit status."""
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("case", type=Path, help="case file")
    parser.add_argument("--out", type=Path, help=f"folder (default: {FOLDER}/<name>)")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE", help="change a value of the case")
    parser.add_argument("--quick", action="store_true", help="few and short runs")
    parser.add_argument("--fresh", action="store_true", help="measure again what is stored")
    given = parser.parse_args()
    try:
        case = lj.load_case(given.case, given.set)
        print(run_part(case, name, measure, page, out=given.out, quick=given.quick, fresh=given.fresh))
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return 0
