# SPDX-License-Identifier: GPL-2.0-or-later
"""Make the calibration of ``run.accuracy`` from benchmarks: ``python benchmarks/accuracy_store.py FILE …``.

The files are finished ``bench.json``; see `lammps_jump.engines.accuracy` for what is made of the result.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lammps_jump.engines.accuracy import KINDS, STORE, CalibratedSetting
from lammps_jump.files import read_json, write_json
from lammps_jump.studies.bench import StudySetting

KEPT = ("case", "restitution", "friction", "members", "reference", "versions", "machine")


def make_store(benchmarks: Iterable[dict[str, Any]]) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the content of ``calibration.json`` from the contents of finished ``bench.json``."""
    kinds = {}
    for data in benchmarks:
        kind = next((name for name, (_, quantity) in KINDS.items() if quantity in data["quantities"]), None)
        if kind is None:
            continue
        quantity = KINDS[kind][1]
        rows = [found for row in data["rows"] if (found := _calibrated(row, quantity))]
        rows.sort(key=lambda row: row.seconds)
        kinds[kind] = {name: data[name] for name in KEPT}
        kinds[kind] |= {"quantity": quantity, "rows": [asdict(row) for row in rows]}
    return {"kinds": kinds}


def _calibrated(row: dict[str, Any], quantity: str) -> CalibratedSetting | None:
    """Return a row of a benchmark as it is stored; None for another flow, several ranks, or no error."""
    errors, setting = row["errors"].get(quantity) or {}, StudySetting(**row["setting"])
    other = any(value is not None for value in (setting.penetration, setting.diameter, setting.skin))
    if errors.get("error") is None or row["seconds"] is None or other or setting.ranks > 1:
        return None
    changes = setting.changes(1.0)
    del changes["engine.ranks"]
    error, floor = round(errors["error"], 6), round(errors["floor"] or 0.0, 6)
    texts = [f"{path}={value if isinstance(value, str) else json.dumps(value)}" for path, value in changes.items()]
    seconds = round(row["seconds"], 4)
    return CalibratedSetting(row["label"], setting.kernel, setting.fraction, texts, seconds, error, floor)


def main(files: list[str]) -> None:
    """Write ``calibration.json`` from the files; kinds of scene that they do not have are kept."""
    old = read_json(STORE)["kinds"] if STORE.is_file() else {}
    kinds = old | make_store(read_json(Path(name)) for name in files)["kinds"]
    write_json(STORE, {"kinds": kinds})
    found = ", ".join(f"{kind} ({len(entry['rows'])} settings)" for kind, entry in kinds.items())
    print(f"{STORE.name}: {found}")


if __name__ == "__main__":
    main(sys.argv[1:])
