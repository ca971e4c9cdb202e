# SPDX-License-Identifier: GPL-2.0-or-later
"""Hashes that say whether two runs, or parts of them, are the same.

=============  ==============================================  ===================================================
hash           of                                              where it is written, and what it decides
=============  ==============================================  ===================================================
`case_key`     fields that decide a run                        ``Case.hash``; head of ``in.lammps``: for the reader
`shown_key`    the same, and the kernel                        ``case_hash`` of ``summary.json``: for the reader
`run_key`      the same, and the program that runs it          ``key`` of marker and ``summary.json``, name of a
                                                               member's run folder: an equal run is not run again
`member_key`   `run_key`, and name, description and analysis   run folder of a member that shares its run: each
                                                               analysis has a folder of its own
`analysis_key` name, description, analysis, checksums of the   ``analysed`` of ``summary.json``: an equal analysis is
               engine's files, version of this program         not made again
`scene_key`    every number of a scene                         ``checkpoint.json``: a run goes on with equal numbers
                                                               alone
`field_keys`   text of each field of ``case.yaml``             head of ``case.yaml`` in a run folder: finds edits
`short_hash`   any plain data                                  default folder of a long list of changes, stored
                                                               calls of a study
=============  ==============================================  ===================================================

All but `scene_key` have twelve hex digits. Checksums of files are those of `files.checksum`.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from .provenance import __version__

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

NO_NUMBERS = ("name", "description", "skipped", "warnings", "adapted", "stiffer", "stability", "stability_mean")
"""Fields of a scene that change no trajectory."""
LATER = {"later": True}
"""Metadata of a field of a scene that was added after keys were stored: left out of the hash at its default."""
TEXTS_SINCE_V1 = (", holding=None", ", went=None", ", given=()")
"""The same of fields of what a scene holds, in its text."""
Plain = Mapping[str, object]


def short_hash(data: Plain) -> str:
    """Twelve hex digits of plain data, whatever the order of its keys."""
    return _digits(json.dumps(data, sort_keys=True))


def _digits(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def case_key(core: Plain) -> str:
    """Hash of the fields that decide a run, `Case.core`."""
    return short_hash(core)


def shown_key(core: Plain, kernel: str) -> str:
    """`case_key` followed by the kernel."""
    return f"{case_key(core)}-{kernel}"


def run_key(core: Plain, program: Plain) -> str:
    """Hash of a run: `core` of its case, and the `program` that runs it (engine, kernel, versions)."""
    return short_hash({"case": core, **program})


def member_key(run: str, rest: Plain) -> str:
    """Hash of a member whose run, `run_key`, others share; `rest` is that of its case."""
    return short_hash({"key": run, **rest})


def analysis_key(rest: Plain, outputs: Plain) -> str:
    """Hash of an analysis: `rest` of its case, and size and checksum of each file that the engine left."""
    return short_hash({**rest, "outputs": outputs, "lammps_jump": __version__})


def scene_key(scene: DataclassInstance) -> str:
    """Hash of every number of a scene: another version of the program may make other numbers of the same case."""
    digest = hashlib.sha256()
    numbers = {one.name: getattr(scene, one.name) for one in fields(scene) if one.name not in NO_NUMBERS}
    for name, value in without_later(scene, numbers).items():
        digest.update(name.encode())
        digest.update(value.tobytes() if isinstance(value, np.ndarray) else _text(value).encode())
    return digest.hexdigest()


def without_later(of: DataclassInstance | type[DataclassInstance], values: Plain) -> dict[str, object]:
    """Values by the fields of a dataclass, without those of `LATER` fields at their default."""
    defaults = {one.name: one.default for one in fields(of) if one.metadata.get("later")}
    return {name: one for name, one in values.items() if name not in defaults or one != defaults[name]}


def _text(value: object) -> str:
    text = repr(value)
    for later in TEXTS_SINCE_V1:
        text = text.replace(later, "")
    return text


def field_keys(text: str) -> dict[str, str]:
    """Hash of the text of each field at the left margin of a YAML file, by its name."""
    return {part.partition(":")[0]: _digits(part) for part in re.split(r"(?m)^(?=\w+:)", text)[1:]}
