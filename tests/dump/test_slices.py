# SPDX-License-Identifier: GPL-2.0-or-later
"""A slice of a dump of three dimensions, with z up, becomes a dump of one layer that can be analysed."""

import json

import numpy as np
import pytest
from made_up import call

from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter

D = 0.01
COLUMNS = ("id", "type", "x", "y", "z", "vx", "vy", "vz", "radius", "mass")


def block(folder, frames=3):
    """Spheres on a cubic lattice, 20 x 6 x 8 of them, z up, at rest but for vz = 3 vx."""
    x, y, z = (D * (part.ravel() + 0.5) for part in np.meshgrid(np.arange(20), np.arange(6), np.arange(8)))
    with DumpWriter(folder / "pour3d.dump", COLUMNS) as writer:
        for k in range(frames):
            values = {"id": np.arange(len(x)) + 1, "type": 1 + 0 * x, "x": x, "y": y, "z": z}
            values |= {"vx": 0 * x + 1e-6, "vy": 0 * x, "vz": 0 * x + 3e-6, "radius": 0 * x + 0.5 * D}
            values["mass"] = 0 * x + np.pi / 6 * 2500 * D**3
            writer.write_frame(make_frame(k, 0.5 * k, [[0, 0.2], [0, 0.06], [-0.01, 0.3]], values))
    return folder / "pour3d.dump"


def test_a_slice_is_a_layer_with_its_own_axes(tmp_path, monkeypatch, capsys):
    path, made = block(tmp_path), tmp_path / "pour3d_slice.lammpstrj"
    status, _, message = call(monkeypatch, capsys, "analyze", path)
    assert status == 2 and f"lammps-jump slice {path} z=0.04" in message
    status, said, message = call(monkeypatch, capsys, "slice", path, "y=0.025")
    assert status == 0 and "at most 160 bodies, 0.01 m thick" in said, message
    frame = open_dump(made)[0]
    assert frame.n == 160 and frame.z is None
    assert (frame.x.max(), frame.y.max()) == pytest.approx((0.195, 0.075))
    assert frame.vy == pytest.approx(3e-6 + 0 * frame.vy) and frame.box[1] == pytest.approx([-0.01, 0.3])
    status, _, message = call(monkeypatch, capsys, "analyze", made, "--heap", "-q")
    assert status == 0, message
    found = json.loads((tmp_path / "pour3d_slice_analysis" / "summary.json").read_text())
    assert found["depth"]["mass"] == pytest.approx(8 * D, rel=0.03)
    assert any(note.startswith("Bodies: spheres of 2500 kg/m3") for note in found["warnings"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["y=3"], "no body lies within 0.005 m of y = 3 m; they run from y = 0.005 to 0.055 m"),
        (["w=0.03"], "write x, y or z and a place, such as y=0.03"), (["y=1 kg"], "expected a number in m"),
        (["y=0.03", "--thickness", "0"], "allowed is > 0 m"), (["y=0.03", "--out", "pour3d.dump"], "is there already"),
    ],
)  # fmt: skip
def test_slices_that_are_refused(tmp_path, monkeypatch, capsys, arguments, said):
    block(tmp_path, frames=1)
    monkeypatch.chdir(tmp_path)
    status, _, message = call(monkeypatch, capsys, "slice", "pour3d.dump", *arguments)
    assert status == 2 and said in " ".join(message.replace("│", " ").split())
    assert [entry.name for entry in tmp_path.iterdir()] == ["pour3d.dump"]
