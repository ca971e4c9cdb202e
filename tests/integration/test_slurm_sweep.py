# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies under a Slurm of one node: the table is that of the same study run here, to the last digit."""

from __future__ import annotations

import pytest
import yaml
from children import run_program
from made_up import INPUTS
from one_node_slurm import missing, one_node_slurm, wait_for

pytestmark = [pytest.mark.slurm, pytest.mark.skipif(bool(missing()), reason=missing())]

STUDY = {
    "case": str(INPUTS / "quick_jump.yaml"),
    "set": {"run.duration": 3, "analysis.window": [2, 3]},
    "axes": {"contact.friction": [0, 0.05, 0.1]},
    "members": 2,
    "collect": ["jump.y2", "jump.speed", "jump.froude", "force.sill.impulse"],
}
STEP = 1500


@pytest.fixture(scope="module")
def slurm():
    with one_node_slurm() as slurm:
        yield slurm


def written(place, **changes):
    """A study file."""
    place.mkdir(exist_ok=True)
    path = place / "friction.yaml"
    path.write_text(yaml.safe_dump({**STUDY, **changes, "set": STUDY["set"] | changes.get("set", {})}))
    return path


def sweep(slurm, *words) -> str:
    """What the command says where Slurm is."""
    status, said = run_program("sweep", *words, env=slurm.environment)
    assert status == 0, said
    return said


def submit(slurm, path, folder, *words) -> str:
    """Submit a study; the number of its array job."""
    return sweep(slurm, path, "--out", folder, "--slurm", "--jobs", "2", *words).split()[-1]


def printed(folder) -> str:
    return "\n".join(path.read_text() for path in sorted((folder / "slurm").glob("*.out")))


def end(slurm, folder, count: int):
    """Wait until no task is left; the study is then done."""
    wait_for(lambda: not slurm.ask("squeue", "-h"), "the end of the tasks")
    said = sweep(slurm, folder, "--status")
    assert said.splitlines()[0].endswith(f"points: {count} done"), said + printed(folder)


def table(folder) -> bytes:
    """The table that the same command writes once all is there."""
    assert run_program("sweep", folder, "--quiet")[0] == 0
    return (folder / "table.csv").read_bytes()


def here(path, folder) -> bytes:
    """The table of a study run here."""
    assert run_program("sweep", path, "--out", folder, "--jobs", "2", "--quiet")[0] == 0
    return (folder / "table.csv").read_bytes()


@pytest.mark.parametrize("engine", ["native", "lammps"])
def test_the_table_is_the_same_here_and_under_slurm(slurm, tmp_path, engine):
    path = written(tmp_path, set={"engine.name": engine})
    submit(slurm, path, tmp_path / "there")
    end(slurm, tmp_path / "there", 6)
    assert table(tmp_path / "there") == here(path, tmp_path / "here")
    verdicts = (tmp_path / "here/table.csv").read_text()
    assert "jump 2" in verdicts or "jump 1" in verdicts  # the collected numbers are there
