# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a case with one setting from one slightly moved start, timed and measured."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import xarray as xr

from lammps_jump import Case
from lammps_jump.analysis.energy import EnergyHistory, EnergyLedger, analyse_energy
from lammps_jump.analysis.flow import Flow, from_scene
from lammps_jump.analysis.front import FrontHistory, FrontTracker, analyse_front
from lammps_jump.analysis.jump.result import analyse_jump
from lammps_jump.analysis.jump.summary import summarise_jump
from lammps_jump.analysis.passes import feed
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.case import CaseFields
from lammps_jump.dump.find import ForceHistory, read_dump, read_forces
from lammps_jump.errors import DumpError, JumpError
from lammps_jump.files import plain
from lammps_jump.scene.scene import Scene
from lammps_jump.units import as_summary

from .runs import execute
from .settings import Setting

JITTER = 1e-6
"""Shift of a start, in diameters, and of row speeds, as a share: small enough to change no mean, large enough that
chaos makes runs independent."""

CURVE_POINTS = 20
JUMP_NUMBERS = (
    "froude", "y1", "y2", "sequent_ratio", "belanger_ratio", "density_ratio", "length", "length_over_y2", "length_usbr",
    "speed", "speed_error", "packing_1", "packing_2",
)  # fmt: skip
"""What the studies of sensitivity keep of a jump, in the words of ``summary.json``."""

Measure = float | str | list[float] | dict[str, float | None] | None


@dataclass(frozen=True)
class Measured:
    """A run, as the studies store it.

    Attributes
    ----------
    status : {'complete', 'failed', 'refused'}
    message : str
        Why the run is not complete, or not analysed.
    measures : dict of str
        Numbers and curves by name; ``verdict`` and ``jump`` where the case asks for the jump.
    cpu_seconds, wall_seconds : float or None
        Time of the engine, s; None for a refused case.
    steps : int
    disc_steps : float
    breakdown : dict of str to float
        Seconds by kind of work.
    """

    status: str
    message: str
    measures: dict[str, Measure] = field(default_factory=dict)
    cpu_seconds: float | None = None
    wall_seconds: float | None = None
    steps: int = 0
    disc_steps: float = 0.0
    breakdown: dict[str, float] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        """Whether the run came to its end."""
        return self.status == "complete"

    @property
    def verdict(self) -> str:
        """Verdict of the jump analysis; empty without one."""
        return self.measures.get("verdict") or ""

    @property
    def jump(self) -> dict[str, float | None] | None:
        """Numbers of the jump, None where none was found."""
        return self.measures["jump"] if self.verdict == "jump" else None


def moved_start(case: Case, member: int) -> Case:
    """Return the case with the start of member `member` of an ensemble: another seed and a shift of `JITTER` diameters.

    Discs at the start move at random. Inflow rows enter so much higher.
    """
    fields = case.fields
    changes: dict[str, object] = {"run.seed": fields.run.seed + member}
    changes |= {f"initial.{i}.jitter": max(item.jitter, JITTER) for i, item in enumerate(fields.initial)}
    if fields.inflow is not None and fields.inflow.kind == "rows" and member:
        changes["inflow.y"] = fields.inflow.y + member * JITTER * fields.discs.diameter
    return case.replace(changes)


def perturbed(scene: Scene, seed: int, jitter: float = JITTER) -> Scene:
    """Return a copy of the scene with its start shifted by at most `jitter` diameters; seed 0 is the scene itself.

    Positions of discs at the start move by uniform random numbers in ± jitter d. The speed of every inlet row changes
    by a factor 1 ± jitter. Both engines get the same numbers.
    """
    if seed == 0:
        return scene
    rng = np.random.default_rng(seed)
    positions = scene.positions + rng.uniform(-jitter, jitter, scene.positions.shape) * scene.diameter
    positions.setflags(write=False)
    inlets = tuple(replace(row, vx=row.vx * (1.0 + rng.uniform(-jitter, jitter))) for row in scene.inlets)
    return replace(scene, positions=positions, inlets=inlets)


def run_setting(case: Case, setting: Setting, member: int) -> Measured:
    """Run a case with a setting from start number `member`, and measure what it asks for.

    Raises
    ------
    CaseError
        The case itself cannot be used.
    RunInterrupted
        The user ended the run.
    """
    try:
        changed = moved_start(case.replace(setting.changes(case.fields.discs.diameter)), member)
        scene = changed.scene()
    except JumpError as error:
        return Measured("refused", str(error))
    with tempfile.TemporaryDirectory() as folder:
        result = execute(scene, Path(folder), setting.kernel, ranks=setting.ranks)
        measures: dict[str, Measure] = {}
        message = result.message
        if result.status == "complete":
            try:
                measures = measure(Path(folder), scene, changed.fields)
            except DumpError as error:
                message = str(error)
    message = message.replace(str(folder), "the run folder")
    return Measured(
        result.status, message, measures, result.cpu_seconds, result.seconds, result.steps, result.disc_steps,
        dict(result.breakdown),
    )  # fmt: skip


@dataclass(frozen=True)
class Observed:
    """What one pass over the frames of a run has left; `forces` by structure."""

    profiles: xr.Dataset
    energy: EnergyHistory
    front: FrontHistory
    forces: dict[str, ForceHistory]


def observe(folder: Path, flow: Flow) -> Observed:
    """Read the dump of a run once, and its forces where it has some."""
    front, energy, table = FrontTracker(flow), EnergyLedger(flow), folder / "forces.csv"
    profiles = compute_profiles(feed(read_dump(folder), flow, [front, energy]), flow)
    return Observed(profiles, energy.result(), front.result(), read_forces(table) if table.is_file() else {})


def measure(folder: Path, scene: Scene, case: CaseFields) -> dict[str, Measure]:
    """Return what a case asks of a run, as numbers and curves: energy, front, jump, impulse on structures."""
    asked = case.analysis
    flow = from_scene(scene, bin_width=asked.bin_width, window=asked.window)
    seen = observe(folder, flow)
    measures: dict[str, Measure] = {}
    if asked.energy:
        measures["energy deviation"] = plain(analyse_energy(seen.energy, flow).max_deviation)
    if asked.front:
        times = np.linspace(0.1, 1.0, CURVE_POINTS) * case.run.duration
        measures["front position"] = np.interp(times, seen.front.time, seen.front.quantile).tolist()
        measures["column height"] = np.interp(times, seen.front.time, seen.front.height).tolist()
        moyce = analyse_front(seen.front, flow).martin_moyce
        measures["martin_moyce"] = moyce and plain(as_summary(moyce))
    if asked.jump:
        depth = seen.profiles["mass_depth_mean"].values
        summary = plain(as_summary(summarise_jump(analyse_jump(seen.profiles, flow))))
        measures |= {
            "depth profile": np.nan_to_num(depth, posinf=0.0, neginf=0.0).tolist(),
            "sequent depth": summary["y2"],
            "shock speed": summary["speed"],
            "verdict": summary["verdict"],
            "jump": {name: summary.get(name) for name in JUMP_NUMBERS},
        }
    for name, force in seen.forces.items() if scene.probes else ():
        total = np.hypot(force.fx.sum(), force.fy.sum())
        measures[f"impulse {name}"] = float(total * (scene.probe_steps * scene.time_step))
    return measures
