# SPDX-License-Identifier: GPL-2.0-or-later
"""A run whose frames are read while the engine writes them has the results of one that is read afterwards."""

import os

import pytest
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.analysis import contacts, pipeline

SHORT = {"run.duration": 0.3, "run.output_interval": 0.02, "engine.name": "native", "analysis.figures": "none"}


KINDS = [
    ("text", ["GrowingDump"]),
    pytest.param("binary", ["GrowingDump"], marks=pytest.mark.long),
    ("gz", ["Dump"]),
]


@pytest.fixture
def passes(monkeypatch):
    """Kinds of the dumps that were read; there is always a core to read on."""
    read, collect = [], pipeline.collect
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1}, raising=False)
    monkeypatch.setattr(
        pipeline, "collect", lambda flow, dump, *more: read.append(type(dump).__name__) or collect(flow, dump, *more)
    )
    return read


@pytest.mark.parametrize("kind, expected", KINDS)
def test_frames_are_read_once_with_the_same_results(tmp_path, passes, kind, expected):
    run = lj.load_case(INPUTS / "quick_jump.yaml", {**SHORT, "run.dump_format": kind}).run(tmp_path / "run")
    assert run.status == "complete" and passes == expected
    kept = ("jump", "force", "inflow", "profiles", "warnings", "discs")
    first, stored = {key: run.summary[key] for key in kept}, (run.folder / "profiles.nc").read_bytes()
    lj.runs.start.reanalyse(run.folder)
    again = lj.open_run(run.folder)
    assert passes == [*expected, "Dump"] and {key: again.summary[key] for key in kept} == first
    assert (run.folder / "profiles.nc").read_bytes() == stored


def test_the_pairs_of_a_frame_are_looked_for_once(tmp_path, passes, monkeypatch):
    """By the momentum of the jump and by the pressure of the player alike, also where the run is analysed again."""
    found, close_pairs = [], contacts.close_pairs
    monkeypatch.setattr(contacts, "close_pairs", lambda *more: found.append(more) or close_pairs(*more))
    run = lj.load_case(INPUTS / "quick_jump.yaml", SHORT).run(tmp_path / "run")
    assert len(found) == run.summary["profiles"]["frames"] == 16
    lj.runs.start.reanalyse(run.folder)
    assert len(found) == 2 * 16


def test_progress_and_seconds_tell_the_parts_of_the_analysis(tmp_path):
    seen = []
    run = lj.load_case(INPUTS / "quick_jump.yaml", SHORT).run(tmp_path / "run", progress=seen.append)
    parts = [report.doing.split()[1] for report in seen if report.doing]
    assert list(dict.fromkeys(parts)) == ["reading", "results", "tables", "player", "figures", "report"]
    assert all(report.step == report.steps for report in seen if report.doing)
    assert list(run.summary["analysis_seconds"]) == ["reading", "results", "tables", "player", "figures", "report"]


def test_a_dump_that_changed_since_is_read_again(tmp_path, passes, monkeypatch):
    """A file that is not what was read counts, and its fault is found."""
    engine = lj.engines.run

    def damaged(scene, folder, *more, **options):
        result = engine(scene, folder, *more, **options)
        with (folder / "dump.lammpstrj").open("ab") as file:
            file.write(b"ITEM: TIMESTEP")
        return result

    monkeypatch.setattr(lj.engines, "run", damaged)
    with pytest.raises(lj.RunError, match="not whole"):
        lj.load_case(INPUTS / "quick_jump.yaml", SHORT).run(tmp_path / "run")


def test_what_contacts_lack_is_asked_when_the_engine_has_ended(tmp_path, monkeypatch):
    """The analysis begins before the engine has made its files: a page once said that contacts.bin is not there."""
    monkeypatch.chdir(tmp_path)
    run = lj.load_case(INPUTS / "inclined_flow.yaml", {**SHORT, "run.duration": 0.04}).run(tmp_path / "run")
    file, away, gather = run.folder / "contacts.bin", run.folder / "away", pipeline.gather
    lacks = "Contact forces lack the tangential springs"

    def notes(before, after):
        before()

        def late(*more):
            after()
            return gather(*more)

        monkeypatch.setattr(pipeline, "gather", late)
        flow = lj.runs.results.flow_of(run.case, run.folder)
        found = lj.runs.results.collect(run.case, flow, run.folder, lj.runs.results.read_dump(run.folder))
        return [note for note in found.warnings if note.startswith(lacks)]

    assert file.is_file() and not [note for note in run.summary["warnings"] if note.startswith(lacks)]
    assert not notes(lambda: file.rename(away), lambda: away.rename(file))
    assert notes(lambda: file.rename(away), lambda: None)
