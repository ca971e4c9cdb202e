# SPDX-License-Identifier: GPL-2.0-or-later
"""Forces, impulses and the reflected wave on made-up records with known answers."""

from dataclasses import replace
from functools import partial
from math import pi

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from made_up import collected, disc_frame, flow_context

from lammps_jump.analysis.forces.figures import history_chart, impulse_chart, section
from lammps_jump.analysis.forces.history import Forces, analyse_forces, moving_mean, peak_error
from lammps_jump.analysis.forces.impulse import MomentumLedger, impulse_identity, window_lengths
from lammps_jump.analysis.forces.reflection import track_reflection
from lammps_jump.analysis.profiles import add_means, compute_profiles
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.frame import make_frame
from lammps_jump.files import plain
from lammps_jump.physics import jump as waves
from lammps_jump.scene.motion import gate
from lammps_jump.scene.scene import Fixed, InletRow
from lammps_jump.scene.walls import Block, Plane

D, M, G, DT = 0.2, 40.0, 9.81, 1e-3
BACK, FLOOR = Plane("back", "x", 0.0, "above"), Plane("floor", "y", 0.0, "above")
BOX = [[-1, 30], [-1, 20]]


context = partial(
    flow_context, domain=((-1.0, 30.0), (-1.0, 20.0)), x_range=(0.0, 30.0), walls=(BACK, FLOOR), stiffness=1e6,
    stiffness_wall=1e6, time_step=DT, probes=("back",), bin_width=1.0,
)  # fmt: skip


def pushed(force, frames=11, every=100, y=5.0, gone=None):
    """Discs at rest at first that a constant force along x speeds up; the last may be missing from a frame on."""
    result = []
    for k in range(frames):
        t = k * every * DT
        n = 3 if gone is None or k < gone else 2
        x = 1.0 + 0.5 * np.arange(n)
        result.append(disc_frame(x, 0 * x + y, force * t / (3 * M), box=BOX, step=k * every, time=t))
    return result


def record(value, windows=100, every=10):
    time = (np.arange(windows) + 1) * every * DT
    force = np.broadcast_to(value, windows).astype(float)
    return ForceHistory(time, force, 0 * force, 0 * force)


def ledger(frames, flow):
    return collected(MomentumLedger(flow), frames)


def test_identity_of_a_constant_force():
    flow = context()
    identity = impulse_identity({"back": record(-600.0)}, ledger(pushed(600.0), flow), flow, "x")
    assert (identity.start, identity.end) == (0.0, 1.0)
    assert identity.momentum_change == pytest.approx(600.0, rel=1e-12)
    assert identity.relative < 1e-12
    assert identity.complete and identity.reason is None
    wrong = impulse_identity({"back": record(-606.0)}, ledger(pushed(600.0), flow), flow, "x")
    assert wrong.relative == pytest.approx(6 / 606, rel=1e-9)


def test_identity_counts_half_a_step_of_the_force_at_either_end():
    """Speeds of a frame lack the last half of its kick: walls give half a step more at the start, less at the end."""
    flow = context()
    history = ledger(pushed(600.0), flow)
    back = np.zeros((len(history.time), 2))
    back[0, 0], back[-1, 0] = 8.0, 2.0
    given = impulse_identity({"back": record(-600.0)}, replace(history, forces={"back": back}), flow, "x").wall_impulse
    assert given - 600.0 == pytest.approx(0.5 * DT * (8.0 - 2.0), rel=1e-6)  # twelve digits of 600


def test_identity_ends_where_discs_leave():
    flow = context()
    momentum = ledger(pushed(600.0, gone=7), flow)
    identity = impulse_identity({"back": record(-600.0)}, momentum, flow, "x")
    assert identity.end == pytest.approx(0.6)
    assert identity.relative < 1e-12


def test_identity_names_what_is_missing():
    flow = context()
    low = ledger(pushed(600.0, y=0.09), flow)  # discs press on the unprobed floor
    assert impulse_identity({"back": record(-600.0)}, low, flow, "x").complete
    assert "floor" in impulse_identity({"back": record(-600.0)}, low, flow, "y").reason
    short = impulse_identity({"back": record(-600.0, windows=50)}, low, flow, "x")
    assert short.end == pytest.approx(0.5)
    rough = replace(flow, scene=replace(flow.scene, fixed=Fixed(90, 99)))
    assert "rough bed" in impulse_identity({"back": record(-600.0)}, low, rough, "x").reason
    assert "no wall" in impulse_identity({}, low, flow, "x").reason
    changing = ledger(pushed(600.0, frames=2, gone=1), flow)
    assert "enter or leave" in impulse_identity({"back": record(-600.0)}, changing, flow, "x").reason


