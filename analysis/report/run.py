# SPDX-License-Identifier: GPL-2.0-or-later
"""Report of a run: its summary, player, curves, figures and film in one page."""
# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from math import hypot
from pathlib import Path
from shlex import quote
from typing import Any

from lammps_jump.analysis.budgets import head
from lammps_jump.analysis.quantities import LISTED, QUANTITIES, captions
from lammps_jump.analysis.tables import MOST, lines, rows_of, sure, tiles
from lammps_jump.analysis.verdicts import doubts, verdict
from lammps_jump.errors import DumpError
from lammps_jump.files import write_text
from lammps_jump.physics.contact import Coefficients
from lammps_jump.units import ABSENT, Number, in_kilo, known, numbers_of, shown, sure_of

from .handed_on import read_curves
from .page import (
    Block,
    Boxes,
    Code,
    Curve,
    Items,
    LivePage,
    Picture,
    Player,
    Section,
    SideBySide,
    Table,
    Text,
    cut,
    errors_of,
    heading,
    picture,
    picture_kind,
    render,
)
from .player import STILL

LARGEST = 5_000_000
"""Bytes of a report without its player; figures come first, the film only where it still fits."""

FILMS = ("animation.mp4", "animation.gif")
REPEAT = """\
lammps-jump build-and-run case.yaml --out again

import lammps_jump as lj
run = lj.load_case("case.yaml").run("again")
"""


def write_report(
    folder: Path,
    summary: Mapping[str, Any],
    case_yaml: str = "",
    *,
    name: str = "report.html",
    player: Player | None = None,
    run_folder: Path | None = None,
    live: LivePage | None = None,
) -> Path:
    """Write the report of a run folder from its summary, its figures and its film.

    Parameters
    ----------
    folder : Path
        Holds ``figures/*.png`` and, if requested, ``animation.mp4`` or ``animation.gif``.
    summary : mapping
        As in ``summary.json``; what it lacks is left out.
    case_yaml : str
        The case as run.
    name : str
        File name.
    player : Player, optional
        Of `player.make_player`.
    run_folder : Path, optional
        Another folder, whose film and pictures that no analysis makes are shown too.
    live : LivePage, optional
        The run from some moments on, in which a reader changes what comes.

    Raises
    ------
    DumpError
        The file cannot be written.
    """
    name_of_run = str(summary.get("name", "run"))
    called = name_of_run if "given" in summary else name_of_run.replace("_", " ")
    title = verdict(summary) or called
    above = ": ".join(filter(None, (name_of_run, summary.get("description"))))

    def rendered(sections: Sequence[Section | None]) -> str:
        return render(title, sections, tab=f"{name_of_run}: report", name=above)

    before = [Section("", _lead(summary)), Section("", [Items(doubts(summary), "Doubtful")])]
    begins = [f"{text[:1].upper()}{text[1:]}." for text in summary.get("begins") or ()]
    before.append(Section("", [Items([*begins, *(summary.get("warnings") or ())], "Notes")]))
    after = [
        _defined(quantity.section(quantity.read(summary[key])), quantity.definitions + quantity.defined(summary))
        for key, quantity in QUANTITIES.items()
        if summary.get(key) and quantity.shown(summary)
    ]
    after.append(_defined(head.section(summary), head.DEFINITIONS))
    numbers = numbers_of(Coefficients)
    values = [(numbers[key], value) for key, value in (summary.get("coefficients") or {}).items() if key in numbers]
    coefficients = [(heading(number.meaning, ""), value, number.unit) for number, value in values]
    folded = Table(coefficients if case_yaml else (), ("Coefficients", "value", "unit"), "Coefficients")
    open_ = folded._replace(rows=() if case_yaml else coefficients, summary="")
    case: list[Block] = [
        open_,
        folded,
        Code(case_yaml, "case.yaml, every default filled in"),
        Items(summary.get("skipped") or ()),
    ]
    last = [_errors(summary), Section("The case", case), _how(summary)]
    room = LARGEST - len(rendered([*before, *after, *last]).encode(errors="replace"))
    path, drawn, paths = Path(folder) / name, curves(Path(folder)), _pictures(Path(folder), run_folder)
    if player:
        linked = [drawn.pop(name) for name in _linked() if name in drawn]
        differently = [live] if live else []
        before.insert(2, Section("", [player, *differently, *([SideBySide(linked)] if linked else [])]))
    page = rendered([*before, *after, _figures(paths, room, player, drawn), *last])
    try:
        write_text(path, page)
    except OSError as error:
        raise DumpError(f"{path}: the report cannot be written ({error.strerror}).") from error
    return path


def _defined(section: Section | None, text: str) -> Section | None:
    """The section of a quantity, with what its numbers mean folded away at its end."""
    if section is None or not section.blocks:
        return section
    return section._replace(blocks=[*section.blocks, Code(text, "What these numbers mean")])


