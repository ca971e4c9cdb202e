# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands of many runs: sweep, cross-validate, validate, bench, stress, budget, sensitivity, calibrate, fluid."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

import lammps_jump as lj
from lammps_jump import calibration, script, studies, sweeps
from lammps_jump.errors import CaseError
from lammps_jump.quoting import typed

from . import options
from .progress import CalibrationLine, StudyLine, ending, show_markdown

app = typer.Typer(rich_markup_mode=None)


@app.command()
def sweep(
    study: Annotated[Path, typer.Argument(help="Study file, case file, or the folder of a study.", show_default=False)],
    site: options.SlurmSite = None,
    slurm: options.Slurm = False,
    axis: Annotated[
        list[str] | None,
        typer.Option("--axis", metavar="PATH=VALUES", help="Values of a field, 0,0.05,0.1. May be repeated."),
    ] = None,
    members: options.Members = None,
    collect: options.Collect = None,
    until: options.Until = None,
    most_members: Annotated[int | None, typer.Option(help="Members that --until may come to (default 32).")] = None,
    out: Annotated[
        Path | None, options.results_place("Folder (default: runs/<stem of the study>, of a case runs/<stem>_sweep).")
    ] = None,
    jobs: options.Jobs = None,
    set_: options.Sets = None,
    ranks: options.Ranks = None,
    retry: Annotated[bool, typer.Option("--retry", help="Run again what failed.")] = False,
    status: Annotated[bool, typer.Option("--status", help="Tell how far it is; run nothing.")] = False,
    table: Annotated[bool, typer.Option("--table", help="Print the table of what is there; run nothing.")] = False,
    member: Annotated[
        str | None, typer.Option(help="Run this member alone, or a range, 4-7, of a folder; for job files.")
    ] = None,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Run a case at many points, several starts each; table, figures and page. Continues where it stopped."""
    if member is not None:
        with options.log_printed(quiet):
            return sweeps.slurm.run_task(out or study, member, retry=retry)
    at = site_of(site, slurm)
    set_ = options.assignments(set_, ranks=ranks)
    given = study_fields(members=members, until=until, axis=axis, collect=collect, set_=set_)
    given |= {"most_members": most_members} if most_members else {}
    if not (status or table or at):
        return run_sweep(study, out, jobs=jobs, retry=retry, quiet=quiet, verbose=verbose, **given)
    read = sweeps.read_study(study, **given)
    sweep = sweeps.Sweep(read, out or sweeps.default_folder(study, read.case))
    if at:
        submit(sweep, at, jobs=jobs, retry=retry)
    if status:
        print(sweeps.slurm.status(sweep))
    if table:
        show_markdown(sweeps.page.table_text(sweep))
    return None


def site_of(site: Path | None, slurm: bool) -> script.job.Site | None:
    """Site for the job of ``--slurm``; None without it."""
    if site is not None and not slurm:
        raise CaseError(f"{site}: a site file is for --slurm; add it, or leave the file out")
    return None if not slurm else script.job.read_site(site) if site else script.job.Site()


def submit(sweep: sweeps.Sweep, at: script.job.Site, *, jobs: int | None, retry: bool = False) -> None:
    """Submit what is left of a study, and print the number of its job."""
    number = sweeps.slurm.submit(sweep, at, at_once=jobs or sweeps.slurm.AT_ONCE, retry=retry)
    done = f"nothing to submit: `{typed('sweep', sweep.folder)}` writes table and page"
    print(f"{sweep.folder}: array job {number}" if number else f"{sweep.folder}: {done}")


def study_fields(
    *,
    members: str | None,
    until: list[str] | None,
    axis: list[str] | None = None,
    collect: str | None = None,
    set_: list[str] | None = None,
) -> dict[str, Any]:
    """Fields of a study that the words of the command line give."""
    given: dict[str, Any] = {"axes": dict(map(sweeps.parse_axis, axis or ())), "members": members}
    given |= {"collect": [word.strip() for word in (collect or "").split(",") if word.strip()]}
    given |= {"set": dict(map(sweeps.parse_set, set_ or ())), "until": dict(map(sweeps.parse_until, until or ()))}
    return {name: value for name, value in given.items() if value}


def run_sweep(
    study: Path | lj.Case,
    out: Path | None,
    *,
    jobs: int | None,
    quiet: bool,
    verbose: bool = False,
    retry: bool = False,
    **given: Any,
) -> None:
    """Run a study with a line of progress, and print its table; exit status 1 where a member failed."""
    line = StudyLine(quiet=quiet)
    with options.log_printed(quiet):
        try:
            sweep = lj.sweep(study, out, jobs=jobs, retry=retry, progress=line, **given)
        finally:
            line.finish()
    if quiet:
        for failure in sweep.failed:
            print(f"{sweeps.page.point_name(sweep.study, failure.point)}, member {failure.seed}: {failure.message}")
    elif sys.stdout.isatty() and not verbose and not sweep.study.axes and sweep.runs:
        about = [sweeps.page.interval(sweep), sweep.status()]
        lines = ending(sweeps.page.verdict_of(sweep), sweep.rows, about, sweep.folder, sweeps.page.doubts(sweep))
        print("\n".join(lines))
    else:
        print(*(f"note: {text}\n" for text in sweeps.page.doubts(sweep)), sep="", end="")
        show_markdown(sweeps.page.table_text(sweep))
        print(f"{sweep.status()}\npage: {sweep.folder / 'sweep.html'}")
    if sweep.failed:
        raise typer.Exit(1)


@app.command("cross-validate")
def cross_validate(
    case: options.CaseFile,
    out: Annotated[Path | None, options.results_place("Folder (default: runs/<name>_cross_validation).")] = None,
    members: Annotated[int | None, typer.Option(help="Runs in each ensemble (default 6, quick 3).")] = None,
    kernel: Annotated[str, typer.Option(help="LAMMPS kernel of the ensembles: auto, stock or compiled.")] = "auto",
    engine: Annotated[str, typer.Option(help="Compared with LAMMPS: native or twin.")] = "native",
    quick: Annotated[bool, typer.Option("--quick", help="Fewer members, no comparison of laws.")] = False,
    set_: options.Sets = None,
    quiet: options.Quiet = False,
) -> None:
    """Compare LAMMPS with the native engine; exit status 1 if they differ where they must agree."""
    study = studies.cross_validation
    read, say = lj.load_case(case, set_), options.sayer(quiet)
    report = study.cross_validate(read, out=out, members=members, kernel=kernel, engine=engine, quick=quick, say=say)
    if not quiet or not report["passed"]:
        print(study.verdict_text(report))
        print(f"look at {(out or study.default_folder(report['name'])) / study.REPORT_FILE}")
    if not report["passed"]:
        raise typer.Exit(1)


@app.command()
def validate(
    laws: Annotated[
        list[str] | None, typer.Argument(metavar="[LAW]…", help="Names of laws; default all.", show_default=False)
    ] = None,
    out: Annotated[
        Path | None, options.results_place("Folder (default: runs/validate, with --quick runs/validate_quick).")
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the laws; run nothing.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer and shorter runs: seconds a law.")] = False,
    jobs: options.Jobs = None,
    place: options.Laws = None,
    keep_dumps: Annotated[bool, typer.Option("--keep-dumps", help="Leave the dumps in the run folders.")] = False,
    fresh: options.Fresh = False,
    quiet: options.QuietStudy = False,
) -> None:
    """Hold results against published laws; table and page. Exit status 1 if a run fails. Continues where it stopped."""
    study = studies.validation
    if list_:
        return print(study.listing(place))
    line, folder = StudyLine(quiet=quiet), out or study.default_folder(quick)
    how: dict[str, Any] = {"quick": quick, "jobs": jobs, "fresh": fresh, "keep_dumps": keep_dumps}
    try:
        report = study.validate(laws or (), folder, laws=place, progress=line, **how)
    finally:
        line.finish()
    show_markdown(study.summary_text(report))
    print(f"page: {folder / study.PAGE_FILE}")
    if any(law["failures"] for law in report["laws"].values()):
        raise typer.Exit(1)
    return None


@app.command()
def bench(
    case: options.CaseFile,
    out: Annotated[Path | None, options.results_place("Folder (default: runs/bench/<name>).")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Three steps, two starts.")] = False,
    axes: Annotated[
        str | None,
        typer.Option(help="Some of f,n,touch,kernel,correction,skin,diameter,ranks; default: all but the last two."),
    ] = None,
    members: Annotated[int | None, typer.Option(min=1, help="Starts of each setting (default 5, quick 2).")] = None,
    table: Annotated[bool, typer.Option("--table", help="Print the table of what is stored; run nothing.")] = False,
    diameters: Annotated[str | None, typer.Option(help="For --axes diameter: values in m, comma-separated.")] = None,
    fractions: Annotated[str | None, typer.Option(help="Time-step fractions in place of 0.01 … 0.4.")] = None,
    kernels: Annotated[str | None, typer.Option(help="Of stock,compiled,native; default all that run here.")] = None,
    set_: options.Sets = None,
    fresh: options.Fresh = False,
    quiet: options.QuietStudy = False,
) -> None:
    """Measure run time against error for steps, kernels, contacts and stiffnesses. Continues where it stopped."""
    words = {"axes": axes, "fractions": fractions, "kernels": kernels, "diameters": diameters}
    varied = studies.bench.read_axes(quick, members, **words)
    if table:
        return show_markdown(studies.bench.stored_table(case, out))
    read, say = lj.load_case(case, set_), options.sayer(quiet)
    text = studies.bench.run_bench(read, out=out, axes=varied, quick=quick, fresh=fresh, say=say)
    show_markdown(text)


@app.command()
def stress(
    out: Annotated[Path | None, options.results_place("Folder (default: runs/stress).")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Small packings, few scenes.")] = False,
    long: Annotated[
        bool, typer.Option("--long", help="Also long runs: a bed for 10^7 steps, a drowned inlet for minutes.")
    ] = False,
    random: Annotated[int | None, typer.Option(min=0, help="Number of random scenes (default 200, quick 10).")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first random scene.")] = 0,
    place: options.Laws = None,
    fresh: options.Fresh = False,
    quiet: options.QuietStudy = False,
) -> None:
    """Test stability: limits of the step, hard and random scenes. Exit status 1 if a scene fails the test."""
    given: dict[str, Any] = {"quick": quick, "long": long, "random": random, "seed": seed}
    result, _ = studies.points.run_named("stress", out, laws=place, fresh=fresh, say=options.sayer(quiet), **given)
    if result["bad"]:
        print("\n".join(["ended badly:", *result["bad"]]))
        raise typer.Exit(1)
    print(f"every scene ended properly; see {out or 'runs/stress'}/stress.md")


@app.command()
def budget(
    case: options.CaseFile,
    of: Annotated[
        str,
        typer.Option("--of", metavar="KEY", help="The number, such as jump.y2, of summary.json.", show_default=False),
    ],
    out: Annotated[Path | None, options.results_place("Folder (default: runs/<name>_budget_<number>).")] = None,
    by: Annotated[
        float | None,
        typer.Option(min=1.01, max=2, help="Each choice is made this factor less and more (default 1.25)."),
    ] = None,
    starts: Annotated[int | None, typer.Option(min=2, help="Starts of the case (default 8).")] = None,
    each: Annotated[int | None, typer.Option(min=2, help="Starts of each changed case (default 4).")] = None,
    joint: Annotated[
        int | None, typer.Option(min=2, help="Runs with all choices drawn at once, to hold the sum against.")
    ] = None,
    set_: options.Sets = None,
    fresh: options.Fresh = False,
    quiet: options.QuietStudy = False,
) -> None:
    """Tell how much of the ± of a number is starts, step, discs, walls and analysis. Continues where it stopped."""
    how = {"by": by, "starts": starts, "each": each, "joint": joint}
    given: dict[str, Any] = {name: value for name, value in how.items() if value is not None}
    read = lj.load_case(case, set_)
    result = studies.budget.budget(read, of, out, fresh=fresh, say=options.sayer(quiet), **given)
    print(result["verdict"])
    print(f"page: {(out or studies.budget.default_folder(read, of)) / studies.budget.PAGE}")


@app.command()
def sensitivity(
    out: Annotated[Path | None, options.results_place("Folder (default: runs/sensitivity).")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Short, coarse flows: seconds.")] = False,
    only: Annotated[str | None, typer.Option(help="Of diameter,restitution,friction,stiffness,froude,sill.")] = None,
    fresh: options.Fresh = False,
    quiet: options.QuietStudy = False,
) -> None:
    """The jump against disc size, restitution, friction, stiffness and Froude number."""
    study = studies.sensitivity.study(quick=quick, only=only)
    place = out or Path("runs/sensitivity")
    show_markdown(studies.points.run_study(study, place, fresh=fresh, say=options.sayer(quiet))[1])


@app.command()
def calibrate(
    study: Annotated[
        Path, typer.Argument(help="Study file, case file, or the folder of a calibration.", show_default=False)
    ],
    site: options.SlurmSite = None,
    slurm: options.Slurm = False,
    target: Annotated[
        list[str] | None,
        typer.Option("--target", metavar="KEY=VALUE ± ERROR", help="A measured number. May be repeated."),
    ] = None,
    data: Annotated[
        list[Path] | None, typer.Option("--data", help="Measured curves: CSV in SI units. May be repeated.")
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option("--columns", metavar="AXIS=COLUMN,TABLE.COLUMN=COLUMN ± ERROR", help="Of each --data, in order."),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option("--vary", metavar="PATH=LOW:HIGH", help="A number to find, and its range. May be repeated."),
    ] = None,
    budget: Annotated[int | None, typer.Option(min=1, help="Most runs (default 40).")] = None,
    members: Annotated[int | None, typer.Option(min=1, help="Starts of each point (default 2).")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the points (default 1).")] = None,
    out: Annotated[Path | None, options.results_place("Folder (default: runs/<stem of the file>_calibrate).")] = None,
    jobs: options.Jobs = None,
    set_: options.Sets = None,
    retry: Annotated[bool, typer.Option("--retry", help="Run again what failed.")] = False,
    quiet: options.QuietStudy = False,
) -> None:
    """Find numbers of a case, such as friction, from measurements. Continues where it stopped."""
    given: dict[str, Any] = {"targets": calibration.all_targets(target or (), data or (), columns or ())}
    given |= {"vary": dict(map(calibration.parse_vary, vary or ())), "set": dict(map(sweeps.parse_set, set_ or ()))}
    given |= {"budget": budget, "members": members, "seed": seed}
    given = {name: value for name, value in given.items() if value}
    if at := site_of(site, slurm):
        number = calibration.submit(study, out, at, at_once=jobs, **given)
        return print(f"array job {number}" if number else "nothing to submit: the same command without --slurm goes on")
    line = CalibrationLine(quiet=quiet)
    try:
        calibrated = lj.calibrate(study, out=out, jobs=jobs, retry=retry, progress=line, **given)
    finally:
        line.finish()
    print(*(calibrated.verdict, *(f"note: {text}" for text in calibrated.notes)), sep="\n")
    print(f"page: {calibrated.folder / calibration.page.PAGE}")
    if not calibrated.data["targets"]:
        raise typer.Exit(1)
    return None


@app.command()
def find(
    study: Annotated[
        Path, typer.Argument(help="Case file, study file with find, or the folder of a search.", show_default=False)
    ],
    vary: Annotated[
        str | None, typer.Option("--vary", metavar="PATH=LOW:HIGH", help="The number to find, and its range.")
    ] = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="KEY >= NUMBER", help="What a number of summary.json must come to.")
    ] = None,
    members: Annotated[int | None, typer.Option(min=1, help="Starts of each value (default 3).")] = None,
    budget: Annotated[int | None, typer.Option(min=3, help="Most runs (default 30).")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the first start (default 1).")] = None,
    share: Annotated[
        str | None,
        typer.Option("--share", help="Share of the starts that is to hold, such as 95% (default: their mean)."),
    ] = None,
    out: Annotated[Path | None, options.results_place("Folder (default: runs/<stem of the file>_find).")] = None,
    jobs: options.Jobs = None,
    set_: options.Sets = None,
    quiet: options.QuietStudy = False,
) -> None:
    """Find the value of a number at which a result meets a given target. Continues where it stopped."""
    given: dict[str, Any] = {"set": dict(map(sweeps.parse_set, set_ or ()))}
    given |= {"vary": dict([calibration.parse_vary(vary)]) if vary else None, "until": until, "seed": seed}
    given |= {"share": share}
    line = StudyLine(quiet=quiet)
    try:
        answer = sweeps.find(study, out=out, members=members, budget=budget, jobs=jobs, progress=line, **given)
    finally:
        line.finish()
    print(answer["verdict"], *(f"note: {text}" for text in answer["notes"]), sep="\n")
    print(f"page: {(out or _found_in(study)) / 'find.html'}")
    if not answer["held"]:
        raise typer.Exit(1)


def _found_in(study: Path) -> Path:
    """Folder in which a search is kept when none is named."""
    return study if study.is_dir() else Path("runs") / f"{study.stem}_find"


@app.command()
def fluid(
    case: options.CaseFile,
    out: Annotated[Path | None, options.results_place("Folder (default: runs/<name>_fluid).")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Two starts and three rates of shear.")] = False,
    depth: Annotated[
        float | None, typer.Option(min=1e-9, help="Depth of the flow, m; default: behind the jump, or of the column.")
    ] = None,
    speed: Annotated[
        float | None, typer.Option(min=1e-9, help="Speed of the flow, m/s; default: of the inflow, or sqrt(g depth).")
    ] = None,
    set_: options.Sets = None,
    fresh: options.Fresh = False,
    quiet: options.QuietStudy = False,
) -> None:
    """Viscosity, yield and speed of sound of the discs of a case; Reynolds and Mach number of its flow."""
    read = lj.load_case(case, set_)
    study, say = studies.fluid.fluid, options.sayer(quiet)
    result = study(read, out, quick=quick, fresh=fresh, depth=depth, speed=speed, say=say)
    show_markdown(result["text"])
