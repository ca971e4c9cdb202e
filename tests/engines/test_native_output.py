# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of the native engine: dump in LAMMPS' formats, forces.csv, result; and what the package may import."""

import csv
import gzip
import struct
import subprocess
import sys

import numpy as np
import pytest
from hosts import start
from made_up import native_frames

from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.errors import CaseError
from lammps_jump.scene.scene import InletRow, handmade_scene
from lammps_jump.scene.walls import Plane

D = 0.2


def small_scene(**kw):
    """Two discs that fall, one more that enters; frames at 0, 100, 200; time zero at step 50."""
    kw = dict(steps=200, output_steps=100, settle_steps=50, probes=("floor",), probe_steps=40) | kw
    return handmade_scene(
        [[0.0, 0.0995], [1.0, 0.5]], [[0, 0], [1.0, 0.2]], (Plane("floor", "y", 0.0, "above"),),
        inlets=(InletRow(3.0, 1.0, 2.0, 0.0, 60, 1000, 0.999 * D),), domain=((-5, 5), (-1, 7)), **kw,
    )  # fmt: skip


def read_text(text):
    """Frames of a text dump: (step, time, columns, rows)."""
    lines = text.splitlines()
    assert lines[:2] == ["ITEM: UNITS", "si"]
    frames, k = [], 2
    while k < len(lines):
        assert lines[k] == "ITEM: TIME" and lines[k + 2] == "ITEM: TIMESTEP" and lines[k + 4] == "ITEM: NUMBER OF ATOMS"
        time, step, n = float(lines[k + 1]), int(lines[k + 3]), int(lines[k + 5])
        assert lines[k + 6] == "ITEM: BOX BOUNDS ff ff pp"
        assert [float(v) for v in lines[k + 7].split()] == [-5, 5]
        assert [float(v) for v in lines[k + 8].split()] == [-1, 7]
        columns = lines[k + 10].removeprefix("ITEM: ATOMS ").split()
        rows = np.array([[float(v) for v in line.split()] for line in lines[k + 11 : k + 11 + n]])
        frames.append((step, time, columns, rows))
        k += 11 + n
    return frames


@pytest.mark.parametrize("rotation", [False, True])
def test_text_dump_holds_the_frames(tmp_path, rotation):
    scene = small_scene(rotation=rotation)
    run_native(scene, tmp_path)
    written = read_text((tmp_path / "dump.lammpstrj").read_text())
    assert [f[0] for f in written] == [0, 100, 200]
    assert [len(f[3]) for f in written] == [2, 3, 3]
    for (step, time, columns, rows), kept in zip(written, native_frames(scene), strict=True):
        assert columns == ["id", "x", "y", "vx", "vy"] + (["omegaz"] if rotation else [])
        assert time == pytest.approx((step - 50) * scene.time_step, rel=1e-12)
        assert (kept.step, kept.time) == (step, scene.time(step))
        assert rows[:, 1] == pytest.approx(kept.x, rel=1e-9)  # ten digits
        assert rows[:, 4] == pytest.approx(kept.vy, rel=1e-9)


def test_dump_reports_the_velocity_at_the_step(tmp_path):
    scene = small_scene()
    last = list(native_frames(scene))[2]
    t = 200 * scene.time_step
    assert last.vy[1] == pytest.approx(0.2 - 9.81 * t, abs=1e-12)


def test_gz_is_the_same_text(tmp_path):
    for name, kind in (("a", "text"), ("b", "gz")):
        (tmp_path / name).mkdir()
        run_native(small_scene(), tmp_path / name, dump_format=kind)
    with gzip.open(tmp_path / "b" / "dump.lammpstrj.gz", "rt") as file:
        assert file.read() == (tmp_path / "a" / "dump.lammpstrj").read_text()