def test_identity_waits_for_the_gate():
    flow = context(walls=(BACK, FLOOR, gate(Plane("gate", "x", 4.0, "below"), 300)))
    identity = impulse_identity({"back": record(-600.0)}, ledger(pushed(600.0), flow), flow, "x")
    assert identity.start == pytest.approx(0.3)
    assert identity.relative < 1e-12


def test_gravity_counts_along_y():
    frames = []
    for frame in pushed(0.0):
        columns = {**frame.columns, "vy": -G * frame.time + 0 * frame.x}
        frames.append(make_frame(frame.step, frame.time, frame.box, columns))
    flow = context()
    identity = impulse_identity({"back": record(0.0)}, ledger(frames, flow), flow, "y")
    assert identity.gravity_impulse == pytest.approx(-3 * M * G, rel=1e-12)
    assert abs(identity.difference) < 1e-9


def test_window_lengths():
    assert window_lengths(np.array([0.1, 0.2, 0.4])) == pytest.approx([0.15, 0.1, 0.2])
    assert len(window_lengths(np.zeros(0))) == 0


def test_moving_mean_keeps_straight_lines_and_damps_waves():
    t = np.arange(200)
    mean = moving_mean(3.0 + 2.0 * t, 9)
    assert mean[4:-4] == pytest.approx(3.0 + 2.0 * t[4:-4])
    assert np.isnan(mean[[0, 3, -4, -1]]).all(), "no value within half a filter of the ends"
    assert np.isnan(moving_mean(t[:8], 9)).all()
    wave = np.sin(2 * pi * t / 9)
    assert np.nanmax(np.abs(moving_mean(wave, 9))) < 1e-12
    assert moving_mean(wave, 1) == pytest.approx(wave)
    assert len(moving_mean(np.zeros(0), 5)) == 0


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=60), st.integers(1, 15))
def test_moving_mean_mirrors_and_stays_between(values, samples):
    values = np.array(values)
    mean = moving_mean(values, samples)
    assert mean[::-1] == pytest.approx(moving_mean(values[::-1], samples), abs=1e-9, nan_ok=True)
    known = mean[np.isfinite(mean)]
    assert len(known) == max(0, len(values) - 2 * (samples // 2))
    assert ((values.min() - 1e-9 <= known) & (known <= values.max() + 1e-9)).all()


def still_water(depth=4.0, speed=0.0, frames=11):
    x = np.arange(D / 2, 20, D)
    layers = round(depth / D)
    px, py = np.repeat(x, layers), np.tile(D * (np.arange(layers) + 0.5), len(x))
    columns = {"id": np.arange(len(px)) + 1, "x": px, "y": py, "vx": speed + 0 * px, "vy": 0 * px}
    return [make_frame(k * 100, 0.1 * k, BOX, columns) for k in range(frames)]


def test_hydrostatic_estimates_of_wall_and_block():
    block = Block("structure", (20.0, 22.0), (-5.0, 3.0))
    flow = context(walls=(BACK, Block("floor", (-5, 20), (-5, 0)), block), probes=("back", "structure"))
    profiles = compute_profiles(still_water(), flow)
    peak = record(10.0)
    peak.fx[40:60] += 1e5
    result = analyse_forces({"back": record(-1.0), "structure": peak}, flow, None, profiles)
    summary = result.summary()
    back, structure = summary["back"], summary["structure"]
    assert back["hydrostatic"] == pytest.approx(waves.hydrostatic_force(4.0, 1000.0, G), rel=1e-9)
    # the structure is 3 m high in 4 m of water
    assert structure["hydrostatic"] == pytest.approx(1000.0 * G * 3.0 * (4.0 - 1.5), rel=1e-9)
    assert structure["peak"] == pytest.approx(1e5 + 10, rel=1e-9)
    assert structure["component"] == "fx"
    np.testing.assert_array_equal(result.structures["structure"].history.fx, peak.fx)
    assert structure["impulse"] == pytest.approx(1e5 * 0.2 + 10 * 1.0, rel=1e-9)
    # corner at -5 m, bed at 0: the moment moves up by 5 m times fx
    table = result.structures["structure"].table
    assert table["moment_smooth"][50] == table["moment"][50] == pytest.approx(5.0 * (1e5 + 10), rel=1e-9)


def test_oncoming_stream_towards_a_structure():
    block = Block("structure", (20.0, 22.0), (-5.0, 9.0))
    flow = context(walls=(BACK, Block("floor", (-5, 20), (-5, 0)), block), probes=("structure",))
    profiles = compute_profiles(still_water(depth=2.0, speed=5.0), flow)
    result = analyse_forces({"structure": record(1.0)}, flow, None, profiles)
    expected = waves.hydrostatic_force(2.0, 1000.0, G) + 1000.0 * 2.0 * 5.0**2
    assert result.summary()["structure"]["stagnation"] == pytest.approx(expected, rel=1e-9)
    assert result.summary()["structure"]["oncoming_flux"] == pytest.approx(1000.0 * 2.0 * 5.0**2, rel=1e-9)


def test_one_long_peak_is_cut_by_the_low_pass():
    """A pulse of 0.01 s in one window shows a fifth of its height behind a mean of 0.05 s."""
    pulse = np.zeros(100)
    pulse[50] = 1000.0
    profiles = compute_profiles(still_water(frames=2), context())
    result = analyse_forces({"back": record(pulse)}, context(), None, profiles)
    assert result.summary()["back"]["peak"] == pytest.approx(200.0)
    assert result.summary()["back"]["peak_unfiltered"] == pytest.approx(1000.0)
    assert result.summary()["back"]["impulse"] == pytest.approx(10.0)


def test_settled_column_against_hydrostatics():
    flow = context(probes=("back", "floor"))
    frames = still_water()
    earlier = [make_frame(f.step, f.time - 1.0, f.box, f.columns) for f in frames]
    profiles = compute_profiles(earlier, flow)
    weight = M * G * frames[0].n
    time = (np.arange(100) + 1) * 0.01 - 1.0
    still = np.zeros(100)
    force = waves.hydrostatic_force(4.0, 1000.0, G)
    forces = {
        "back": ForceHistory(time, still - 0.9 * force, still, still),
        "floor": ForceHistory(time, still, still - weight, still),
    }
    settled = analyse_forces(forces, flow, ledger(earlier, flow), profiles).settled
    assert settled["back"]["ratio"] == pytest.approx(0.9, rel=1e-9)
    assert settled["floor"]["ratio"] == pytest.approx(1.0, rel=1e-12)


def test_dry_wall_and_no_discs_have_no_ratio():
    """A probed wall that no water reaches before the gate opens, and a floor with nothing on it."""
    far = Plane("far", "x", 30.0, "below")
    flow = context(walls=(BACK, far, FLOOR), probes=("far", "floor"))
    dry = [make_frame(k * 100, 0.1 * k - 1.0, BOX, still_water()[0].columns) for k in range(11)]
    time = (np.arange(100) + 1) * 0.01 - 1.0
    still = np.zeros(100)
    forces = {"far": ForceHistory(time, still, still, still), "floor": ForceHistory(time, still, still - 1.0, still)}
    momentum = ledger(dry, flow)
    momentum.discs[:] = 0
    settled = analyse_forces(forces, flow, momentum, compute_profiles(dry, flow)).settled
    assert settled["far"]["depth"] == settled["far"]["hydrostatic"] == 0
    assert np.isnan(settled["far"]["ratio"]) and np.isnan(settled["floor"]["ratio"])


def reflection(speed=-3.0, incoming=6.0, arrive=1.0):
    """A stream 1 m deep meets a wall at x = 20 m; the stopped part, 3 m deep, grows upstream at a set speed."""
    time, x = np.arange(0, 4, 0.1), np.arange(0.25, 30, 0.5)
    front = np.where(time >= arrive, 20 + speed * (time - arrive), np.inf)[:, None]
    share = np.clip((front - (x - 0.25)) / 0.5, 0, 1)
    wet = (x < 20) & (time[:, None] >= arrive - (20 - x) / incoming)
    depth = np.where(wet, 1.0 * share + 3.0 * (1 - share), 0.0)
    discharge = np.where(wet, incoming * share, 0.0)
    return xr.Dataset(
        {"mass_depth": (("time", "x"), depth), "discharge": (("time", "x"), discharge)},
        coords={"time": time, "x": x},
        attrs={"bin_width": 0.5, "x_low": 0.0},
    )


def test_reflected_wave_runs_at_its_speed():
    wave = track_reflection(reflection(), Block("structure", (20, 22), (-5, 6)), context())
    assert wave.speed == pytest.approx(-3.0, abs=0.1)  # the place within a bin of 0.5 m is read from velocities
    assert wave.oncoming_velocity == pytest.approx(6.0, rel=0.05)
    depth, speed = waves.reflected_bore(wave.oncoming_depth, wave.oncoming_velocity, G)
    assert (wave.bore_depth, wave.bore_speed) == (depth, speed)
    assert "structure" in wave.sentence()


def test_no_stream_no_reflected_wave():
    profiles = reflection()
    dry = profiles.assign(mass_depth=0 * profiles.mass_depth)
    block = Block("structure", (20, 22), (-5, 6))
    assert track_reflection(dry, block, context()) is None
    assert track_reflection(profiles, Block("structure", (0.5, 22), (-5, 6)), context()) is None


def test_error_of_a_peak_is_the_scatter_of_the_maxima_of_blocks():
    time = np.arange(1, 1201) * 0.01
    force = np.where(time < 2.0, 0.0, 1.0)
    rng = np.random.default_rng(2)
    peaks = rng.uniform(5, 9, 18)
    force[np.round((3.0 + 0.5 * (np.arange(18) + 0.5)) / 0.01).astype(int)] = peaks  # one in each block of 0.5 s
    late = time > 3.005
    assert peak_error(time[late], force[late]) == pytest.approx(np.std(peaks[:17], ddof=1), rel=0.1)
    assert np.isnan(peak_error(time[:150], force[:150])) and np.isnan(peak_error(time, 0 * time))


def test_the_peak_of_a_steady_stream_is_that_of_its_window():
    """A jolt at the first sample and another at 0.3 s are start-up; the window holds a pulse of 0.1 s."""
    force = np.full(100, 10.0)
    force[0], force[28:32], force[70:80] = 9000.0, 2000.0, 500.0
    profiles = add_means(compute_profiles(still_water(), context()), (0.5, 1.0))
    row = InletRow(0.0, 0.1, 1.0, 0.0, 1, 100, D)
    found = analyse_forces({"back": record(force)}, context(inlets=(row,)), None, profiles).summary()["back"]
    assert (found["peak"], found["peak_unfiltered"]) == (pytest.approx(500.0), 500.0)
    # the first value behind a mean over five samples is that of the third
    assert found["startup_peak"] == pytest.approx((9000 + 4 * 10) / 5)
    assert found["startup_peak_time"] == pytest.approx(0.03)
    impact = analyse_forces({"back": record(force)}, context(), None, profiles).summary()["back"]
    assert impact["peak"] == found["startup_peak"] and np.isnan(impact["startup_peak"])


def test_a_structure_tells_its_component_and_its_resultant():
    """Fx of 3 kN against Fy of -4 kN: their resultant of 5 kN points 53 degrees down."""
    flow, time = context(), (np.arange(200) + 1) * 0.01
    profiles = add_means(compute_profiles(pushed(600.0), flow))
    history = ForceHistory(time, np.full(200, 3e3), np.full(200, -4e3), np.zeros(200))
    none = ForceHistory(time, np.zeros(200), np.zeros(200), np.zeros(200))
    found = analyse_forces({"back": history, "floor": none}, flow, None, profiles)
    one, other = found.structures["back"], found.structures["floor"]
    assert (one.component, one.peak, one.reason) == ("fy", pytest.approx(-4e3), None)
    assert one.resultant == pytest.approx(5e3) and one.resultant_angle == pytest.approx(-53.13, abs=0.01)
    assert (one.mean_resultant, one.mean_angle) == (pytest.approx(5e3), pytest.approx(-53.13, abs=0.01))
    assert (other.component, other.peak, other.reason) == (None, 0.0, "nothing touched it")
    assert np.isnan(other.resultant) and list(found.shown) == ["back"]
    (panel,) = history_chart(found).panels
    assert [line.label for line in panel.lines] == ["Fy as recorded", "Fx, 0.05 s mean", "Fy, 0.05 s mean", "peak Fy"]
    assert panel.ylim[0] < -4 and panel.ylim[1] > 3
    blocks = section(Forces.of(plain(found.summary()))).blocks
    largest, whole = (table for table in blocks[1:3])
    assert largest.rows[0][:3] == ("back", "Fy", pytest.approx(-4.0)) and len(whole.rows) == 1
    assert any("Nothing touched floor." in str(block[0]) for block in blocks)
    assert history_chart(analyse_forces({"floor": none}, flow, None, profiles)) is None
    assert impulse_chart(analyse_forces({"floor": none}, flow, None, profiles)) is None
