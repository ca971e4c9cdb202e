# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs on the page of `open`: what a page gets of a folder that grows, and Run, Stop and Go on."""

import json
import os
import select
import shutil
import signal
import struct
import subprocess
import threading
from collections import deque
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from children import HOOK
from serving import asked, send, serving

import lammps_jump as lj
from lammps_jump import folders
from lammps_jump.case.case import ReadCase
from lammps_jump.served import children as children_module
from lammps_jump.served import watched as watched_module
from lammps_jump.served.children import ServedChild
from lammps_jump.served.watched import SoFar, Times, WatchedRun, WatchedState, reached

CASE = """\
name: falls
discs: {diameter: 0.2, sizes: {kind: uniform, spread: 0.2}}
contact: {restitution: 0.5, impact_speed: 5}
domain: {x: [-1, 6], y: [-1, 4]}
walls:
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
  - {name: sill, kind: block, x: [1.3, 1.5], y: [0, 0.5]}
initial: [{kind: column, x: [0, 1], y: [0, 1]}]
probes: {forces: [sill]}
run: {duration: 0.5, output_interval: 0.02}
engine: {name: native}
analysis: {energy: true, figures: none}
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished run, which tests copy."""
    place = tmp_path_factory.mktemp("finished")
    (place / "falls.yaml").write_text(CASE)
    lj.load_case(place / "falls.yaml").run(place / "run")
    return place / "run"


def rows(data, q):
    """Time, and ids, places (m) and speeds (m/s) in columns, of each frame that the server has sent."""
    found, at = [], 0
    while at < len(data):
        time, count, _ = struct.unpack_from("<dii", data, at)
        whole = np.frombuffer(data, "<i4", 3 * count, at + 16).reshape(3, count)
        speeds = np.frombuffer(data, "<f4", 2 * count, at + 16 + 12 * count).reshape(2, count)
        found.append((time, whole[0], whole[1:] * q, speeds))
        at += 16 + 24 * count
    return found


def all_of(watched):
    """What a page gets of a run, once it has all that is there."""
    while (found := watched.update()).get("more"):
        pass
    return found, watched.frames(0, found["of"])


def test_a_page_gets_the_frames_of_the_dump(finished):
    before = {one: (one.stat().st_mtime_ns, one.stat().st_size) for one in finished.rglob("*")}
    watched = WatchedRun(finished)
    found, data = all_of(watched)
    assert (found["status"], found["frames"], found["time"]) == ("complete", 26, pytest.approx(0.5))
    q = found["about"]["q"]
    for (time, ids, places, speeds), frame in zip(rows(data, q), lj.open_run(finished).frames(), strict=True):
        frame = frame.sorted()
        assert time == frame.time and ids.tolist() == frame.ids.tolist()
        assert np.abs(places - [frame.x, frame.y]).max() <= 0.5 * q * (1 + 1e-9)
        assert np.allclose(speeds, [frame.vx, frame.vy], rtol=1e-6)
    curves = {one["key"]: one["chart"] for one in watched.curves()}
    assert list(curves) == ["gauges", "forces", "energy"]
    kinetic = next(line for line in curves["energy"]["panels"][0]["lines"] if line["label"] == "kinetic")
    assert kinetic["y"][-1] == pytest.approx(lj.open_run(finished).summary["energy"]["kinetic"], rel=1e-3)
    assert {one: (one.stat().st_mtime_ns, one.stat().st_size) for one in finished.rglob("*")} == before


def growing(finished, folder):
    """A folder as its run has just begun, and its whole dump."""
    folder.mkdir()
    for name in ("case.yaml", folders.MARKER_FILE):
        shutil.copy(finished / name, folder)
    return (finished / "dump.lammpstrj").read_bytes()


