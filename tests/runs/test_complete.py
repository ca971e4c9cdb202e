# SPDX-License-Identifier: GPL-2.0-or-later
"""'complete' is written after a check alone; an analysis that failed or was killed is made again."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from children import run_child
from made_up import INPUTS, call, files, troubles, without_analysis

import lammps_jump as lj
from lammps_jump import engines
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.write import run_writer
from lammps_jump.folders import STAGING
from lammps_jump.runs import start

pytestmark = pytest.mark.usefixtures("blank_pictures")

SHORT = {"run.duration": 0.3, "run.output_interval": 0.02, "engine.name": "native", "analysis.jump": False}
DUMP, FORCES = "dump.lammpstrj", "forces.csv"


@pytest.fixture(scope="module")
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


@pytest.fixture(scope="module")
def finished(case, tmp_path_factory):
    return case.run(tmp_path_factory.mktemp("complete") / "run").folder


@pytest.fixture(scope="module")
def engine_result(finished):
    """What the engine said of the finished run."""
    return lj.open_run(finished).result


@pytest.fixture
def folder(finished, tmp_path):
    return Path(shutil.copytree(finished, tmp_path / "run"))


def frames_changed(change: Callable[[list], list]) -> Callable[[Path, lj.Scene], None]:
    """A damage to the frames of a dump, each a list of step, time, box and columns."""

    def damage(folder: Path, scene) -> None:
        frames = [
            [f.step, f.time, f.box, {name: values.copy() for name, values in f.columns.items()}]
            for f in lj.read_dump(folder)
        ]
        with run_writer(folder, scene) as writer:
            for frame in change(frames):
                writer.write_frame(make_frame(*frame))

    return damage


def of_last(name: str, value: Callable) -> Callable[[list], list]:
    """A change of the first disc in the last frame; `value` is called with its columns."""

    def change(frames: list) -> list:
        columns = frames[-1][3]
        columns[name][0] = value(columns)
        return frames

    return change


def swapped(frames: list) -> list:
    for frame in frames:
        frame[3] |= {"x": frame[3]["y"], "y": frame[3]["x"] + 8}
    return frames


def backwards(frames: list) -> list:
    times = [frame[1] for frame in frames][::-1]
    return [[frame[0], time, *frame[2:]] for frame, time in zip(frames, times, strict=True)]


def lines_changed(name: str, change: Callable[[list[str]], list[str]]) -> Callable[[Path, lj.Scene], None]:
    def damage(folder: Path, scene) -> None:
        (folder / name).write_text("\n".join(change((folder / name).read_text().splitlines())) + "\n")

    return damage


def torn(folder: Path, scene) -> None:
    os.truncate(folder / DUMP, (folder / DUMP).stat().st_size - 30)


def not_a_number(lines: list[str]) -> list[str]:
    time, name, _, *rest = lines[5].split(",")
    return [*lines[:5], ",".join([time, name, "nan", *rest]), *lines[6:]]


DAMAGES = {
    "frames cut out": (frames_changed(lambda frames: frames[:3] + frames[5:]), "14 of 16 frames"),
    "frames swapped": (
        frames_changed(lambda frames: [*frames[:3], frames[4], frames[3], *frames[5:]]),
        "frame 4: step",
    ),
    "a frame doubled": (
        frames_changed(lambda frames: [*frames[:3], *frames[2:]]),
        "it does not advance and was passed over",
    ),
    "time backwards": (frames_changed(backwards), "frame 1: time"),
    "a disc far away": (frames_changed(of_last("y", lambda columns: 1e9)), "y = 1e+09 m, outside the domain"),
    "a negative id": (frames_changed(of_last("id", lambda columns: -1)), "no positive whole number"),
    "an id of zero": (frames_changed(of_last("id", lambda columns: 0)), "no positive whole number"),
    "an id twice": (frames_changed(of_last("id", lambda columns: columns["id"][1])), "an id stands there twice"),
    "a torn frame": (torn, "15 of 16 frames"),
    "an empty dump": (lambda folder, scene: (folder / DUMP).write_text(""), "is empty"),
    "no dump": (lambda folder, scene: (folder / DUMP).unlink(), "no dump"),
    "force rows missing": (lines_changed(FORCES, lambda lines: lines[: len(lines) // 2]), "rows of forces"),
    "a force row twice": (lines_changed(FORCES, lambda lines: [*lines, lines[-1]]), "rows of forces"),
    "force rows moved": (lines_changed(FORCES, lambda lines: [lines[0], *lines[:0:-1]]), "not those of the windows"),
    "a force that is none": (lines_changed(FORCES, not_a_number), "is no number"),
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.fault("wrong frames, discs or forces")
def test_the_checks_see_every_damage(case, finished, tmp_path, damage):
    """The frames and forces by themselves; whole runs and analyses with some damages follow."""
    spoil, said = DAMAGES[damage]
    for name in (DUMP, FORCES):
        shutil.copy(finished / name, tmp_path)
    spoil(tmp_path, case.scene())
    assert said in "; ".join(troubles(tmp_path, lj.open_run(finished)))


def some_of(damages: set[str]) -> list:
    """All damages, all but some of them marked long."""
    return [pytest.param(name, marks=[] if name in damages else pytest.mark.long) for name in DAMAGES]


@pytest.mark.parametrize("damage", some_of({"frames cut out", "a torn frame", "a force row twice"}))
@pytest.mark.fault("wrong frames, discs or forces")
def test_complete_is_not_written_for_what_is_not_whole(case, finished, engine_result, tmp_path, monkeypatch, damage):
    """The dump of a disk that was full for a second, say, was called complete."""
    spoil, said = DAMAGES[damage]
    without_analysis(monkeypatch)

    def run(scene, folder, *arguments, **options):
        """The finished run again, without its engine."""
        for name in (DUMP, FORCES):
            shutil.copy(finished / name, folder)
        spoil(folder, scene)
        return engine_result

    monkeypatch.setattr(start.engines, "run", run)
    with pytest.raises(lj.RunError, match="what it wrote is not whole") as caught:
        case.run(tmp_path / "run")
    assert said in str(caught.value) and "--force" in str(caught.value) and caught.value.exit_status == 1
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    assert summary["status"] == "failed" and said in summary["message"]
    with pytest.raises(lj.SetupError, match="of this case that failed"):
        case.run(tmp_path / "run")


@pytest.mark.parametrize("damage", some_of({"a disc far away", "no dump", "force rows missing"}))
@pytest.mark.fault("wrong frames, discs or forces")
def test_analyze_names_what_is_no_longer_what_the_run_wrote(case, folder, damage):
    spoil, said = DAMAGES[damage]
    spoil(folder, case.scene())
    before = files(folder)
    with pytest.raises(lj.DumpError, match="not what the run wrote") as caught:
        start.reanalyse(folder)
    assert said in str(caught.value) and files(folder) == before


@pytest.mark.fault("wrong frames, discs or forces")
def test_x_and_y_swapped(case, folder):
    """Within the domain only the checksum tells."""
    frames_changed(swapped)(folder, case.scene())
    with pytest.raises(lj.DumpError, match=f"{DUMP} differs"):
        start.reanalyse(folder)


@pytest.mark.fault("wrong frames, discs or forces")
def test_fractions_of_an_id(case, folder):
    """Text dumps of our own writer have whole ids; others have not."""
    damage = lines_changed(DUMP, lambda lines: [*lines[:-1], lines[-1].replace(" ", ".5 ", 1)])
    damage(folder, case.scene())
    with pytest.raises(lj.DumpError, match="no positive whole number"):
        start.reanalyse(folder)


def test_a_force_record_that_is_gone(case, folder):
    (folder / FORCES).unlink()
    with pytest.raises(lj.DumpError, match=r"forces.csv is gone.*nothing|forces.csv is gone"):
        start.reanalyse(folder)


def test_the_summary_holds_the_checksums(folder):
    summary = json.loads((folder / "summary.json").read_text())
    assert set(summary["outputs"]) == {DUMP, FORCES, "end.npz"}
    assert {"profiles.nc", "report.html", "figures/depth_profile.png"} <= set(summary["analysed"]["files"])
    assert summary["outputs"][DUMP]["size"] == (folder / DUMP).stat().st_size


# --- an analysis that failed or was killed ---------------------------------------------------------------------------


SPOILT = {
    "figure gone": lambda folder: (folder / "figures/depth_profile.png").unlink(),
    "page cut": lambda folder: os.truncate(folder / "report.html", 5),
    "profiles garbage": lambda folder: (folder / "profiles.nc").write_bytes(b"garbage"),
    "not analysed": lambda folder: set_in(folder / "summary.json", analysed=None),
    "not checked": lambda folder: set_in(folder / "summary.json", status="unchecked", analysed=None),
    "summary gone": lambda folder: (folder / "summary.json").unlink(),
    "summary cut": lambda folder: os.truncate(folder / "summary.json", 100),
}


OFTEN = {"figure gone", "not checked", "summary cut"}


@pytest.mark.parametrize("name", [pytest.param(one, marks=[] if one in OFTEN else pytest.mark.long) for one in SPOILT])
def test_a_result_that_is_not_whole_is_made_again(monkeypatch, capsys, folder, name):
    """It was answered with 'already holds this run: nothing to do'."""
    if name != "figure gone":
        without_analysis(monkeypatch)
        start.reanalyse(folder)
    whole, stamp = json.loads((folder / "summary.json").read_text()), (folder / DUMP).stat().st_mtime_ns
    SPOILT[name](folder)
    status, output, _ = call(monkeypatch, capsys, "run", folder)
    assert status == 0 and "only its analysis is made" in output
    found = json.loads((folder / "summary.json").read_text())
    for key in ("status", "key", "steps", "discs", "outputs"):
        assert found[key] == whole[key]
    assert set(found["analysed"]["files"]) == set(whole["analysed"]["files"])
    assert (folder / DUMP).stat().st_mtime_ns == stamp
    assert "nothing to do" in call(monkeypatch, capsys, "run", folder)[1]


def set_in(path: Path, **values) -> None:
    path.write_text(json.dumps({**json.loads(path.read_text()), **values}))


def test_an_analysis_that_fails_changes_nothing_and_is_made_again(case, folder, monkeypatch):
    before = files(folder)

    def fail(*arguments, **options):
        raise lj.DumpError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr("lammps_jump.analysis.pipeline.write_fields", fail)
        patch.setattr("lammps_jump.analysis.pipeline.draw_figures", fail)
        with pytest.raises(lj.DumpError, match="the disk is full"):
            start.reanalyse(folder)
        assert files(folder) == before
        with pytest.raises(lj.RunError, match="the run is complete, its dump could not be analysed: the disk is full"):
            case.run(folder, force=True)
    stored = json.loads((folder / "summary.json").read_text())
    assert stored["status"] == "complete" and stored["analysed"] is None
    stamp = (folder / DUMP).stat().st_mtime_ns
    assert case.run(folder).summary["analysed"] and (folder / DUMP).stat().st_mtime_ns == stamp


KILLED = """
import os, signal, sys
from pathlib import Path
import lammps_jump.runs.conclude as conclude
from lammps_jump.runs import start
name, folder = sys.argv[1:]
def killed(*arguments, **options):
    os.kill(os.getpid(), signal.SIGKILL)
