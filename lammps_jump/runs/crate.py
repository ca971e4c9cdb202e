# SPDX-License-Identifier: GPL-2.0-or-later
"""A bundle to cite: what a folder of a run or a study holds, as RO-Crate 1.1 (https://w3id.org/ro/crate/1.1).

The file ``ro-crate-metadata.json`` describes the files where they lie: the case, what was computed from it by which
versions, sizes and checksums, the figures, and the licence that the person gives.
"""

from __future__ import annotations

import mimetypes
import re
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import CRATE, SUMMARY_FILE, checksum, write_json
from lammps_jump.folders import locked, read_marker, require_no_link, require_replaceable, standing
from lammps_jump.quoting import shortened, visible

from .summary import open_results, read_summary

PROFILE = "https://w3id.org/ro/crate/1.1"
LICENCES = "https://spdx.org/licenses/"
FORMATS = {
    ".yaml": "application/yaml",
    ".nc": "application/x-netcdf",
    ".lammpstrj": "text/plain",
    ".npz": "application/zip",
}
TOOLS = {"lammps_jump": "lammps-jump", "lammps": "LAMMPS", "python": "Python", "numpy": "NumPy"}
"""Programs of `versions` in ``summary.json``, and what they are called."""


def write_crate(folder: Path, licence: str) -> Path:
    """Write ``ro-crate-metadata.json`` into the folder of a run or a study.

    Parameters
    ----------
    folder : Path
    licence : str
        Short name of SPDX, such as ``CC-BY-4.0``, or an address that begins with ``https://``.

    Raises
    ------
    CaseError
        A licence that is neither.
    DumpError
        No run that is complete, no study; or a file that is not what the run wrote.
    SetupError
        Another file has that name.
    """
    link = licence if licence.startswith("https://") else f"{LICENCES}{licence}"
    if not re.fullmatch(r"https://[A-Za-z0-9][\w.~:/+-]{0,280}|[A-Za-z0-9][A-Za-z0-9.+-]{0,60}", licence, re.ASCII):
        said = "write a short name of SPDX, such as CC-BY-4.0, or an address that begins with https://"
        raise CaseError(f"--license '{shortened(visible(licence))}': is no licence; {said}")
    marker = read_marker(folder)
    if marker is None or marker.kind not in ("run", "sweep"):
        raise DumpError(f"{folder}: holds no run and no study of this program")
    require_replaceable(folder, CRATE)
    if marker.kind == "run":
        results = open_results(folder)
        results.require_same(*(results.sums or {}))
    with locked(folder):
        names = [name for pattern in marker.files for name in standing(folder, pattern) if name != CRATE]
        if marker.kind == "sweep":
            require_no_link(folder / "runs")
            names += standing(folder, "runs/*/case.yaml") + standing(folder, f"runs/*/{SUMMARY_FILE}")
        files = [
            name for name in dict.fromkeys(names) if (folder / name).is_file() and not (folder / name).is_symlink()
        ]
        summary = read_summary(folder) if marker.kind == "run" else _first_summary(folder, files)
        graph = _graph(folder, sorted(files), summary, link)
        return write_json(folder / CRATE, {"@context": f"{PROFILE}/context", "@graph": graph})


def _first_summary(folder: Path, files: list[str]) -> dict[str, Any]:
    """Summary of a member of a study: its versions, its name and its description are those of all."""
    return next((read_summary((folder / name).parent) for name in files if name.startswith("runs/")), {})


def _graph(folder: Path, files: list[str], summary: Mapping[str, Any], licence: str) -> list[dict[str, Any]]:
    """The entities of a crate."""
    made = datetime.fromtimestamp((folder / SUMMARY_FILE).stat().st_mtime, UTC).isoformat(timespec="seconds")
    case, name = next(one for one in ("case.yaml", "study.yaml") if one in files), summary.get("name") or folder.name
    versions_of = summary.get("versions") or {}
    tools = [
        {"@id": f"#{key}", "@type": "SoftwareApplication", "name": called, "version": versions_of[key]}
        for key, called in TOOLS.items()
        if key in versions_of
    ]
    described = summary.get("description") or f"results of lammps-jump for the case {name}"
    said = {"identifier": summary["case_hash"]} if "case_hash" in summary and case == "case.yaml" else {}
    root = {"@id": "./", "@type": "Dataset", "name": name, "description": described, "datePublished": made,
            "license": {"@id": licence}, "hasPart": _links(files), "mentions": {"@id": "#run"}, **said}  # fmt: skip
    action = {"@id": "#run", "@type": "CreateAction", "name": f"{name}, computed", "endTime": made,
              "instrument": _links([one["@id"] for one in tools]), "object": _links([case]),
              "result": _links([one for one in files if one != case])}  # fmt: skip
    about = {"@id": CRATE, "@type": "CreativeWork", "about": {"@id": "./"}, "conformsTo": {"@id": PROFILE}}
    right = {"@id": licence, "@type": "CreativeWork", "name": licence.removeprefix(LICENCES),
             "description": f"licence of these files: {licence}"}  # fmt: skip
    return [about, root, action, right, *tools, *(_file(folder, one) for one in files)]


def _links(names: list[str]) -> list[dict[str, str]]:
    return [{"@id": name} for name in names]


def _file(folder: Path, name: str) -> dict[str, Any]:
    """A file with its size, kind and checksum."""
    sums = checksum(folder / name)
    kind = FORMATS.get(Path(name).suffix) or mimetypes.guess_type(name)[0] or "application/octet-stream"
    return {"@id": name, "@type": "File", "name": name, "contentSize": str(sums["size"]), "sha256": sums["sha256"],
            "encodingFormat": kind}  # fmt: skip
