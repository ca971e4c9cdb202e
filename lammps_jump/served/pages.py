# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages of what was opened: a case file, a run or a study.

The case file that is open is read, and written whole, unless another program has changed it meanwhile.
"""

from __future__ import annotations

import hashlib
from base64 import b64decode
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

from lammps_jump import drawings
from lammps_jump.case.case import ReadCase
from lammps_jump.case.text import read_text
from lammps_jump.errors import JumpError, ScaleError, SetupError
from lammps_jump.files import END_OF_LINE, change_text, real_path, writes
from lammps_jump.folders import read_marker
from lammps_jump.quoting import typed
from lammps_jump.runs.folder import default_folder, require_case

from .children import Children, OutOfDate, PageWork, ServedChild, prepare
from .look import MOST_DRAWN, DroppedFile, flow_page, look, with_drawing, with_shape
from .run_pages import MOST_NAME, LivePages, RunPages, StudyView, number_in
from .server import HERE, Pages, RefusedRequest, Reply, answer, asset, page_of

LOOK_SECONDS, DRAWING_SECONDS = 20.0, 60.0
"""Seconds after which a look at a text, or a drawing that was dropped, is left."""
MOST_RUNS = 1000
"""Folders of runs of one case that are looked at for one that is free."""
SEVERAL = (
    "run.members: this page runs one start; the command runs all of them, and `lammps-jump open` shows their folder"
)
"""Why a case of several starts has no button."""


def pages_of(path: Path) -> OpenedTarget:
    """The pages of a case file, or of the folder of a run or of a study.

    Raises
    ------
    CaseError
        There is no such file, or the folder holds neither.
    """
    if (path / "study.yaml").is_file():
        return StudyPages(path)
    return RunAlone(path) if path.is_dir() else CasePages(path)


class OpenedTarget(Pages):
    """Target that was opened; see `Pages`.

    Attributes
    ----------
    start : str
        Path of the page that is to be opened first.
    """

    start = ""

    def __init__(self) -> None:
        self.children, self.live = Children(), LivePages()
        self.runs = RunPages(self.children, self.live)

    def get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        """Pages of runs, and the files of all pages."""
        return self.runs.get(path[4:], query) if path.startswith("run/") else asset(path)

    def post(self, path: str, asked: Mapping[str, Any]) -> Reply | None:
        """Answer to a request about a run."""
        return self.runs.post(path[4:], asked) if path.startswith("run/") else None

    def prepare(self) -> None:
        """Start what a page will need at once."""

    def alone(self, token: str) -> Reply | None:
        """The live page or the report with this token."""
        return self.live.with_token(token) or self.runs.report(token)

    def close(self) -> list[ServedChild]:
        """Leave what is looked at, and end the runs that were started here, which can go on; those that went on."""
        self.live.bounded.close()
        return self.children.close()


class RunAlone(OpenedTarget):
    """The page of one run folder."""

    start = "run/0/"

    def __init__(self, folder: Path):
        super().__init__()
        require_case(folder)
        self.runs.number(folder)


class StudyPages(OpenedTarget):
    """The page of a study: its table, and each of its runs by a click."""

    def __init__(self, folder: Path):
        super().__init__()
        self.study = StudyView(folder, self.runs)

    def get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        """The page, and how far the study is."""
        if path == "":
            return page_of(HERE / "study.html")
        return answer(self.study.state()) if path == "state" else super().get(path, query)


class CasePages(OpenedTarget):
    """The page of a case file: its text, what `look` finds in it, and its run."""

    def __init__(self, path: Path):
        super().__init__()
        self.file = CaseFile(path)
        self._bounded = self.live.bounded
        self._read: tuple[str | None, ReadCase] = None, None  # type: ignore[assignment]
        self._started: dict[Path, dict[str, Any]] = {}

    def get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        """The page, and the text as it is now."""
        if path == "":
            return page_of(HERE / "case.html")
        if path == "file":
            page = self.file.read()
            same = page.key == query.get("key")
            page_data = {"name": str(self.file.shown), "key": page.key, "text": None if same else page.text}
            return answer({**page_data, "run": self._plan(page.text), "largest": MOST_DRAWN})
        return super().get(path, query)

    def post(self, path: str, asked: Mapping[str, Any]) -> Reply | None:
        """Look at a text, add the walls of a drawing to it, save it, or run what is saved."""
        if path == "look":
            return self._look(asked)
        if path == "drawing":
            return self._drawing(asked)
        if path == "shape":
            return self._shape(asked)
        if path == "flow":
            return self._flow(asked)
        if path == "save":
            saved = self.file.save(text_of(asked, "text"), text_of(asked, "key"))
            if saved is None:
                return answer({"changed": True, **self.file.read()._asdict()}, 409)
            return answer({"key": saved.key})
        if path == "run":
            return self._run(text_of(asked, "key"))
        return super().post(path, asked)

    def prepare(self) -> None:
        """Start the process that looks at texts."""
        prepare()

    def _look(self, asked: Mapping[str, Any]) -> Reply:
        """Look at a text; a look at an older text of the same page is left."""
        text, wide, page = text_of(asked, "text"), number_of(asked, "wide"), str(asked.get("page", ""))[:MOST_NAME]
        file = self.file.shown.absolute()  # the process that looks may be in another folder
        remedy = f"`{typed('check', self.file.shown)}` has no such limit"
        try:
            return answer(self._bounded.run(PageWork(partial(look, text, file, wide), LOOK_SECONDS, remedy, page)))
        except OutOfDate:
            return answer({"refused": "a newer text has come", "left": True}, 409)

    def _shape(self, asked: Mapping[str, Any]) -> Reply:
        """The text of a page with a shape that was drawn in its picture; nothing is written."""
        text, what, points = text_of(asked, "text"), text_of(asked, "what"), asked.get("points")
        if what not in drawings.DRAWN:
            raise RefusedRequest(400, "what is no shape")
        two = isinstance(points, list) and [len(one) if isinstance(one, list) else 0 for one in points] == [2, 2]
        if not two:
            raise RefusedRequest(400, "points are no two points")
        ends = [(number_in(x, "points"), number_in(y, "points")) for x, y in points]  # type: ignore[union-attr]
        call = partial(with_shape, text, self.file.shown.absolute(), what, ends)
        return answer(self._bounded.run(PageWork(call, LOOK_SECONDS, "write it into the text")))

    def _flow(self, asked: Mapping[str, Any]) -> Reply:
        """The address of a live page of a text; one for an older text of the same page is left."""
        remedy = f"`{typed('live', self.file.shown)}` has no such limit"
        call = partial(flow_page, text_of(asked, "text"), self.file.shown.absolute())
        return self.live.make(call, str(asked.get("page", "")), remedy)

    def _drawing(self, asked: Mapping[str, Any]) -> Reply:
        """The text of a page with the walls of a drawing, and the command that does the same; nothing is written."""
        text, name, scale = (text_of(asked, part) for part in ("text", "name", "scale"))
        try:
            data = b64decode(text_of(asked, "data"), validate=True)
        except ValueError:
            raise RefusedRequest(400, "data is not in base64") from None
        dropped = DroppedFile(Path(name).name, data, scale.strip() or None)
        remedy = f"`{typed('import', Path(name), '--into', self.file.shown)}` has no such limit"
        try:
            drawing = self._bounded.run(
                PageWork(partial(with_drawing, text, self.file.shown.absolute(), dropped), DRAWING_SECONDS, remedy)
            )
        except ScaleError as error:
            return answer({"refused": str(error), "scale": True}, 422)
        given = ["--scale", scale.strip()] if scale.strip() else []
        return answer({**drawing, "command": typed("import", Path(name), *given, "--into", self.file.shown)})

    def _plan(self, text: str) -> dict[str, Any] | None:
        """Plan of the button: the command, and the number of a run of this case that is there already."""
        try:
            case, folder, there = self._folder(text)
        except JumpError:
            return None  # the page shows what is wrong
        if case.fields.run.members:
            return {"number": None, "command": typed("build-and-run", self.file.shown), "why": SEVERAL}
        words = ["open", folder] if there else self._words(case, folder)
        return {"number": self.runs.number(folder) if there else None, "command": typed(*words)}

    def _run(self, key: str) -> Reply:
        """Run the case of the file with this key; the number of the run."""
        page = self.file.read()
        if page.key != key:
            raise SetupError(f"{self.file.shown}: was changed meanwhile; look at it, and run it then")
        case, folder, there = self._folder(page.text)
        if case.fields.run.members:
            raise SetupError(SEVERAL)
        if not there:
            self._started[folder] = case.core
            self.children.start(folder, *self._words(case, folder))
            self.runs.expect(folder, case)
        return answer({"number": self.runs.number(folder)})

    def _words(self, case: ReadCase, folder: Path) -> list[str | Path]:
        """The command that runs the case in a folder."""
        words: list[str | Path] = ["build-and-run", self.file.shown]
        return words if folder == default_folder(case) else [*words, "--out", folder]

    def _folder(self, text: str) -> tuple[ReadCase, Path, bool]:
        """The case of a text, the folder of its run, and whether the run is there; else a folder that is free.

        Raises
        ------
        JumpError
            The case cannot be used.
        """
        if self._read[0] != text:
            self._read = text, ReadCase.parse(text, str(self.file.shown), folder=self.file.shown.parent)
        case = self._read[1]
        first = default_folder(case)
        for number in range(1, MOST_RUNS):
            folder = first if number == 1 else first.with_name(f"{first.name}-{number}")
            child = self.children.of(folder)
            begins = child is not None and child.status is None
            if holds(folder, case) or (begins and self._started.get(folder) == case.core):
                return case, folder, True
            if not begins and not folder.exists():
                return case, folder, False
        raise SetupError(f"{first}: there are {MOST_RUNS} runs of other cases beside it")


def holds(folder: Path, case: ReadCase) -> bool:
    """Tells whether a folder holds a run of this case."""
    try:
        marker = read_marker(folder)
    except JumpError:
        return False
    return marker is not None and marker.kind == "run" and marker.about.get("case") == case.core


def text_of(asked: Mapping[str, Any], name: str) -> str:
    """A text that a page sends.

    Raises
    ------
    Refused
        Something else, or a text that no file can hold.
    """
    value = asked.get(name)
    if not isinstance(value, str) or "\x00" in value:
        raise RefusedRequest(400, f"{name} is no text")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise RefusedRequest(400, f"{name} holds half of a letter") from None
    return value.replace("\r\n", "\n")


def number_of(asked: Mapping[str, Any], name: str) -> int:
    """A whole number that a page sends; Refused for something else."""
    value = asked.get(name)
    if not isinstance(value, int) or isinstance(value, bool):
        raise RefusedRequest(400, f"{name} is no whole number")
    return value


class HashedText(NamedTuple):
    """A text, and a hash that says whether it is still the same."""

    text: str
    key: str


class CaseFile:
    """One case file.

    Parameters
    ----------
    path : Path
        Where it is a link, the file that it leads to is meant.

    Raises
    ------
    CaseError
        As `read_text`.
    """

    def __init__(self, path: Path):
        self.shown, self.path = path, real_path(path)
        self._lock = Lock()
        self.read()

    def read(self) -> HashedText:
        """The text, with the ends of lines that a page has."""
        text = read_text(self.path)
        return HashedText(END_OF_LINE.sub("\n", text), _key(text))

    def save(self, text: str, key: str) -> HashedText | None:
        """Write a text over the one with this key; None, and nothing is written, where the file holds another one.

        See `change_text`.

        Raises
        ------
        CaseError, SetupError
            The file is gone, or cannot be written.
        """
        with self._lock:
            there = read_text(self.path)
            if _key(there) != key:
                return None
            with writes(self.shown, SetupError, "correct the permissions of file and folder"):
                saved = change_text(self.path, there, text)
            return HashedText(text, _key(saved)) if saved is not None else None


def _key(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
