# SPDX-License-Identifier: GPL-2.0-or-later
"""What looks at a run as it goes: progress line, newest frame, steady watch and log."""

from __future__ import annotations

import gzip
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up import INPUTS
from PIL import Image

from lammps_jump.analysis.grains.rest import SPAN
from lammps_jump.case import load_case
from lammps_jump.cli.live import SECONDS, LiveView
from lammps_jump.cli.progress import ProgressLine
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.tail import DumpTail
from lammps_jump.dump.write import DumpWriter
from lammps_jump.engines.choice import choose_ranks
from lammps_jump.engines.lammps.outputs import read_log
from lammps_jump.engines.native import run_native
from lammps_jump.engines.result import Progress
from lammps_jump.errors import DumpError
from lammps_jump.files import DUMP_NAMES
from lammps_jump.physics.inlet import Hydrograph
from lammps_jump.runs.steady import SteadyWatch, steady_window


@pytest.fixture
def scene():
    return load_case(INPUTS / "quick_jump.yaml").scene()


def frame_text(time: float, step: int, rows: np.ndarray, first: int = 1) -> str:
    body = "".join(f"{i} {x:.10g} {y:.10g} {vx:.10g} 0\n" for i, (x, y, vx) in enumerate(rows, first))
    return (
        f"ITEM: TIME\n{time:.10g}\nITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        f"ITEM: BOX BOUNDS ff ff pp\n-1 32\n-8 20\n-1 1\nITEM: ATOMS id x y vx vy\n{body}"
    )


def step_flow(toe: float, d: float = 0.15) -> np.ndarray:
    """Four layers at 10 m/s before the toe, sixteen at 2.5 m/s behind it: 20 m of channel."""
    rows = []
    for x in np.arange(0.5 * d, 20, d):
        layers, speed = (4, 10.0) if x < toe else (16, 2.5)
        rows += [(x, (j + 0.5) * d, speed) for j in range(layers)]
    return np.array(rows)


@pytest.mark.parametrize("drift, steady", [(0.0, True), (-0.6, False)])
def test_watch_stops_a_standing_jump_and_no_moving_one(tmp_path, scene, drift, steady):
    """The moving one passes half the channel in 17 s: 2.9 m in a window of 4.8 s, where 0.5 m is allowed."""
    watch = SteadyWatch(scene, tmp_path, (0.0, 20.0))
    random = np.random.default_rng(3)
    answers = []
    with (tmp_path / "dump.lammpstrj").open("w") as file:
        for k in range(150):
            toe = 12 + drift * 0.1 * k + 0.05 * random.standard_normal()
            file.write(frame_text(0.1 * k, k, step_flow(toe), first=1 + 40 * k))  # discs come and go
            file.flush()
            answers.append(watch())
    assert answers[-1] is steady
    assert bool(watch.reason) is steady
    if steady:
        # two looks, half a window apart, need a window and a half of record
        assert answers.index(True) * 0.1 >= 1.5 * steady_window(scene, (0.0, 20.0)) - 0.2


@pytest.mark.parametrize(
    ("speed", "said"), [(0.01, ", and the discs stand still"), pytest.param(1.0, "", marks=pytest.mark.long)]
)
def test_watch_ends_a_run_whose_inlet_is_drowned(tmp_path, scene, monkeypatch, speed, said):
    """Discs enter until 2 s; the watch looks at the place that it was given, wherever the process goes meanwhile."""
    monkeypatch.chdir(tmp_path)
    watch = SteadyWatch(scene, Path("."), (0.0, 20.0))
    monkeypatch.chdir("/")
    pool = step_flow(0.0) * (1, 1, speed / 2.5)
    with (tmp_path / "dump.lammpstrj").open("w") as file:
        for k in range(100):
            file.write(frame_text(0.1 * k, k, pool, first=1 + min(k, 20)))
    assert watch()
    window = steady_window(scene, (0.0, 20.0))
    assert watch.reason.endswith(f"the inlet is drowned, no disc has entered since t = 2 s{said}")
    assert 2 + window <= float(watch.reason.split("t = ")[1].split()[0]) <= 2.2 + window


def test_watch_reads_every_frame_once_and_leaves_the_unfinished(tmp_path, scene):
    watch = SteadyWatch(scene, tmp_path, (0.0, 20.0))
    assert watch() is False  # no dump yet
    fed = []
    watch.detector.feed = lambda time, *state: fed.append(time)
    path = tmp_path / "dump.lammpstrj"
    whole = [frame_text(t, t, step_flow(10)) for t in range(4)]
    path.write_text(whole[0] + whole[1][:300])
    watch()
    path.write_text(whole[0] + whole[1] + whole[2] + whole[3][:50])
    watch()
    path.write_text("".join(whole) + "ITEM: TIME\n")
    watch()
    assert fed == [0, 1, 2, 3]