def test_frames_come_as_they_are_written(finished, tmp_path):
    """In any pieces; each once its last line is there."""
    watched = WatchedRun(tmp_path / "run")
    assert watched.update()["status"] == "none"
    whole = growing(finished, tmp_path / "run")
    begins = [i for i in range(len(whole)) if whole.startswith(b"ITEM: TIME\n", i)]
    with folders.locked(tmp_path / "run"):
        assert watched.update() | {"status": "", "message": ""} == {
            **watched.update(), "status": "", "message": "", "frames": 0,
        }  # fmt: skip
        for cut in (10, begins[1] - 1, begins[1], begins[1] + 500, begins[3] + 11, begins[20]):
            (tmp_path / "run" / "dump.lammpstrj").write_bytes(whole[:cut])
            found, data = all_of(watched)
            there = sum(end <= cut for end in begins[1:])
            assert found["status"] == "running" and found["frames"] == there
            assert len(rows(data, 1.0)) == found["frames"]
        assert "forces at its end" in str(watched.curves())
        (tmp_path / "run" / "dump.lammpstrj").write_bytes(whole)
        shutil.copy(finished / "summary.json", tmp_path / "run")
    found, data = all_of(watched)
    assert (found["status"], found["frames"]) == ("complete", 26)
    assert data == all_of(WatchedRun(finished))[1]
    assert sorted(one.name for one in (tmp_path / "run").iterdir()) == [
        folders.MARKER_FILE, "case.yaml", "dump.lammpstrj", "summary.json",
    ]  # fmt: skip


def test_the_start_of_a_case_is_shown_before_its_run_has_written_a_frame(finished, tmp_path):
    watched = WatchedRun(tmp_path / "run")
    watched.expect(ReadCase.load(finished))
    found, data = all_of(watched)
    assert (found["status"], found["frames"], found["time"]) == ("none", 1, 0.0) and found["about"]["walls"]
    assert data == WatchedRun(finished).frames(0, "") + first_of(all_of(WatchedRun(finished))[1])
    whole = growing(finished, tmp_path / "run")
    (tmp_path / "run" / "dump.lammpstrj").write_bytes(whole)
    shutil.copy(finished / "summary.json", tmp_path / "run")
    now, all_data = all_of(watched)
    assert now["of"] != found["of"] and (now["frames"], now["trouble"]) == (26, "")
    assert all_data == all_of(WatchedRun(finished))[1]


def first_of(data):
    """The first frame of those that the server has sent."""
    return data[: 16 + 24 * struct.unpack_from("<dii", data)[1]]


def test_frames_are_answered_while_curves_are_made(finished, monkeypatch):
    watched, seen = WatchedRun(finished), []
    all_of(watched)
    made = SoFar.curves
    monkeypatch.setattr(SoFar, "curves", lambda *a, **k: seen.append(watched.update()["frames"]) or made(*a, **k))
    assert [one["key"] for one in watched.curves()] == ["gauges", "forces", "energy"] and seen == [26]
    assert WatchedRun(finished.parent / "none").curves() == []


FOLLOWED = """
const fs = require("fs"), vm = require("vm"), page = vm.createContext({});
vm.runInContext(fs.readFileSync(process.argv[1], "utf8") + "; this.Following = Following;", page);
const arrivals = JSON.parse(process.argv[2]), shown = [], one = new page.Following(0);
for (let now = 0, next = 0; now <= arrivals[arrivals.length - 1][0] + 6000; now += 50) {
  for (; next < arrivals.length && arrivals[next][0] <= now; next++) one.arrive(arrivals[next][0], arrivals[next][1]);
  shown.push([now, one.at(now), next ? arrivals[next - 1][1] : 0]);
}
console.log(JSON.stringify(shown));
"""


def followed(gaps, flow):
    """Instant (ms), shown time and time of the newest frame (s), 20 a second; of gaps (ms) and the flow in each (s)."""
    arrivals = np.column_stack([np.cumsum(gaps), np.cumsum(np.broadcast_to(flow, len(gaps)))]).tolist()
    script = Path(watched_module.__file__).with_name("live.js")
    done = subprocess.run(
        ["node", "-e", FOLLOWED, str(script), json.dumps(arrivals)], capture_output=True, text=True, check=True
    )
    return np.array(json.loads(done.stdout))


