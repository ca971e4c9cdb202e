"""``lammps-jump check``: every derived number of a case, and what the run will leave out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from lammps_jump.case.derived import as_data, as_text
from lammps_jump.case.to_scene import build_scene
from lammps_jump.engines.accuracy import load_with_accuracy


def check_case(path: Path, assignments: list[str], *, as_json: bool = False) -> str:
    """Text (or JSON) of the table; raises as `load_case` and `build_scene` do."""
    loaded, chosen = load_with_accuracy(path, assignments)
    scene = build_scene(loaded)
    scene = replace(scene, warnings=(*scene.warnings, *chosen))
    if as_json:
        return json.dumps(as_data(loaded.case, scene), indent=2, allow_nan=False)
    return as_text(loaded.case, scene)
