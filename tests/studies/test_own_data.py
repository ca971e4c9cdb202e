# SPDX-License-Identifier: GPL-2.0-or-later
"""A person's measured curve against that of a run: known distances, and what is refused."""

import json
import os
import re

import numpy as np
import pytest
import xarray as xr

from lammps_jump.cli.app import main
from lammps_jump.dump.exports import write_netcdf
from lammps_jump.errors import CaseError, DumpError, JumpError, SetupError
from lammps_jump.files import checksum, write_json
from lammps_jump.runs.results import export
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


def marked(folder):
    """A made-up run whose summary has the checksums of its tables."""
    made_run(folder)
    profiles = {"depth": ("x", np.arange(3.0))}
    write_netcdf(xr.Dataset(profiles, {"x": np.arange(3.0)}), folder / "profiles.nc")
    files = {name: checksum(folder / name) for name in ("gauges.csv", "profiles.nc")}
    write_json(folder / "summary.json", {"status": "complete", "analysed": {"key": "k", "files": files}})
    return folder


def resealed(folder, name, content):
    """Change a table and its checksum, as in a folder that was received."""
    (folder / name).write_bytes(content)
    summary = json.loads((folder / "summary.json").read_text())
    summary["analysed"]["files"][name] = checksum(folder / name)
    write_json(folder / "summary.json", summary)


GAUGES = "time=t,gauges.depth_5=h"
PROFILES = "x=t,profiles.depth=h"


@pytest.mark.fault("values in JSON files")
@pytest.mark.parametrize(
    ("summary", "said"),
    [
        ('{"status": "failed", "message": "one was lost"}', "the run there is failed, not complete: one was lost"),
        ('{"status": "complete", "analysed": null}', "was not analysed to the end"),
        ('{"status": "complete", "analysed": {"key": 1, "files": {}}}', "analysed.key: Input should be a valid string"),
        ("{}", "of no known status"), ("[]", "no summary"), ("null", "no summary"), ("{", "is no JSON"),
        (100_000 * "[", "too deep"), ("\xff", "is no JSON"),
    ],
)  # fmt: skip
def test_a_run_is_compared_only_where_its_summary_calls_it_complete(tmp_path, data, summary, said):
    for run in (marked(tmp_path / "run"), marked(tmp_path / "study" / "runs" / "k")):
        (run / "summary.json").write_bytes(summary.encode("latin-1"))
    with pytest.raises(JumpError, match=re.escape(said)):
        compare_with_data(tmp_path / "run", data, GAUGES, tmp_path / "out")
    with pytest.raises(JumpError, match=f"{re.escape(said)}|no complete run"):  # a failed start is left out
        compare_with_data(tmp_path / "study", data, GAUGES, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.fault("flipped bits")
@pytest.mark.parametrize(("name", "columns"), [("gauges.csv", GAUGES), ("profiles.nc", PROFILES)])
def test_a_table_that_was_changed_is_not_compared(tmp_path, data, name, columns):
    run = marked(tmp_path / "run")
    compare_with_data(run, data, columns, tmp_path / "out")
    whole = (run / name).read_bytes()
    for damaged in (whole[:-1], whole + b"1", bytes([whole[0] ^ 1]) + whole[1:]):
        (run / name).write_bytes(damaged)
        with pytest.raises(DumpError, match="differs from its checksum"):
            compare_with_data(run, data, columns, tmp_path / "out")
    (run / name).unlink()
    with pytest.raises(DumpError, match="cannot be read"):
        compare_with_data(run, data, columns, tmp_path / "out")


@pytest.mark.fault("flipped bits")
def test_profiles_that_were_changed_are_not_exported(tmp_path):
    run = marked(tmp_path / "run")
    with pytest.raises(DumpError, match=r"profiles\.nc: cannot be read"):  # made up, it has no times
        export(run, ["csv"], tmp_path / "out")
    write_netcdf(xr.Dataset({"depth": ("x", np.ones(3))}, {"x": np.arange(3.0)}), run / "profiles.nc")
    with pytest.raises(DumpError, match="differs from its checksum"):
        export(run, ["csv"], tmp_path / "other")
    assert not (tmp_path / "other").exists()


@pytest.mark.fault("wrong tables")
@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("gauges.csv", b"time,depth_5\n1,1,100\n2,2,100\n", "line 2: 3 values, but 2 heads"),
        ("gauges.csv", b"time,depth_5\n0,x\n1,y\n", "line 2, column depth_5: 'x' is no number"),
        ("gauges.csv", b"time,depth_5\n0,2020-01-01\n1,1\n", "'2020-01-01' is no number"),
        ("gauges.csv", b"time,depth_5\n0," + 400 * b"9" + b"\n1,1\n", "has fewer than 2 values"),
        ("gauges.csv", b"time,depth_5\n0,1e200\n1,1\n", "1e+200 is beyond 1e+100"),
        ("gauges.csv", b"time,depth_5\n0,\xe9\n1,1\n", "no text in UTF-8"),
        ("gauges.csv", b"time,depth_5\n0," + 200_000 * b"9" + b"\n", "field larger than field limit"),
        ("gauges.csv", b"time,time,depth_5\n0,1,2\n", "more than one column time"),
        ("gauges.csv", b"", "has 0 rows"),
        ("gauges.csv", 100_000 * b"[" + b"\n1\n", f"no column time; there are {199 * '['}\N{HORIZONTAL ELLIPSIS}"),
        ("profiles.nc", b"garbage", "cannot be read"),
        ("profiles.nc", b"", "cannot be read"),
        ("profiles.nc", b"CDF\x02" + 60 * b"\xff", "cannot be read"),
    ],
)
def test_a_received_table_is_read_to_the_letter(tmp_path, data, name, content, said):
    run = marked(tmp_path / "run")
    resealed(run, name, content)
    with pytest.raises(JumpError, match=re.escape(said)):
        compare_with_data(run, data, GAUGES if name == "gauges.csv" else PROFILES, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.fault("wrong tables")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t,h\n1,1e308\n2,-1e308\n3,1\n", "line 2, column h: 1e+308 is beyond 1e+100"),
        (f"t,h\n1,{200_000 * '9'}\n2,3\n", "line 2: field larger than field limit"),
        ("t,h\n1,100,1\n2,100,1\n", "line 2: 3 values, but 2 heads"),
    ],
)
def test_a_measured_file_is_read_to_the_letter(tmp_path, data, text, said):
    data.write_text(text)
    with pytest.raises(CaseError, match=re.escape(said)):
        compare_with_data(marked(tmp_path / "run"), data, GAUGES, tmp_path / "out")