def _lead(summary: Mapping[str, Any]) -> list[Text | Boxes]:
    rows = rows_of([summary], most=MOST + 1)
    return [
        Text(summary.get("message") or "", "bad"),
        Boxes(tiles(rows, summary)[:MOST]),
        *(Text(f"{line[:1].upper()}{line[1:]}", "small") for line in lines(summary)),
        Text(sure(summary) if rows else "", "sure"),
    ]


def _errors(summary: Mapping[str, Any]) -> Section:
    """Standard errors within this run, by the words of their numbers; how sure they are."""
    known = [(one, one.read(summary[name])) for name, one in QUANTITIES.items() if summary.get(name)]
    rows = [
        (f"{name}: {label}" if name else label, error)
        for quantity, part in known
        for name, result in quantity.errors(part)
        if result is not None
        for label, error in errors_of(result)
    ]
    said = [text for quantity, part in known for text in quantity.certainty(part)] if rows else []
    table = Table(rows, ("Number", "standard error"), f"Standard errors of {len(rows)} numbers")
    return Section("Errors within this run", [table, *map(Text, said)])


def _linked() -> list[str]:
    """Curves over time that are below the player and show its time."""
    return [f"{quantity.linked}.png" for quantity in QUANTITIES.values() if quantity.linked]


def curves(folder: Path) -> dict[str, Curve]:
    """Figures that the page draws of a run folder, by the name of their files, in the order of the report.

    Raises
    ------
    DumpError
        As of `read_curves`.
    """
    curves_read = read_curves(folder)
    return {f"{name}.png": Curve(text, curves_read[name]) for name, text in captions().items() if name in curves_read}


def _pictures(folder: Path, run_folder: Path | None) -> dict[str, Path]:
    """Films and pictures of a folder, by name, and those of the other one; links and other files are left out."""
    paths, known = {}, captions()
    for place in filter(None, (run_folder, folder)):
        figures = () if (place / "figures").is_symlink() else (place / "figures").glob("*.png")
        for path in (*sorted(figures), *(place / film for film in FILMS)):
            if picture_kind(path) and (place == folder or path.stem not in known):
                paths[path.name] = path
    return paths


def _figures(given: Mapping[str, Path], room: int, player: Player | None, drawn: Mapping[str, Curve]) -> Section:
    """The film, curves and pictures in a fixed order, as long as there is room; the film gives way to the pictures."""
    left = {*drawn, *(_linked() if player else ()), *([STILL] if player and player.still else ())}
    films = [given[name] for name in FILMS if name in given]
    paths = {name: given[name] for name in sorted(given) if name not in (*FILMS, *left)}
    known = {f"{name}.png": text for name, text in captions().items()}
    order = [name for name in known if name in paths] + [name for name in paths if name not in known]
    files = [(paths[name], known.get(name, name.removesuffix(".png").replace("_", " "))) for name in order]
    shown: list[Picture] = []
    left_out = []
    for path, caption in [*files, *((film, "The flow") for film in films)]:
        block = picture(path, caption) if path.stat().st_size < LARGEST else None
        if block is None or len(block.source) + 500 > room:
            left_out.append(path.name if path in films else f"figures/{path.name}")
            continue
        room -= len(block.source) + 200
        shown.insert(0 if path in films else len(shown), block)
    tail = f"Too large for this page, beside it in the run folder: {', '.join(left_out)}." if left_out else ""
    return Section("Figures", [SideBySide(list(drawn.values())), *shown, Text(tail)])


def _command(summary: Mapping[str, Any]) -> list[Text | Code]:
    """The command that makes the results again."""
    if "given" not in summary:
        return [Text("In this run folder, with the versions below:"), Code(REPEAT)]
    options = [text for key, value in summary["given"].items() for text in _option(key, value)]
    return [Code(" ".join(["lammps-jump analyze", quote(summary["name"]), *options]))]


def _option(key: str, value: object) -> list[str]:
    """Options of the command that were given with a bare dump."""
    if key == "analyses" and isinstance(value, Sequence):
        return [f"--{LISTED[name].option or name}" for name in value if name in LISTED]
    if key == "stations" and isinstance(value, Sequence):
        value = ",".join(f"{x:zg}" for x in value)
    if isinstance(value, Mapping):
        value = ",".join(f"{kind}={number:zg}" for kind, number in value.items())
    return [f"--{key.replace('_', '-')} {value if isinstance(value, str) else format(value, 'g')}"]


