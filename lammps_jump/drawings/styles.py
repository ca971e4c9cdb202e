# SPDX-License-Identifier: GPL-2.0-or-later
"""Styles of SVG as far as they say what is drawn and where: attributes, ``style``, and rules of style sheets."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple
from xml.etree.ElementTree import Element

from lammps_jump.errors import CaseError
from lammps_jump.quoting import shortened

PLACES = {"x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "transform"}
"""What a style may say in place of an attribute, of where something is."""
INHERITED = ("visibility", "fill", "stroke")
SEEN = {*INHERITED, "display", "opacity", "clip-path", "mask", *PLACES}
"""Properties that are looked at."""
SIMPLE = re.compile(r"([A-Za-z][\w-]*|\*)?((?:[.#][\w-]+)*)")
NOTHING = re.compile(r"\+?0*(?:\.0*)?%?")
MOST_TRIED = 3_000_000
"""Rules that are held against elements, copies counted."""
MOST_TOLD = 3
"""Rules that notes name."""


class Rule(NamedTuple):
    """Condition of a selector without combinators, and what it sets; `rank` says which of two rules wins."""

    rank: tuple[int, int, int, int]
    classes: frozenset[str]
    id: str
    kind: str
    sets: dict[str, str]


class Styles:
    """The rules of the style sheets of a file."""

    def __init__(self, file: str, rules: list[Rule], unknown: list[str]) -> None:
        self.file, self.unknown, self.tried = file, unknown, 0
        self.rules: dict[str, list[Rule]] = {}
        for rule in rules:
            known_by = f"#{rule.id}" if rule.id else f".{min(rule.classes)}" if rule.classes else rule.kind
            self.rules.setdefault(known_by, []).append(rule)

    @classmethod
    def of(cls, root: Element, file: str) -> Styles:
        """Styles of a file. Rules that depend on where an element stands are not understood, and told."""
        rules: list[Rule] = []
        unknown: list[str] = []
        for element in root.iter():
            if isinstance(element.tag, str) and element.tag.rpartition("}")[2] == "style":
                for selectors, body in _rules("".join(element.itertext())):
                    sets = {name: value for name, value in declared(body).items() if name in SEEN}
                    for selector in selectors.split(",") if sets else ():
                        rule = _rule(selector.strip(), sets, len(rules))
                        rules += [rule] if rule else []
                        unknown += [] if rule else [shortened(" ".join(selector.split()))]
        return cls(file, rules, unknown)

    def given(self, element: Element, kind: str) -> dict[str, str]:
        """Attributes of an element, with what rules and its own style set in their place.

        Raises
        ------
        CaseError
            More rules for the elements than are looked at.
        """
        found = dict(element.attrib)
        if self.rules:
            names = element.get("class", "").split()
            keys = {f"#{element.get('id', '')}", *(f".{name}" for name in names), kind, "*"}
            near, classes = [rule for key in keys for rule in self.rules.get(key, ())], set(names)
            self.tried += len(near)
            if self.tried > MOST_TRIED:
                raise CaseError(
                    f"{self.file}: its style sheet has so many rules for the same elements that more than "
                    f"{MOST_TRIED:,} are to be held against them; save it as plain SVG"
                )
            fit = [
                rule for rule in near
                if rule.classes <= classes and rule.id in ("", element.get("id")) and rule.kind in ("*", kind)
            ]  # fmt: skip
            for rule in sorted(fit):
                found |= rule.sets
        own = declared(element.get("style", ""))
        return found | {name: value for name, value in own.items() if name in SEEN}

    def notes(self) -> Iterator[str]:
        """Sentences on what is not understood."""
        if self.unknown:
            more = f" and {len(self.unknown) - MOST_TOLD} more" if len(self.unknown) > MOST_TOLD else ""
            yield f"rules of the style sheet that are not understood: {'; '.join(self.unknown[:MOST_TOLD])}{more}"


def _rule(selector: str, sets: dict[str, str], order: int) -> Rule | None:
    """The rule of a selector; None of one with combinators, pseudo-classes or attributes."""
    simple = SIMPLE.fullmatch(selector)
    if simple is None or not selector:
        return None
    parts = re.findall(r"[.#][\w-]+", simple[2])
    ids = [part[1:] for part in parts if part[0] == "#"]
    classes = frozenset(part[1:] for part in parts if part[0] == ".")
    if len(set(ids)) > 1:
        return None
    kind = simple[1] or "*"
    return Rule((len(ids), len(classes), kind != "*", order), classes, ids[0] if ids else "", kind, sets)


def _uncommented(text: str) -> str:
    """A style without its comments; one that does not end is none."""
    kept, here = [], 0
    while (begin := text.find("/*", here)) >= 0 and (end := text.find("*/", begin + 2)) >= 0:
        kept.append(text[here:begin])
        here = end + 2
    return " ".join([*kept, text[here:]])


def _rules(text: str) -> Iterator[tuple[str, str]]:
    """Selectors and body of each rule of a style sheet."""
    *bodies, _ = _uncommented(text).split("}")
    for one in bodies:
        head, begin, body = one.rpartition("{")
        if begin:
            yield head.rpartition("{")[2], body


def declared(text: str) -> dict[str, str]:
    """Properties and values of a style, the last of each."""
    pairs = (one.partition(":") for one in _uncommented(text).split(";"))
    return {name.strip().lower(): value.replace("!important", "").strip() for name, colon, value in pairs if colon}


def style_of(parent: Mapping[str, str], given: Mapping[str, str]) -> dict[str, str]:
    """Style that an element and its parts inherit; ``shown`` is ``no`` where nothing is seen, whatever parts say."""
    found = {name: given[name].strip() for name in INHERITED if given.get(name, "inherit").strip() != "inherit"}
    gone = given.get("display", "").strip() == "none" or (
        bool(given.get("opacity", "").strip()) and NOTHING.fullmatch(given["opacity"].strip()) is not None
    )
    shown = "no" if gone or parent.get("shown") == "no" else "yes"
    return {**parent, **found, "shown": shown}
