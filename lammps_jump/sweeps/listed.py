# SPDX-License-Identifier: GPL-2.0-or-later
"""``points.json`` of a study: its points, and the run folder of every member."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from pydantic import BaseModel, Field, NonNegativeInt, ValidationError, model_validator

from lammps_jump.errors import CaseError
from lammps_jump.files import read_json
from lammps_jump.quoting import echoed

from .study import MOST_MEMBERS, MOST_RUNS

POINTS_FILE = "points.json"


class ListedMember(BaseModel, strict=True):
    """A member: number of its point, seed, name of its run folder."""

    point: NonNegativeInt
    seed: NonNegativeInt
    key: str


class Listed(BaseModel, strict=True):
    """What ``points.json`` holds."""

    points: list[dict[str, Any]] = Field(max_length=MOST_RUNS)
    members: list[ListedMember] = Field(max_length=MOST_RUNS)

    @model_validator(mode="after")
    def _counts(self) -> Listed:
        counts = Counter(item.point for item in self.members)
        if counts and (last := max(counts)) >= len(self.points):
            raise ValueError(f"a member belongs to point {last}; the points are 0 to {len(self.points) - 1}")
        if (most := max(counts.values(), default=0)) > MOST_MEMBERS:
            raise ValueError(f"a point has {most} members; at most {MOST_MEMBERS} are allowed")
        return self


def read_points(folder: Path) -> Listed | None:
    """The ``points.json`` of a study; None where there is none.

    Raises
    ------
    CaseError
        The file cannot be read, or holds something else: the place, what is wrong and what to do.
    """
    path = folder / POINTS_FILE
    try:
        return Listed.model_validate(read_json(path))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(map(str, first["loc"]))
        value = "" if first["type"] in ("value_error", "too_long") else f", got {echoed(first['input'])}"
        said = f"{f'{place}: ' if place else ''}{first['msg'].removeprefix('Value error, ')}{value}"
    except (OSError, ValueError) as error:
        said = str(getattr(error, "strerror", None) or error)
    raise CaseError(f"{path}: {said}; delete the file, and the same command writes it again")