def test_an_inflow_against_time_is_watched_once_its_table_has_ended(tmp_path, scene):
    slow = Hydrograph((0.0, 1.5), (0.2, 0.6), (20.0, 5.0))
    watch = SteadyWatch(replace(scene, hydrograph=slow), tmp_path, (0.0, 20.0))
    fed = []
    watch.detector.feed = lambda time, *state: fed.append(time)
    (tmp_path / "dump.lammpstrj").write_text(
        "".join(frame_text(t, t, step_flow(10)) for t in range(4)) + "ITEM: TIME\n"
    )
    watch()
    assert fed == [2, 3]
    assert steady_window(watch.scene, (0.0, 20.0)) >= 1.5 * 20.0 / 5.0  # at the speed that stays
    dry = replace(slow, depths=(0.6, 0.0))
    assert steady_window(replace(scene, hydrograph=dry), (0.0, 20.0)) is None


@pytest.mark.parametrize("dump_format", ["text", "gz", "binary"])
def test_without_inflow_a_run_ends_at_rest(tmp_path, dump_format):
    """A dam's discs move until 3 s; from then on they rest, and 20 sqrt(d/g) later the run may stop."""
    scene = load_case(INPUTS / "dam_break.yaml", ["run.stop_when_steady=true"]).scene()
    assert steady_window(scene, (0, 10)) is None and not any("stop_when_steady" in text for text in scene.warnings)
    watch, span = SteadyWatch(scene, tmp_path, (0, 10), dump_format), SPAN * (scene.diameter / 9.81) ** 0.5
    answers, (x, y) = [watch()], scene.positions.T
    with DumpWriter(tmp_path / DUMP_NAMES[dump_format], scene.dump_columns, dump_format) as file:
        for k, time in enumerate(np.arange(0.0, 4.0 + span, 0.1)):
            columns = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": 0 * x + (time < 2.95), "vy": 0 * y}
            columns |= {name: 0 * x + 0.1 for name in scene.dump_columns if name not in columns}
            file.write_frame(make_frame(k, time, ((-1, 90), (-1, 90)), columns))
            answers.append(watch())
    assert answers[-1] and not any(answers[: int(10 * (3.0 + span))])
    assert "the discs rest since t = 3 s" in watch.reason
    ended = float(watch.reason.split("t = ")[1].split()[0])
    assert 3 + span - 0.01 <= ended <= 3.21 + span  # frames every 0.1 s, the newest is whole with the next


def test_without_gravity_nothing_comes_to_rest(tmp_path):
    scene = load_case(INPUTS / "energy_box_16.yaml", ["run.stop_when_steady=true"]).scene()
    assert not any(scene.gravity) and any("stop_when_steady has no effect" in text for text in scene.warnings)
    assert SteadyWatch(scene, tmp_path, (0, 10))() is False


def test_a_gzip_dump_of_several_parts_is_read_on_and_damage_is_told(tmp_path):
    """A run that went on has written another gzip stream behind the first."""
    path, rows = tmp_path / "dump.lammpstrj.gz", step_flow(10)
    tail, seen = DumpTail(path, "gz"), []
    for k in range(3):
        with path.open("ab") as file:
            file.write(gzip.compress(frame_text(k, k, rows).encode()))
        seen.append([frame.step for frame in tail.new_frames()])
    assert seen == [[0], [1], [2]]
    with path.open("ab") as file:
        file.write(b"no gzip")
    with pytest.raises(DumpError, match="the gzip stream is damaged"):
        list(tail.new_frames())


def test_newest_frame_is_the_last_whole_one(tmp_path):
    path = tmp_path / "dump.lammpstrj"
    assert DumpTail(path).newest() is None
    whole = [frame_text(t, t, step_flow(10)) for t in range(3)]
    path.write_text(whole[0])
    assert DumpTail(path).newest() is None  # it may still be written to
    path.write_text("".join(whole))
    for guess in (2_000_000, 100):  # it grows until a frame fits
        frame = DumpTail(path).newest(guess)
        assert frame.step == 1 and frame.x == pytest.approx(step_flow(10)[:, 0])


