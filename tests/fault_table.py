# SPDX-License-Identifier: GPL-2.0-or-later
"""How often each kind of fault is tried, and the table of them in docs/reliability.md, which ``make faults`` writes.

A test marked ``fault("kind")`` counts once, or as often as its fixture `tried` says. A test that records a "cell" (row,
column, text) fills one of the second table. The short form runs with all other
tests. The long form (``JUMP_FAULTS=long``) tries more. It writes the table if every test passes; ``JUMP_FAULTS=short``
writes that of the short form.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from features import ENGINES, FEATURES

FORM = os.environ.get("JUMP_FAULTS", "")
LONG = FORM == "long"
PAGE = Path(__file__).parents[1] / "docs" / "reliability.md"
BEGIN, END = "<!-- written by make faults -->\n", "<!-- end -->\n"
BEGIN_PLACES = "<!-- places, written by make faults -->\n"

KINDS = {
    "killed": ("at most one checkpoint interval", "`--resume` continues; the native engine gives the same bytes"),
    "ended and continued": ("nothing", "the run without an end ([table](#every-feature-on-every-engine))"),
    "signals": ("nothing behind the last step", "a message with the command that continues; exit status 75"),
    "files that cannot be written": (
        "nothing: the old or the new file is whole",
        "the file and the cause; `--resume` continues",
    ),
    "power cut, unsynced writes lost": ("at most one checkpoint interval", "the newest whole checkpoint is used"),
    "full disk": ("what was not written", "status `failed`, never `complete`"),
    "cut files": ("what was cut off", "file, and what is missing"),
    "flipped bits": ("nothing", "the file that differs from its checksum"),
    "wrong frames, discs or forces": ("nothing", "frame, step or row that is wrong"),
    "values in JSON files": ("nothing", "file, field and what is wrong"),
    "wrong tables": ("nothing", "file, line and column, or that a table differs from its checksum"),
    "mutants of run folders": ("nothing", "file and what is wrong in it, or the status of the run"),
    "mutants of tables of a run": ("nothing", "file, line or byte, and what is wrong there"),
    "mutants of cases": ("nothing: no file is written", "line, field and what is allowed"),
    "mutants of dumps": ("nothing", "the frame or value that is wrong"),
    "values and mutants of states": ("nothing: no run begins", "file and what in it is of no run"),
    "mutants of drawings": ("nothing: no file is written", "file and what in it is wrong; at a bound, the bound"),
    "mutants of studies and rounds": ("nothing", "file, field and what is wrong"),
    "text as a command": ("nothing: no command is run", "the character that is not allowed"),
    "folders": ("nothing of the user's", "what stands there, or which process writes"),
    "places that commands read and write": ("nothing of the user's", "the place, and what is wrong with it"),
    "files in the folder of a study": ("nothing of the user's", "the file, and what is wrong in it"),
    "requests to a page": ("nothing: no file is written", "a status and a sentence; the next request is answered"),
    "other programs that write the same file": ("nothing of either", "that it has changed, or is changed all the time"),
    "surroundings": ("nothing", "a note of what is left aside, or what to install"),
}
"""Kind of fault: what may be lost, what the user sees. The tests of the kind check both."""

NONE = "\N{EN DASH}"
"""Text of a cell where an engine lacks a feature."""
CELLS_BEGIN, CELLS_END = "<!-- cells written by make faults -->\n", "<!-- end of cells -->\n"
CASE, SITE, RUN, LAWS, POINTS = (
    "case file",
    "site file",
    "folder of a run",
    "folder of laws and studies",
    "measured points",
)
DUMP, FOLDER, FILE = "dump", "folder that is written", "file that is written"
OPENED = "case file or folder that a page shows"
QUICK = ("--quick", "--quiet")
MEASURED = ("--target", "energy.drift=0 ± 1", "--vary", "contact.restitution=0.1:0.9", "--quiet")
SOUGHT = (
    "--vary", "contact.restitution=0.1:0.9", "--until", "energy.drift >= 2", "--members", "1", "--budget", "3",
    "--quiet",
)  # fmt: skip
CURVE = ("--columns", "time=t,energy.total=h")
PLACES = {
    ("analyze", "targets"): (RUN, ("analyze", "@")),
    ("analyze", "out"): (FOLDER, ("analyze", "DUMP", "--out", "@")),
    ("analyze", "case"): (CASE, ("analyze", "DUMP", "--out", "OUT", "--case", "@")),
    ("animate", "folder"): (RUN, ("animate", "@")),
    ("animate", "out"): (FILE, ("animate", "RUN", "--out", "@")),
    ("bench", "case"): (CASE, ("bench", "@", "--quick")),
    ("bench", "out"): (FOLDER, ("bench", "CASE", "--quick", "--out", "@")),
    ("budget", "case"): (CASE, ("budget", "@", "--of", "jump.y2", "--out", "OUT")),
    ("budget", "out"): (FOLDER, ("budget", "CASE", "--of", "jump.y2", "--out", "@")),
    ("build", "case"): (CASE, ("build", "@", "--out", "OUT")),
    ("build", "out"): (FOLDER, ("build", "CASE", "--out", "@")),
    ("build", "site"): (SITE, ("build", "CASE", "--out", "OUT", "--slurm", "--site", "@")),
    ("build-and-run", "case"): (CASE, ("build-and-run", "@", "--out", "OUT")),
    ("build-and-run", "site"): (SITE, ("build-and-run", "CASE", "@", "--slurm", "--members", "2", "--out", "OUT")),
    ("build-and-run", "out"): (FOLDER, ("build-and-run", "CASE", "--out", "@")),
    ("calibrate", "study"): (CASE, ("calibrate", "@", *MEASURED, "--out", "OUT")),
    ("calibrate", "site"): (SITE, ("calibrate", "CASE", "@", "--slurm", *MEASURED, "--out", "OUT")),
    ("calibrate", "data"): (POINTS, ("calibrate", "CASE", "--data", "@", *CURVE, *MEASURED, "--out", "OUT")),
    ("calibrate", "out"): (FOLDER, ("calibrate", "CASE", *MEASURED, "--out", "@")),
    ("check", "case"): (CASE, ("check", "@")),
    ("compare", "first"): (RUN, ("compare", "@", "RUN", "--out", "OUT.html")),
    ("compare", "second"): (POINTS, ("compare", "RUN", "@", "--columns", "time=t,energy.total=h", "--out", "OUT")),
    ("compare", "out"): (FILE, ("compare", "RUN", "DUMPED", "--out", "@")),
    ("cross-validate", "case"): (CASE, ("cross-validate", "@", *QUICK)),
    ("cross-validate", "out"): (FOLDER, ("cross-validate", "CASE", *QUICK, "--out", "@")),
    ("export", "target"): (RUN, ("export", "@", "--csv", "--vtk", "--out", "OUT")),
    ("export", "out"): (FOLDER, ("export", "RUN", "--csv", "--out", "@")),
    ("figures", "folder"): (RUN, ("figures", "@")),
    ("find", "study"): (CASE, ("find", "@", *SOUGHT)),
    ("find", "out"): (FOLDER, ("find", "CASE", *SOUGHT, "--out", "@")),
    ("fluid", "case"): (CASE, ("fluid", "@", *QUICK)),
    ("fluid", "out"): (FOLDER, ("fluid", "CASE", *QUICK, "--out", "@")),
    ("import", "drawing"): (POINTS, ("import", "@")),
    ("import", "into"): (CASE, ("import", "DRAWING", "--into", "@")),
    ("live", "target"): (OPENED, ("live", "@", "--out", "OUT.html")),
    ("live", "out"): (FILE, ("live", "CASE", "--out", "@")),
    ("open", "target"): (OPENED, ("open", "@", "--no-browser")),
    ("preview", "case"): (CASE, ("preview", "@", "--out", "OUT")),
    ("preview", "out"): (FOLDER, ("preview", "CASE", "--out", "@")),
    ("run", "folder"): (RUN, ("run", "@")),
    ("sensitivity", "out"): (FOLDER, ("sensitivity", *QUICK, "--out", "@")),
    ("show", "folder"): (RUN, ("show", "@")),
    ("slice", "target"): (DUMP, ("slice", "@", "y=0", "--out", "OUT")),
    ("slice", "out"): (FILE, ("slice", "DUMP", "y=0", "--out", "@")),
    ("stress", "out"): (FOLDER, ("stress", *QUICK, "--out", "@")),
    ("stress", "place"): (LAWS, ("stress", *QUICK, "--laws", "@", "--out", "OUT")),
    ("sweep", "study"): (CASE, ("sweep", "@")),
    ("sweep", "site"): (SITE, ("sweep", "CASE", "@", "--slurm", "--members", "2", "--out", "OUT")),
    ("sweep", "out"): (FOLDER, ("sweep", "CASE", "--members", "2", "--out", "@")),
    ("validate", "out"): (FOLDER, ("validate", *QUICK, "--laws", "LAWS", "--out", "@")),
    ("validate", "place"): (LAWS, ("validate", "--list", "--laws", "@")),
}
"""What each command reads and writes: by command and parameter the kind of place, and a call with @ for the place.

