# SPDX-License-Identifier: GPL-2.0-or-later
"""The scenes that come with the package (``inputs/``) as starting cases, and whether a description is of its case."""

from __future__ import annotations

import json
import re
from pathlib import Path

from pydantic import ValidationError

from lammps_jump.errors import CaseError
from lammps_jump.files import text_of
from lammps_jump.folders import MARKER_FILE
from lammps_jump.quoting import LONGEST

from .fields import CaseFields
from .text import CaseSource, PathKey, nearest, parse_source

NOT_TOLD = ("name", "analysis", "probes", "engine", "run.members", "run.checkpoint_interval", "run.dump_format")
"""Fields whose change is not told behind a description: the flow is the same."""
OF_THE_FLOW = ("gravity", "slope", "discs", "contact", "domain", "walls", "initial", "inflow", "outflow")
"""Fields that a description of a scene may speak of."""
CHANGED = "changed: "


def scene_folder() -> Path:
    """Folder of the case files: inside the package in a wheel, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "inputs"
    return inside if inside.is_dir() else package.parent / "inputs"


def scene_names() -> list[str]:
    """Names that `scene_text` knows."""
    return sorted(path.stem for path in scene_folder().glob("*.yaml"))


def scene_text(name: str) -> str:
    """Text of a scene's case file.

    Raises
    ------
    CaseError
        For a name that is not there, with the nearest that is.
    """
    names = scene_names()
    if name not in names:
        raise CaseError(f"new {name}: there is no such scene; {nearest(name, names)}")
    return text_of(scene_folder() / f"{name}.yaml")


def described(text: str, source: CaseSource) -> str:
    """A description with the values behind it that ``--set`` or a study has changed; without them where it is too long.

    It names values that an earlier case had changed once: ``a channel; changed: run.seed = 1, contact.friction = 0.1``.
    """
    before, sign, told = text.rpartition(CHANGED)
    changes = dict(re.findall(r"([\w.-]+) = (.*?)(?=, [\w.-]+ = |$)", told)) if sign else {}
    before = before.removesuffix("; ") if changes else text
    for path, assignment in source.overrides.items():
        if path == ("description",):
            changes = {}
        elif (value := source.value(path)) is not None and _is_told(path):
            name = assignment.partition("=")[0].strip()
            changes.pop(name, None)
            changes[name] = value if isinstance(value, str) else json.dumps(value)
    whole = "; ".join(filter(None, [before, CHANGED + ", ".join(map(" = ".join, changes.items())) if changes else ""]))
    return whole if len(whole) <= LONGEST else f"{before[: LONGEST - 40]}; {len(changes)} values changed"


def _is_told(path: PathKey) -> bool:
    dotted = ".".join(map(str, path))
    return "jitter" not in path and not any(f"{dotted}.".startswith(f"{name}.") for name in NOT_TOLD)


def of_another_case(source: CaseSource) -> str:
    """Name of the scene whose description a case still has although its flow is another one; else empty.

    Scenes themselves and run folders are as they were written.
    """
    text, place = source.data.get("description"), Path(source.file).absolute().parent
    if not isinstance(text, str) or place == scene_folder() or (place / MARKER_FILE).exists():
        return ""
    line = " ".join(text.split())
    for name in scene_names():
        if f"\ndescription: {line}\n" in (scene := scene_text(name)):
            try:
                found, own = (CaseFields.model_validate(data) for data in (parse_source(scene).data, source.data))
            except ValidationError:  # the check tells it, with its place
                return ""
            return name if any(getattr(found, key) != getattr(own, key) for key in OF_THE_FLOW) else ""
    return ""
