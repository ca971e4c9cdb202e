# SPDX-License-Identifier: GPL-2.0-or-later
"""Signals end a run in order: its state is saved, nothing is analysed, the status says that it can go on."""

from __future__ import annotations

import os
import signal
import threading

import pytest
from children import run_program
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.interrupts import held_back
from lammps_jump.runs import start

ENGINES = {
    "native": ["--engine", "native"],
    "stock": ["--kernel", "stock"],
    "compiled": ["--kernel", "compiled"],
    "ranks": ["--kernel", "stock", "--ranks", 2],
}
STEP = 3000


def signalled(folder, engine: str, number: int, who: str = "first") -> str:
    """Output of a run that gets a signal at `STEP`, and ends with status 75."""
    changes = ("run.duration=200", "run.output_interval=0.5", "analysis.figures=none")
    options = [*ENGINES[engine], *(word for change in changes for word in ("--set", change))]
    command = ["build-and-run", INPUTS / "energy_box_16.yaml", "--out", folder, *options]
    status, output = run_program(*command, signal_at=(number, STEP, who))
    assert status == 75, output
    return output


@pytest.mark.lammps
@pytest.mark.parametrize(
    ("number", "engine"),
    [
        (signal.SIGHUP, "native"),
        pytest.param(signal.SIGXCPU, "native", marks=pytest.mark.long),
        pytest.param(signal.SIGUSR1, "stock", marks=pytest.mark.long),
        pytest.param(signal.SIGQUIT, "compiled", marks=pytest.mark.long),
        pytest.param(signal.SIGUSR2, "ranks", marks=pytest.mark.long),
    ],
)
@pytest.mark.fault("signals")
def test_a_signal_saves_the_run_and_nothing_is_analysed(number, engine, plugin, tmp_path):
    """HUP and USR1 killed the program, XCPU and QUIT the engine too; an analysis of seconds followed the others."""
    folder = tmp_path / "run"
    output = signalled(folder, engine, number)
    assert f"{signal.Signals(number).name}: the run saves its state and ends" in output
    assert output.index("saves its state") < output.index("the run was ended at t =") and "--resume" in output
    run = lj.open_run(folder)
    assert read_checkpoint(folder).step == run.result.steps >= STEP
    assert run.status == "interrupted" and "not analysed" in run.warnings[-1]
    assert not {"profiles.nc", "report.html", "figures"} & set(os.listdir(folder))
    if engine == "native":
        start.reanalyse(folder)  # what there is can be looked at
        assert lj.open_run(folder).status == "interrupted" and (folder / "profiles.nc").exists()


LONG = pytest.mark.long


@pytest.mark.lammps
@pytest.mark.parametrize(
    ("number", "told", "engine"),
    [
        pytest.param(signal.SIGXCPU, "engine", "native", marks=LONG),
        pytest.param(signal.SIGXCPU, "engine", "stock", marks=LONG),
        pytest.param(signal.SIGXCPU, "engine", "ranks", marks=LONG),
        pytest.param(signal.SIGUSR1, "all", "native", marks=LONG),
        pytest.param(signal.SIGUSR1, "all", "stock", marks=LONG),
        pytest.param(signal.SIGUSR1, "all", "ranks", marks=LONG),
    ],
)
@pytest.mark.fault("signals")
def test_signals_that_not_only_the_program_gets_end_the_run_in_order(engine, number, told, tmp_path):
    """The system tells each process of its limit of processor time; a batch system signals every process."""
    signalled(tmp_path / "run", engine, number, told)
    assert read_checkpoint(tmp_path / "run").step >= STEP


@pytest.mark.parametrize("place", ["lammps_jump.runs.start.write_folder", "lammps_jump.engines.run"])
@pytest.mark.fault("signals")
def test_a_signal_outside_the_engine_says_how_to_go_on(place, tmp_path, monkeypatch):
    def signal_comes(*arguments, **options):
        signal.raise_signal(signal.SIGUSR1)

    monkeypatch.setattr(place, signal_comes)
    case = lj.load_case(INPUTS / "energy_box_16.yaml", {"engine.name": "native"})
    with pytest.raises(lj.RunInterrupted, match="same command with --resume goes on"):
        case.run(tmp_path)


def test_a_signal_that_is_held_back_comes_afterwards():
    seen = []
    before = signal.signal(signal.SIGUSR2, lambda number, stack: seen.append(number))
    try:
        with held_back([signal.SIGUSR2]):
            signal.pthread_kill(threading.get_ident(), signal.SIGUSR2)
            assert not seen
        assert seen == [signal.SIGUSR2]
    finally:
        signal.signal(signal.SIGUSR2, before)
