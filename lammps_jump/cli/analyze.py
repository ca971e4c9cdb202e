"""``lammps-jump analyze`` and ``animate``: a run folder, or anybody's dump."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from lammps_jump.errors import CaseError
from lammps_jump.runs.start import Say


def analyze_target(
    target: Path,
    *,
    out: Path | None,
    case: Path | None,
    diameter: float | None,
    density: float | None,
    bin_width: float | None,
    assignments: list[str],
    quiet: bool,
    say: Say,
) -> dict[str, Any]:
    """Analyse; returns the numbers found, which are also in ``summary.json`` of the folder of results.

    Raises
    ------
    CaseError, DumpError
        Also where an option is given that has no meaning for the target.
    """
    _positive("--bin-width", bin_width, "m")
    if target.is_dir() and (target / "case.yaml").exists():
        from lammps_jump.runs.reopen import reanalyse

        from .display import print_summary

        for option, value in {"--out": out, "--case": case, "--diameter": diameter, "--density": density}.items():
            if value is not None:
                raise CaseError(
                    f"{option} {value}: {target} is a run folder, whose case says all that and whose results stay in "
                    f"it; {option} goes with a bare dump: name the dump file itself to analyse it as one"
                )
        sets = [*assignments, *([f"analysis.bin_width={bin_width}"] if bin_width else [])]
        summary = reanalyse(target, sets, quiet)
        if not quiet:
            print_summary(summary, target)
        return summary
    return _bare_dump(target, out, case, diameter, density, bin_width, assignments, say)


def _positive(option: str, value: float | None, unit: str) -> None:
    if value is not None and not 0 < value < float("inf"):
        raise CaseError(f"{option} {value}: allowed is > 0 {unit}")


def _bare_dump(target, out, case, diameter, density, bin_width, assignments, say) -> dict[str, Any]:
    from lammps_jump.analysis.flow import from_scene
    from lammps_jump.analysis.guess import from_dump
    from lammps_jump.analysis.quantities import analyse
    from lammps_jump.case.checks import MOST_BINS
    from lammps_jump.dump.find import find_dump
    from lammps_jump.dump.read import open_dump
    from lammps_jump.runs.summary import write_summary

    path = find_dump(target)
    _positive("--diameter", diameter, "m")
    _positive("--density", density, "kg/m^3")
    if case is None and assignments:
        raise CaseError(f"--set {assignments[0]}: changes a case, and a bare dump has none; name it with --case")
    for option, value in {"--diameter": diameter, "--density": density}.items():
        if case is not None and value is not None:
            raise CaseError(f"{option} {value}: {case} says it; leave out one of --case and {option}")
    if case is not None:
        from lammps_jump.case import load_case
        from lammps_jump.case.to_scene import build_scene

        flow = from_scene(build_scene(load_case(case, assignments)))
    else:
        flow = from_dump(open_dump(path), diameter=diameter, density=1000.0 if density is None else density)
    low, high = flow.x_range
    if bin_width is not None and not (high - low) / MOST_BINS <= bin_width <= high - low:
        raise CaseError(
            f"--bin-width {bin_width}: allowed is {(high - low) / MOST_BINS:.2g} to {high - low:.4g} m, the length of "
            f"the channel in {path}"
        )
    folder = out or path.parent / f"{path.name.split('.')[0]}_analysis"
    parts = analyse(replace(flow, bin_width=bin_width or flow.bin_width), path, folder, ("jump", "front"))
    write_summary(folder, {"name": path.name, **parts})
    for note in parts["warnings"]:  # what was guessed is among them
        say(f"note: {note}")
    say(f"results are in {folder}")
    return parts


def animate_target(target: Path, out: Path | None, fps: int, say: Say = print) -> Path:
    """Write the moving picture of a folder or dump; returns its path."""
    from lammps_jump.analysis.draw.film import NO_FFMPEG, animate
    from lammps_jump.analysis.flow import from_scene
    from lammps_jump.analysis.guess import from_dump
    from lammps_jump.dump.find import find_dump, read_forces
    from lammps_jump.dump.read import open_dump

    if not 1 <= fps <= 120:
        raise CaseError(f"--fps {fps}: allowed is 1 to 120")
    path = find_dump(target)
    dump = open_dump(path)
    forces = None
    if (path.parent / "case.yaml").exists():
        from lammps_jump.case import load_case
        from lammps_jump.case.to_scene import build_scene

        flow = from_scene(build_scene(load_case(path.parent / "case.yaml")))
        if (path.parent / "forces.csv").exists():
            forces = read_forces(path.parent / "forces.csv")
    else:
        flow = from_dump(dump)
    destination = out or path.parent / "animation.mp4"
    written = animate(dump, flow, destination, fps=fps, forces=forces)
    if written != destination:
        say(f"note: {NO_FFMPEG}")
    return written
