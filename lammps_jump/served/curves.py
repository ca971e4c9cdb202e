# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves of a run so far: depth at gauges, force on structures, energy. The analyses are those of the report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from lammps_jump.analysis.budgets import energy
from lammps_jump.analysis.devices import waves
from lammps_jump.analysis.draw.chart import Chart
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.forces import figures as forces
from lammps_jump.analysis.passes import Collector, Gathered
from lammps_jump.analysis.profiles import Binner, add_means
from lammps_jump.case.case import ReadCase
from lammps_jump.dump.find import ForceHistory, forces_of, read_forces
from lammps_jump.engines.lammps.finish import forces_text
from lammps_jump.errors import DumpError
from lammps_jump.files import plain

PATIENCE = 1.0
"""Seconds after which curves are made again of what has come."""
PLACES = (0.25, 0.5, 0.75)
"""Of the channel, where the depth is followed if the case has no gauges."""
TITLES = {
    "gauges": "Depth",
    "forces": "Force on the structures",
    "energy": "Energy of the discs, that of contacts left out",
}


class SoFar:
    """Collects what the curves of a run are made of.

    Attributes
    ----------
    collectors : list of Collector
        To be shown every frame.
    """

    def __init__(self, case: ReadCase, flow: Flow, folder: Path):
        scene, (low, high) = flow.scene, flow.x_range
        places = scene.gauges or tuple(float(np.round(low + part * (high - low), 3)) for part in PLACES)
        self.flow = replace(flow, scene=replace(scene, gauges=places))
        self.folder, self.engine = folder, case.fields.engine.name
        self.binner = Binner(flow)
        # elastic energy needs the contacts of every frame: the report has it
        self.energy = energy.EnergyLedger(flow, elastic=False)
        self.collectors: list[Collector] = [self.binner, self.energy]
        self._made: list[dict[str, Any]] = []
        self._made_at, self._of = 0.0, -1

    def curves(self, *, live: bool) -> list[dict[str, Any]]:
        """Title, key and described curve (or the reason why it is absent) of each; made again when it is time to."""
        count = self.binner.frames
        if count == self._of or (live and perf_counter() - self._made_at < PATIENCE and self._made):
            return self._made
        self._made_at, self._of = perf_counter(), count
        self._made = self._make(live) if count else []
        return self._made

    def _make(self, live: bool) -> list[dict[str, Any]]:
        profiles, absent = add_means(self.binner.result()), ""
        records: dict[str, ForceHistory] = {}
        try:
            records = self._forces()
        except (DumpError, OSError) as error:
            absent = str(error)
        if not records and self.flow.scene.probes:
            late = self.engine != "lammps" and live
            absent = absent or f"the {self.engine} engine writes forces at its end" if late else "no force yet"
        history = self.energy.result()
        gathered = Gathered(self.flow, profiles, None, {"energy": history}, records)
        shown: dict[str, Any] = {}
        if found := waves.analyse(gathered):
            shown |= waves.figures(found, gathered)
        if records and (pushed := forces.analyse(gathered)):
            shown["forces"] = forces.history_chart(pushed)
            absent = "" if shown["forces"] else "nothing has touched them so far"
        shown["energy"] = energy.energy_chart(energy.analyse_energy(history, self.flow))
        charts = [
            {"key": name, "title": TITLES[name], "chart": plain(shown[name].plain)}
            for name in TITLES
            if isinstance(shown.get(name), Chart)
        ]
        return charts + ([{"key": "forces", "title": TITLES["forces"], "absent": absent}] if absent else [])

    def _forces(self) -> dict[str, ForceHistory]:
        """Rows of forces so far: LAMMPS writes a file a structure, of which one is made at the end."""
        table = self.folder / "forces.csv"
        if table.is_file():
            return read_forces(table)
        if not self.flow.scene.probes:
            return {}
        return forces_of(forces_text(self.flow.scene, self.folder), table)
