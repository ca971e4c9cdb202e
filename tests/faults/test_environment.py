# SPDX-License-Identifier: GPL-2.0-or-later
"""Surroundings that fail: a sentence and an exit status, no traceback, no hang, bounded memory."""

from __future__ import annotations

import gzip
import json
import os
import shutil
import sys

import pytest
from children import run_child, run_program
from made_up import INPUTS, without_analysis

import lammps_jump as lj
from lammps_jump.cli.app import main
from lammps_jump.engines import launch
from lammps_jump.errors import ResumeError, RunError
from lammps_jump.runs import start

SHORT = ("--set", "run.duration=0.1", "--set", "run.output_interval=0.02", "--set", "analysis.jump=false")


def said_by(monkeypatch, capsys, folder, *words: str) -> tuple[int, str]:
    """Exit status and stderr of the command line, in this process."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["lammps-jump", *words])
    with pytest.raises(SystemExit) as stop:
        main()
    return int(stop.value.code or 0), capsys.readouterr().err


@pytest.mark.parametrize("kind", ["pipe", "device", "link to a device"])
@pytest.mark.fault("folders")
def test_what_never_ends_is_not_waited_for(monkeypatch, capsys, tmp_path, kind):
    place = tmp_path / "never"
    if kind == "pipe":
        os.mkfifo(place)
    elif kind == "link to a device":
        place.symlink_to("/dev/zero")
    name = "/dev/zero" if kind == "device" else str(place)
    (tmp_path / "dump").write_text("ITEM: TIMESTEP")
    for words in (("check",), ("build-and-run",), ("analyze",), ("animate",), ("analyze", "dump", "--case")):
        status, said = said_by(monkeypatch, capsys, tmp_path, *words, name)
        assert status == 2 and name in said and "no regular file" in said and said.count("\n") == 1
    folder = tmp_path / "run"
    folder.mkdir()
    for file in ("case.yaml", "dump.lammpstrj"):
        (folder / file).symlink_to(name)
    for command in ("run", "analyze"):
        status, said = said_by(monkeypatch, capsys, tmp_path, command, str(folder))
        assert status == 2 and "no regular file" in said and said.count("\n") == 1


HEAD = b"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n%d\nITEM: BOX BOUNDS ff ff pp\n0 9\n0 9\n-1 1\nITEM: ATOMS id x y\n"
BOMBS = {
    "zeros": (b"", b"\0"),
    "a line without an end": (b"ITEM: TIMESTEP\n", b"1"),
    "a row without an end": (HEAD % 1 + b"1 ", b"0"),
    "blank lines": (b"ITEM: TIMESTEP\n0\n", b"\n"),
    "blanks in a row": (HEAD % 5, b" "),
    "discs": (HEAD % 100_000_000, b"1 2 3\n"),
}
MEGABYTES = 150


@pytest.mark.parametrize(
    "name", [name if name == "a row without an end" else pytest.param(name, marks=pytest.mark.long) for name in BOMBS]
)
@pytest.mark.fault("mutants of dumps")
def test_a_gzip_bomb_is_bounded(tmp_path, name):
    """A file below 1 MB that unpacks to 150 MB: refused, in less address space than that would take as numbers."""
    start, part = BOMBS[name]
    with gzip.open(tmp_path / "bomb.gz", "wb", compresslevel=1) as file:
        file.write(start)
        piece = part * (1_000_000 // len(part))
        for _ in range(MEGABYTES):
            file.write(piece)
    assert (tmp_path / "bomb.gz").stat().st_size < 3_000_000
    limited = 'ulimit -v 4000000; exec "$0" -m lammps_jump analyze bomb.gz'
    status, said = run_child(["bash", "-c", limited, sys.executable], cwd=tmp_path, env={"OPENBLAS_NUM_THREADS": "1"})
    assert status == 2 and "bomb.gz" in said and "Traceback" not in said and said.count("\n") <= 2
    assert [path.name for path in tmp_path.iterdir()] == ["bomb.gz"]


@pytest.mark.parametrize("text", [100_000 * "[" + 100_000 * "]", 100_000 * '{"a":'], ids=["lists", "groups"])
@pytest.mark.fault("values in JSON files")
def test_brackets_in_the_files_of_a_folder(tmp_path, text, monkeypatch):
    """Deep JSON is no JSON: the run folder is read without it."""
    without_analysis(monkeypatch)
    folder = tmp_path / "run"
    lj.load_case(INPUTS / "quick_jump.yaml", ["run.duration=0.1"]).run(folder, engine="native")
    (folder / "summary.json").write_text(text)
    start.reanalyse(folder)
    assert lj.open_run(folder).status == "complete"
    (folder / "summary.json").unlink()
    (folder / "checkpoint.json").write_text(text)
    with pytest.raises(ResumeError, match=r"checkpoint\.json: cannot be read"):
        start.start(lj.open_run(folder).case, folder, resume=True)


@pytest.mark.long
@pytest.mark.parametrize(
    "backend",
    ["nonsense", *(pytest.param(name, marks=pytest.mark.long) for name in ("module://no.such.module", "agg"))],
)
@pytest.mark.fault("surroundings")
def test_a_backend_that_is_not_known_is_left_aside(tmp_path, backend):
    words = ("build-and-run", INPUTS / "quick_jump.yaml", *SHORT, "--quiet", "--out", tmp_path / "o")
    status, said = run_program(*words, env={"MPLBACKEND": backend})
    told = "note: MPLBACKEND=nonsense is not known to matplotlib and is left aside\n"
    assert status == 0 and said == told * (backend == "nonsense")
    assert (tmp_path / "o" / "report.html").is_file()


@pytest.mark.parametrize(
    ("engine", "how"),
    [
        ("native", "removed"),
        ("lammps", "renamed"),
        pytest.param("native", "renamed", marks=pytest.mark.long),
        pytest.param("lammps", "removed", marks=pytest.mark.long),
    ],
)
@pytest.mark.fault("folders")
def test_a_folder_that_is_taken_away(tmp_path, monkeypatch, engine, how):
    folder = tmp_path / "run"

    def take_away() -> None:
        if how == "renamed" and folder.exists():
            folder.rename(tmp_path / "elsewhere")
        while folder.exists():  # the engine still writes files into it
            shutil.rmtree(folder, ignore_errors=True)

    ran = launch.run

    def run(*arguments, **options):
        found = ran(*arguments, **options)
        take_away()
        return found

    options = {"progress": lambda now: take_away()}
    if engine == "lammps":  # whose reports may come too late
        options = {}
        monkeypatch.setattr("lammps_jump.engines.run", run)
    case = lj.load_case(INPUTS / "quick_jump.yaml", ["run.duration=0.1"])
    with pytest.raises(RunError, match="was removed or renamed while the run went on") as caught:
        case.run(folder, engine=engine, **options)
    assert "\n" not in str(caught.value) and not folder.exists()


@pytest.mark.long
@pytest.mark.parametrize("blocks", [*(pytest.param(size, marks=pytest.mark.long) for size in (0, 1)), 40])
@pytest.mark.fault("full disk")
def test_files_that_cannot_grow(tmp_path, blocks):
    """A limit of the file size (kB) stands for a full disk: no traceback, and no summary that says complete."""
    command = [
        "bash", "-c", f'ulimit -f {blocks}; exec "$0" "$@"', sys.executable, "-m", "lammps_jump", "build-and-run",
        INPUTS / "quick_jump.yaml", "--engine", "native", "--set", "run.duration=1.5", "--set",
        "run.output_interval=0.01", "--quiet", "--out", tmp_path / "run",
    ]  # fmt: skip
    status, said = run_child(command, cwd=tmp_path)
    assert status in (1, 2) and "Traceback" not in said and "error: " in said
    summary = tmp_path / "run" / "summary.json"
    assert not summary.exists() or json.loads(summary.read_text())["status"] == "failed"
