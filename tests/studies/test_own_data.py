# SPDX-License-Identifier: GPL-2.0-or-later
"""A person's measured curve against that of a run: known distances, and what is refused."""

import json
import re

import numpy as np
import pytest

from lammps_jump.cli.app import main
from lammps_jump.errors import CaseError
from lammps_jump.studies import compare_with_data


def made_run(folder, shift=0.0):
    folder.mkdir(parents=True)
    time = np.linspace(0, 10, 101)
    rows = [f"{t},{2 * t + shift},{'' if t > 5 else 1.0}" for t in time]
    (folder / "gauges.csv").write_text("\n".join(["time,depth_5,depth_9", *rows]) + "\n")
    (folder / "summary.json").write_text('{"status": "complete"}')
    return folder


@pytest.fixture
def data(tmp_path):
    path = tmp_path / "wave.csv"
    path.write_text("# of a gauge\nt, h\n1, 1.9\n2, 4.1\n3, 5.9\n12, 3\n")
    return path


def test_distance_of_one_run(tmp_path, data):
    (found,), out = compare_with_data(made_run(tmp_path / "run"), data, "time=t,gauges.depth_5=h", tmp_path / "out")
    assert (found.points, found.points_measured, found.starts) == (3, 4, 1)
    assert found.mean == pytest.approx(0.1 / 3) and found.rms == pytest.approx(0.1)
    assert found.rms_over_range == pytest.approx(0.1 / 4.0) and np.isnan(found.mean_interval)
    assert json.loads((out / "compared.json").read_text())[0]["mean_interval"] is None
    assert "3 of 4" in (out / "compared.md").read_text() and (out / "compared.png").stat().st_size > 1000


def test_interval_over_starts(tmp_path, data):
    for k in range(4):
        made_run(tmp_path / "study" / "runs" / str(k), 0.1 * k)
    (found,), _ = compare_with_data(tmp_path / "study", data, "time=t,gauges.depth_5=h", tmp_path / "out")
    assert found.starts == 4 and found.mean == pytest.approx(0.15 + 0.1 / 3)
    assert found.mean_interval == pytest.approx(3.182446 * np.std([0, 0.1, 0.2, 0.3], ddof=1) / 2)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ("time=t", "expected AXIS=COLUMN,TABLE.COLUMN=COLUMN"),
        ("time=t,depth=h", "expected AXIS=COLUMN"),
        ("time=t,gauges.depth_7=h", "gauges.csv has no column depth_7; there are time, depth_5, depth_9"),
        ("time=t,front.x=h", "no table front; there are gauges, profiles"),
        ("time=t,gauges.depth_5=depth", "has no column depth; there are t, h"),
        ("time=h,gauges.depth_9=t", "2 are needed; are the units the same"),
    ],
)
def test_what_is_refused(tmp_path, data, columns, said):
    run = made_run(tmp_path / "run")
    if "units" in said:
        data.write_text("t,h\n1,100\n2,200\n")
    with pytest.raises(CaseError, match=re.escape(said)):
        compare_with_data(run, data, columns, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_value_that_is_no_number_and_the_command(tmp_path, data, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = made_run(tmp_path / "run")
    assert _status(["compare", str(run), str(data)]) == 2
    assert _status(["compare", str(run), str(data), "--columns", "time=t,gauges.depth_5=h"]) == 0
    assert "| gauges.depth_5 | h | 3 of 4 |" in capsys.readouterr().out
    assert (tmp_path / "run_against_wave" / "compared.png").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# mine\nt,h\n1,2\n\n2,two\n3,4\n", "wave.csv, line 5, column h: 'two' is no finite number; write"),
        ("t,h\n1,\n2,3\n", "line 2, column h: '' is no finite number"),
        ("t,h\n1,inf\n2,3\n", "line 2, column h: 'inf' is no finite number"),
        ("t,h\n1,2,3\n2,3\n", "line 2: 3 values, but 2 heads"),
        ("t;h\n1;2\n2;3\n", "no column t; there are t;h; put commas between the columns"),
        ("t,h,h\n1,2,3\n2,3,4\n", "more than one column h; there are t, h, h"),
        ("t,h\n1,2\n", "has 1 rows below its heads; 2 are needed"),
        ("", "has 0 rows below its heads"),
        (b"\xff\xfet\x00", "cannot be read: it is no text in UTF-8; name a CSV file"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_place(tmp_path, data, text, said):
    run = made_run(tmp_path / "run")
    data.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CaseError, match=re.escape(said)):
        compare_with_data(run, data, "time=t,gauges.depth_5=h", tmp_path / "out")
    with pytest.raises(CaseError, match=re.escape("none.csv cannot be read: No such file")):
        compare_with_data(run, tmp_path / "none.csv", "time=t,gauges.depth_5=h", tmp_path / "out")


def _status(words):
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr("sys.argv", ["lammps-jump", *words])
        raise SystemExit(main())
    return ended.value.code or 0