def _how(summary: Mapping[str, Any]) -> Section:
    seconds, discs = summary.get("wall_seconds") or {}, summary.get("discs") or {}
    speed, versions = summary.get("disc_steps_per_second"), summary.get("versions") or {}
    sums = {name: values.get("sha256") for name, values in (summary.get("outputs") or {}).items()}
    rows = [
        ("Engine", f"{summary['engine']}, kernel {summary.get('kernel') or ABSENT}" if summary.get("engine") else None),
        *((f"Wall time, {name}", f"{value:z.2f} s") for name, value in seconds.items() if value is not None),
        ("Steps", summary.get("steps")),
        ("Disc-steps per second", f"{speed / 1e6:z.1f} million" if speed else None),
        ("Discs", ", ".join(f"{value} {name}" for name, value in discs.items()) or None),
        *((f"Version of {name}", value) for name, value in versions.items()),
    ]
    hashes = [("Hash of the case", summary.get("case_hash")), *((f"SHA-256 of {name}", sums[name]) for name in sums)]
    return Section(
        "How to repeat it",
        [
            Table([row for row in rows if row[1] is not None]),
            *_command(summary),
            Table([row for row in hashes if row[1] is not None], ("Hashes", "value"), "Hashes of case and files"),
            Table(summary.get("states") or (), ("Step", "SHA-256 of the state"), "Hashes of the state at ten times"),
            Code(json.dumps(summary, indent=1), "summary.json"),
        ],
    )


@dataclass(frozen=True)
class Side:
    """One of the runs.

    Attributes
    ----------
    name : str
        Tells the two apart.
    summary : mapping
        As in ``summary.json``.
    curves : mapping of str to Curve
        Of `run.curves`.
    player : Player or None
    """

    name: str
    summary: Mapping[str, Any]
    curves: Mapping[str, Curve]
    player: Player | None


def comparison(left: Side, right: Side) -> str:
    """The page of two runs."""
    names = left.name, right.name
    heads = SideBySide([Text(name, "sure") for name in names])
    players = [side.player for side in (left, right) if side.player is not None]
    discs = [heads, SideBySide(players)] if len(players) == 2 else []
    both = [name for name in left.curves if name in right.curves]
    pairs = [SideBySide(_on_one_scale(left.curves[name], right.curves[name])) for name in both]
    alone = [f"{name}: {curve.caption}" for name, side, other in ((names[0], left, right), (names[1], right, left))
             for key, curve in side.curves.items() if key not in other.curves]  # fmt: skip
    table = Table(list(_rows(left.summary, right.summary)), ("", *names, "difference"))
    sections = [
        Section("", discs),
        Section("Numbers", [table, Text("One run each; for error bars: their commands with --members 8.", "sure")]),
        Section("Curves", [heads, *pairs, Text(f"Of one run alone: {'; '.join(alone)}." if alone else "", "small")]),
    ]
    return render(" and ".join(names), sections, tab=" and ".join(names))


def _rows(left: Mapping[str, Any], right: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    """Label, both numbers and their difference, cut to their errors within the runs."""
    for name, quantity in QUANTITIES.items():
        first, second = (quantity.walls(summary.get(name) or {}) for summary in (left, right))
        for part in dict.fromkeys([*first, *second]):
            sides = first.get(part), second.get(part)
            for number in numbers_of(quantity.result).values():
                has_labels = any(
                    known(getattr(side, number.key, None)) and quantity.applies(number.key, side) for side in sides
                )
                if number.label != number.meaning and has_labels:
                    yield _row(part, number, *sides)


def _row(part: str, number: Number, left: object, right: object) -> tuple[str, str, str, str]:
    key, (scale, unit) = number.key, in_kilo(number.unit)
    values: list[Any] = [getattr(side, key, None) for side in (left, right)]
    texts = [shown(None) if side is None else cut(side, key, scale) for side in (left, right)]
    errors = [sure_of(side, key).value for side in (left, right)]
    difference = shown(None)
    if all(known(value) for value in values):
        error = hypot(*(error / scale for error in errors if error is not None)) if None not in errors else None
        difference = shown((values[1] - values[0]) / scale, error=error, alone=True).replace("-", "−")
    label = heading(number.meaning, unit)
    return f"{part}: {label}" if part else label, texts[0], texts[1], difference


def _on_one_scale(left: Curve, right: Curve) -> list[Curve]:
    """Both curves with the axes of both; panels that only one of them has keep their own."""
    pair = [Curve(curve.caption, deepcopy(dict(curve.data))) for curve in (left, right)]
    for panels in zip(*(curve.data.get("panels", ()) for curve in pair), strict=False):
        for axis, limits in (("x", "xlim"), ("y", "ylim")):
            ends = [_ends(panel, axis, limits) for panel in panels]
            known = [one for one in ends if one]
            if len(known) == len(ends):
                low, high = min(end[0] for end in known), max(end[1] for end in known)
                for panel in panels:
                    panel[limits] = [low, high]
    return pair


def _ends(panel: Mapping[str, Any], axis: str, limits: str) -> tuple[float, float] | None:
    """Least and greatest value on an axis of a panel; None without a value."""
    faint = len(panel["lines"]) > 1
    values = [value for line in panel["lines"] if not (faint and line["look"] in ("faint", "dots"))
              for value in line.get(axis, ()) if value is not None]  # fmt: skip
    values += [value for _, value in panel["levels"] if value is not None] if axis == "y" else []
    if not values:
        return None
    low, high = panel[limits]
    return min(values) if low is None else low, max(values) if high is None else high
