# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of a report: sections of blocks, put into one HTML file that needs no network.

Scripts of the page add the player and the curves; without them the page is whole but for what they draw. The policy of
the page names the hashes of its own style and scripts: no other script or style can act in it, whatever a text holds.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

import base64
import hashlib
import io
import json
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup, escape

from lammps_jump.files import plain, read_file, read_start, text_of
from lammps_jump.units import ABSENT, AT_LEAST, POWERS, in_kilo, known, numbers_of, shown, sure_of, two_digits

from .frames import digits_of, encode

if TYPE_CHECKING:
    from PIL.Image import Image

PNG = "image/png"
MOST_PICTURE = 1_000_000_000
"""Bytes of a picture or film that is looked at."""
LONG = 20
"""Numbers of a list that are packed; fewer are in the data."""
UNKNOWN = -(1 << 30)
SCRIPTS = ("frames.js", "discs.js", "view.js", "pointer.js", "player.js", "sliders.js", "curves.js")
Value = float | int | str | None


class Text(NamedTuple):
    """A paragraph; `kind` is '', 'small', 'sure', or 'verdict', 'warn', 'bad' for a box, which may start in bold."""

    text: str
    kind: str = ""
    bold: str = ""


class Mark(NamedTuple):
    """Text of a cell with a class of the page's style."""

    text: str
    kind: str


class Table(NamedTuple):
    """A table; columns that hold a number are aligned right. With a summary it is folded away."""

    rows: Sequence[Sequence[Value | Mark]]
    header: Sequence[str] = ()
    summary: str = ""

    @property
    def numeric(self) -> list[bool]:
        """Mask of the columns that hold a number, shape (columns,)."""
        columns = max((len(row) for row in self.rows), default=0)
        return [any(len(row) > i and _is_number(row[i]) for row in self.rows) for i in range(columns)]


class NumberBox(NamedTuple):
    """One of the few numbers at the top, half its interval as text, and what it is compared with.

    `source` has the equations of the comparison, shown where it is pointed at.
    """

    label: str
    value: Value
    unit: str = ""
    error: str = ""
    against: str = ""
    source: str = ""


class Boxes(NamedTuple):
    """Numbers at the top of a page."""

    numbers: Sequence[NumberBox]


class Items(NamedTuple):
    """A list of sentences; with a title they are in a box."""

    texts: Sequence[str]
    title: str = ""


class Code(NamedTuple):
    """Text as it is; with a summary it is folded away."""

    text: str
    summary: str = ""


class Picture(NamedTuple):
    """A picture or film as a data URI."""

    caption: str
    source: str


class Curve(NamedTuple):
    """Curves over a common axis, drawn by the page from `data`."""

    caption: str
    data: Mapping[str, Any]


class Player(NamedTuple):
    """The discs in time: header and packed frames of `frames.pack`, and a picture for browsers without script."""

    header: Mapping[str, Any]
    frames: str
    still: Picture | None = None


class LivePage(NamedTuple):
    """A page in which the flow of the run runs, for a frame of this one; see `lammps_jump.live`.

    Attributes
    ----------
    packed : str
        Its text without the frames of the run: gzip, base64.
    moments : sequence of float
        Of the run at which it can begin, s.
    style : str
    scripts : sequence of str
        Its own, which the policy of the page around names too.
    """

    packed: str
    moments: Sequence[float]
    style: str
    scripts: Sequence[str]


class Slider(NamedTuple):
    """An axis of a study: what it is, and its values in words."""

    label: str
    values: Sequence[str]


class PlayerChoice(NamedTuple):
    """A player with a list of runs by name, of which it shows one; the number `shown` first.

    `axes` are sliders that choose the run at their `places`, the number of a value on each axis for each run. `sides`
    are blocks of each run that are shown with it.
    """

    blocks: Sequence[Player]
    names: Sequence[str]
    shown: int
    axes: Sequence[Slider] = ()
    places: Sequence[Sequence[int]] = ()
    sides: Sequence[Sequence[Boxes | Curve]] = ()

    @property
    def parts(self) -> list[Player | Boxes | Curve]:
        """All players, then what is next to them."""
        return [*self.blocks, *(block for side in self.sides for block in side)]


class SideBySide(NamedTuple):
    """Blocks side by side, below each other on a narrow screen."""

    blocks: Sequence[Text | Table | Curve | Player]

    @property
    def parts(self) -> Sequence[Text | Table | Curve | Player]:
        """Parts that are side by side."""
        return self.blocks


Block = Text | Table | Boxes | Items | Code | Picture | Curve | Player | PlayerChoice | SideBySide | LivePage


class Section(NamedTuple):
    """Part of a page under a heading, in the list of contents; those without a title are above that list."""

    title: str
    blocks: Sequence[Block]