def test_last_frame_of_an_ended_run_is_shown(tmp_path, scene, monkeypatch):
    """A run that is over before the first picture is due leaves one all the same."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    path = tmp_path / "dump.lammpstrj"
    whole = [frame_text(t, t, step_flow(10)) for t in range(2)]
    path.write_text("".join(whole))
    assert DumpTail(path).newest(ended=True).step == DumpTail(path).newest(guess=100, ended=True).step == 1
    monkeypatch.chdir(tmp_path)
    view = LiveView(scene, Path("."), lambda report: None)
    view(Progress(step=1, steps=1, time=0.1, discs=10))
    assert not view.picture.exists()
    monkeypatch.chdir("/")  # the folder of the run stays where it was
    view.finish()
    assert (tmp_path / "live.png").exists()


@pytest.fixture
def screen(monkeypatch):
    """A screen that is none: windows of `window_stand_in`."""
    import matplotlib.pyplot as plt
    import window_stand_in

    before = plt.get_backend(), plt.isinteractive()
    monkeypatch.setenv("DISPLAY", ":77")
    monkeypatch.setattr(window_stand_in, "shown", [])
    plt.switch_backend("module://window_stand_in")
    yield window_stand_in
    plt.close("all")
    plt.switch_backend(before[0])
    plt.interactive(before[1])


def watch(scene, folder, reports=3, then=lambda report: None):
    """A view fed with a growing dump; how many pictures the file and the window showed is left in them."""
    view = LiveView(scene, folder, then)
    with (folder / "dump.lammpstrj").open("w") as dump:
        dump.write(frame_text(-0.1, 0, step_flow(2)))
        for k in range(reports):
            dump.write(frame_text(0.1 * k, k, step_flow(4 + 4 * k)))
            dump.flush()
            view.shown -= 2 * SECONDS
            view(Progress(step=k, steps=reports, time=0.1 * k, discs=1000))
    return view


def test_live_view_shows_the_newest_frames_in_a_window(tmp_path, scene, screen, capfd):
    reports = []
    view = watch(scene, tmp_path, then=reports.append)
    assert [report.step for report in reports] == [0, 1, 2]
    assert len(screen.shown) == 3 and view.window is not None and capfd.readouterr().err == ""
    one, _, three = screen.shown
    assert one.shape == three.shape and (one != three).any()
    assert np.array_equal(np.asarray(Image.open(tmp_path / "live.png")), np.round(255 * three).astype(np.uint8))


@pytest.mark.parametrize(("mood", "pictures"), [("closed", 1), pytest.param("broken", 0, marks=pytest.mark.long)])
def test_a_window_that_is_closed_or_fails_ends_no_run(tmp_path, scene, screen, monkeypatch, mood, pictures):
    monkeypatch.setattr(screen, "mood", mood)
    scene = replace(scene, steps=2 * scene.output_steps)
    result = run_native(scene, tmp_path, progress=hurried(LiveView(scene, tmp_path, lambda report: None)))
    assert result.status == "complete" and len(screen.shown) <= pictures
    (tmp_path / "live.png").unlink(missing_ok=True)
    view = watch(scene, tmp_path)
    assert view.window is None and len(screen.shown) >= pictures
    assert (tmp_path / "live.png").exists()  # the file goes on without it


def hurried(view):
    """The view, drawing at every report."""

    def report(progress):
        view.shown -= 2 * SECONDS
        view(progress)

    return report


def test_no_screen_leads_to_the_file_and_a_note(tmp_path, scene, monkeypatch, capfd):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    view = watch(scene, tmp_path)
    assert view.window is None and (tmp_path / "live.png").exists()
    assert "no screen" in (note := capfd.readouterr().err) and "live.png" in note
    watch(scene, tmp_path, then=ProgressLine(1.0, quiet=True))
    assert capfd.readouterr().err == ""


def test_a_screen_that_does_not_answer_leads_to_the_file(tmp_path, scene, monkeypatch, capfd):
    monkeypatch.setenv("DISPLAY", ":77")
    monkeypatch.setattr("matplotlib.get_backend", lambda: "agg")  # what matplotlib falls back to there
    assert watch(scene, tmp_path).window is None
    assert "no toolkit" in capfd.readouterr().err
    monkeypatch.setattr("matplotlib.get_backend", lambda: "tkagg")
    monkeypatch.setattr("matplotlib.pyplot.ion", lambda: 1 / 0)
    assert watch(scene, tmp_path).window is None
    assert "no window can be opened (division by zero)" in capfd.readouterr().err


def test_progress_line_tells_time_discs_and_time_left():
    stream = io.StringIO()
    clock = iter((0.0, 90.0, 110.0))
    line = ProgressLine(10.0, stream=stream, clock=lambda: next(clock))
    line(Progress(step=0, steps=1000, time=0.0, discs=1234))
    assert stream.getvalue() == ""  # 90 s of compiling are no time of steps
    line(Progress(step=500, steps=1000, time=5.0, discs=1234))
    text = stream.getvalue()
    assert "t = 5.000 of 10 s" in text and "50 %" in text and "1234 discs" in text and "20 s left" in text
    quiet = io.StringIO()
    silent = ProgressLine(10.0, quiet=True, stream=quiet, clock=iter((0.0, 1.0, 20.0)).__next__)
    silent(Progress(1, 2, 1.0, 1))
    silent(Progress(2, 2, 1.0, 1))
    silent.finish()
    assert quiet.getvalue() == ""


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_progress_on_a_terminal_is_one_bar_with_the_same_numbers(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    stream, clock = Terminal(), iter((0.0, 0.1, 10.0, 20.0))
    line = ProgressLine(10.0, stream=stream, clock=lambda: next(clock))
    line(Progress(step=1, steps=1000, time=0.01, discs=1))
    assert stream.getvalue() == ""  # too early
    line(Progress(step=500, steps=1000, time=5.0, discs=1_000_000))
    line(Progress(step=600, steps=1000, time=6.0, discs=1_000_000))
    line.finish()
    text = stream.getvalue()
    assert "t = 5.000 of 10 s" in text and "10.0 M disc-steps/s" in text and "13 s left" in text
    assert text.count("\n") == 1 and "━" in text


def test_progress_of_a_part_that_goes_on_counts_from_its_first_report():
    stream, clock = io.StringIO(), iter((0.0, 5.0, 20.0))
    line = ProgressLine(10.0, stream=stream, clock=lambda: next(clock))
    line(Progress(step=900, steps=1000, time=9.0, discs=10))
    line(Progress(step=950, steps=1000, time=9.5, discs=10))
    assert "95 %" in stream.getvalue() and "15 s left" in stream.getvalue()


def test_progress_line_goes_on_with_the_analysis(monkeypatch):
    """It used to stand still at the last step it had shown, with no time left."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    stream, clock = Terminal(), iter((0.0, 0.0, 10.0, 10.1, 10.2, 10.3))
    line = ProgressLine(10.0, stream=stream, clock=lambda: next(clock))
    line(Progress(step=0, steps=1000, time=0.0, discs=10))
    line(Progress(step=870, steps=1000, time=8.7, discs=10))
    for doing in ("analysis: reading", "analysis: reading", "analysis: report"):
        line(Progress(step=1000, steps=1000, time=10.0, discs=10, doing=doing))
    line.finish()
    text = stream.getvalue()
    assert text.index("87 %") < text.index("analysis: reading") < text.index("analysis: report")
    assert text.count("analysis: reading") == 1  # too early for the same again


