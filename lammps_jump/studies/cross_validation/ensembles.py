"""Ensembles: one scene from slightly different starts, each run reduced to profiles and series and kept on disk.

Two runs of a chaotic flow never agree disc by disc for long; what they can share is the statistics over starts that
nobody could tell apart.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.engines.result import ProgressCallback, RunResult
from lammps_jump.errors import RunError, RunInterrupted
from lammps_jump.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

JITTER = 1e-6
"""Start positions move by up to this many diameters, row speeds by up to this share of themselves."""
REDUCTION = 3
"""Counts up when what is kept of a run changes; older results are then made anew."""

LAMMPS_NAMES = {"stock": "lammps_stock", "compiled": "lammps_compiled"}


@dataclass(frozen=True)
class EngineChoice:
    """Who computes: 'native', or 'lammps' with a kernel (and its plugin)."""

    name: str
    kernel: str = "numba"
    plugin: Path | None = None

    @property
    def label(self) -> str:
        """Short name for folders and tables."""
        return "native" if self.name == "native" else LAMMPS_NAMES[self.kernel]


@dataclass(frozen=True)
class Member:
    """What is kept of one run.

    Attributes
    ----------
    seed : int
    engine : str
    profiles : xarray.Dataset
        Of `analysis.profiles.compute_profiles`.
    series : dict of ndarray, shape (frames,)
        time (s), discs, kinetic, gravitational, elastic (J/m), front, front_99 (m).
    forces : dict of str to ndarray, shape (windows, 4)
        time, fx, fy, moment by structure.
    result : dict
        The engine's `RunResult`.
    fresh : bool
        Computed now, not read from disk.
    """

    seed: int
    engine: str
    profiles: xr.Dataset
    series: dict[str, np.ndarray]
    forces: dict[str, np.ndarray]
    result: dict[str, Any]
    fresh: bool


def perturbed(scene: Scene, seed: int, jitter: float = JITTER) -> Scene:
    """The scene from a start nobody could tell from its own; seed 0 is the scene itself.

    Positions of discs at the start move by uniform random numbers in ± jitter d, the speed of every inlet row by a
    factor 1 ± jitter. Nothing else changes: both engines get the same numbers.
    """
    if seed == 0:
        return scene
    rng = np.random.default_rng(seed)
    positions = scene.positions + rng.uniform(-jitter, jitter, scene.positions.shape) * scene.diameter
    positions.setflags(write=False)
    inlets = tuple(replace(row, vx=row.vx * (1.0 + rng.uniform(-jitter, jitter))) for row in scene.inlets)
    return replace(scene, positions=positions, inlets=inlets)


def _digest(*parts: bytes) -> str:
    found = hashlib.sha256()
    for part in parts:
        found.update(part)
        found.update(b"\0")
    return found.hexdigest()[:12]


REDUCING = (
    "profiles", "profile_kernels", "front", "energy", "contact_sums", "contacts", "cell_grid", "flow",
)  # fmt: skip
"""Modules of the analysis that make a member's numbers."""


def _sources(package: str, names: tuple[str, ...] | None = None) -> bytes:
    folder = Path(__import__(package, fromlist=["_"]).__file__).parent
    files = sorted(folder.glob("*.py")) if names is None else [folder / f"{name}.py" for name in names]
    return b"".join(file.read_bytes() for file in files)


def member_key(scene: Scene, engine: EngineChoice, bin_width: float | None, window) -> str:
    """Hash of all that a member's result depends on: the scene's numbers, the engine's code, the reduction's code."""
    from lammps_jump.engines.lammps.loader import wheel_version
    from lammps_jump.script.assemble import data_text, script_text

    reduction = _sources("lammps_jump.analysis", REDUCING)
    common = f"{REDUCTION} {bin_width} {window}".encode()
    # the script holds every number that LAMMPS sees; the native engine gets the same scene
    numbers = script_text(scene, kernel="compiled", dump_format="binary").encode() + data_text(scene).encode()
    numbers += f"{scene.integrator} {scene.friction_law} {scene.steps} {scene.output_steps}".encode()
    if engine.name == "native":
        code = _sources("lammps_jump.engines.native")
    else:
        # the plugin's folder is named after the hash of its sources, compiler and flags
        code = f"{wheel_version()} {engine.kernel} {engine.plugin or ''}".encode()
        code += script_text(scene, kernel=engine.kernel, dump_format="binary").encode()
    return _digest(common, reduction, numbers, code)