def render(
    title: str, sections: Sequence[Section | None], *, tab: str = "", name: str = "", embedded: bool = False
) -> str:
    """One self-contained HTML page; `tab` is the browser's title, `name` is above the title.

    An embedded one is in a frame of a notebook, to which it sends its time.

    None among the sections, blocks that hold nothing, and sections of such blocks only are left out.
    """
    full = [
        Section(heading, [block for block in blocks if block[0] or isinstance(block, Picture)])
        for heading, blocks in filter(None, sections)
    ]
    given = [block for section in full for block in section.blocks]
    blocks = [
        one for block in given for one in (block.parts if isinstance(block, SideBySide | PlayerChoice) else [block])
    ]
    players = [block._replace(frames=packed(block.frames)) for block in blocks if isinstance(block, Player)]
    curves = [block for block in blocks if isinstance(block, Curve)]
    numbers: list[np.ndarray] = [np.zeros(1)]
    headers = [_lean_forces(plain(player.header), numbers) for player in players]
    shown = [_lean(plain(curve.data), numbers) for curve in curves]
    steps = np.diff(np.concatenate(numbers)).astype(int)
    data = {"players": headers, "curves": shown}
    style, scripts = _own("page.css"), [_own(file) for file in SCRIPTS] if players or curves else []
    scripts += [_own("embedded.js")] if embedded else []
    live = next((block for block in blocks if isinstance(block, LivePage)), None)
    scripts += [_own("differently.js")] if live else []
    framed = ([live.style], live.scripts) if live else ((), ())  # what is in a frame of a page needs its policy too
    kept = [section for section in full if section.blocks]
    return _template().render(
        title=title,
        tab=tab or title,
        name=name,
        first=[section for section in kept if not section.title],
        sections=[section for section in kept if section.title],
        players=players,
        data=as_json(data) if players or curves else "",
        numbers=Markup(encode((steps, np.frexp(np.append(0, steps[:-1]))[1])) if len(numbers) > 1 else ""),
        style=style,
        scripts=scripts,
        policy=policy([style, *framed[0]], [*scripts, *framed[1]], computes=live is not None),
    )


def packed(text: str) -> Markup:
    """Packed frames as they are in a page; ValueError for another text, which could be markup."""
    digits_of(text)
    return Markup(text)