LOG = """\
LAMMPS (22 Jul 2025)
   Step          Time          Atoms      f_outlet_1     c_top
         0   0                      0   0             -1e+20
       100   0.1                  100   0             100
       200   0.2                  150   50            200
Loop time of 1.5 on 1 procs for 200 steps with 150 atoms
Pair    | 1.0        | 1.0        | 1.0        |   0.0 | 24.03
Other   |            | 0.1        |            |       | 11.75
Neighbor list builds = 7
"""


def test_log_is_read(tmp_path):
    path = tmp_path / "log.lammps"
    path.write_text(LOG)
    log = read_log(path)
    assert (log.step, log.time, log.discs, log.removed, log.highest_id) == (200, 0.2, 150, 50, 200)
    assert log.disc_steps == 0.5 * (0 + 100) * 100 + 0.5 * (100 + 150) * 100
    assert log.breakdown == {"pair": 1.0, "other": 0.1}
    assert log.error == ""
    path.write_text(LOG + "ERROR: Lost atoms: original 5 current 4\n")
    assert read_log(path).error.startswith("ERROR: Lost")
    assert read_log(tmp_path / "absent").step == 0


def test_ranks(scene):
    # one rank for a small scene whatever is free; a number is obeyed
    small = load_case(INPUTS / "energy_box_16.yaml").scene()
    assert choose_ranks("auto", small)[0] == 1
    assert choose_ranks(3, scene)[0] == 3
    assert choose_ranks(10_000, scene)[1]
    few = replace(scene, inlets=(), steps=1)
    assert few.expected_discs == len(scene.positions) > 0
    assert scene.expected_discs >= 2000