@pytest.mark.skipif(not shutil.which("node"), reason="node is not installed")
def test_a_run_that_grows_is_shown_evenly():
    """Frames come in bursts: each 100 ms there is another picture, but in the longest of gaps so far."""
    now, shown, newest = followed([400] * 20, 0.3).T
    assert (np.diff(shown) >= 0).all() and (shown <= newest + 1e-12).all() and shown[-1] == pytest.approx(6)
    going = (now >= 800) & (now < 8000)
    assert (shown[2:] > shown[:-2])[going[2:]].all()  # ten a second
    steps = np.diff(shown)[going[1:]]
    assert steps.max() < 1.5 * np.median(steps)
    gaps = [400, 1000, 500, 2700, 400, 800, 2700, 600, 900, 2000, 400, 1000]
    now, shown, newest = followed(gaps, np.array(gaps) * 3e-4).T
    assert (np.diff(shown) >= 0).all() and (shown <= newest + 1e-12).all() and shown[-1] == newest[-1]
    after = (now >= 4600) & (now < sum(gaps))  # the longest gap has been seen once
    assert (shown[2:] > shown[:-2])[after[2:]].mean() > 0.95
    assert (newest - shown)[after].max() < 2 * 2.7 * 0.3 * 1.1  # two of the longest gaps behind, s of the flow


@pytest.mark.parametrize(
    ("state", "times", "whole", "said"),
    [
        (WatchedState("none"), (None, None, 12.0), True, ""),
        (WatchedState("running", "process 7"), (6.0, None, 12.0), True, "6.00 of 12 s"),
        (WatchedState("complete", steps=100), (12.0, 12.0, 12.0), True, "12.00 s"),
        (WatchedState("complete", steps=100), (11.9, 12.0, 12.0), True, "12.00 s"),
        (
            WatchedState("complete", steps=100), (6.0, 12.0, 12.0), False,
            "12.00 s; frames read up to 6.00 of 12.00 s",
        ),
        (
            WatchedState("complete", steps=50, steady="the discs rest."), (6.0, 6.0, 12.0), True,
            "ended at 6.00 s, before its 12 s: the discs rest",
        ),
        (
            WatchedState("complete", steps=50, steady="steady"), (2.0, 6.0, 12.0), False,
            "ended at 6.00 s, before its 12 s: steady; frames read up to 2.00 of 6.00 s",
        ),
        (
            WatchedState("interrupted", "stopped by signal INT", steps=50), (5.9, 6.0, 12.5), True,
            "ended at 6.00 s, before its 12.5 s: stopped by signal INT",
        ),
        (
            WatchedState("interrupted", "it was cut off", cut_off=True), (6.0, None, 12.0), True,
            "ended at 6.00 s, before its 12 s: it was cut off",
        ),
        (
            WatchedState("failed", "3 discs\nare lost", steps=50), (6.0, 6.0, 12.0), True,
            "ended at 6.00 s, before its 12 s: 3 discs are lost",
        ),
        (WatchedState("failed", "no engine"), (None, None, 12.0), True, "ended, before its 12 s: no engine"),
        (WatchedState("unchecked", steps=100), (12.0, 12.0, 12.0), True, "12.00 s"),
    ],
)  # fmt: skip
def test_how_far_a_run_came(state, times, whole, said):
    """ "The run is complete, 6.00 of 12 s" stood over a run that had ended early, and over one still being read."""
    assert reached(state, Times(*times), whole=whole) == said