if name == "report":
    conclude.runs.results.write_report = killed
elif name == "publish":
    import lammps_jump.folders as folders
    count = []
    replace = os.replace
    def some(old, new):
        count.append(new)
        if len(count) > 6:
            killed()
        replace(old, new)
    os.replace = some
start.reanalyse(Path(folder), ["analysis.bin_width=2"])
"""


@pytest.mark.long
@pytest.mark.parametrize("place", ["report", "publish"])
@pytest.mark.fault("killed")
def test_a_killed_analysis_is_made_again(folder, place):
    before = files(folder)
    status, _ = run_child([sys.executable, "-c", KILLED, place, folder])
    assert status == -signal.SIGKILL and (folder / STAGING).is_dir()
    if place == "report":  # nothing has been moved yet
        left = {name: text for name, text in files(folder).items() if STAGING not in name and ".lock" not in name}
        assert left == before
    run = lj.load_case(folder, {"analysis.bin_width": 2}).run(folder)
    assert run.status == "complete" and run.summary["profiles"]["bin_width"] == 2 and run.summary["analysed"]
    assert not (folder / STAGING).exists() and not (folder / ".lock").exists()
    assert set(files(folder)) == set(before)


# --- LAMMPS ----------------------------------------------------------------------------------------------------------


@pytest.mark.lammps
@pytest.mark.parametrize(
    ("dump_format", "left"),
    [
        pytest.param("gz", 0.5, marks=pytest.mark.long),
        pytest.param("gz", -8, marks=pytest.mark.long),
        pytest.param("binary", 0.5, marks=pytest.mark.long),
        ("text", 0.5),
    ],
)
@pytest.mark.fault("full disk")
def test_a_dump_that_lammps_could_not_write_whole(tmp_path, monkeypatch, dump_format, left):
    """It looks at no error of its dump: 20 of 91 frames were a complete run. Without its last 8 bytes gzip fails."""
    case = lj.load_case(
        INPUTS / "quick_jump.yaml",
        {**SHORT, "engine.name": "lammps", "engine.kernel": "stock", "run.dump_format": dump_format},
    )
    if left > 0:  # else the reader's own note is what tells
        without_analysis(monkeypatch)
    engine_run = engines.run

    def run(scene, folder, *arguments, **options):
        result = engine_run(scene, folder, *arguments, **options)
        dump = next(folder.glob("dump.lammps*"))
        size = dump.stat().st_size
        os.truncate(dump, int(left * size) if left > 0 else size + left)
        return result

    monkeypatch.setattr(start.engines, "run", run)
    with pytest.raises(lj.RunError, match="of 16 frames" if left > 0 else "is cut off"):
        case.run(tmp_path / "run")
    assert json.loads((tmp_path / "run/summary.json").read_text())["status"] == "failed"
