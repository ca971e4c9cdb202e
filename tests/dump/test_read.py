# SPDX-License-Identifier: GPL-2.0-or-later
"""The reader on files of LAMMPS, on its own writer's and on damaged ones."""

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import examples

from lammps_jump.dump.check import damages
from lammps_jump.dump.find import find_dump, read_dump
from lammps_jump.dump.frame import make_frame, require_finite
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError

DATA = Path(__file__).parents[1] / "data"
HEAD = (
    "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS ff ff pp\n0 10\n0 5\n-0.1 0.1\n"
    "ITEM: ATOMS {c}\n"
)


def text(rows, step=0, columns="id x y vx vy", n=None):
    return HEAD.format(step=step, n=len(rows) if n is None else n, c=columns) + "".join(f"{row}\n" for row in rows)


def write(tmp_path, content, name="dump"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_text_and_binary_of_lammps_hold_the_same_frames():
    a, b = list(open_dump(DATA / "lammps_dump.lammpstrj")), list(open_dump(DATA / "lammps_dump.lammpsbin"))
    assert [f.step for f in a] == [f.step for f in b] == [0, 100, 200, 300]
    assert [f.n for f in a] == [30] * 4
    for one, other in zip(a, b, strict=True):
        assert one.time == pytest.approx(other.time, abs=1e-15)
        np.testing.assert_array_equal(one.box, other.box)
        for name in ("x", "y", "vx", "vy"):
            # the text has ten digits
            np.testing.assert_allclose(one.columns[name], other.columns[name], rtol=6e-10, atol=0)
    assert open_dump(DATA / "lammps_dump.lammpsbin").units == "si"
    assert open_dump(DATA / "lammps_dump_no_units.bin").units is None


def test_scaled_positions_are_laid_out_in_the_box():
    scaled = next(iter(open_dump(DATA / "lammps_dump_scaled.lammpstrj"))).sorted()
    plain = next(iter(open_dump(DATA / "lammps_dump.lammpstrj"))).sorted()
    # six digits of a box of 10 m
    np.testing.assert_allclose(scaled.x, plain.x, atol=1e-5)
    np.testing.assert_allclose(scaled.y, plain.y, atol=1e-5)


@pytest.mark.parametrize(
    ("source", "fmt"),
    [("lammps_dump.lammpstrj", "text"), ("lammps_dump.lammpsbin", "binary"), ("lammps_dump_no_units.bin", "binary")],
)
def test_the_writer_gives_the_bytes_of_lammps(tmp_path, source, fmt):
    dump = open_dump(DATA / source)
    with DumpWriter(tmp_path / "copy", dump.columns, fmt, units=dump.units) as writer:
        for frame in dump:
            writer.write_frame(frame)
    assert (tmp_path / "copy").read_bytes() == (DATA / source).read_bytes()


numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)


@examples(60)
@given(
    frames=st.lists(st.lists(st.tuples(numbers, numbers), max_size=5), min_size=1, max_size=4),
    fmt=st.sampled_from(["text", "gz", "binary"]),
    time=st.one_of(st.none(), st.floats(-10, 10)),
)
def test_what_was_written_is_read_back_bit_by_bit(tmp_path_factory, frames, fmt, time):
    path = tmp_path_factory.mktemp("round") / "dump"
    with DumpWriter(path, ("id", "x", "y"), fmt, precision="%.17g") as writer:
        for step, points in enumerate(frames):
            x, y = np.array(points, float).reshape(-1, 2).T
            columns = {"id": np.arange(len(x)) + 1, "x": x, "y": y}
            now = None if time is None else time + step
            writer.write_frame(make_frame(step, now, [[0, 1], [0, 1]], columns))
    dump = open_dump(path)
    for _ in range(2):  # iterable again
        read = list(dump)
        assert [frame.n for frame in read] == [len(points) for points in frames]
        for frame, points in zip(read, frames, strict=True):
            expected = np.array(points, float).reshape(-1, 2)
            np.testing.assert_array_equal(frame.x, expected[:, 0])
            np.testing.assert_array_equal(frame.y, expected[:, 1])
            known = None if time is None else pytest.approx(time + frame.step, rel=1e-15, abs=0)
            assert frame.time == known
    assert dump.warnings == [] and dump.count() == len(frames)


