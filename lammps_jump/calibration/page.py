# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a calibration: the verdict, then what it rests on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lammps_jump.analysis.report.page import Code, Items, Section, Table, Text, render
from lammps_jump.files import write_text
from lammps_jump.provenance import versions
from lammps_jump.sweeps.words import heading
from lammps_jump.units import ABSENT, shown

from .study import Calibration
from .words import point_text

PAGE = "calibration.html"


def sections(study: Calibration, data: Mapping[str, Any], folder: Path) -> list[Section]:
    """The parts of the page."""
    return [
        Section("", [Text(f"{data['runs']} runs of at most {data['budget']}, {data['failed']} left out.", "sure")]),
        Section("", [Items(data["notes"], "What to know")]),
        Section("Numbers", [Table(parameter_rows(data), PARAMETER_HEADS)]),
        Section("Measurements", [Table(target_rows(data), TARGET_HEADS)]),
        Section("Runs", [Table(run_rows(data), ("point", "runs"))]),
        Section("How to repeat it", [
            Table([("Versions", ", ".join(f"{name} {text}" for name, text in versions("scikit-learn").items()))]),
            Text(f"`lammps-jump calibrate {folder}` goes on with this study, or does nothing where all is there."),
            Code(study.to_yaml(), "study.yaml"),
        ]),
    ]  # fmt: skip


PARAMETER_HEADS = ("number", "best", "95 % from", "to", "looked for in", "identified")
TARGET_HEADS = ("target", "measured", "error", "at the best values", "scatter over starts", "error of the emulator")


def parameter_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    """The varied numbers."""
    return [
        [heading(path), *(shown(one[key], digits=3) for key in ("best", "low", "high")),
         f"{one['prior'][0]:zg} to {one['prior'][1]:zg}", shown(one["identified"])]
        for path, one in data["parameters"].items()
    ]  # fmt: skip


def target_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    """Measured numbers beside those at the best values; of curves their size alone."""
    rows: list[list[Any]] = []
    for name, one in data["targets"].items():
        loo = shown(data["loo"][name]["emulator"], digits=2)
        if "at" in one:
            rows.append([name, f"{len(one['at'])} points", ABSENT, ABSENT, ABSENT, loo])
        else:
            numbers = (shown(one[key]) for key in ("measured", "error", "at_best", "spread"))
            rows.append([name, *numbers, loo])
    return rows


def run_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    """Points and their run folders."""
    return [[point_text(one["values"]), ", ".join(one["runs"]) or "left out"] for one in data["points"]]


def write_page(study: Calibration, data: Mapping[str, Any], folder: Path) -> Path:
    """Write ``calibration.html``."""
    name = ": ".join(filter(None, (study.case.name, study.case.fields.description)))
    text = render(data["verdict"], sections(study, data, folder), tab=f"{study.case.name}: calibration", name=name)
    return write_text(folder / PAGE, text)