@pytest.mark.fault("folders")
def test_pipes_and_devices_are_not_waited_for(tmp_path, data):
    run = marked(tmp_path / "run")
    os.mkfifo(run / "aa.csv")
    compare_with_data(run, data, GAUGES, tmp_path / "out")
    for odd in ("pipe", "zero", "large"):
        data.unlink()
        if odd == "pipe":
            os.mkfifo(data)
        elif odd == "zero":
            data.symlink_to("/dev/zero")
        else:
            data.unlink(missing_ok=True)
            data.touch()
            os.truncate(data, 20_000_000)
        with pytest.raises(CaseError, match=r"cannot be read: (no regular file|more than 10 MB)"):
            compare_with_data(run, data, GAUGES, tmp_path / "out")
    (run / "gauges.csv").unlink()
    os.mkfifo(run / "gauges.csv")
    data.unlink()
    data.write_text("t,h\n1,1\n2,2\n")
    with pytest.raises(DumpError, match="no regular file"):
        compare_with_data(run, data, GAUGES, tmp_path / "out")


@pytest.mark.fault("folders")
def test_files_of_others_and_links_stay_as_they_are(tmp_path, data):
    run, out = marked(tmp_path / "run"), tmp_path / "out"
    out.mkdir()
    mine = tmp_path / "thesis.txt"
    mine.write_text("precious")
    (out / "compared.png").symlink_to(mine)
    with pytest.raises(SetupError, match="was not made by lammps-jump"):
        compare_with_data(run, data, GAUGES, out)
    (out / "compared.png").unlink()
    compare_with_data(run, data, GAUGES, out)
    (out / "compared.png").unlink()
    (out / "compared.png").symlink_to(mine)
    compare_with_data(run, data, GAUGES, out)  # now the folder is ours, and the link gives way
    assert mine.read_text() == "precious" and not (out / "compared.png").is_symlink()
    with pytest.raises(SetupError, match="holds the comparison of"):
        compare_with_data(marked(tmp_path / "another"), data, GAUGES, out)
    (tmp_path / "study" / "runs").mkdir(parents=True)
    (tmp_path / "study" / "runs" / "k").symlink_to(run)
    with pytest.raises(SetupError, match="is a link"):
        compare_with_data(tmp_path / "study", data, GAUGES, out)


@pytest.mark.fault("text as a command")
def test_heads_are_text_in_figure_and_page(tmp_path, data):
    data.write_text("t,h$_{$|<b>\n1,1.9\n2,4.1\n")
    _, out = compare_with_data(marked(tmp_path / "run"), data, "time=t,gauges.depth_5=h$_{$|<b>", tmp_path / "out")
    assert "| h$_{$\\|<b> |" in (out / "compared.md").read_text()


def _status(words):
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr("sys.argv", ["lammps-jump", *words])
        raise SystemExit(main())
    return ended.value.code or 0