def test_binary_dump_has_lammps_layout(tmp_path):
    run_native(small_scene(), tmp_path, dump_format="binary")
    data = (tmp_path / "dump.lammpsbin").read_bytes()
    at = 0

    def take(form):
        nonlocal at
        values = struct.unpack_from("=" + form, data, at)
        at += struct.calcsize("=" + form)
        return values

    for number, frame in enumerate(native_frames(small_scene())):
        assert take("q10sii") == (-10, b"DUMPCUSTOM", 1, 2)
        assert take("qqi") == (frame.step, len(frame.ids), 0)
        assert take("6i") == (1, 1, 1, 1, 0, 0)
        assert take("6d")[:4] == (-5, 5, -1, 7)
        assert take("i") == (5,)
        (units,) = take("i")
        assert take(f"{units}s")[0] == (b"si" if number == 0 else b"")
        assert take("bd") == (1, frame.time)
        (length,) = take("i")
        assert take(f"{length}s") == (b"id x y vx vy",)
        writers, numbers = take("ii")
        assert (writers, numbers) == (1, 5 * len(frame.ids))
        table = np.array(take(f"{numbers}d")).reshape(-1, 5)
        assert np.array_equal(table, np.column_stack([frame.ids, frame.x, frame.y, frame.vx, frame.vy]))
    assert at == len(data)


def test_forces_file_has_one_row_a_window(tmp_path):
    scene = small_scene()
    run_native(scene, tmp_path)
    simulation = NativeSimulation(scene)
    simulation.run(scene.steps)
    with (tmp_path / "forces.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time", "structure", "fx", "fy", "moment"]
    assert [float(r["time"]) for r in rows] == pytest.approx([scene.time(40 * k) for k in range(1, 6)])
    assert {r["structure"] for r in rows} == {"floor"}
    assert [float(r["fy"]) for r in rows] == pytest.approx([row[3] for row in simulation.forces], rel=1e-9)
    assert float(rows[0]["fy"]) < 0  # the resting disc weighs down


def test_result_counts_exactly():
    result = run_native(small_scene(), None)
    assert (result.engine, result.kernel, result.status, result.message) == ("native", "core", "complete", "")
    assert (result.inserted, result.present, result.removed, result.lost) == (3, 3, 0, 0)
    assert result.steps == 200
    assert result.disc_steps == pytest.approx(2 * 60 + 3 * 140, abs=0)
    assert set(result.versions) >= {"python", "numpy", "lammps_jump"}


def test_progress_reaches_the_end():
    reports = []
    run_native(small_scene(), None, progress=reports.append, report_every=0.0)
    assert reports[-1].step == reports[-1].steps == 200
    assert reports[-1].discs == 3
    assert [r.step for r in reports] == sorted(r.step for r in reports)


def test_unknown_dump_format_is_refused(tmp_path):
    with pytest.raises(CaseError, match="text, gz, binary"):
        run_native(small_scene(), tmp_path, dump_format="xyz")


def test_native_engine_needs_neither_lammps_nor_mdanalysis():
    code = (
        "import sys; sys.modules['lammps'] = sys.modules['MDAnalysis'] = None; import lammps_jump.engines.native;"
        "assert not {'matplotlib', 'xarray'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.lammps
def test_binary_dump_is_byte_for_byte_what_lammps_writes(tmp_path):
    scene = handmade_scene(
        [[0.5, 1.0], [1.5, 1.0]], [[1.0, 0.0], [0.0, 2.0]], domain=((0.0, 2.0), (0.0, 2.0)), gravity=(0.0, 0.0), steps=0
    )
    run_native(scene, tmp_path, dump_format="binary")
    lammps = start("stock", scene, [], tmp_path / "lammps")
    lammps.do("dump d all custom 1 a.bin id x y vx vy", "dump_modify d sort id time yes units yes", "run 0")
    lammps.close()
    ours, theirs = (tmp_path / "dump.lammpsbin").read_bytes(), (tmp_path / "lammps" / "a.bin").read_bytes()
    z = slice(26 + 20 + 24 + 32, 26 + 20 + 24 + 48)  # bounds: half a disc here
    assert (len(ours), ours[: z.start], ours[z.stop :]) == (len(theirs), theirs[: z.start], theirs[z.stop :])
