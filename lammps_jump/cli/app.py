"""Command line: options and their help; the work is done in the modules each command imports when it is called."""

from __future__ import annotations

import gc
import sys
from pathlib import Path
from typing import Annotated

import typer

from lammps_jump.engines import plugin
from lammps_jump.errors import CaseError, JumpError, SetupError
from lammps_jump.studies.table import show

from .early import start_engine_early
from .streams import patient_output

app = typer.Typer(
    name="lammps-jump",
    help="Free-surface flow with discs: one YAML case in; a LAMMPS script, a run, profiles, figures and a report out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(wanted: bool) -> None:
    if wanted:
        from lammps_jump.provenance import versions

        print(f"lammps-jump {versions().get('lammps_jump', '?')}")
        raise typer.Exit()


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Free-surface flow with discs: one YAML case in; a LAMMPS script, a run, profiles, figures and a report out."""
    try:
        Path.cwd()
    except FileNotFoundError:
        raise SetupError("the current folder is no longer there; `cd` into one that is, and try again") from None


def _folder(text: str) -> Path:
    """A folder or file of ``--out``; an empty text (an unset variable of a shell) would be the current folder."""
    if not text.strip():
        raise typer.BadParameter("an empty text names no place; `--out .` is the current folder")
    return Path(text)


CaseFile = Annotated[
    Path, typer.Argument(help="Case file (YAML); inputs/ holds one for each scene.", show_default=False)
]
Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="Change one value: path=value, list items by index or name. May be repeated.",
        metavar="PATH=VALUE",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out", parser=_folder, metavar="PATH", help="Folder for the results (default: runs/<name of the case>)."
    ),
]
EngineName = Annotated[str | None, typer.Option("--engine", help="lammps or native.")]
Kernel = Annotated[str | None, typer.Option("--kernel", help="auto, stock or compiled (LAMMPS only).")]
Ranks = Annotated[str | None, typer.Option("--ranks", help="Number of MPI ranks, or auto.")]
Accuracy = Annotated[
    str | None,
    typer.Option("--accuracy", help="Cheapest setting shown to meet it, such as 1% (see docs/benchmark.md)."),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no notes; errors only.")]
QuietStudy = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no notes; only what was found.")]
Resume = Annotated[
    bool,
    typer.Option("--resume", help="Go on with the interrupted run in the folder; frames and sums are of the whole."),
]
Force = Annotated[bool, typer.Option("--force", help="Run even where the folder already holds this result.")]


def _say(quiet: bool):
    return (lambda text: None) if quiet else (lambda text: print(text, flush=True))


def _assignments(
    sets: list[str] | None,
    engine: str | None = None,
    kernel: str | None = None,
    ranks: str | None = None,
    accuracy: str | None = None,
) -> list[str]:
    chosen = [
        f"engine.{key}={value}"
        for key, value in (("name", engine), ("kernel", kernel), ("ranks", ranks))
        if value is not None
    ]
    if accuracy is not None:
        chosen.append(f"run.accuracy={accuracy}")
    return [*(sets or []), *chosen]


@app.command("build-and-run")
def build_and_run(
    case: CaseFile,
    out: Out = None,
    engine: EngineName = None,
    kernel: Kernel = None,
    ranks: Ranks = None,
    accuracy: Accuracy = None,
    set_: Sets = None,
    force: Force = False,
    resume: Resume = False,
    live: Annotated[bool, typer.Option("--live", help="Show the run as it goes: a window, and live.png.")] = False,
    quiet: Quiet = False,
) -> None:
    """The whole job: validate, write the script, run, analyse, report."""
    from lammps_jump.runs.resume import resume_case
    from lammps_jump.runs.start import build_and_run as start

    from .display import print_summary

    if resume and force:
        raise CaseError("--resume goes on with a run, --force starts it anew: use one of the two")
    options = {"out": out, "assignments": _assignments(set_, engine, kernel, ranks, accuracy)}
    options |= {"quiet": quiet, "live": live, "say": _say(quiet)}
    summary = resume_case(case, **options) if resume else start(case, force=force, **options)
    if not quiet:
        print_summary(summary, out or Path("runs") / summary["name"])


@app.command()
def build(
    case: CaseFile,
    out: Out = None,
    kernel: Kernel = None,
    ranks: Ranks = None,
    set_: Sets = None,
    slurm: Annotated[bool, typer.Option("--slurm", help="Also write a job file for a SLURM cluster.")] = False,
) -> None:
    """Write the run folder (case and LAMMPS script) and stop there."""
    from lammps_jump.runs import start as pipeline

    prepared = pipeline.prepare(case, _assignments(set_, None, kernel, ranks), out)
    pipeline.write_folder(prepared)
    if slurm:
        from lammps_jump.engines.lammps.job import write_job

        print(f"job file: {write_job(prepared.scene, prepared.folder, prepared.ranks)}")
    script = (prepared.folder / "in.lammps").exists()
    there = ", or there with `lmp -in in.lammps`" if script else ""
    print(f"{prepared.folder}: run it with `lammps-jump run {prepared.folder}`{there}")


@app.command()
def run(
    folder: Annotated[Path, typer.Argument(help="Folder made by `lammps-jump build`.", show_default=False)],
    resume: Resume = False,
    quiet: Quiet = False,
) -> None:
    """Run a built folder and analyse it."""
    from lammps_jump.runs import start as pipeline
    from lammps_jump.runs.reopen import reopen
    from lammps_jump.runs.resume import resume_prepared

    from .display import print_summary

    prepared = reopen(folder)
    if resume:
        summary = resume_prepared(prepared, quiet=quiet, say=_say(quiet))
    else:
        pipeline.write_folder(prepared)
        summary = pipeline.run_folder(prepared, build_seconds=0.0, quiet=quiet, say=_say(quiet))
    if not quiet:
        print_summary(summary, folder)


@app.command()
def analyze(
    target: Annotated[Path, typer.Argument(help="Run folder, or any LAMMPS custom dump with x y.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", parser=_folder, metavar="PATH", help="Folder for the results of a bare dump (default: beside it)."
        ),
    ] = None,
    case: Annotated[Path | None, typer.Option("--case", help="Case file that belongs to a bare dump.")] = None,
    diameter: Annotated[float | None, typer.Option(help="Disc diameter, m (of a bare dump; default: guessed).")] = None,
    density: Annotated[float | None, typer.Option(help="Density, kg/m^3 (of a bare dump; default 1000).")] = None,
    bin_width: Annotated[float | None, typer.Option(help="Width of a profile bin, m.")] = None,
    set_: Sets = None,
    quiet: Quiet = False,
) -> None:
    """Depth profiles, jump, front, forces and figures of a run folder or of anybody's dump."""
    from .analyze import analyze_target

    analyze_target(
        target,
        out=out,
        case=case,
        diameter=diameter,
        density=density,
        bin_width=bin_width,
        assignments=set_ or [],
        quiet=quiet,
        say=_say(quiet),
    )


@app.command()
def check(
    case: CaseFile,
    engine: EngineName = None,
    kernel: Kernel = None,
    accuracy: Accuracy = None,
    set_: Sets = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
) -> None:
    """Validate a case; print what is derived from it and what will be skipped. Runs and writes nothing."""
    from .check import check_case

    print(check_case(case, _assignments(set_, engine, kernel, None, accuracy), as_json=as_json))


@app.command()
def new(scene: Annotated[str, typer.Argument(help="Scene to start from; without it, the list.")] = "") -> None:
    """Print a starting case of a scene: lammps-jump new dam_break > my_case.yaml"""
    from lammps_jump.case.templates import scene_names, scene_text

    print(scene_text(scene) if scene else "\n".join(scene_names()), end="" if scene else "\n")


@app.command()
def schema() -> None:
    """Print the JSON schema of case files, for editors."""
    import json

    from lammps_jump.case.fields import Case

    print(json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **Case.model_json_schema()}, indent=2))


