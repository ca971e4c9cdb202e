"""Makes the stored calibration (``calibration.json``), by which `lammps_jump.engines.accuracy` chooses a setting.

The file is made from finished benchmarks: ``python -m lammps_jump.studies.calibration_store BENCH.json …``.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lammps_jump.engines.accuracy import KINDS, STORE


def make_store(benchmarks: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """The content of ``calibration.json`` from finished benchmarks (`bench.study.bench_case`)."""
    kinds: dict[str, Any] = {}
    for data in benchmarks:
        kind = next((name for name, (_, quantity) in KINDS.items() if quantity in data["quantities"]), None)
        if kind is None:
            continue
        quantity = KINDS[kind][1]
        rows = []
        for row in data["rows"]:
            errors, setting = row["errors"].get(quantity) or {}, row["setting"]
            numeric = setting["penetration"] is None and setting["diameter"] is None and setting["skin"] is None
            if errors.get("error") is None or row["seconds"] is None or not numeric or setting["ranks"] > 1:
                continue
            rows.append(
                {
                    "label": row["label"],
                    "kernel": setting["kernel"],
                    "fraction": setting["fraction"],
                    "assignments": _assignments(setting),
                    "seconds": round(row["seconds"], 4),
                    "error": round(errors["error"], 6),
                    "floor": round(errors["floor"] or 0.0, 6),
                }
            )
        kept = ("case", "restitution", "friction", "members", "reference", "versions", "machine")
        kinds[kind] = {name: data[name] for name in kept}
        kinds[kind] |= {"quantity": quantity, "rows": sorted(rows, key=lambda item: item["seconds"])}
    return {"kinds": kinds}


def _assignments(setting: dict[str, Any]) -> list[str]:
    from lammps_jump.studies.bench.settings import Setting

    return [text for text in Setting(**setting).assignments(1.0) if not text.startswith("engine.ranks")]


def main(arguments: list[str]) -> None:
    """Write ``calibration.json`` from the benchmark files named; kinds not named are kept."""
    old = json.loads(STORE.read_text())["kinds"] if STORE.is_file() else {}
    new = make_store(json.loads(Path(name).read_text()) for name in arguments)["kinds"]
    STORE.write_text(json.dumps({"kinds": old | new}, indent=1) + "\n")
    found = ", ".join(f"{kind} ({len(entry['rows'])} settings)" for kind, entry in (old | new).items())
    print(f"{STORE.name}: {found}")


if __name__ == "__main__":
    import sys

    main(sys.argv[1:])