`tests/faults/test_places.py` compares them with the commands, and tries `FAULTS` on each.
"""
NAMED = {
    "`initial.folder`": (RUN, {"initial": [{"kind": "run", "folder": "@"}]}, ("check", "NAMER")),
    "`walls.file`": (POINTS, {"walls": [{"name": "bed", "kind": "line", "file": "@"}]}, ("check", "NAMER")),
    "`walls.motion.file`": (
        POINTS,
        {"walls": [{"name": "lid", "kind": "circle", "centre": [2, 2], "radius": 1,
                    "motion": {"kind": "table", "file": "@"}}]},
        ("check", "NAMER"),
    ),
    "`case` of a study": (
        CASE, {"case": "@", "axes": {"discs.density": [900, 1000]}}, ("sweep", "NAMER", "--out", "OUT"),
    ),
    "`targets.data` of a study": (
        POINTS,
        {"kind": "calibrate", "case": "CASE", "vary": {"contact.restitution": [0.1, 0.9]},
         "targets": [{"data": "@", "columns": "time=t,energy.total=h ± 0.1"}]},
        ("calibrate", "NAMER", "--out", "OUT"),
    ),
}  # fmt: skip
"""What files name: by the field the kind of place, what stands in the case (a part of it) or study, with @ for the
place, and a call with NAMER for that file."""
NO_PLACE = {"doctor", "kernels build", "kernels status", "new", "schema"}
"""Commands that take no place of the user's; the cache of `kernels` is tried by tests/compiling/test_build.py."""
FAULTS = {
    **dict.fromkeys(
        (CASE, SITE, POINTS, DUMP),
        ("absent", "folder", "pipe", "endless", "empty", "garbage", "brackets", "huge", "Latin-1"),
    ),
    RUN: ("absent", "pipe", "endless", "empty", "garbage", "empty folder", "folder of pipes", "folder of links"),
    LAWS: ("absent", "pipe", "endless", "empty", "empty folder"),
    OPENED: (
        "absent",
        "pipe",
        "endless",
        "garbage",
        "huge",
        "Latin-1",
        "empty folder",
        "folder of pipes",
        "folder of links",
    ),
    FOLDER: ("empty", "garbage", "pipe", "endless", "dangling", "below a file"),
    FILE: ("folder", "garbage", "pipe", "endless", "dangling", "below a file"),
}
"""What is put in a place of each kind; a file that is written is one that the user has."""

