# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands that make a run: build-and-run, build, run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import lammps_jump as lj
from lammps_jump import cli, runs, script, sweeps
from lammps_jump.errors import CaseError, RunError
from lammps_jump.quoting import typed

from . import options
from .progress import ProgressLine, print_summary
from .studies import run_sweep, site_of, study_fields, submit

app = typer.Typer(rich_markup_mode=None)


@app.command("build-and-run")
def build_and_run(
    case: options.CaseFile,
    site: options.SlurmSite = None,
    slurm: options.Slurm = False,
    out: options.Out = None,
    engine: options.EngineName = None,
    kernel: options.Kernel = None,
    ranks: options.Ranks = None,
    accuracy: options.Accuracy = None,
    set_: options.Sets = None,
    force: options.Force = False,
    resume: options.Resume = False,
    live: Annotated[
        bool, typer.Option("--live", help="Draw the run while it goes on, in a window and in live.png.")
    ] = False,
    members: options.Members = None,
    collect: options.Collect = None,
    until: options.Until = None,
    jobs: options.Jobs = None,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Check a case, write its script, run it, analyse it and write the report; several starts of it with --members."""
    at = site_of(site, slurm)
    loaded = lj.load_case(case, options.assignments(set_, engine=engine, kernel=kernel, ranks=ranks, accuracy=accuracy))
    if members is not None or until or loaded.fields.run.members:
        for option, given in (("--live", live), ("--force", force), ("--resume", resume)):
            if given:
                raise CaseError(f"{option}: is for one run; members go on by the same command, so leave it out")
        place = out or Path(f"{runs.folder.default_folder(loaded)},members")
        fields = study_fields(members=members, until=until, collect=collect)
        if at is None:
            return run_sweep(loaded, place, jobs=jobs, quiet=quiet, verbose=verbose, **fields)
        return submit(sweeps.Sweep(sweeps.read_study(loaded, **fields), place), at, jobs=jobs)
    if collect:
        raise CaseError(f"--collect {collect}: is for --members; one run writes all its numbers to summary.json")
    if at is not None:
        raise CaseError(f"--slurm: is for --members; for one run use `{typed('build', case, '--slurm')}`, then sbatch")
    folder = out or runs.folder.default_folder(loaded)
    return _run(loaded, folder, quiet=quiet, verbose=verbose, live=live, force=force, resume=resume)


@app.command()
def build(
    case: options.CaseFile,
    out: options.Out = None,
    kernel: options.Kernel = None,
    ranks: options.Ranks = None,
    set_: options.Sets = None,
    slurm: Annotated[bool, typer.Option("--slurm", help="Also write a job file for a Slurm cluster.")] = False,
    site: Annotated[
        Path | None,
        typer.Option("--site", help="Partition, account and modules for --slurm (YAML; page 'On a cluster')."),
    ] = None,
    force: options.Force = False,
) -> None:
    """Write the run folder (case and LAMMPS script) without running it."""
    loaded = lj.load_case(case, options.assignments(set_, kernel=kernel, ranks=ranks))
    folder = out or runs.folder.default_folder(loaded)
    job = script.job.read_site(site) if site else script.job.Site() if slurm else None
    runs.start.build(loaded, folder, job=job, force=force)
    if job is not None:
        print(f"job file: {folder / 'job.slurm'}")
    alone = (folder / "in.lammps").exists() and not script.stock.lacking(loaded.scene())
    there = ", or there with `lmp -in in.lammps`" if alone else ""
    print(f"{folder}: run it with `{typed('run', folder)}`{there}")


@app.command()
def run(
    folder: Annotated[Path, typer.Argument(help="Folder made by `lammps-jump build`.", show_default=False)],
    force: options.Force = False,
    resume: options.Resume = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Run a built folder and analyse it."""
    _run(lj.open_run(folder).case, folder, quiet=quiet, verbose=verbose, force=force, resume=resume)


def _run(
    case: lj.Case, folder: Path, *, quiet: bool, verbose: bool, live: bool = False, force: bool, resume: bool
) -> None:
    """Runs a case, shows its progress by a line, with `live` also by pictures, and prints its results."""
    if live and case.fields.run.dump_format != "text":
        raise CaseError(
            f"--live needs text dumps, but run.dump_format is {case.fields.run.dump_format}; set it to text, or leave "
            "--live out"
        )
    fixed = case.scene().fixed
    line = ProgressLine(case.fields.run.duration, quiet=quiet, fixed=fixed.count if fixed else 0)
    view = cli.live.LiveView(case.scene(), folder, line) if live else line
    with options.log_printed(quiet):
        try:
            done = lj.run(case, folder, force=force, resume=resume, progress=view)
        except RunError:  # others leave the folder as it was
            view.finish()
            raise
        finally:
            line.finish()
    view.finish()
    if not quiet:
        print_summary(done.summary, folder, verbose=verbose)