@examples(300)
@given(
    token=st.one_of(
        numbers.map(repr),
        numbers.map(lambda v: f"{v:.17e}"),
        numbers.map(lambda v: f"{v:.10g}"),
        st.decimals(allow_nan=False, allow_infinity=False, places=12, min_value=-(10**6), max_value=10**6).map(str),
        st.sampled_from(["+1", "-.5", "5.", "0", "-0", "1e5", "1E-05", "123456789012345678901234", "5e-324", "inf"]),
    )
)
def test_every_number_is_rounded_as_python_rounds_it(tmp_path_factory, token):
    path = tmp_path_factory.mktemp("number") / "dump"
    path.write_text(text([f"{token} 1 2"], columns="a x y"))
    value = next(iter(open_dump(path))).columns["a"][0]
    assert value == float(token) and np.signbit(value) == np.signbit(float(token))


def test_random_17_digit_numbers_are_exact(tmp_path):
    rng = np.random.default_rng(20)
    values = rng.normal(size=4000) * 10.0 ** rng.integers(-30, 30, 4000)
    path = write(tmp_path, text([f"{v:.17g} 1 2" for v in values], columns="a x y"))
    np.testing.assert_array_equal(next(iter(open_dump(path))).columns["a"], values)


def test_nan_and_words_and_windows_line_ends(tmp_path):
    rows = ["1 Ar nan 2 -inf", "2 He 1.5 3 4"]
    dump = open_dump(write(tmp_path, text(rows, columns="id element x y vx").replace("\n", "\r\n")))
    (frame,) = dump
    assert np.isnan(frame.x[0]) and frame.columns["vx"][0] == -np.inf and list(frame.ids) == [1, 2]
    assert "element" not in frame.columns and "element" in dump.warnings[0]


LIGGGHTS = "id type type x y z ix iy iz vx vy vz fx fy fz omegax omegay omegaz radius"


@pytest.mark.parametrize("compressed", [False, True])
def test_a_column_that_stands_twice_with_equal_values_is_taken_once(tmp_path, compressed):
    """As the examples of LIGGGHTS write dumps; also a column that is no number, and one that comes again later."""
    rows = [f"{i} 1 1 0.{i} 0.5 0 0 0 0 1 -{i} 0 0 0 0 0 0 2 0.05" for i in (1, 2, 3)]
    content = (text(rows, columns=LIGGGHTS) + text(rows, columns=LIGGGHTS, step=5)).encode()
    (tmp_path / "d").write_bytes(gzip.compress(content) if compressed else content)
    dump = open_dump(tmp_path / "d")
    one, two = dump
    assert dump.columns == tuple(dict.fromkeys(LIGGGHTS.split())) and not dump.warnings
    for frame in (one, two):
        assert list(frame.columns) == list(dump.columns)
        assert list(frame.x) == [0.1, 0.2, 0.3] and list(frame.vy) == [-1, -2, -3] and set(frame.radii) == {0.05}
    other = open_dump(write(tmp_path, text(["1 nan 2 nan 1", "2 0 2 0 2"], columns="id vx x vx id")))
    (frame,) = other
    assert np.isnan(frame.vx[0]) and list(frame.ids) == [1, 2]


def test_the_number_of_discs_and_their_order_may_change(tmp_path):
    content = text(["3 3 0 0 0", "1 1 0 0 0"]) + text([], step=1) + text(["2 2 0 0 0"], step=2)
    dump = open_dump(write(tmp_path, content))
    frames = list(dump)
    assert [f.n for f in frames] == [2, 0, 1]
    assert list(frames[0].sorted().ids) == [1, 3] and list(frames[0].sorted().x) == [1, 3]
    assert [h.step for h in dump.headers()] == [0, 1, 2]
    assert [f.step for f in dump.select([2, 0])] == [0, 2]