def run_member(
    scene: Scene,
    seed: int,
    engine: EngineChoice,
    store: Path,
    *,
    bin_width: float | None = None,
    window: tuple[float, float] | None = None,
    label: str = "",
    progress: ProgressCallback | None = None,
) -> Member:
    """Run one member, or read it from `store` where it is there already.

    Parameters
    ----------
    scene : Scene
        Unperturbed.
    seed : int
        Of `perturbed`.
    engine : EngineChoice
    store : Path
        Folder of finished members: ``<label or engine>_<seed>_<hash>/``.
    bin_width, window
        For the profiles.

    Raises
    ------
    RunError
        Where the run did not complete.
    """
    start = perturbed(scene, seed)
    name = label or engine.label
    place = store / f"{name}_{seed}_{member_key(start, engine, bin_width, window)}"
    if (place / "result.json").exists():
        return read_member(place, seed, name)
    store.mkdir(parents=True, exist_ok=True)
    for old in store.glob(f"{name}_{seed}_*"):
        shutil.rmtree(old, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="running-", dir=store) as work:
        folder = Path(work) / "run"
        folder.mkdir()
        result = run_engine(start, engine, folder, progress)
        if result.status == "interrupted":
            raise RunInterrupted(
                f"ended in {name}, member {seed}; finished members are kept in {store}: the same command goes on there"
            )
        if result.status != "complete":
            raise RunError(f"{name}, member {seed}: {result.message}")
        kept = Path(work) / "kept"
        kept.mkdir()
        reduce_run(start, folder, kept, bin_width, window)
        numbers = {key: getattr(result, key) for key in ("engine", "kernel", "steps", "disc_steps", "seconds")}
        numbers |= {key: getattr(result, key) for key in ("inserted", "present", "removed", "lost", "ledger")}
        (kept / "result.json").write_text(json.dumps({"seed": seed, **numbers}, indent=1))
        kept.rename(place)
    return replace(read_member(place, seed, name), fresh=True)


def run_engine(scene: Scene, engine: EngineChoice, folder: Path, progress: ProgressCallback | None) -> RunResult:
    """Run a scene on the chosen engine with a binary dump in `folder`."""
    if engine.name == "native":
        from lammps_jump.engines.native import run_native

        return run_native(scene, folder, progress=progress, dump_format="binary")
    from lammps_jump.engines.launch import Setting, run

    setting = Setting(kernel=engine.kernel, plugin=engine.plugin, dump_format="binary")
    return run(scene, folder, setting, progress=progress)


def reduce_run(
    scene: Scene, folder: Path, kept: Path, bin_width: float | None, window: tuple[float, float] | None
) -> None:
    """One pass over a run's dump; writes ``profiles.nc``, ``series.npz`` and ``forces.npz`` into `kept`."""
    from lammps_jump.analysis.energy import EnergyLedger
    from lammps_jump.analysis.flow import from_scene
    from lammps_jump.analysis.front import FrontTracker
    from lammps_jump.analysis.profiles import compute_profiles, write_profiles
    from lammps_jump.dump.find import read_forces
    from lammps_jump.dump.read import open_dump

    context = from_scene(scene, bin_width=bin_width, window=window)
    front, energy = FrontTracker(context), EnergyLedger(context)
    discs: list[int] = []

    def frames() -> Iterator:
        for frame in open_dump(next(folder.glob("dump.*"))):
            time = context.time(frame)
            front.add(frame, time)
            energy.add(frame, time)
            discs.append(frame.n)
            yield frame

    write_profiles(compute_profiles(frames(), context), kept / "profiles.nc")
    fronts, energies = front.result(), energy.result()
    elastic = energies.elastic if energies.elastic is not None else np.zeros_like(energies.time)
    np.savez_compressed(
        kept / "series.npz",
        time=energies.time,
        discs=np.array(discs),
        kinetic=energies.kinetic + energies.rotational,
        gravitational=energies.potential,
        elastic=elastic,
        front=fronts.bulk + fronts.back,
        front_99=fronts.quantile + fronts.back,
    )
    forces = read_forces(folder / "forces.csv") if (folder / "forces.csv").exists() else {}
    tables = {name: np.column_stack([f.time, f.fx, f.fy, f.moment]) for name, f in forces.items()}
    np.savez_compressed(kept / "forces.npz", **tables)


def read_member(place: Path, seed: int, engine: str) -> Member:
    """A member from its folder."""
    from lammps_jump.analysis.profiles import read_profiles

    with np.load(place / "series.npz") as data:
        series = {name: data[name] for name in data.files}
    with np.load(place / "forces.npz") as data:
        forces = {name: data[name] for name in data.files}
    result = json.loads((place / "result.json").read_text())
    return Member(seed, engine, read_profiles(place / "profiles.nc"), series, forces, result, False)


def run_ensemble(
    scene: Scene,
    seeds: list[int],
    engine: EngineChoice,
    store: Path,
    *,
    bin_width: float | None = None,
    window: tuple[float, float] | None = None,
    label: str = "",
    before: Callable[[str, int], ProgressCallback | None] | None = None,
    after: Callable[[Member], None] | None = None,
) -> list[Member]:
    """All members of an ensemble, finished ones read from `store`; `before` and `after` tell how it goes."""
    members = []
    for seed in seeds:
        progress = before(label or engine.label, seed) if before else None
        member = run_member(
            scene, seed, engine, store, bin_width=bin_width, window=window, label=label, progress=progress
        )
        if after:
            after(member)
        members.append(member)
    return members
