# SPDX-License-Identifier: GPL-2.0-or-later
"""Words of a case that were renamed: refused where a user writes them, read where an earlier version wrote them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lammps_jump.case.text import CaseSource, PathKey
from lammps_jump.errors import CaseError
from lammps_jump.folders import MARKER_FILE
from lammps_jump.quoting import shortened

RECIPROCALS = {"contact.penetration_fraction": "contact.largest_overlap"}
"""Fields that have another name and hold the reciprocal of what they held."""
VALUES = {"contact.friction_law": {"hooke": "viscous"}}
"""Fields whose words have other names."""
LIKELY = re.compile(r"\bpenetration_fraction\b|\bhooke\b")
"""Stands in every text that holds an old word."""


def written_by_us(file: Path) -> bool:
    """Whether a file stands in a folder of this program: an earlier version may have written it."""
    return (file.parent / MARKER_FILE).exists()


def refuse(source: CaseSource, *, study: bool = False) -> None:
    """CaseError where a case, or a study with a case in it, has an old word: its place, and the new word."""
    for path, said in _in_study(source.data) if study else _in_case(source.data):
        raise CaseError(f"{source.place(path)}: {said}")


def translate(source: CaseSource, *, study: bool = False) -> None:
    """Put new words for old ones into a case or study that an earlier version wrote, and keep that in mind."""
    source.translated = any(_in_study(source.data) if study else _in_case(source.data))
    if not source.translated:
        return
    data = source.data
    if study:
        parts = {name: in_changes(data[name]) for name in ("set", "axes") if isinstance(data.get(name), Mapping)}
        data = {**data, "case": in_case(data.get("case")), **parts}
        if isinstance(zipped := parts.get("axes", {}).get("zip"), Mapping):
            data["axes"]["zip"] = in_changes(zipped)
    else:
        data = in_case(data)
    source.data = data


def in_case(data: Any) -> Any:
    """Plain data of a case with new words."""
    if not isinstance(data, Mapping):
        return data
    groups = {
        name: {key.partition(".")[2]: value for key, value in in_changes(_dotted(name, group)).items()}
        for name, group in data.items()
        if isinstance(group, Mapping)
    }
    return {name: groups.get(name, value) for name, value in data.items()}


def in_changes(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Values, or lists of them, by the path of their field, with new words."""
    return {RECIPROCALS.get(path, path): new_word(path, value) for path, value in changes.items()}


def new_word(path: str, value: Any) -> Any:
    """A value of a field, or a list of values, in new words; `path` may be old."""
    if isinstance(value, list):
        return [new_word(path, one) for one in value]
    if path in RECIPROCALS:
        number = _number(value)
        return 1.0 / number if number else value
    return VALUES.get(path, {}).get(value, value) if isinstance(value, str) else value


def as_written(data: Mapping[str, Any]) -> dict[str, Any]:
    """Plain data of a case with the words of the version that wrote it, for keys and files of its folder."""
    old_names = {new: old for old, new in RECIPROCALS.items()}
    old_words = {path: {new: old for old, new in words.items()} for path, words in VALUES.items()}
    found = dict(data)
    for name, group in data.items():
        if isinstance(group, Mapping):
            found[name] = {}
            for path, value in _dotted(name, group).items():
                if path in old_names:
                    value = _reciprocal(value)
                elif path in old_words:
                    value = old_words[path].get(value, value)
                found[name][old_names.get(path, path).partition(".")[2]] = value
    return found


def _dotted(name: str, group: Mapping[str, Any]) -> dict[str, Any]:
    return {f"{name}.{key}": value for key, value in group.items()}


def _reciprocal(value: float) -> float:
    """The reciprocal; a whole number where that differs by round-off alone."""
    exact = 1.0 / value
    return float(round(exact)) if abs(exact - round(exact)) < 1e-9 * exact else exact


def _number(value: Any) -> float:
    """A number, also as text; 0 where it is none that has a reciprocal."""
    try:
        return 0.0 if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        return 0.0


def _in_case(data: Any) -> Iterator[tuple[PathKey, str]]:
    """Path and what is to be said of each old word of a case."""
    for name, group in data.items() if isinstance(data, Mapping) else ():
        if isinstance(group, Mapping):
            for path, said in _in_changes(_dotted(name, group)):
                yield (name, path.partition(".")[2]), said


def _in_study(data: Any) -> Iterator[tuple[PathKey, str]]:
    """The same of a study: of its case, of changed values and of axes."""
    if not isinstance(data, Mapping):
        return
    yield from ((("case", *path), said) for path, said in _in_case(data.get("case")))
    axes = data.get("axes")
    zipped = axes.get("zip") if isinstance(axes, Mapping) else None
    for place, changes in ((("set",), data.get("set")), (("axes",), axes), (("axes", "zip"), zipped)):
        if isinstance(changes, Mapping):
            yield from (((*place, path), said) for path, said in _in_changes(changes))


def _in_changes(changes: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Path and what is to be said of each old word among values by path."""
    for path, value in changes.items():
        new = new_word(path, value)
        if path in RECIPROCALS:
            name = RECIPROCALS[path].partition(".")[2]
            numbers = value if isinstance(value, list) else [value]
            known = numbers and all(map(_number, numbers))
            yield path, f"{_shown(value)} is now {name}: {_shown(new)}" if known else f"is now {name}, its reciprocal"
        elif path in VALUES and new != value:
            yield path, f"{_shown(value)} is now {_shown(new)}"


def _shown(value: Any) -> str:
    return shortened(f"[{', '.join(map(str, value))}]" if isinstance(value, list) else str(value))