def test_a_missing_column_names_those_there_are(tmp_path):
    frame = next(iter(open_dump(write(tmp_path, text(["1 2 3"], columns="id x y")))))
    with pytest.raises(DumpError, match=r"no column 'vx'.*id x y"):
        _ = frame.vx
    with pytest.raises(ValueError, match="read-only"):
        frame.x[0] = 1.0


GOOD = text(["1 1 2 3 4", "2 5 6 7 8"])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is empty"),
        ("\n\n  \n", "is empty"),
        ("hello world, this is no dump\n", "line 1"),
        (bytes(range(256)) * 4, "not a LAMMPS dump"),
        (struct.pack("<qq", 0, 30) + bytes(200), "binary2txt"),
        (text(["1 1 2 3 4", "2 5 six 7 8"]), r"line 11: expected a number for y, found 'six'"),
        (text(["1 1 2 3 4", "2 5 6 7"]), r"line 11: expected 5 values"),
        (text(["1 1 2 3 4", "2 5 6 7 8 9"]), r"line 11: expected 5 values"),
        (text(["1 1 2 3 4", "", "2 5 6 7 8"], n=2), r"line 11: expected 5 values"),
        (text(["1 1 2 3 4", "2 5 6 7 8"], n=1), r"line 11: expected the next frame|line 11: expected 'ITEM"),
        (text(["1 1 2 3 4"], n=2) + GOOD, r"line 11: expected disc 2 of 2"),
        (text(["1 1 2 3 4", "2 5 6_0 7 8"]), r"line 11: expected a number for y"),
        (
            text(["1 1 1", "2 1 2"], columns="id x x"),
            r"step 0: the column x stands twice in 'id x x', and row 2 .* 1 and 2",
        ),
        (GOOD.replace("id x y vx vy", "id x y x vy"), "the column x stands twice"),
        (GOOD.replace("ITEM: TIMESTEP\n0\n", ""), "ITEM: TIMESTEP' first"),
        (GOOD.replace("NUMBER OF ATOMS\n2", "NUMBER OF ATOMS\n-2"), "line 4: expected a number of discs"),
        (GOOD.replace("NUMBER OF ATOMS\n2", "NUMBER OF ATOMS\ntwo"), "line 4: expected a number of discs"),
        (GOOD.replace("0 10", "0 ten"), "line 6: expected two bounds"),
        (GOOD.replace("ITEM: BOX", "ITEM: BIX"), "line 5"),
        (GOOD[:40], "inside its first frame"),
        (GOOD.replace("NUMBER OF ATOMS\n2", "NUMBER OF ATOMS\n7000000000"), "too short for 7000000000 discs"),
        (b"\x1f\x8b\x08\x00" + bytes(30), "empty|first frame|not a LAMMPS"),
        (b"\x28\xb5\x2f\xfd" + bytes(30), "zstd"),
    ],
)
def test_a_wrong_file_is_an_error_that_tells_where(tmp_path, content, message):
    with pytest.raises(DumpError, match=message):
        list(open_dump(write(tmp_path, content)))


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(DumpError, match="No such file"):
        open_dump(tmp_path / "nothing")
    with pytest.raises(DumpError, match="folder"):
        open_dump(tmp_path)


@pytest.mark.parametrize("cut", [1, 5, 20, 60, 100])
def test_a_cut_off_last_frame_is_reported_and_skipped(tmp_path, cut):
    dump = open_dump(write(tmp_path, (GOOD + GOOD)[:-cut]))
    assert len(list(dump)) == 1
    assert "cut off" in dump.warnings[0] and "number 2" in dump.warnings[0]
    assert dump.count() == 1


