# SPDX-License-Identifier: GPL-2.0-or-later
"""Dumps that are damaged or say something absurd: analysed, or refused in one sentence."""

from __future__ import annotations

import io
import random
import warnings
from functools import partial

import numpy as np
import pytest
from fault_table import many
from made_up import INPUTS, columns_of_discs, disc_frame

import lammps_jump as lj
from lammps_jump.analysis import pipeline
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError
from lammps_jump.runs import results

pytestmark = pytest.mark.fault("mutants of dumps")

ANALYSE = pipeline.analyse
MUTANTS = many(16, 500)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> bytes:
    """The text of a dump of a jump: a fast shallow stream against a deep slow one."""
    path = tmp_path_factory.mktemp("whole") / "dump.lammpstrj"
    with DumpWriter(path, ("id", "x", "y", "vx", "vy")) as out:
        for step in range(6):
            x, y = columns_of_discs(lambda x, step=step: np.where(x < 8 - 0.1 * step, 4, 14), 0, 14)
            speed = np.where(x < 8 - 0.1 * step, 10.0, 2.0)
            out.write_frame(disc_frame(x, y, speed, box=[(-1, 15), (-1, 9)], step=10 * step, time=0.1 * step))
    return path.read_bytes()


def outcome(data: bytes, folder, *, figures: str = "none", **given) -> str:
    """What became of the analysis of a dump: empty, or the message of the refusal."""
    path = folder / "dump.lammpstrj"
    path.write_bytes(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(pipeline, "analyse", partial(ANALYSE, pictures=pipeline.Pictures(figures)))
                results.analyse_dump(path, None, results.AnalysisInputs(**given), folder / "out")
    except DumpError as error:
        assert "\n" not in str(error) and len(str(error)) < 600
        return str(error)
    return ""


def with_value(data: bytes, column: int, value: str) -> bytes:
    """The dump with another value in a row of its last frame."""
    lines = data.decode().splitlines()
    row = lines[-3].split()
    row[column] = value
    lines[-3] = " ".join(row)
    return ("\n".join(lines) + "\n").encode()


def test_the_whole_dump_is_analysed(whole, tmp_path):
    assert outcome(whole, tmp_path, figures="default") == ""


ABSURD = [
    ("1e12", True),
    ("-1e300", True),
    ("nan", True),
    ("inf", True),
    ("1e308", True),
    ("1e5", False),
    ("-50", False),
]


OFTEN = {(1, "1e12"), (2, "nan"), (3, "1e308"), (4, "inf"), (1, "-50"), (2, "1e5")}
"""Each column and each kind of value; the others are long."""


@pytest.mark.parametrize(
    ("column", "value", "refused"),
    [
        pytest.param(column, *one, marks=[] if (column, one[0]) in OFTEN else pytest.mark.long)
        for column in (1, 2, 3, 4)
        for one in ABSURD
    ],
)
def test_an_absurd_value_is_refused_with_step_and_name(whole, tmp_path, column, value, refused):
    said = outcome(with_value(whole, column, value), tmp_path, bin_width=1e4 if (column, value) == (1, "1e5") else None)
    if refused:
        assert "step 50" in said and ("x", "y", "vx", "vy")[column - 1] + " is" in said


@pytest.mark.parametrize("value, refused", [("1e12", True), ("nan", True), ("1e9", False), ("-1e9", False)])
def test_a_film_with_an_absurd_height_is_bounded_or_refused(whole, tmp_path, value, refused):
    path = tmp_path / "dump.lammpstrj"
    path.write_bytes(with_value(whole, 2, value))
    try:
        written = results.animate(path, tmp_path / "film.gif", 5)
    except DumpError as error:
        assert refused and "step 50" in str(error)
    else:
        assert not refused and written.stat().st_size < 10_000_000


@pytest.mark.parametrize("value", ["nan", "-1", "1e300", "0"])
def test_an_absurd_id_or_radius_is_analysed_or_refused(whole, tmp_path, value):
    outcome(with_value(whole, 0, value), tmp_path)
    outcome(with_value(whole.replace(b" vx vy", b" vx radius"), 4, value), tmp_path)


@pytest.mark.parametrize(
    "value, said", [("-1", "id -1 is no"), ("2.5", "id 2.5 is no whole number"), ("7", "id 7 stands there twice")]
)
def test_an_id_that_is_none_is_refused(whole, tmp_path, value, said):
    assert said in outcome(with_value(whole, 0, value), tmp_path)


@pytest.mark.parametrize("step", ["1" + 400 * "0", "9223372036854775808", "-1" + 30 * "0"])
def test_a_step_beyond_all_counting_is_refused(whole, tmp_path, step):
    said = outcome(whole.replace(b"TIMESTEP\n50\n", f"TIMESTEP\n{step}\n".encode()), tmp_path)
    assert "expected a step number, found" in said


def mutants(data: bytes, number: int):
    """Dumps with bytes flipped, cut, doubled, or numbers replaced; the same each time."""
    numbers = [
        b"0",
        b"-1",
        b"1e300",
        b"nan",
        b"99999999999999999999",
        b"",
        b"x",
        b"-0",
        b"1e-320",
        b"\x00",
        b"inf",
        b"2",
    ]
    for seed in range(number):
        dice = random.Random(seed)
        changed = bytearray(data)
        for _ in range(dice.choice((1, 1, 3, 30))):
            place = dice.randrange(len(changed))
            kind = dice.randrange(5)
            if kind == 0:
                changed[place] ^= 1 << dice.randrange(8)
            elif kind == 1:
                del changed[place : place + dice.choice((1, 10, 1000, len(changed)))]
            elif kind == 2:
                changed[place:place] = changed[place : place + dice.choice((1, 100, 5000))]
            else:
                stop = place + 1
                while stop < len(changed) and changed[stop] not in b" \n":
                    stop += 1
                start = max(changed.rfind(b" ", 0, place), changed.rfind(b"\n", 0, place)) + 1
                changed[start:stop] = dice.choice(numbers)
            if not changed:
                break
        yield seed, bytes(changed)


def test_mutants_are_analysed_or_refused(whole, tmp_path, tried):
    refused = 0
    for seed, data in mutants(whole, MUTANTS):
        print(f"seed {seed}")
        refused += bool(outcome(data, tmp_path, figures="none" if seed % 8 else "all"))
    assert 0 < refused < MUTANTS
    tried(MUTANTS)


@pytest.mark.long
def test_a_bare_dump_of_a_young_jump(tmp_path):
    """Few discs stand in front of it: none need be connected to the bed that is guessed."""
    changes = ["initial=[]", "run.duration=3", "discs.sizes=null", "analysis.jump=false"]
    run = lj.load_case(INPUTS / "quick_jump.yaml", changes).run(tmp_path / "run", kernel="stock")
    assert outcome((run.folder / "dump.lammpstrj").read_bytes(), tmp_path, figures="all") == ""


@pytest.mark.parametrize(
    "given",
    [
        {"diameter": 1e6},
        {"density": 1e-300},
        *(pytest.param(one, marks=pytest.mark.long) for one in ({"diameter": 1e-6}, {"bin_width": 1e-3})),
    ],
)
def test_absurd_sizes_are_analysed_or_refused(whole, tmp_path, given):
    outcome(whole, tmp_path, **given)


def test_frames_without_discs_are_counted(tmp_path, monkeypatch):
    """A gzip file of 680 kB held 1.2 million of them, which took minutes."""
    monkeypatch.setattr("lammps_jump.dump.formats.MOST_EMPTY", 10)
    head = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS pp pp pp\n"
    head += 3 * "0 1\n" + "ITEM: ATOMS id x y\n"
    assert "no frame holds a disc" in outcome("".join(map(head.format, range(10))).encode(), tmp_path)
    assert "more than 10 frames without a disc" in outcome("".join(map(head.format, range(11))).encode(), tmp_path)


def test_frames_are_counted(whole, tmp_path, monkeypatch):
    monkeypatch.setattr("lammps_jump.dump.formats.MOST_FRAMES", 3)
    assert "more than 3 frames" in outcome(whole, tmp_path)


def test_a_binary_length_beyond_the_file_is_not_asked_of_memory(tmp_path):
    file = io.BytesIO()
    path = tmp_path / "dump.bin"
    with DumpWriter(path, ("id", "x", "y"), "binary") as out:
        out.write_frame(disc_frame([1.0, 2.0], [1.0, 1.0], box=[(0, 3), (0, 3)]))
    file.write(path.read_bytes())
    data = bytearray(file.getvalue())
    for place in range(0, len(data) - 4, 4):
        changed = bytearray(data)
        changed[place : place + 4] = (0x7FFFFFFF).to_bytes(4, "little")
        path.write_bytes(changed)
        try:
            for frame in lj.read_dump(path):
                assert frame.n <= 2
        except DumpError as error:
            assert "\n" not in str(error)
