# SPDX-License-Identifier: GPL-2.0-or-later
"""Measured tables of single jumps: the stream before a jump, and numbers of many starts beside their stated errors."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lammps_jump.analysis.tables import markdown

Data = Mapping[str, Any]
STREAM = ("start", "stop", "mass_depth", "velocity", "momentum_flux", "thrust", "total", "total_error")
STARTS = (
    "jump.froude",
    "jump.y2",
    "jump.belanger_y2",
    "jump.belanger_deviation",
    "jump.speed",
    "jump.length_over_y2",
    "jump.tail.slope",
    "jump.local.sequent_ratio",
    "jump.local.belanger_ratio",
    "jump.local.pressure_relation_ratio",
    "jump.local.density_relation_ratio",
    "jump.local.pressure_coefficient_1",
    "jump.local.pressure_coefficient_2",
    "jump.local.momentum_residual",
    "force.sill.peak",
)
"""Numbers of ``summary.json`` that are shown."""


def stream_rows(folder: Path) -> Data:
    """Stretches of the stream between inlet and toe."""
    stream = json.loads((folder / "summary.json").read_text())["jump"]["stream"]
    stretches = zip(*(stream[name] for name in STREAM), strict=True)
    return {
        "total_deviation": stream["total_deviation"],
        "rows": [dict(zip(STREAM, one, strict=True)) for one in stretches],
    }


def stream_table(data: Data) -> str:
    """A stretch a row."""
    columns = {
        "x, m:": "{start:g} to {stop:g}",
        "s, m:": "{mass_depth:.3f}",
        "u, m/s:": "{velocity:.2f}",
        "momentum flux, m³/s²:": "{momentum_flux:.1f}",
        "thrust, m³/s²:": "{thrust:.1f}",
        "sum P, m³/s²:": "{total:.1f} ± {total_error:.1f}",
    }
    told = f"Its mean is missed by at most {100 * data['total_deviation']:.2f} % (`jump.stream.total_deviation`)."
    return f"{markdown(columns, data['rows'])}\n\n{told}"


def starts_rows(folder: Path) -> Data:
    """Means over starts, their scatter, and the errors that single runs state."""
    point = json.loads((folder / "summary.json").read_text())["points"][0]
    kept = ("mean", "sd", "low", "high", "own_error", "unit")
    found = point["numbers"]
    rows = [{"number": name} | {key: found[name].get(key) for key in kept} for name in STARTS]
    return {"members": point["members"], "rows": rows}


def starts_table(data: Data) -> str:
    """A number a row."""
    columns = {
        "number": "`{number}`",
        "mean over starts:": lambda row: _mean(row),
        "standard deviation of starts:": "{sd:.2g}",
        "error that one run states:": lambda row: f"{row['own_error']:.2g}" if row["own_error"] else "-",
    }
    return markdown(columns, data["rows"])


def _mean(row: Data) -> str:
    """Mean with half of its 95 % interval and unit."""
    unit = row["unit"] or ""
    return f"{row['mean']:.4g} ± {(row['high'] - row['low']) / 2:.2g} {unit}".strip()
