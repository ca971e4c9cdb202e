# SPDX-License-Identifier: GPL-2.0-or-later
"""Poses of walls that the discs push: what is read of a file that grows, and what is refused."""

import pytest

from lammps_jump.dump.walls import PoseFile
from lammps_jump.errors import DumpError

HEAD = "time,wall,x,y,angle\n"


def test_poses_are_read_as_the_file_grows_and_are_straight_between(tmp_path):
    path = tmp_path / "walls.csv"
    poses = PoseFile(path, ["lid", "float"])
    assert poses.at(0.0) == {}  # not there yet
    path.write_text(f"{HEAD}0,lid,0,0,0\n0,float,1,0,0\n1,lid,0,-0.5,0.2\n1,float,3,0,0\n2,lid,0,-9")
    assert poses.at(0.0) == {"lid": (0, 0, 0), "float": (1, 0, 0)}
    assert poses.at(0.25)["lid"] == pytest.approx((0, -0.125, 0.05))
    assert poses.at(2.0)["lid"] == (0, -0.5, 0.2)  # its last line has no end yet
    with path.open("a") as file:
        file.write(".5,0.4\n\n2,float,4,0,0\n2,float,4,0,0\n")
    assert poses.at(2.0) == {"lid": (0, -9.5, 0.4), "float": (4, 0, 0)}
    assert poses.at(0.5)["float"] == pytest.approx((2, 0, 0))  # back in time
    assert poses.at(-1.0)["float"] == (1, 0, 0)


def test_the_velocity_of_a_wall_is_that_of_its_rows(tmp_path):
    """Exact for a steady push; at rest at first; the same before the next row is there."""
    path, times = tmp_path / "walls.csv", [0.0, 0.1, 0.3, 0.4]
    rows = [f"{t:.15g},lid,{3 * t * t:.17g},{2 * t:.17g},{-t * t:.17g}\n" for t in times]
    found = []
    for count in (3, 4):
        path.write_text(HEAD + "".join(rows[:count]))
        poses = PoseFile(path, ["lid"])
        found.append(poses.rates(0.3)["lid"])
        assert found[-1] == pytest.approx((1.8, 2.0, -0.6)) and poses.rates(0.0)["lid"] == (0, 0, 0)
        assert poses.rates(0.1)["lid"] == pytest.approx((0.3, 2.0, -0.1))  # two rows: the mean between them
    assert found[0] == found[1] and poses.rates(0.4)["lid"] == pytest.approx((2.4, 2.0, -0.8))


@pytest.mark.parametrize(
    "text",
    [
        "time,x\n",
        f"{HEAD}0,sill,0,0,0\n",
        f"{HEAD}0,lid,0,0\n",
        f"{HEAD}0,lid,0,0,0,0\n",
        f"{HEAD}0,lid,0,nan,0\n",
        f"{HEAD}0,lid,0,1e999,0\n",
        f"{HEAD}0,lid,0,0,0\n0,lid,1,0,0\n",
        f"{HEAD}x,lid,0,0,0\n",
        f"{HEAD}0,lid,0,0,\ud800\n",
    ],
)
def test_lines_that_are_no_rows_are_refused(tmp_path, text):
    path = tmp_path / "walls.csv"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(DumpError, match=r"walls\.csv"):
        PoseFile(path, ["lid"]).at(0.0)


def test_a_file_that_is_none_or_too_large_is_refused(tmp_path, monkeypatch):
    (tmp_path / "walls.csv").mkdir()
    with pytest.raises(DumpError, match="cannot be read"):
        PoseFile(tmp_path / "walls.csv", ["lid"]).at(0.0)
    (tmp_path / "more.csv").write_text(HEAD)
    monkeypatch.setattr("lammps_jump.dump.walls.MOST_POSES", 5)
    with pytest.raises(DumpError, match="at most 5 are read"):
        PoseFile(tmp_path / "more.csv", ["lid"]).at(0.0)


@pytest.mark.fault("wrong frames, discs or forces")
def test_rows_beyond_the_frames_of_the_run_are_refused(tmp_path):
    path = tmp_path / "walls.csv"
    path.write_text(HEAD + "".join(f"{time},lid,0,0,0\n" for time in range(3)))
    assert PoseFile(path, ["lid"], 3).at(2.0) == {"lid": (0, 0, 0)}
    with pytest.raises(DumpError, match="line 4: more rows of the wall lid than the 2 frames of the run"):
        PoseFile(path, ["lid"], 2).at(2.0)