def test_a_page_is_told_how_far_its_run_came(finished, tmp_path):
    assert all_of(WatchedRun(finished))[0]["reached"] == "0.50 s"
    shutil.copytree(finished, tmp_path / "run")
    path = tmp_path / "run" / "summary.json"
    stored = json.loads(path.read_text())
    path.write_text(json.dumps(stored | {"stopped_when_steady": "steady", "steps": stored["steps"] // 2}))
    assert WatchedRun(tmp_path / "run").update()["reached"].startswith("ended at 0.25 s, before its 0.5 s: steady")
    path.write_text(json.dumps(stored | {"status": "failed", "message": "a disc is lost"}))
    assert "before its 0.5 s: a disc is lost" in WatchedRun(tmp_path / "run").update()["reached"]


def test_a_dump_that_was_cut_is_read_anew(finished, tmp_path):
    """A run that goes on cuts its dump back to its checkpoint: a page gives up the frames it has."""
    whole = growing(finished, tmp_path / "run")
    path, watched = tmp_path / "run" / "dump.lammpstrj", WatchedRun(tmp_path / "run")
    path.write_bytes(whole[: len(whole) // 2])
    first, _ = all_of(watched)
    path.write_bytes(whole[: len(whole) // 3])
    found, data = all_of(watched)
    assert found["of"] != first["of"] and found["frames"] == len(rows(data, 1.0)) < first["frames"]
    assert watched.frames(0, first["of"]) == b""


def in_frame(number, change):
    """Changes one frame of a dump, given as lines behind its `ITEM: TIME`."""

    def spoil(text):
        frames = text.split("ITEM: TIME\n")
        lines = frames[number].split("\n")
        change(lines)
        return "ITEM: TIME\n".join([*frames[:number], "\n".join(lines), *frames[number + 1 :]])

    return spoil


def row(at, column, value):
    """Puts a value into a row of discs of a frame."""

    def change(lines):
        first = next(number for number, line in enumerate(lines) if line.startswith("ITEM: ATOMS")) + 1
        cells = lines[first + at].split()
        lines[first + at] = " ".join([*cells[:column], value, *cells[column + 1 :]])

    return in_frame(5, change)


def set_line(at, value):
    return in_frame(5, lambda lines: lines.__setitem__(at, value))


SPOILT = {
    "no number": (row(2, 2, "nan"), "", 4),
    "a word": (row(2, 2, "x"), "expected", 4),
    "an id twice": (row(2, 0, "1"), "an id stands there twice", 4),
    "an id that is none": (row(2, 0, "0"), "an id is no positive whole number", 4),
    "a disc far away": (row(2, 2, "1e6"), "outside the domain", 4),
    "another time": (set_line(0, "0.0801"), "time 0.0801 s, but its step is at 0.08 s", 4),
    "a time that is none": (set_line(0, "soon"), "expected a time", 4),
    "another step": (set_line(2, "77"), "step 77 stands where step", 4),
    "a row that is missing": (in_frame(5, lambda lines: lines.pop(12)), "stands where step", 4),
    "frames that are missing": (lambda text: text[: text.rindex("ITEM: TIME\n")], "25 of 26 frames", 25),
    "a frame that is missing": (
        lambda text: "ITEM: TIME\n".join(one for n, one in enumerate(text.split("ITEM: TIME\n")) if n != 5),
        "stands where step", 4,
    ),
    "nothing": (lambda text: "", "0 of 26 frames", 0),
    "no dump": (lambda text: "hello\n", "expected", 0),
}  # fmt: skip
"""What becomes of a dump, what is said of it, and the frames that are shown."""


@pytest.mark.parametrize("spoilt", SPOILT)
@pytest.mark.parametrize("ended", [True, False])
def test_a_damaged_dump_is_told_as_long_as_it_is_seen(finished, tmp_path, spoilt, ended):
    """The error stood there for 0.4 s; then the run was complete with the frames before it."""
    spoil, said, shown = SPOILT[spoilt]
    shutil.copytree(finished, tmp_path / "run")
    path = tmp_path / "run" / "dump.lammpstrj"
    path.write_text(spoil(path.read_text()))
    if not ended:
        (tmp_path / "run" / "summary.json").unlink()
    watched = WatchedRun(tmp_path / "run")
    found, data = all_of(watched)
    if not ended and (shown == 0 or "of 26 frames" in said):
        assert not found["trouble"] and found["frames"] == shown  # it may go on
        return
    for _ in range(2):
        assert found["status"] == ("damaged" if ended else "interrupted")
        assert said in found["trouble"] and str(path) in found["trouble"] and not found["more"]
        assert found["frames"] == shown == len(rows(data, 1.0))
        found, data = all_of(watched)


@pytest.mark.parametrize("kind", ["pipe", "folder", "endless"])
def test_a_dump_that_is_no_file_is_told(finished, tmp_path, kind):
    shutil.copytree(finished, tmp_path / "run")
    path = tmp_path / "run" / "dump.lammpstrj"
    path.unlink()
    {"pipe": os.mkfifo, "folder": os.mkdir, "endless": lambda path: path.symlink_to("/dev/zero")}[kind](path)
    with serving(tmp_path / "run") as server:
        for _ in range(2):
            found = asked(server, "run/0/state")
            assert found["status"] == "damaged" and "cannot be read" in found["message"] and found["frames"] == 0


def test_a_defect_while_frames_are_shown_is_told_from_then_on(finished, monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("no such luck")

    watched = WatchedRun(finished)
    monkeypatch.setattr("lammps_jump.analysis.report.frames.FramePacker.add", broken)
    with pytest.raises(ZeroDivisionError):
        watched.update()
    found = watched.update()
    assert found["status"] == "damaged" and "no such luck" in found["trouble"]


def test_what_a_page_keeps_is_thinned_and_sent_anew(finished, monkeypatch):
    monkeypatch.setattr("lammps_jump.analysis.report.frames.MOST_FRAMES", 10)
    found, data = all_of(WatchedRun(finished))
    assert found["frames"] <= 10 and found["of"] == "1-2"
    assert np.allclose(np.diff([time for time, *_ in rows(data, 1.0)]), 0.08)


def test_a_folder_of_another_kind_is_refused_in_words(finished, tmp_path):
    growing(finished, tmp_path / "run")
    (tmp_path / "run" / "case.yaml").write_text((finished / "case.yaml").read_text().replace("0.5", "0.6"))
    with serving(finished) as server:
        server.pages.runs.number(tmp_path / "run")
        status, _, data = send(server, "GET", f"/{server.token}/run/1/state")
        assert status == 422 and "was changed after the folder was made" in json.loads(data)["refused"]
        assert asked(server, "run/0/state")["status"] == "complete"
        for path in (
            "run/2/state",
            "run/-1/state",
            "run/00000000/state",
            "run/0",
            "run/0/../1/state",
            "run/0/case.yaml",
        ):
            assert send(server, "GET", f"/{server.token}/{path}")[0] == 404
        for path in ("frames?first=-1&of=1-0", "frames?first=x", "frames"):
            assert send(server, "GET", f"/{server.token}/run/0/{path}")[0] == 400
        assert asked(server, "run/0/frames?first=0&of=other") == b""


def test_a_report_acts_within_itself(finished, tmp_path):
    shutil.copytree(finished, tmp_path / "run")
    (tmp_path / "run" / "report.html").write_text("<script>fetch('../../save')</script>")
    with serving(tmp_path / "run") as server:
        status, told, body = send(server, "GET", f"/{server.token}/run/0/report")
        place = told["Location"]
        assert status == 303 and not body and server.token not in place
        assert send(server, "GET", f"/{server.token}/run/0/report")[1]["Location"] == place
        status, told, body = send(server, "GET", place)
        assert status == 200 and body == b"<script>fetch('../../save')</script>"
        # what it reads of its own address is good for nothing else
        for path in ("file", "run/0/state", "run/0/report", "report", "ask.js"):
            assert send(server, "GET", place + path)[0] == 403
        assert send(server, "POST", place, {})[0] == send(server, "POST", place + "run/0/stop", {})[0] == 403
        rules = told["Content-Security-Policy"]
        assert rules.startswith("sandbox allow-scripts") and "allow-same-origin" not in rules
        assert "default-src 'none'" in rules and "connect-src" not in rules
        (tmp_path / "run" / "report.html").unlink()
        (tmp_path / "run" / "report.html").symlink_to("/etc/passwd")
        assert send(server, "GET", f"/{server.token}/run/0/report")[0] == 404
        assert send(server, "GET", place)[0] == 403


def test_a_run_that_was_cut_off_is_called_so(finished, tmp_path):
    """Frames without a summary, a checkpoint or a process: they are shown, and there is a way to go on."""
    whole = growing(finished, tmp_path / "run")
    assert WatchedRun(tmp_path / "run").update()["status"] == "none"  # built, and never run
    (tmp_path / "run" / "dump.lammpstrj").write_bytes(whole[: 2 * len(whole) // 3])
    found, _ = all_of(WatchedRun(tmp_path / "run"))
    assert (found["status"], found["cut_off"]) == ("interrupted", True) and 10 < found["frames"] < 26
    assert "it was cut off and left no checkpoint" in found["message"]
    with serving(tmp_path / "run") as server:
        state = asked(server, "run/0/state")
        assert state["go_on"] == f"lammps-jump run {tmp_path / 'run'} --resume"


@pytest.mark.parametrize(
    ("status", "said"),
    [
        (75, "stopped, and can go on: lammps-jump run './a run' --resume"),
        pytest.param(
            0, "ended with status 0: lammps-jump build-and-run ./--help.yaml --out 'a run'", marks=pytest.mark.long
        ),
        pytest.param(
            1, "ended with status 1: lammps-jump build-and-run ./--help.yaml --out 'a run'", marks=pytest.mark.long
        ),
    ],
)
def test_what_is_said_of_a_run_at_the_end_can_be_typed(monkeypatch, tmp_path, status, said):
    monkeypatch.chdir(tmp_path)
    child = ServedChild(Path("a run"), "build-and-run", Path("./--help.yaml"), "--out", Path("a run"))
    assert child.wait() == 2 and "--help.yaml: no such case file" in " ".join(child.lines)
    monkeypatch.setattr(child.process, "poll", lambda: status)
    assert child.farewell == said.replace("./a run", "a run")


def test_runs_of_others_are_neither_stopped_nor_disturbed(finished, tmp_path):
    shutil.copytree(finished, tmp_path / "run")
    with serving(tmp_path / "run") as server, folders.locked(tmp_path / "run"):
        state = asked(server, "run/0/state")
        assert state["status"] == "running" and state["stop"] is None and f"process {os.getpid()}" in state["message"]
        status, _, data = send(server, "POST", f"/{server.token}/run/0/stop", {})
        assert status == 422 and "no run that was started here" in json.loads(data)["refused"]


def started(server):
    """Start the run of the case that is open; its command."""
    number = asked(server, "run", {"key": asked(server, "file")["key"]})["number"]
    return server.pages.children.of(server.pages.runs._runs[number].folder)


@pytest.fixture
def waiting(tmp_path, monkeypatch):
    """The engine waits at step 400, behind some frames; a function that starts a run and returns when it is there."""
    path = os.pathsep.join([str(HOOK), *filter(None, [os.environ.get("PYTHONPATH")])])
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.setenv("JUMP_TEST_SIGNAL", "0@400@engine")
    monkeypatch.setenv("JUMP_TEST_REACHED", str(pipe := tmp_path / "reached"))
    monkeypatch.delenv("JUMP_TEST_PROCESS", raising=False)
    os.mkfifo(pipe)

    def ended(child):
        child.wait()
        pipe.write_bytes(b"")  # so that nobody waits for a run that never comes there

    def start(server):
        reads = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
        child = started(server)
        watcher = threading.Thread(target=ended, args=(child,), daemon=True)
        watcher.start()
        select.select([reads], [], [])
        assert os.read(reads, 1) == b".", child.lines
        begun.append((watcher, reads))
        return child

    begun = []
    yield start
    for watcher, reads in begun:
        watcher.join()
        os.close(reads)


def test_run_and_stop_are_the_commands_that_they_show(tmp_path, monkeypatch):
    """The cheap form of the test below: nothing is run."""

    class Quiet(ServedChild):
        def __init__(self, folder, *words):
            self.folder, self.command, self._lines, done.words = folder, "", deque(), words
            self.process = SimpleNamespace(pid=4711, poll=lambda: done.status, send_signal=done.signals.append)
            self._reader = threading.Thread(target=int)

    done = SimpleNamespace(status=None, signals=[])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(children_module, "ServedChild", Quiet)
    (tmp_path / "falls.yaml").write_text(CASE)
    with serving(tmp_path / "falls.yaml") as server:
        plan = asked(server, "file")["run"]
        assert send(server, "POST", f"/{server.token}/run", {"key": "other"})[0] == 422
        started(server)
        assert plan["command"] == " ".join(map(str, ("lammps-jump", *done.words[:2])))
        assert asked(server, "run/0/state")["stop"] == "kill -TERM 4711"
        asked(server, "run/0/stop", {})
        assert done.signals == [signal.SIGTERM]
        done.status = 75
        assert not asked(server, "run/0/state")["own"]


@pytest.mark.long
def test_run_stop_and_go_on(finished, tmp_path, monkeypatch, waiting):
    """The engine waits at a step until it is stopped; what goes on ends with the bytes of the run without a stop."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "falls.yaml").write_text(CASE)
    with serving(tmp_path / "falls.yaml") as server:
        plan = asked(server, "file")["run"]
        assert plan == {"number": None, "command": f"lammps-jump build-and-run {tmp_path / 'falls.yaml'}"}
        assert send(server, "POST", f"/{server.token}/run", {"key": "other"})[0] == 422
        child = waiting(server)
        state = asked(server, "run/0/state")
        assert state["own"] and state["stop"] == f"kill -TERM {child.process.pid}" and 2 <= state["frames"] < 26
        asked(server, "run/0/stop", {})
        assert child.wait() == 75
        state = asked(server, "run/0/state")
        assert state["status"] == "interrupted" and state["go_on"] == "lammps-jump run runs/falls --resume"
        assert 0 < state["time"] < 0.5 and not state["own"]
        monkeypatch.delenv("JUMP_TEST_SIGNAL")
        asked(server, "run/0/go-on", {})
        assert server.pages.children.of(state_folder := server.pages.runs._runs[0].folder).wait() == 0
        found, data = all_of(server.pages.runs._runs[0])
        assert found["status"] == "complete" and found["frames"] == 26 == len(rows(data, 1.0))
        assert (state_folder / "dump.lammpstrj").read_bytes() == (finished / "dump.lammpstrj").read_bytes()
        plan = asked(server, "file")["run"]
        assert plan == {"number": 0, "command": "lammps-jump open runs/falls"}  # the same case is not run again
        (tmp_path / "falls.yaml").write_text(CASE.replace("[1.3, 1.5]", "[1.3, 1.6]"))
        assert asked(server, "file")["run"]["command"].endswith("--out runs/falls-2")


@pytest.mark.long
def test_what_was_started_here_is_stopped_when_the_server_ends(tmp_path, monkeypatch, waiting):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "falls.yaml").write_text(CASE)
    with serving(tmp_path / "falls.yaml") as server:
        child = waiting(server)
        assert server.pages.close() == [child]
    assert child.status == 75 and WatchedRun(tmp_path / "runs" / "falls").update()["status"] == "interrupted"


def test_times_of_frames_grow(finished):
    _, data = all_of(WatchedRun(finished))
    assert all(before < after for (before, *_), (after, *_) in pairwise(rows(data, 1.0)))