tried: Counter[str] = Counter()
cells: dict[tuple[str, str], str] = {}


def many(short: int, long: int) -> int:
    """How often something is tried in the form that runs."""
    return long if LONG else short


def count(properties: list[tuple[str, object]]) -> None:
    """Take in the properties of a test that passed."""
    found = dict(properties)
    if "cell" in found:
        row, column, text = found["cell"]  # type: ignore[misc]
        cells[row, column] = text
    if "fault" in found:
        tried[str(found["fault"])] += int(found.get("times", 1))


def write_table() -> None:
    """Put the tables into their places in the page; kinds of which no test has run keep their rows."""
    before = {
        line.split("|")[1].strip(): f"{line}\n" for line in PAGE.read_text(encoding="utf-8").splitlines() if "|" in line
    }
    rows = [
        f"| {kind} | {tried[kind]:,} | {lost} | {seen} |\n" if tried[kind] else before.get(kind, "")
        for kind, (lost, seen) in KINDS.items()
    ]
    table = "| fault | times tried | what is lost | what the user sees |\n|---|---|---|---|\n" + "".join(rows)
    _put(BEGIN, table, END)
    _put(BEGIN_PLACES, places_table(), END)
    if cells:
        rows, columns = (list(dict.fromkeys(names)) for names in zip(*sorted(cells, key=_place), strict=True))
        lines = [f"| {row} | {' | '.join(cells[row, column] for column in columns)} |\n" for row in rows]
        _put(
            CELLS_BEGIN,
            f"| feature | {' | '.join(columns)} |\n|{'---|' * (1 + len(columns))}\n{''.join(lines)}",
            CELLS_END,
        )


def _place(cell: tuple[str, str]) -> tuple[int, int]:
    return list(FEATURES).index(cell[0]), ENGINES.index(cell[1])


def _put(begin: str, table: str, end: str) -> None:
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
    PAGE.write_text(head + begin + table + end + rest.partition(end)[2], encoding="utf-8")


def cells_of_page() -> dict[tuple[str, str], str]:
    """The second table as it stands in the page: text by row and column."""
    table = PAGE.read_text(encoding="utf-8").partition(CELLS_BEGIN)[2].partition(CELLS_END)[0]
    (_, *columns), _, *rows = ([word.strip() for word in line.split("|")[1:-1]] for line in table.splitlines())
    return {(row, column): text for row, *texts in rows for column, text in zip(columns, texts, strict=True)}


def option_of(command: str, parameter: str) -> str:
    """A place as a person writes it."""
    words = PLACES[command, parameter][1]
    before = words[words.index("@") - 1]
    return (
        f"`{command} {before}`"
        if before.startswith("--") and before not in QUICK
        else f"`{command} {parameter.upper()}`"
    )


def places_table() -> str:
    """What commands read and write, by the kind of place, and what is tried on each."""
    lines = ["| place | given to | tried in its place |", "|---|---|---|"]
    for kind, faults in FAULTS.items():
        given = [option_of(*key) for key, (one, _) in PLACES.items() if one == kind]
        given += [field for field, (one, *_) in NAMED.items() if one == kind]
        lines.append(f"| {kind} | {', '.join(given)} | {', '.join(faults)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":  # make reference: the table that needs no runs
    _put(BEGIN_PLACES, places_table(), END)