@pytest.mark.parametrize("keep", [1400, 1500, 2000, 2700])
def test_a_cut_off_binary_frame_is_reported_and_skipped(tmp_path, keep):
    dump = open_dump(write(tmp_path, (DATA / "lammps_dump.lammpsbin").read_bytes()[:keep]))
    assert len(list(dump)) == 1 and "cut off" in dump.warnings[0]


def test_a_cut_off_gzip_stream_keeps_its_whole_frames(tmp_path):
    rng = np.random.default_rng(3)
    path = tmp_path / "dump.gz"
    with DumpWriter(path, ("id", "x", "y"), "gz") as writer:
        for step in range(20):
            x, y = rng.random((2, 500))
            writer.write_frame(make_frame(step, None, [[0, 1], [0, 1]], {"id": np.arange(500), "x": x, "y": y}))
    whole = path.read_bytes()
    assert gzip.decompress(whole).startswith(b"ITEM: UNITS")
    dump = open_dump(write(tmp_path, whole[: len(whole) // 2], "half.gz"))
    frames = list(dump)
    assert 5 <= len(frames) <= 14 and "cut" in dump.warnings[0]


def test_damaged_binary_is_an_error(tmp_path):
    good = bytearray((DATA / "lammps_dump.lammpsbin").read_bytes())
    good[0x9B] = 7  # size of the only block
    with pytest.raises(DumpError, match="does not fit"):
        list(open_dump(write(tmp_path, bytes(good))))


@examples(300)
@given(
    source=st.sampled_from(["lammps_dump.lammpstrj", "lammps_dump.lammpsbin", "lammps_dump_scaled.lammpstrj"]),
    changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=4),
    cut=st.floats(0.2, 1.0),
    head=st.booleans(),
)
def test_damaged_files_end_in_frames_or_in_our_error(tmp_path_factory, source, changes, cut, head):
    content = bytearray((DATA / source).read_bytes())
    for place, byte in changes:
        content[int(place * (200 if head else len(content)))] = byte
    path = tmp_path_factory.mktemp("damaged") / "dump"
    path.write_bytes(content[: int(cut * len(content))])
    try:
        frames = list(open_dump(path))
    except DumpError as error:
        assert str(path) in str(error)
    else:
        assert 1 <= len(frames) <= 4


def test_a_frame_larger_than_the_buffer(tmp_path):
    n = 200_000
    x = np.arange(n) / 7
    path = tmp_path / "dump"
    with DumpWriter(path, ("id", "x", "y"), precision="%.17g") as writer:
        for step in range(2):
            writer.write_frame(make_frame(step, 0.1 * step, [[0, 1], [0, 1]], {"id": np.arange(n), "x": x, "y": -x}))
    frames = list(open_dump(path))
    assert [f.n for f in frames] == [n, n]
    np.testing.assert_array_equal(frames[1].y, -x)


def test_frames_from_arrays_must_agree_in_length():
    assert make_frame(0, None, [[0, 1], [0, 1]], {"x": [1, 2], "y": [3, 4]}).n == 2
    with pytest.raises(DumpError, match="differ in length"):
        make_frame(0, None, [[0, 1], [0, 1]], {"x": [1, 2], "y": [3]})


def test_the_writer_says_what_is_wrong(tmp_path):
    with pytest.raises(DumpError, match="text, gz or binary"):
        DumpWriter(tmp_path / "a", ("id",), "xml")
    with pytest.raises(DumpError, match="cannot be written"):
        DumpWriter(tmp_path / "no" / "a", ("id",))
    with DumpWriter(tmp_path / "b", ("id", "x")) as writer, pytest.raises(DumpError, match="lacks column 'x'"):
        writer.write_frame(make_frame(0, None, [[0, 1], [0, 1]], {"id": [1]}))


def series(folder, steps=(0, 500, 1000), name="dump.{}.lammps"):
    """Files of one frame each, as LAMMPS writes them for a ``*`` in the name of the dump."""
    for step in steps:
        (folder / name.format(step)).write_text(text(["1 1 2", "2 5 6"], columns="id x y", step=step))
    return folder


def test_files_of_a_frame_each_are_one_dump(tmp_path):
    folder = series(tmp_path)
    for place in (folder, folder / "dump.*.lammps"):
        dump = read_dump(place)
        assert dump.columns == ("id", "x", "y")
        # 1000 comes after 500, though not in the alphabet
        assert [header.step for header in dump.headers()] == [frame.step for frame in dump] == [0, 500, 1000]
        assert dump[1].step == 500 and len(dump) == 3
        assert dump.path == folder / "dump.*.lammps" and not dump.warnings
    files = [folder / f"dump.{step}.lammps" for step in (1000, 0, 500)]
    assert find_dump(*files) == folder / "dump.*.lammps"
    with pytest.raises(DumpError, match=r"allowed is one dump, or all files of one pattern.*'dump\.\*\.lammps'"):
        find_dump(*files[:2])
    with pytest.raises(DumpError, match="no such file"):
        find_dump(folder / "other.*.lammps")


def test_the_last_file_of_a_killed_run_may_be_cut_off(tmp_path):
    folder = series(tmp_path)
    last = folder / "dump.1000.lammps"
    for rest in (last.read_text()[:-8], ""):
        last.write_text(rest)
        dump = read_dump(folder)
        assert len(dump) == 2 and len(dump.warnings) == 1 and "dump.1000.lammps" in dump.warnings[0]
    (folder / "dump.500.lammps").write_text("")
    with pytest.raises(DumpError, match=r"dump\.500\.lammps is empty"):
        len(read_dump(folder))


def test_files_of_two_runs_are_no_dump(tmp_path):
    for run in (1, 2):
        series(tmp_path, name=f"dump.{run}_{{}}.lammps")
    with pytest.raises(DumpError, match=r"dump\.2_0\.lammps: step 0 follows step 1000 .*pattern in quotes"):
        list(read_dump(tmp_path))
    assert len(read_dump(tmp_path / "dump.2_*.lammps")) == 3


def test_the_first_column_at_fault_is_named():
    """Columns were looked at in an order that changed from run to run."""
    names = ("vy", "id", "y", "vx", "x", "radius")
    frame = make_frame(7, 0.0, [(0, 1), (0, 1)], {name: [np.nan] for name in names})
    with pytest.raises(DumpError, match="step 7, row 1 of the frame: vy is nan, not a number"):
        require_finite(frame, "dump")


def with_steps(path, steps, fmt="text"):
    """A dump whose only disc is at x = its step, with times where `steps` are pairs."""
    with DumpWriter(path, ("id", "x", "y"), fmt) as writer:
        for step, time in ((one if isinstance(one, tuple) else (one, None)) for one in steps):
            writer.write_frame(make_frame(step, time, [[0, 1], [0, 1]], {"id": [1], "x": [step], "y": [0]}))
    return path


NOT_FORWARD = {
    "frame twice": ([0, 10, 20, 20, 30], [0, 10, 20, 30], "frame 4 is at step 20, after step 20: it does not advance"),
    "restart appended": (
        [0, 10, 20, 30, 20, 30, 40],
        [0, 10, 20, 30, 40],
        "frame 5 is at step 20, after step 30: 2 frames that do not advance were passed over",
    ),
    "minimised, then run": ([0, 37, 0, 10, 50], [0, 37], "frame 3 is at step 0, after step 37: another run begins"),
    "two runs": ([5, 10, 0, 5, 50], [5, 10], "only the 2 frames before it are used"),
    "other run after one frame": ([9, 0, 10], [9], "only the 1 frame before it is used"),
    "time falls back": (
        [(0, 0.0), (10, 0.1), (20, 0.05), (30, 0.2)],
        [0, 10, 30],
        r"frame 3 is at step 20 (0.05 s), after step 10 (0.1 s)",
    ),
    "forward": ([-20, -10, 0, 10], [-20, -10, 0, 10], ""),
}


@pytest.mark.parametrize("fmt", ["text", "gz", "binary"])
@pytest.mark.parametrize("kind", NOT_FORWARD)
def test_frames_that_do_not_advance_are_passed_over_and_told(tmp_path, kind, fmt):
    steps, used, said = NOT_FORWARD[kind]
    dump = open_dump(with_steps(tmp_path / "dump", steps, fmt))
    for found in (dump.headers(), list(dump), list(dump[:]), [dump[k] for k in range(len(used))]):
        assert [frame.step for frame in found] == used
    assert [frame.x[0] for frame in dump] == used and len(dump) == len(used)
    (told,) = dump.warnings or [""]
    assert said in told and damages(dump.warnings) == dump.warnings


def test_a_pattern_of_parts_that_overlap_goes_forward(tmp_path):
    """Each part of a run that was restarted repeats the step of the restart; of two runs none is guessed."""
    for part, steps in enumerate([[0, 10, 20], [20, 30], [20, 30, 40]]):
        with_steps(tmp_path / f"dump.{part}", steps)
    dump = read_dump(tmp_path)
    assert [frame.step for frame in dump] == [0, 10, 20, 30, 40] and "3 frames that do not advance" in dump.warnings[0]
    with_steps(tmp_path / "dump.3", [0, 50])
    with pytest.raises(DumpError, match=r"dump\.3: step 0 follows step 40"):
        list(read_dump(tmp_path))


@pytest.mark.parametrize("row", ["# note", "  # 1 2 3 4 5", "#"])
@pytest.mark.parametrize("place", [0, 9, 10, 11, 18, 20, 22])
def test_a_comment_is_passed_over_and_told(tmp_path, row, place):
    lines = (GOOD + GOOD.replace("TIMESTEP\n0", "TIMESTEP\n7")).splitlines()
    lines.insert(place, row)
    if place == 0:  # what a file begins with says what it is
        with pytest.raises(DumpError, match="line 1"):
            open_dump(write(tmp_path, "\n".join(lines) + "\n"))
        return
    dump = open_dump(write(tmp_path, "\n".join(lines) + "\n"))
    for frames in ([dump[0], dump[1]], list(dump)):
        assert [list(frame.x) for frame in frames] == [[1, 5], [1, 5]]
    (told,) = dump.warnings
    step = 0 if place <= 11 else 7
    assert f"line {place + 1}: a comment at step {step} was passed over" in told and damages([told])
    assert dump.count() == 2
    lines[22 if place < 22 else 21] = "2 5 six 7 8"
    with pytest.raises(DumpError, match=r"line 2[23]: expected a number for y"):
        list(open_dump(write(tmp_path, "\n".join(lines) + "\n")))


@pytest.mark.parametrize("cut", [1, 4, 8, 9, 10, 17])
def test_a_run_that_was_killed_and_appended_to_is_read_on(tmp_path, cut):
    """The torn frame is told and left out, wherever in its rows it ends; the next ones are whole."""
    parts = [GOOD.replace("TIMESTEP\n0", f"TIMESTEP\n{step}") for step in (0, 5, 5, 10)]
    dump = open_dump(write(tmp_path, parts[0] + parts[1][:-cut] + parts[2] + parts[3]))
    steps = [header.step for header in dump.headers()]
    if cut == 1:  # only the newline is missing: LAMMPS' next word is behind the last number
        assert steps == [0, 5, 10]
    assert steps == [frame.step for frame in dump] == [0, 5, 10]
    (told,) = dump.warnings
    assert "step 5: the frame from line" in told and "another begins there; it was passed over" in told
    assert damages([told]) == [told]
    with pytest.raises(DumpError, match="expected disc"):  # frames that are all too short are no killed run
        list(open_dump(write(tmp_path, parts[0] + 3 * parts[1][:-cut])))