@app.command()
def doctor() -> None:
    """Tell whether the engines are usable here, and if not, what to install."""
    from .doctor import examine

    text, healthy = examine()
    print(text)
    if not healthy:
        raise typer.Exit(1)


@app.command("cross-validate")
def cross_validate(
    case: CaseFile,
    out: Annotated[
        Path | None,
        typer.Option("--out", parser=_folder, metavar="PATH", help="Folder (default: runs/<name>_cross_validation)."),
    ] = None,
    members: Annotated[int | None, typer.Option(help="Runs in each ensemble (default 6, quick 3).")] = None,
    kernel: Annotated[str, typer.Option(help="LAMMPS kernel of the ensembles: auto, stock or compiled.")] = "auto",
    quick: Annotated[bool, typer.Option("--quick", help="Fewer members, no comparison of laws.")] = False,
    set_: Sets = None,
    quiet: Quiet = False,
) -> None:
    """Hold LAMMPS and the native engine against each other; exit status 1 where they must agree and do not."""
    from lammps_jump.studies.cross_validation.study import run_command

    options = {"members": members, "kernel": kernel, "quick": quick, "quiet": quiet}
    if not run_command(case, out=out, assignments=set_ or [], say=_say(quiet), **options):
        raise typer.Exit(1)


kernels = typer.Typer(help="The compiled plugin for LAMMPS.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(kernels, name="kernels")


@kernels.command("build")
def kernels_build(
    force: Annotated[bool, typer.Option("--force", help="Build again even where a whole one is cached.")] = False,
) -> None:
    """Build the plugin into the cache, for administrators and for job files; prints its path."""
    print(plugin.plugin_path(build=True, force=force))


@kernels.command("status")
def kernels_status() -> None:
    """Tell whether the plugin can be used here."""
    status = plugin.availability()
    print(status.reason or "usable")
    if not status.available:
        raise typer.Exit(1)


@app.command()
def animate(
    folder: Annotated[Path, typer.Argument(help="Run folder or dump.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", parser=_folder, metavar="PATH", help="File (.mp4 or .gif); default animation.mp4 in the folder."
        ),
    ] = None,
    fps: Annotated[int, typer.Option(help="Frames a second.")] = 20,
) -> None:
    """Moving picture of a run: discs as true circles coloured by speed, forces on structures, time."""
    from .analyze import animate_target

    print(animate_target(folder, out, fps))


@app.command()
def bench(
    case: Annotated[
        Path,
        typer.Argument(help="Case file, or `collision` for two discs against their closed forms.", show_default=False),
    ],
    out: Annotated[
        Path | None, typer.Option("--out", parser=_folder, metavar="PATH", help="Folder (default: runs/bench/<name>).")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Three steps, two starts.")] = False,
    axes: Annotated[
        str | None,
        typer.Option(help="Of f,n,touch,kernel,correction,skin,diameter,ranks; default all but the last two."),
    ] = None,
    members: Annotated[int | None, typer.Option(min=1, help="Starts of each setting (default 5, quick 2).")] = None,
    cells: Annotated[
        bool, typer.Option("--cells", help="CPU time against the cell size of the thesis' search.")
    ] = False,
    skips: Annotated[bool, typer.Option("--skips", help="What each thing left out of a script saves.")] = False,
    speed: Annotated[
        bool, typer.Option("--speed", help="Kernels and skins side by side on the developed flow, against stock.")
    ] = False,
    table: Annotated[bool, typer.Option("--table", help="Print the table of what is stored; run nothing.")] = False,
    diameters: Annotated[str | None, typer.Option(help="For --axes diameter: values in m, comma-separated.")] = None,
    fractions: Annotated[str | None, typer.Option(help="Time-step fractions in place of 0.01 … 0.4.")] = None,
    kernels: Annotated[str | None, typer.Option(help="Of stock,compiled,native; default all that run here.")] = None,
    set_: Sets = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Measure again what is stored.")] = False,
    quiet: QuietStudy = False,
) -> None:
    """Run time against error over step, kernel, touch, stiffness …; resumable."""
    from lammps_jump.studies import bench, runs

    part = next((name for name, wanted in (("cells", cells), ("skips", skips), ("speed", speed)) if wanted), None)
    varied = bench.read_axes(axes, fractions, kernels, diameters)
    options = {"axes": varied, "members": members, "quick": quick, "fresh": fresh, "say": _say(quiet)}
    if table and part is None:
        return show(bench.stored_table(case, out))
    show(bench.run_bench(runs.StudyCase(case, tuple(set_ or ())), out=out, part=part, **options))


@app.command()
def stress(
    out: Annotated[
        Path | None, typer.Option("--out", parser=_folder, metavar="PATH", help="Folder (default: runs/stress).")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Small packings, few scenes.")] = False,
    long: Annotated[bool, typer.Option("--long", help="10^7 steps of a bed, minutes of drowned inlet.")] = False,
    random: Annotated[int | None, typer.Option(min=0, help="Number of random scenes (default 200, quick 10).")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first random scene.")] = 0,
    fresh: Annotated[bool, typer.Option("--fresh", help="Measure again what is stored.")] = False,
    quiet: QuietStudy = False,
) -> None:
    """Numerical stability: limits of the step, hard and random scenes; exit status 1 where one ends badly."""
    from lammps_jump.studies.stress.study import stress as study

    found = study(out, quick=quick, long=long, random=random, seed=seed, fresh=fresh, say=_say(quiet))
    if found:
        print("\n".join(["ended badly:", *found]))
        raise typer.Exit(1)
    print(f"every scene ended properly; see {out or 'runs/stress'}/stress.md")


@app.command()
def sensitivity(
    out: Annotated[
        Path | None, typer.Option("--out", parser=_folder, metavar="PATH", help="Folder (default: runs/sensitivity).")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Short, coarse flows: seconds.")] = False,
    only: Annotated[str | None, typer.Option(help="Of diameter,restitution,friction,stiffness,froude,sill.")] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Measure again what is stored.")] = False,
    quiet: QuietStudy = False,
) -> None:
    """The jump against disc size, restitution, friction, stiffness and Froude number."""
    from lammps_jump.studies.sensitivity import run_sensitivity

    show(run_sensitivity(out, quick=quick, only=only, fresh=fresh, say=_say(quiet)))


@app.command()
def calibrate(
    out: Annotated[
        Path | None, typer.Option("--out", parser=_folder, metavar="PATH", help="Folder (default: runs/calibrate).")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Four candidates on coarse flows: seconds.")] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Measure again what is stored.")] = False,
    quiet: QuietStudy = False,
) -> None:
    """Contact coefficients that make discs behave most like water; the distances are printed."""
    from lammps_jump.studies.calibration import run_calibration

    show(run_calibration(out, quick=quick, fresh=fresh, say=_say(quiet)))


def main() -> None:
    """Entry point: errors of ours become one paragraph and an exit status, never a traceback."""
    # imports leave a million objects that stay: looking through them again and again took a tenth of an analysis
    gc.set_threshold(50_000, 20, 50)
    start_engine_early(sys.argv[1:])
    with patient_output() as output:
        status = _status()
        output.flush()
        if output.trouble is not None:
            print(f"error: standard output cannot be written ({output.trouble.strerror})", file=sys.stderr)
            status = status or 1
    gc.freeze()  # nor once more at the end: a third of a second
    raise SystemExit(status)


def _status() -> int:
    """Run the command; its exit status."""
    try:
        app(standalone_mode=True)
    except SystemExit as stop:
        if stop.code == 130:  # what typer makes of Ctrl-C
            print("\nended by the user; nothing more was written", file=sys.stderr)
        return int(stop.code or 0)
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    return 0


if __name__ == "__main__":
    main()
