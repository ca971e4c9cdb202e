# SPDX-License-Identifier: GPL-2.0-or-later
"""Pressure along outlines from records that are made up: hydrostatic, percentiles, and where the force acts."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up import flow_context

from lammps_jump.analysis.forces.pressure import NOT_SUMMED, analyse, dataset, figures, section
from lammps_jump.analysis.passes import Gathered
from lammps_jump.dump.walls import read_pressure, write_pressure
from lammps_jump.errors import DumpError
from lammps_jump.scene.pressed import bins_of, gauge_of
from lammps_jump.scene.walls import Block

SILL = Block("sill", (5.0, 6.0), (0.0, 2.0))
ROWS, DT = 400, 1e-2
G = 9810.0


def gathered(folder, across, stretches, file=True):
    """What a pass leaves of a record of these forces, shape (windows, stretches), N/m; each acts in its middle."""
    flow = flow_context(
        domain=((-20.0, 20.0), (-5.0, 20.0)), x_range=(-1.0, 20.0), walls=(SILL,), pressure=tuple(stretches),
        time_step=DT, window=(2.0, 4.0),
    )  # fmt: skip
    middle = np.array([0.5 * (one.begin + one.end) for one in stretches])
    rows = [(k + 1, np.column_stack([row, 0.1 * row, row * middle]).ravel()) for k, row in enumerate(across)]
    write_pressure(folder / "pressure.npz", flow.scene, rows)
    profiles = SimpleNamespace(attrs={"window_start": 2.0, "window_end": 4.0})
    return Gathered(flow, profiles, None, {}, {}, pressure=folder / "pressure.npz" if file else None)


@pytest.fixture(autouse=True)
def window(monkeypatch):
    monkeypatch.setattr("lammps_jump.analysis.forces.pressure.window_of", lambda _: (2.0, 4.0))


def test_hydrostatic_pressure_acts_at_a_third_of_its_height(tmp_path):
    """rho g (h - y) on the left face: rho g h^2/2 at h/3, but for the width of the bins, h^2/12n^2 of their moment."""
    stretches = bins_of(SILL, 240)
    left = np.array([one.along == (0.0, 1.0) for one in stretches])
    y = np.array([one.place[1] for one in stretches])
    width = np.array([one.width for one in stretches])
    steady = np.where(left, G * (2.0 - y) * width, 0.0)
    found = analyse(gathered(tmp_path, np.tile(steady, (ROWS, 1)), stretches))["sill"]
    assert found.force == pytest.approx(G * 2.0, rel=1e-9) and found.force_error == 0.0
    assert (found.force_x, found.force_height) == pytest.approx((5.0, 2.0 / 3.0), rel=1e-3)
    assert (found.x, found.y) == pytest.approx((5.0, y[left].min())) and found.mean == pytest.approx(
        steady.max() / width[0]
    )


def test_percentiles_and_the_largest_are_of_all_windows_after_the_start(tmp_path):
    """1, 2, ..., 400 Pa in turn: the mean of the window is that of its rows."""
    stretches = [gauge_of(SILL, (4.9, 1.0), 0.5)]
    found = analyse(gathered(tmp_path, np.arange(1.0, ROWS + 1)[:, None] * 0.5, stretches))["sill_1"]
    assert found.mean == pytest.approx(np.arange(201, 401).mean()) and found.mean_error > 0
    assert found.percentile_95 == pytest.approx(np.percentile(np.arange(1, 401), 95))
    assert found.percentile_99 == pytest.approx(np.percentile(np.arange(1, 401), 99))
    assert (found.largest, found.largest_at, found.width) == pytest.approx((400.0, 4.0, 0.5))
    assert np.isnan(found.force) and (found.x, found.y) == pytest.approx((5.0, 1.0))


def test_the_file_figures_and_section_have_walls_and_gauges(tmp_path):
    stretches = [*bins_of(SILL, 12), gauge_of(SILL, (4.9, 1.0), 0.5)]
    rng = np.random.default_rng(1)
    made = gathered(tmp_path, rng.random((ROWS, len(stretches))), stretches)
    found = analyse(made)
    assert list(found) == ["sill", "sill_1"]
    (data,) = dataset(found).values()
    assert dict(data.sizes) == {"time": ROWS, "s": len(stretches)}
    assert data["name"].values.tolist() == ["sill"] * (len(stretches) - 1) + ["sill_1"]
    assert data["mean"].values[-1] == pytest.approx(found["sill_1"].mean)
    assert (data["shear"] / data["pressure"]).values == pytest.approx(0.1)
    shown = figures(found, made)
    assert set(shown) == {"pressure", "pressure_gauges"} and len(shown["pressure"].panels[0].lines) == 4
    assert len(section(found).blocks) == 2


def test_without_a_record_the_reason_is_told(tmp_path):
    stretches = bins_of(SILL, 12)
    found = analyse(gathered(tmp_path, np.zeros((ROWS, len(stretches))), stretches, file=False))
    assert found["sill"].reason == NOT_SUMMED and np.isnan(found["sill"].mean)
    assert "No pressure is told" in section(found).blocks[0].text
    untouched = analyse(gathered(tmp_path, np.zeros((ROWS, len(stretches))), stretches))
    assert untouched["sill"].reason == "nothing touched it"


@pytest.mark.parametrize("damage", ["gone", "text", "short", "nan"])
def test_a_damaged_file_is_refused(tmp_path, damage):
    stretches = bins_of(SILL, 12)
    made = gathered(tmp_path, np.ones((ROWS, len(stretches))), stretches)
    path, scene = made.pressure, made.flow.scene
    if damage == "gone":
        path.unlink()
    elif damage == "text":
        path.write_text("time,pressure\n")
    else:
        values = np.ones((3, len(stretches) - (damage == "short"), 3))
        np.savez(path, steps=np.arange(3), means=values * (np.nan if damage == "nan" else 1.0))
    with pytest.raises(DumpError, match=r"pressure\.npz"):
        read_pressure(path, scene)
    assert analyse(made)["sill"].reason
