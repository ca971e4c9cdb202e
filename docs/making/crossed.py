# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of a cross-validation, from ``cross_validation.json``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.studies.cross_validation.quantities import relative_size

Data = Mapping[str, Any]
CHECK = ("name", "kernel", "worst", "agrees")
QUANTITY = ("name", "place", "unit", "kind", "mean_1", "mean_2", "deviation_1", "deviation_2", "difference")
VERDICT = ("half_width", "verdict")


def rows(folder: Path) -> Data:
    """What the tables need of a study; the rest of its file is curves and single runs."""
    data = json.loads((folder / "cross_validation.json").read_text())

    def kept(found: list[dict], *names: str) -> list[dict]:
        return [{name: row[name] for name in names} for row in found]

    parted = {name: data["divergence"][name]["rate"] for name in ("growth", "twin_growth")}
    return {
        "members": len(data["seeds"]),
        "kernel": data["lammps_kernel"],
        "rows": kept(data["disc_by_disc"], *CHECK),
        "rates": parted,
        "quantities": kept(data["statistics"]["quantities"], *QUANTITY, *VERDICT),
        "laws": {name: kept(law["quantities"], *QUANTITY, *VERDICT) for name, law in data["laws"].items()},
    }


def share(row: Data) -> str:
    """Difference with its 95 % interval, per cent of the quantity; an asterisk where the two differ."""
    size = relative_size(dict(row))
    if not size or row["half_width"] is None or row["difference"] is None:
        return "-"
    sign = " *" if row["verdict"] == "differ" else ""
    return f"{100 * row['difference'] / size:+.2g} ± {100 * row['half_width'] / size:.2g} %{sign}"


def table(data: Data) -> str:
    """Disc by disc, the rate at which the engines part, statistics, laws."""
    scenes: dict[str, dict[str, object]] = {}
    for index, row in enumerate(data["rows"]):
        seen = [one["name"] for one in data["rows"][:index] if one["kernel"] == row["kernel"]]
        name = row["name"] + (", developed" if row["name"] in seen else "")
        scenes.setdefault(name, {"scene": name})[row["kernel"]] = f"{row['worst']:.0e}"
    kernels = dict.fromkeys(row["kernel"] for row in data["rows"])
    first = markdown({"scene": "", **{f"{kernel}:": _of(kernel) for kernel in kernels}}, scenes.values())
    times = [f"{1000 / rate:.1f} ms" if rate else "no growth" for rate in data["rates"].values()]
    parting = (
        f"Then the distance grows by e in {times[0]}; of the native engine and a perturbed run of it in {times[1]}."
    )
    lines = [
        {"quantity": row["name"], "mean": f"{row['mean_1']:.4g} {row['unit']}", "native - LAMMPS": share(row)}
        | {law: _law(found, row["name"]) for law, found in data["laws"].items()}
        for row in data["quantities"]
        if row["kind"] == "scalar" and row["mean_1"] is not None and share(row) != "-"
    ]
    differ = sum(row["verdict"] == "differ" for row in data["quantities"])
    told = f"Of {len(data['quantities'])} quantities and curves {differ} differ, with {data['members']} runs of each."
    columns = {"quantity": "", "LAMMPS:": _of("mean"), "native - LAMMPS:": _of("native - LAMMPS")}
    columns |= {f"{law}:": _of(law) for law in data["laws"]}
    return "\n\n".join([first, parting, markdown(columns, lines), told])


def _of(name: str) -> Column:
    return lambda row: row.get(name, "-")


def _law(found: list[dict], name: str) -> str:
    return next((share(row) for row in found if row["name"] == name), "-")
