# SPDX-License-Identifier: GPL-2.0-or-later
"""Ensembles: one scene from slightly different starts, each run reduced to profiles and series and kept on disk.

Two runs of a chaotic flow never agree disc by disc for long. What they can share is the statistics over starts that
differ by less than any measurement shows.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import xarray as xr

from lammps_jump import analysis
from lammps_jump.analysis.energy import EnergyLedger
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.front import FrontTracker
from lammps_jump.analysis.passes import feed
from lammps_jump.analysis.profiles import compute_profiles, read_profiles, write_profiles
from lammps_jump.dump.find import read_dump, read_forces
from lammps_jump.engines import native
from lammps_jump.engines.lammps.loader import wheel_version
from lammps_jump.engines.plugin.build import plugin_path
from lammps_jump.engines.result import ProgressCallback
from lammps_jump.errors import RunError, RunInterrupted
from lammps_jump.files import write_json
from lammps_jump.scene.scene import Scene
from lammps_jump.script.assemble import data_text, script_text
from lammps_jump.studies.runs import execute

JITTER = 1e-6
"""Start positions move by up to this many diameters, row speeds by up to this share of themselves."""
REDUCTION = 3
"""Counts up when what is kept of a run changes; older results are then made anew."""
LABELS = {"stock": "lammps_stock", "compiled": "lammps_compiled", "native": "native"}
"""Name of an ensemble in folders and tables, by kernel."""


@dataclass(frozen=True)
class RunNumbers:
    """Numbers of an engine's `RunResult` that are kept of a run, with its seed."""

    seed: int
    engine: str
    kernel: str
    steps: int
    disc_steps: float
    seconds: float
    inserted: int
    present: int
    removed: int
    lost: int
    ledger: dict[str, float] | None


@dataclass(frozen=True)
class Member:
    """What is kept of one run.

    Attributes
    ----------
    name : str
        Of its ensemble.
    profiles : xarray.Dataset
        Of `analysis.profiles.compute_profiles`.
    series : dict of ndarray, shape (frames,)
        time (s), discs, kinetic, gravitational, elastic (J/m), front, front_99 (m).
    forces : dict of str to ndarray, shape (windows, 4)
        time, fx, fy, moment by structure.
    result : RunNumbers
    fresh : bool
        Computed now, not read from disk.
    """

    name: str
    profiles: xr.Dataset
    series: dict[str, np.ndarray]
    forces: dict[str, np.ndarray]
    result: RunNumbers
    fresh: bool = False


@dataclass(frozen=True)
class Binning:
    """Width of a profile's bins (m) and window of its means (s); None for the default of the analysis."""

    bin_width: float | None = None
    window: tuple[float, float] | None = None


@dataclass(frozen=True)
class Ensemble:
    """Runs of one scene from several starts.

    Attributes
    ----------
    scene : Scene
        Unperturbed.
    kernel : {'stock', 'compiled', 'native'}
    store : Path
        Folder of finished members: ``<name>_<seed>_<hash>/``.
    binning : Binning
    label : str
        Name; default that of `LABELS`.
    """

    scene: Scene
    kernel: str
    store: Path
    binning: Binning = Binning()
    label: str = ""

    @property
    def name(self) -> str:
        """Name in folders and tables."""
        return self.label or LABELS[self.kernel]


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


def _sources(package) -> bytes:
    """Return the source text of a folder of this package."""
    return b"".join(path.read_bytes() for path in sorted(Path(package.__path__[0]).glob("*.py")))


def member_key(scene: Scene, kernel: str, binning: Binning) -> str:
    """Return the hash of all that a member depends on: the numbers of the scene, the code of engine and reduction."""
    # the script holds every number that LAMMPS sees; the native engine gets the same scene
    numbers = script_text(scene, kernel="compiled", dump_format="binary") + data_text(scene)
    numbers += f"{scene.integrator} {scene.friction_law} {scene.steps} {scene.output_steps}"
    if kernel == "native":
        code = _sources(native)
    else:
        # the folder of the plugin is named after the hash of its sources, compiler and flags
        plugin = plugin_path() if kernel == "compiled" else ""
        code = f"{wheel_version()} {kernel} {plugin}{script_text(scene, kernel=kernel, dump_format='binary')}".encode()
    found = hashlib.sha256()
    for part in (f"{REDUCTION} {binning}".encode(), _sources(analysis), numbers.encode(), code):
        found.update(part + b"\0")
    return found.hexdigest()[:12]


def run_member(ensemble: Ensemble, seed: int, progress: ProgressCallback | None = None) -> Member:
    """Run the member with a seed, or read it from the store where it is there already.

    Raises
    ------
    RunError
        Where the run did not complete.
    """
    start, name, store = perturbed(ensemble.scene, seed), ensemble.name, ensemble.store
    place = store / f"{name}_{seed}_{member_key(start, ensemble.kernel, ensemble.binning)}"
    if (place / "result.json").exists():
        return read_member(place, name)
    store.mkdir(parents=True, exist_ok=True)
    for old in store.glob(f"{name}_{seed}_*"):
        shutil.rmtree(old, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="running-", dir=store) as work:
        folder, kept = Path(work) / "run", Path(work) / "kept"
        folder.mkdir()
        kept.mkdir()
        result = execute(start, folder, ensemble.kernel, dump_format="binary", progress=progress)
        if result.status == "interrupted":
            raise RunInterrupted(
                f"ended in {name}, member {seed}; finished members are kept in {store}: the same command continues"
            )
        if result.status != "complete":
            raise RunError(f"{name}, member {seed}: {result.message}")
        reduce_run(start, folder, kept, ensemble.binning)
        numbers = RunNumbers(seed, *(getattr(result, one.name) for one in fields(RunNumbers)[1:]))
        write_json(kept / "result.json", numbers)
        kept.rename(place)
    return replace(read_member(place, name), fresh=True)


def reduce_run(scene: Scene, folder: Path, kept: Path, binning: Binning) -> None:
    """Read the dump of a run once; write ``profiles.nc``, ``series.npz`` and ``forces.npz`` into `kept`."""
    flow = from_scene(scene, bin_width=binning.bin_width, window=binning.window)
    front, energy = FrontTracker(flow), EnergyLedger(flow)
    frames = feed(read_dump(folder), flow, [front, energy])
    write_profiles(compute_profiles(frames, flow), kept / "profiles.nc")
    fronts, energies = front.result(), energy.result()
    np.savez_compressed(
        kept / "series.npz",
        time=energies.time,
        discs=energies.discs,
        kinetic=energies.kinetic + energies.rotational,
        gravitational=energies.potential,
        elastic=energies.elastic if energies.elastic is not None else np.zeros_like(energies.time),
        front=fronts.bulk + fronts.back,
        front_99=fronts.quantile + fronts.back,
    )
    forces = read_forces(folder / "forces.csv") if (folder / "forces.csv").exists() else {}
    tables = {name: np.column_stack([f.time, f.fx, f.fy, f.moment]) for name, f in forces.items()}
    np.savez_compressed(kept / "forces.npz", **tables)


def read_member(place: Path, name: str) -> Member:
    """Return a member from its folder."""
    with np.load(place / "series.npz") as series, np.load(place / "forces.npz") as forces:
        result = RunNumbers(**json.loads((place / "result.json").read_text()))
        return Member(name, read_profiles(place / "profiles.nc"), dict(series), dict(forces), result)