def as_json(data: object) -> Markup:
    """Data for a script element: without `<` no text in it can end the element; NaN and infinities are null."""
    return Markup(json.dumps(plain(data), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"))


def _lean_forces(data: object, numbers: list[np.ndarray]) -> object:
    """The header of a player whose forces are packed, in the order of the data; see `_lean`."""
    if isinstance(data, Mapping):
        return {
            key: _lean(value, numbers) if key == "force" else _lean_forces(value, numbers)
            for key, value in data.items()
        }
    return [_lean_forces(value, numbers) for value in data] if isinstance(data, list) else data


def _lean(data: object, numbers: list[np.ndarray]) -> object:
    """Data whose long lists of numbers are replaced by their length and decimals; the lists, as whole numbers.

    The largest of a list keeps five digits. What is not known is `UNKNOWN`.
    """
    if isinstance(data, Mapping):
        return {key: _lean(value, numbers) for key, value in data.items()}
    if not isinstance(data, list):
        return data
    if len(data) < LONG or not all(value is None or isinstance(value, float) for value in data):
        return [_lean(value, numbers) for value in data]
    values = np.array(data, float)
    decimals = 4 - int(np.floor(np.log10(np.nanmax(np.abs(values), initial=1e-99))))
    numbers.append(np.where(np.isnan(values), UNKNOWN, np.rint(values * 10.0**decimals)))
    return {"count": len(data), "decimals": decimals}


def policy(styles: Sequence[str], scripts: Sequence[str], *, computes: bool = False) -> str:
    """Content security policy of a page that runs these scripts and styles, and asks no network for anything.

    A page that `computes` may run WebAssembly, and a thread of its own.
    """
    words, looks = " ".join(map(_hash, scripts)), " ".join(map(_hash, styles))
    words = f"worker-src blob:; script-src 'wasm-unsafe-eval' {words}" if computes else f"script-src {words}"
    run = f"{words}; " if scripts else ""
    return (
        f"default-src 'none'; img-src data: blob:; media-src data: blob:; {run}style-src {looks}; "
        "base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@lru_cache
def _own(file: str) -> Markup:
    """The text of a style or script of this folder."""
    return Markup(text_of(Path(__file__).parent / file))


@lru_cache(maxsize=1)
def _template() -> Template:
    loader = FileSystemLoader(Path(__file__).parent)
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    environment.filters["shown"] = text
    environment.tests["a"] = lambda block, kind: type(block).__name__ == kind
    return environment.get_template("page.html.j2")


def _is_number(value: Value | Mark) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def text(value: Value) -> Markup:
    """A value as safe HTML: four digits, powers of ten written out, whole numbers in groups of three."""
    if isinstance(value, int) and not isinstance(value, bool):
        return Markup(f"{value:,}".replace(",", "\u202f").replace("-", "−"))
    plain = shown(value)
    if not isinstance(value, float):
        return escape(plain)
    mantissa, _, exponent = plain.partition("e")
    power = Markup("&thinsp;×&thinsp;10<sup>{}</sup>").format(int(exponent)) if exponent else ""
    return Markup(mantissa if exponent else mantissa.replace("-", "−")) + power


def described(result: object, *keys: str) -> list[tuple[str, Value]]:
    """Rows (meaning with unit, value) of a result's numbers, in words of their descriptions; forces in kN."""
    numbers, values = numbers_of(result), cells(result, *keys)
    scaled = [in_kilo(numbers[key].unit) for key in keys]
    heads = (heading(numbers[key].meaning, unit) for key, (_, unit) in zip(keys, scaled, strict=True))
    row_cells = (
        value / scale if isinstance(value, float) else value for value, (scale, _) in zip(values, scaled, strict=True)
    )
    return list(zip(heads, row_cells, strict=True))


def cells(result: object, *keys: str) -> tuple[Value, ...]:
    """Numbers of a result as cells of a table; None where they were not measured."""
    values = (getattr(result, key) for key in keys)
    return tuple(value if known(value) else None for value in values)


def heading(meaning: str, unit: str) -> str:
    """Head of a row: the meaning, first letter large, with the unit in brackets."""
    first = meaning[:1].upper() if meaning[:1].isascii() else meaning[:1]  # a capital gamma would be another symbol
    return f"{first}{meaning[1:]}" + (f" [{unit.translate(POWERS)}]" if unit else "")


def errors_of(result: object) -> list[tuple[str, str]]:
    """Rows (meaning with unit, standard error within this run) of a result's numbers that have one."""
    numbers = [number for number in numbers_of(result).values() if known(getattr(result, number.key))]
    sure = [(number, *sure_of(result, number.key)) for number in numbers]
    return [
        (heading(number.meaning, unit), f"{AT_LEAST * bound}{two_digits(error / scale)}")
        for number, error, bound in sure
        if error
        for scale, unit in [in_kilo(number.unit)]
    ]


def percent(share: Any, digits: int = 1) -> str:
    """A share in per cent; with more than one digit its sign is shown."""
    if not known(share):
        return shown(None)
    return f"{100 * share:{'+' if digits > 1 else ''}z.{digits}f} %"


def percent_of(share: float | None, error: float | None = None, bound: bool = False, *, alone: bool = False) -> str:
    """A share in per cent with its error, which may be a lower bound; `alone` shows it cut to the error."""
    if share is None or share != share:
        return ABSENT
    if error is None or not isfinite(error) or not error:
        return f"{100 * share:+z.1f} %".replace("-", "−")
    text = shown(100 * share, error=100 * error, bound=bound, alone=alone)
    return f"{'+' * (share > 0)}{text} %".replace("-", "−")


def with_error(result: object, key: str, scale: float = 1.0, unit: str = "", *, alone: bool = False) -> str:
    """A number of a result with how sure it is within this run, where that is known."""
    value, (error, bound) = getattr(result, key), sure_of(result, key)
    if not known(value):
        return ABSENT
    error = None if error is None else error / scale
    return shown(value / scale, unit, error, bound=bound, alone=alone).replace("-", "−")


def cut(result: object, key: str, scale: float = 1.0, unit: str = "") -> str:
    """A number of a result, cut to its standard error within this run."""
    return with_error(result, key, scale, unit, alone=True)


def picture_kind(path: Path) -> str:
    """Kind of a file by its first bytes, as a page names it: PNG, GIF or MP4; empty for all else, and for a link."""
    try:
        head = b"" if path.is_symlink() else read_start(path, 12)
    except OSError:  # no regular file, or gone
        return ""
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return PNG
    return "image/gif" if head.startswith((b"GIF87a", b"GIF89a")) else "video/mp4" if head[4:8] == b"ftyp" else ""


def picture(path: Path, caption: str, small: bytes = b"") -> Picture:
    """A file of a `picture_kind` for the page; large pictures of discs, which PNG stores badly, become WebP.

    `small` is of `smaller`, where the picture was in memory.
    """
    data, kind = read_file(path, MOST_PICTURE), picture_kind(path)
    if kind == PNG and len(data) >= 150_000:
        from PIL import Image

        with suppress(OSError, ValueError, SyntaxError, Image.DecompressionBombError):  # damaged: it stays as it is
            small = small or smaller(Image.open(io.BytesIO(data)))
        if 0 < len(small) < 0.7 * len(data):
            data, kind = small, "image/webp"
    return Picture(caption, f"data:{kind};base64,{base64.b64encode(data).decode()}")


def smaller(picture: Image) -> bytes:
    """A picture as WebP, as wide as the page."""
    buffer, small = io.BytesIO(), picture.convert("RGB")
    small.thumbnail((960, 4000))
    small.save(buffer, "WEBP", quality=20, method=3)
    return buffer.getvalue()


def show_page(path: Path) -> None:
    """Open a page in the browser of the user."""
    webbrowser.open(path.resolve().as_uri())
