# SPDX-License-Identifier: GPL-2.0-or-later
"""The jump analysis on made-up flows: steps and ramps that move at a set speed, and flows that are no jump."""

# ruff: noqa: RUF001  (minus signs and quotes as the page shows them)

from dataclasses import replace
from functools import partial
from math import radians, sqrt

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from made_up import columns_of_discs, disc_frame, examples, flow_context, numbers

from lammps_jump.analysis.jump.found import LOCAL_BOUNDS, LOWER_BOUNDS, MADE_OF, UNTOLD, Budget, Jump, Local, inherited
from lammps_jump.analysis.jump.frame import Moving, Roller, growth_rate
from lammps_jump.analysis.jump.result import analyse_jump, level_reach, without_baffles
from lammps_jump.analysis.jump.section import analyse, certainty, section
from lammps_jump.analysis.jump.stream import compression_front, measure_stream, running_median
from lammps_jump.analysis.jump.summary import belongs_to, notes, summarise_jump, untimed, worded
from lammps_jump.analysis.jump.track import JumpTrack, equivalent_position, fit_ramp, straight_motion
from lammps_jump.analysis.passes import Gathered, feed
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.analysis.report.page import SideBySide, Table, Text, errors_of, render
from lammps_jump.analysis.slope import AlongBed, sloping_stretch
from lammps_jump.analysis.statistics import STUDENT, Mean, mean_of, piece_error, propagated
from lammps_jump.analysis.tables import rows_of, tiles
from lammps_jump.analysis.verdicts import verdict
from lammps_jump.dump.frame import make_frame
from lammps_jump.physics import jump as theory
from lammps_jump.scene.scene import InletRow
from lammps_jump.scene.walls import Block, Line, Plane
from lammps_jump.units import numbers_of

D, G = 0.2, 9.81
BOX = [[-5, 65], [-5, 20]]
S1, S2, SPEED = 1.0, 6.0, -2.0
FROUDE = sqrt(0.5 * 6 * 7)  # Bélanger backwards: S (S + 1) = 2 Fr^2
U1 = SPEED + FROUDE * sqrt(G * S1)
U2 = SPEED + (U1 - SPEED) * S1 / S2


context = partial(
    flow_context, domain=((-5.0, 65.0), (-5.0, 20.0)), x_range=(0.0, 60.0), walls=(Plane("floor", "y", 0.0, "above"),),
    bin_width=1.0, window=(0.0, 10.0),
)  # fmt: skip


def flow(layers, speed, time=0.0, low=0.0, high=60.0):
    """Touching discs: layers(x) of them in each column, all with velocity speed(x)."""
    x, y = columns_of_discs(layers, low, high)
    return disc_frame(x, y, speed(x), box=BOX, step=round(time * 1000), time=time)


def moving_step(frames=24, start=40.0):
    """A bore that jumps one column upstream in every frame."""
    result = []
    for k in range(frames):
        front = start + SPEED * 0.1 * k
        at = lambda x, f=front: x < f  # noqa: E731  (the front of this frame)
        frame = flow(lambda x, a=at: np.where(a(x), 5, 30), lambda x, a=at: np.where(a(x), U1, U2), 0.1 * k)
        result.append(frame)
    return result


def mirrored(frame):
    columns = {name: np.array(values) for name, values in frame.columns.items()}
    columns["x"], columns["vx"] = -columns["x"], -columns["vx"]
    box = np.array(frame.box)
    box[0] = -box[0][::-1]
    return make_frame(frame.step, frame.time, box, columns)


@pytest.fixture(scope="module")
def step_result():
    return analyse_jump(compute_profiles(moving_step(), context()), context())


def test_step_moves_at_its_speed(step_result):
    assert step_result.verdict == "jump"
    assert step_result.motion.speed == pytest.approx(SPEED, abs=1e-9)  # columns fall on bin edges: exact
    assert step_result.motion.error < 1e-9
    expected = 40.0 + SPEED * step_result.track.time
    assert step_result.track.position == pytest.approx(expected, abs=1e-9)
    assert np.abs(step_result.track.toe - expected).max() <= 0.63  # a step inside a bin: toe within that bin, to 1/8
    assert step_result.toe_speed == pytest.approx(SPEED, abs=0.05)


def test_step_states_and_balance(step_result):
    one, two = step_result.upstream, step_result.downstream
    for state, depth, speed in ((one, S1, U1), (two, S2, U2)):
        assert state.mass_depth == pytest.approx(depth, rel=1e-9)
        assert state.velocity == pytest.approx(speed, rel=1e-9)
        assert state.packing == pytest.approx(np.pi / 4, rel=1e-9)
        assert state.surface_depth == pytest.approx(depth, rel=0.01)  # eight lines a diameter see the arcs
        assert state.beta == pytest.approx(1.0, rel=1e-9)
    assert one.froude_relative == pytest.approx(FROUDE, rel=1e-9)
    assert step_result.mass.closure == pytest.approx(0.0, abs=1e-9)
    assert step_result.momentum_terms.classical == pytest.approx(0.0, abs=1e-7)
    # nothing is stored between stations that move with the step, but the shifted profile is linear between bins
    assert abs(step_result.momentum_terms.unsteady) < 0.02


def test_step_summary(step_result):
    summary = numbers(summarise_jump(step_result))
    local = summary["local"]
    assert local["sequent_ratio"] == pytest.approx(6.0, rel=1e-9)
    assert local["belanger_ratio"] == pytest.approx(6.0, rel=1e-9)
    assert local["density_ratio"] == pytest.approx(1.0, abs=0.01)
    assert local["density_relation_ratio"] == pytest.approx(6.0, rel=0.01)
    assert local["energy_loss"] == pytest.approx(theory.energy_loss(S1, S2), rel=1e-9)
    assert local["momentum_residual"] == pytest.approx(0.0, abs=1e-7)
    assert all(abs(local[f"moved_{key}"]) < 1e-9 for key in ("y1", "y2", "froude", "belanger_y2"))
    assert summary["toe"] <= summary["position"] <= summary["end"]
    assert summary["length"] < 2.0  # a step: the bin it lies in, and one more that straight lines between bins add
    assert local["pressure_relation_ratio"] is None  # no stiffness, so no contact pressure
    assert summary["length_theory"] == pytest.approx(theory.silvester_jump_length(FROUDE, S1))


def test_mirror_symmetry(step_result):
    frames = [mirrored(frame) for frame in moving_step()]
    turned = context(x_range=(-60.0, 0.0), domain=((-65.0, 5.0), (-5.0, 20.0)))
    result = analyse_jump(compute_profiles(frames, turned), turned)
    straight, there = numbers(summarise_jump(step_result)), numbers(summarise_jump(result))
    assert result.direction == -1
    for key in ("speed", "toe", "end", "position"):
        assert there[key] == pytest.approx(-straight[key], abs=1e-9), key
    for key in ("y1", "y2", "froude", "belanger_y2", "length", "head_lost_theory"):
        assert there[key] == pytest.approx(straight[key], rel=1e-9), key
    for key, sign in (("u1", -1), ("u2", -1), ("froude", 1), ("sequent_ratio", 1), ("energy_loss", 1)):
        assert there["local"][key] == pytest.approx(sign * straight["local"][key], rel=1e-9), key


def test_ramp_length_is_found():
    """A ramp of 10 m between the levels: 5 % to 95 % of it is 9 m."""

    def layers(x):
        return 5 + 25 * np.clip((x - 30) / 10, 0, 1)

    frames = [flow(layers, lambda x: U1 * 5 / layers(x), 0.1 * k) for k in range(10)]
    summary = numbers(summarise_jump(analyse_jump(compute_profiles(frames, context()), context())))
    assert summary["verdict"] == "jump"
    assert summary["speed"] == pytest.approx(0.0, abs=1e-9)
    assert summary["length_mass"] == pytest.approx(9.0, abs=0.5)  # whole layers of 0.2 m, half a bin of 1 m
    assert summary["length_ramp"] == pytest.approx(10.0, abs=0.5)
    assert "stands still" in summary["reason"]


@pytest.mark.parametrize(
    ("layers", "speed", "reason"),
    [
        (lambda x: 0 * x + 5, lambda x: 0 * x + 14.0, "nowhere rises"),
        (lambda x: 0 * x, lambda x: 0 * x, "dry"),
        (lambda x: np.where(x < 30, 5, 30), lambda x: 0 * x + 0.5, "subcritical"),
        (lambda x: np.where(x < 30, 5, 10), lambda x: 0 * x + 14.0, "supercritical"),
        (lambda x: np.where(x < 30, 0, 30), lambda x: 0 * x + 2.0, "dry bed"),
    ],
)
def test_no_jump_says_why(layers, speed, reason):
    profiles = compute_profiles([flow(layers, speed, 0.1 * k) for k in range(4)], context())
    result = analyse_jump(profiles, context())
    summary = numbers(summarise_jump(result))
    assert result.verdict == "no jump found"
    assert reason in result.reason
    assert summary["y1"] is None
    assert summary["speed"] is None


def stream_of(thrust, frames=20, toe=40.0):
    """Stream 1 m deep at 16 m/s up to 50 m, with this thrust (m^3/s^2), shape (bins,) or (frames, bins)."""
    x = np.arange(50) + 0.5
    ones = np.ones((frames, 50))
    depth = np.where(x < toe, 1.0, 6.5) * ones
    fields = {
        "mass_depth": depth,
        "discharge": 16.0 * ones,
        "momentum_flux": 256.0 * ones - thrust,
        "thrust": thrust * ones,
    }
    stream = xr.Dataset({name: (("time", "x"), values) for name, values in fields.items()}, {"x": x})
    nothing, places = np.full(frames, np.nan), np.full(frames, toe)
    return stream, JumpTrack(
        np.arange(frames), places, places + 6, places + 3, *[nothing] * 4, nothing + 50, ("",) * frames
    )


def test_compression_front_is_where_the_thrust_rises():
    x = np.arange(50) + 0.5
    rng = np.random.default_rng(1)
    # pulses and gaps behind 12 m, chance contacts before it
    thrust = np.where(x > 12, rng.exponential(43.0, (20, 50)), rng.exponential(3.0, (20, 50)))
    stream, track = stream_of(thrust)
    assert np.median(compression_front(stream, track, G)) == pytest.approx(12.0, abs=1.0)
    places = np.array([50.0, 40.0, 90.0, 30.0, np.nan, 20.0, 10.0])
    assert running_median(places, 3).tolist() == [45.0, 50.0, 40.0, 60.0, 25.0, 15.0, 15.0]
    assert np.isnan(running_median(np.full(5, np.nan))).all()
    quiet, track = stream_of(rng.exponential(3.0, (20, 50)))
    assert np.isnan(compression_front(quiet, track, G)).all()


def test_flux_and_thrust_along_the_stream():
    x = np.arange(50) + 0.5
    stream, track = stream_of(np.where(x > 12, 43.0, 3.0))
    track = replace(track, compression=compression_front(stream, track, G))
    found = measure_stream(stream, track, np.ones(20, bool), -1.0, 6.5, G)
    assert found.start[0] == 1.0 and found.stop[-1] <= 39.0 and np.diff(found.start) == pytest.approx(5.0)
    assert found.total == pytest.approx(256.0) and found.total_deviation < 1e-12
    assert found.momentum_flux[[0, -1]] == pytest.approx([253.0, 213.0])
    assert found.froude == pytest.approx(17.0 / sqrt(G))
    assert found.deviation == pytest.approx(6.5 / theory.belanger(17.0 / sqrt(G)) - 1)
    assert (found.compression, found.undisturbed, found.at_inlet) == (12.0, 12.0, True)
    turned = found.turned(-1)
    assert (turned.start[0], turned.velocity[0], turned.compression) == (-1.0, -16.0, -12.0)


def test_the_verdict_names_its_state_and_warns_of_a_compressed_inflow(step_result):
    jump = worded(summarise_jump(step_result))
    assert "The state before the toe is that of the stream 5." in jump.reason and "m before the front" in jump.reason
    assert jump.notes == () and jump.headline.startswith("Hydraulic jump: found in 24 of 24 frames, front at ")
    assert "stream before the toe" in jump.headline and "0.0 %" in jump.headline
    x = np.arange(50) + 0.5
    stream, track = stream_of(np.where(x > 12, 43.0, 3.0))
    track = replace(track, compression=compression_front(stream, track, G))
    pressed = replace(jump, stream=measure_stream(stream, track, np.ones(20, bool), -1.0, 6.5, G))
    assert "12.0 m behind the inlet" in notes(pressed)[0]
    assert "compress that stream from x = 12 m on" in belongs_to(pressed)


def test_the_share_of_frames_grades_the_verdict():
    """Frames with a jump and frames without: no coin is tossed at one half."""
    with_jump, without = (
        moving_step(24),
        [flow(lambda x: 0 * x + 5, lambda x: 0 * x + 14.0, 0.1 * k) for k in range(24)],
    )
    for jumps, expected in ((24, "jump"), (14, "marginal jump"), (10, "marginal jump"), (2, "no jump found")):
        frames = with_jump[:jumps] + without[jumps:]
        jump = worded(summarise_jump(analyse_jump(compute_profiles(frames, context()), context())))
        assert (jump.verdict, jump.frames_found) == (expected, jumps)
        assert jump.share_found == pytest.approx(jumps / 24)
    assert jump.headline.startswith("No hydraulic jump to compare with Bélanger: no jump found.")


def test_too_short_a_channel_and_no_gravity():
    frames = [flow(lambda x: 0 * x + 5, lambda x: 0 * x + 1.0)]
    short = context(x_range=(0.0, 5.0))
    assert "fewer than eight bins" in analyse_jump(compute_profiles(frames, short), short).reason
    weightless = context(gravity=(0.0, 0.0))
    assert "no gravity" in analyse_jump(compute_profiles(frames, weightless), weightless).reason


def test_locked_heap_is_named():
    """Discs at rest under a steep surface behind the toe, as friction leaves them."""

    def layers(x):
        return np.where(x < 20, 5, np.maximum(35 - (x - 20) * 0.75, 1))

    frames = [flow(layers, lambda x: np.where(x < 20, 12.0, 0.0), 0.1 * k) for k in range(10)]
    result = analyse_jump(compute_profiles(frames, context()), context())
    assert result.verdict == "locked heap"
    assert result.heap.surface_slope == pytest.approx(-0.15, abs=0.01)
    assert result.heap.standing_share > 0.9


def test_level_water_at_rest_behind_a_bore_is_a_jump():
    frames = [flow(lambda x: np.where(x < 30, 5, 30), lambda x: np.where(x < 30, 12.0, 0.0), 0.1 * k) for k in range(9)]
    assert analyse_jump(compute_profiles(frames, context()), context()).verdict == "jump"


def test_drowned_inlet_is_named():
    flooded = context(inflow_depth=1.0, inflow_speed=14.0)
    frames = [flow(lambda x: 0 * x + 30, lambda x: 0 * x + 1.0, 0.1 * k) for k in range(4)]
    result = analyse_jump(compute_profiles(frames, flooded), flooded)
    assert (result.verdict, "over the inlet" in result.reason) == ("drowned inlet", True)
    frames = [
        flow(lambda x: np.where(x < 1.6, 5, 30), lambda x: np.where(x < 1.6, 14.0, 2.4), 0.1 * k) for k in range(4)
    ]
    near = replace(flooded, bin_width=0.4)
    assert analyse_jump(compute_profiles(frames, near), near).verdict == "drowned inlet"


def test_reach_is_the_longest_level_stretch():
    walls = (Block("floor", (-10, 50.5), (-10, 0)), Block("sill", (50, 51), (-10, 2)))
    there = context(walls=walls)
    bed = compute_profiles([flow(lambda x: 0 * x + 5, lambda x: 0 * x + 1)], there)["bed"].values
    assert level_reach(bed, D).tolist() == list(range(50))
    assert level_reach(bed[::-1], D).tolist() == list(range(10, 60))
    assert not level_reach(np.full(9, np.nan), D).size


def test_a_baffle_does_not_end_the_level_bed():
    """A block lower than a quarter of the water above it and shorter than that depth; a sill or a long step does."""
    bed, water = np.zeros(20), np.full(20, 4.0)
    bed[8:10], bed[15:] = 0.9, 2.0
    assert without_baffles(bed, water, 1.0, D)[:15].tolist() == [0.0] * 15
    assert without_baffles(bed, water, 2.0, D)[8:10].tolist() == [0.9] * 2  # four metres long
    assert without_baffles(bed, 0.8 * water, 1.0, D)[8:10].tolist() == [0.9] * 2  # higher than a quarter
    bed[8:10] = -0.5
    assert without_baffles(bed, water, 1.0, D).tolist() == bed.tolist()  # a pit stays


def test_a_basin_at_the_foot_of_a_chute():
    """The inlet stands 3 m above the bed: it is not drowned, and its stream is no state before the jump."""
    chute = Line("chute", points=((-1.0, 3.0), (2.0, 3.0), (8.0, 0.0), (61.0, 0.0)))
    rows = (InletRow(0.0, 3.1, 20.0, 0.0, 1, 10, 0.2),)
    there = context(walls=(chute,), inlets=rows, inflow_depth=1.2, inflow_speed=20.0)

    def stream(frame):
        below = frame.x > 8.0
        columns = {name: np.array(values)[below] for name, values in frame.columns.items()}
        return make_frame(frame.step, frame.time, frame.box, columns)

    frames = [stream(frame) for frame in moving_step(24, 14.5)]
    profiles = compute_profiles(frames, there)
    assert analyse_jump(profiles, there).verdict == "jump"  # the toe comes within 2.4 m of the foot
    found = analyse(Gathered(there, profiles, None, {}, {}))
    assert (found.of, found.inflow) == ("stream before the toe", None)


@examples(60)
@given(
    toe=st.floats(5, 25),
    length=st.floats(0, 20),
    low=st.floats(0.2, 2),
    rise=st.floats(0.5, 8),
)
def test_fit_recovers_a_ramp(toe, length, low, rise):
    edges = np.arange(61.0)
    end = toe + length
    fine = np.linspace(0, 60, 60 * 200 + 1)
    fine = 0.5 * (fine[1:] + fine[:-1])
    shape = np.clip((fine - toe) / max(length, 1e-9), 0, 1)
    depth = low + rise * shape.reshape(60, 200).mean(axis=1)
    ramp = fit_ramp(edges, depth)
    assert ramp.share > 0.99
    # the ends are known to a bin where the ramp is shorter than one, else to about its eighth
    tolerance = 1.01 if length < 3 else 0.3
    assert abs(ramp.toe - toe) < tolerance
    assert abs(ramp.end - end) < tolerance
    place = equivalent_position(edges, depth, ramp.toe, ramp.end, low, low + rise)
    assert place == pytest.approx(toe + 0.5 * length, abs=0.02)  # 200 points a bin stand for the exact profile


def test_flat_profile_has_no_ramp():
    assert fit_ramp(np.arange(21.0), np.full(20, 3.0)) is None
    assert fit_ramp(np.arange(21.0), np.linspace(3, 1, 20)) is None


def test_straight_motion_of_exact_line():
    t = np.linspace(0, 5, 21)
    motion = straight_motion(t, 3.0 - 1.5 * t)
    assert motion.speed == pytest.approx(-1.5, abs=1e-12)
    assert motion.start == pytest.approx(3.0, abs=1e-12)
    assert motion.error == pytest.approx(0.0, abs=1e-9)
    assert straight_motion(t, np.full(21, np.nan)).points == 0
    assert np.isnan(straight_motion(t[:1], t[:1]).speed)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_speed_error_covers_the_truth(memory):
    """The 95 % interval holds the true speed of a front whose speed wanders, in 95 of 100 records."""
    rng = np.random.default_rng(5)
    t = np.arange(200) * 0.1
    covered = 0
    for _ in range(300):
        wander = rng.normal(size=200)
        for k in range(1, 200):
            wander[k] += memory * wander[k - 1]
        motion = straight_motion(t, 2.0 * t + 0.1 * np.cumsum(wander))
        covered += abs(motion.speed - 2.0) < STUDENT * motion.error
    # 300 draws scatter by 1.3 %; a memory of ten frames costs a little in pieces of 25
    assert 0.88 <= covered / 300 <= 0.995


def test_slow_swings_raise_the_error():
    fast, slow = np.tile([1.0, -1.0], 4), np.repeat([1.0, -1.0], 4)
    assert piece_error(fast) == pytest.approx(np.std(fast, ddof=1) / sqrt(8))
    assert piece_error(slow) > 1.2 * np.std(slow, ddof=1) / sqrt(8)
    assert np.isnan(piece_error(np.ones(7))) and np.isnan(piece_error(np.append(fast[1:], np.nan)))


@pytest.mark.parametrize(("memory", "lowest"), [(0.0, 0.94), (0.8, 0.94), (0.9, 0.88)])
def test_mean_error_covers_the_truth(memory, lowest):
    """So does that of a mean, also with swings as long as a piece of 15 samples (the last)."""
    rng = np.random.default_rng(6)
    covered = 0
    for _ in range(400):
        series = rng.normal(size=120) / sqrt(1 - memory**2)
        for k in range(1, 120):
            series[k] = memory * series[k - 1] + series[k] * sqrt(1 - memory**2)
        mean = mean_of(series)
        covered += abs(mean.value) < STUDENT * mean.error
    assert lowest <= covered / 400 <= 0.995


def wandering_step():
    """A bore of 48 frames whose speed and depth change from frame to frame."""
    rng = np.random.default_rng(3)
    fronts = 40.0 + np.cumsum(0.1 * (SPEED + rng.normal(size=48)))
    layers = rng.integers(28, 33, 48)

    def frame(k):
        def deep(x):
            return np.where(x < fronts[k], 5, layers[k])

        return flow(deep, lambda x: np.where(x < fronts[k], U1, U2), 0.1 * k)

    return [frame(k) for k in range(48)]


def test_each_printed_number_has_its_error():
    jump = summarise_jump(analyse_jump(compute_profiles(wandering_step(), context()), context()))
    found = numbers(jump)
    for key in ("y2", "speed", "toe_speed", "froude", "belanger_y2", "belanger_deviation", "length", "length_over_y2"):
        assert 0 < found[f"{key}_error"] < 2 * abs(found[key]) + 1, key
    for key in ("h2", "froude", "sequent_ratio", "belanger_ratio", "density_ratio", "head_upstream", "energy_loss"):
        assert 0 < found["local"][f"{key}_error"] < 2 * abs(found["local"][key]) + 1, key
    # what is computed of the same pieces: the ratio's error is not that of independent depths
    pieces = jump.pieces
    ratios = [piece.downstream.mass_depth / piece.upstream.mass_depth for piece in pieces]
    assert found["local"]["sequent_ratio_error"] == pytest.approx(piece_error(np.array(ratios)), rel=1e-9)
    speeds = [piece.motion.speed for piece in pieces]
    assert found["speed_error"] == pytest.approx(piece_error(np.array(speeds)), rel=1e-9)
    assert found["drift"]["speed"] == pytest.approx(np.mean(speeds[4:]) - np.mean(speeds[:4]), rel=1e-9)
    assert found["members"]["speed"] >= (found["speed_error"] / (0.03 * found["speed"])) ** 2
    assert found["members"]["y2"] >= 1


def tables_of(jump):
    """All tables of the section."""
    blocks = [
        one for block in section(jump).blocks for one in (block.blocks if isinstance(block, SideBySide) else [block])
    ]
    return [block for block in blocks if isinstance(block, Table)]


def test_the_section_says_what_the_numbers_are_worth():
    jump = worded(summarise_jump(analyse_jump(compute_profiles(wandering_step(), context()), context())))
    page = render("", [section(jump)])
    assert "short jump, of one to two" in page and "stream before the toe" in page
    assert "±" not in page and "average at least" in certainty(jump)[1]
    upstream = replace(jump, roller=Roller(2.5, 1.0, 2.0, 1.5))
    rows = [row for table in tables_of(upstream) for row in table.rows]
    assert [row[1] for row in rows if row[0].startswith("Roller")] == ["2", "2.5"]


def test_numbers_that_one_run_cannot_tell_say_so_everywhere():
    jump = worded(summarise_jump(analyse_jump(compute_profiles(wandering_step(), context()), context())))
    found, known = numbers(jump), numbers_of(Jump)
    local = found["local"]
    assert {"y2", "speed", "froude", "belanger_y2", "belanger_deviation"} <= set(found["lower_bounds"])
    assert {"u2", "sequent_ratio", "belanger_ratio", "energy_loss"} <= set(local["lower_bounds"])
    assert all(f"{key}_error" in known for key in LOWER_BOUNDS)
    assert all(f"{key}_error" in numbers_of(Local) for key in LOCAL_BOUNDS)
    errors = dict(errors_of(jump)) | dict(errors_of(jump.local))
    told = errors["Mass depth s behind the end [m]"], errors["Sequent depth, by mass [m]"]
    assert all(text.startswith("at least ") for text in told)
    assert "at least" not in errors["Length of the jump [m]"]
    assert "±" not in untimed(jump).reason + jump.reason
    assert "front at " in jump.headline and "± at least " in jump.headline


def test_what_is_made_of_a_marked_number_is_marked(step_result):
    """A state that changes in what one run cannot tell changes no number that is not marked."""
    assert set(inherited(["a"], {"b": ["a"], "c": ["x", "b"], "d": ["x"]})) == {"a", "b", "c"}
    assert set(UNTOLD) <= set(inherited(UNTOLD, MADE_OF))
    before = numbers(summarise_jump(step_result))
    one, two = step_result.upstream, step_result.downstream
    faster = replace(step_result.motion, speed=1.01 * SPEED)
    changes = {
        "y2": {"downstream": replace(two, mass_depth=1.01 * S2)},
        "h2": {"downstream": replace(two, surface_depth=1.01 * two.surface_depth)},
        "u2": {"downstream": replace(two, velocity=1.01 * U2)},
        "speed": {"motion": faster, "upstream": replace(one, speed=1.01 * SPEED)},
    }
    for name, change in changes.items():
        after = numbers(summarise_jump(replace(step_result, **change)))
        for prefix, old, new, marked in (
            ("", before, after, after["lower_bounds"]), ("local.", before["local"], after["local"], LOCAL_BOUNDS)
        ):  # fmt: skip
            moved = {key for key in old if f"{key}_error" in old and old[key] and new[key] != pytest.approx(old[key])}
            assert moved <= set(marked) | {"h1", "h2", "head_lost"}, (name, prefix, moved - set(marked))


@pytest.mark.parametrize("kind", ["locked heap", "drowned inlet", "no jump found"])
def test_no_row_of_a_jump_where_there_is_none(kind, step_result):
    found = replace(worded(summarise_jump(step_result)), budget=Budget(start=-2.0, stop=5.0, lost=1.0))
    shown = str(section(replace(found, verdict=kind)))
    words_of_a_jump = ("Length", "Head", "Mass depth", "s₂/s₁", "Bélanger's", "Roller", "Tail water", "Energy between")
    for words in words_of_a_jump:
        assert words not in shown.replace(found.reason, ""), words
    marginal = str(section(replace(found, verdict="marginal jump")))
    assert "Mass depth" in marginal and "Length of the jump" not in marginal and "Energy between" not in marginal


def test_the_tail_is_held_against_the_stream_that_was_delivered():
    here = context(inflow_depth=1.0, inflow_speed=16.0)
    result = analyse_jump(compute_profiles(wandering_step(), here), here)
    asked, given = summarise_jump(result), summarise_jump(result, (Mean(1.1, 0.01), Mean(15.0, 0.2)))
    for jump, depth, velocity in ((asked, 1.0, 16.0), (given, 1.1, 15.0)):
        expected = theory.sequent_depth(velocity - result.motion.speed, depth)
        assert jump.belanger_y2 == pytest.approx(expected, rel=1e-9)
        assert jump.belanger_deviation == pytest.approx(jump.y2 / expected - 1, rel=1e-9)
        assert jump.y2 == result.tail.depth.value and jump.y1 == depth
        assert jump.froude == pytest.approx((velocity - result.motion.speed) / sqrt(G * depth), rel=1e-9)
    slope = propagated(lambda u: theory.sequent_depth(u - result.motion.speed, 1.1), Mean(15.0, 0.2)).error
    assert given.belanger_y2_error > max(slope, asked.belanger_y2_error) > 0
    assert f"{given.belanger_y2:.2f}" in worded(given).headline and "delivered inflow" in worded(given).headline
    assert given.inflow.velocity == 16.0  # theory of what was asked for


def test_errors_are_handed_on():
    one, two = Mean(3.0, 0.3), Mean(4.0, 0.4)
    for function, value, error in (
        (lambda a, b: a - b, -1.0, 0.5),
        (lambda a, b: a * b, 12.0, 12.0 * np.hypot(0.1, 0.1)),
    ):
        found = propagated(function, one, two)
        assert (found.value, found.error) == pytest.approx((value, error))
    assert np.isnan(propagated(lambda a: a, Mean(1.0, np.nan)).error)


def test_too_few_frames_have_no_error(step_result):
    few = analyse_jump(compute_profiles(moving_step(15), context()), context())
    found = numbers(summarise_jump(few))
    assert found["y2"] and found["speed"] and found["y2_error"] is None and found["speed_error"] is None
    assert set(found["members"].values()) == {None} and found["drift"]["y2"] is None
    assert few.pieces == () and len(step_result.pieces) == 8


@pytest.mark.parametrize("width", [0.5, 1.0, 2.0])
def test_state_1_does_not_depend_on_the_bins(width):
    """A stream that thickens over its last three depths before the front: its undisturbed part is what counts."""
    here = context(bin_width=width)
    frames = []
    for k in range(16):
        front = 40.0 + SPEED * 0.1 * k
        deep = lambda x, f=front: np.where(x < f - 3, 5, np.where(x < f, 6, 30))  # noqa: E731  (the front of this frame)
        frames.append(flow(deep, lambda x, d=deep: U1 * 5 / d(x), 0.1 * k))
    jump = summarise_jump(analyse_jump(compute_profiles(frames, here), here))
    assert jump.local.y1 == pytest.approx(1.0, rel=1e-6) and jump.local.u1 == pytest.approx(U1, rel=1e-6)
    assert jump.local.moved_y1 == pytest.approx(0.0, abs=1e-6)
    assert jump.y2 == pytest.approx(6.0, rel=1e-6)


@pytest.mark.parametrize("width", [0.25, 0.5, 1.0])
def test_toe_and_length_are_smoothed_over_one_length_whatever_the_bins(width):
    xi = np.arange(-20 + width / 2, 20, width)
    moving = Moving(np.zeros(1), xi, {"s": np.clip(xi / 6, 0, 1)[None]})
    smooth = moving.smoothed("s", 2.0)
    middle = np.abs(xi - 3) < 1
    assert smooth[middle] == pytest.approx(xi[middle] / 6, abs=1e-9)
    # a corner smoothed over a length L lies slope L/8 higher; linear between bins, and their own part left out
    assert np.interp(0.0, xi, smooth) == pytest.approx(2.0 / 8 / 6, abs=0.012)
    assert np.isfinite(smooth).all() and smooth[0] == 0 and smooth[-1] == 1


def test_the_headline_is_the_comparison_everywhere():
    """Title, sentence, tiles and table say one depth, one Bélanger and one deviation."""
    here = context(inflow_depth=1.0, inflow_speed=U1)
    result = analyse_jump(compute_profiles(moving_step(), here), here)
    jump = worded(summarise_jump(result, (Mean(1.05, 0.001), Mean(U1, 0.01))))
    found = numbers(jump)
    assert (jump.of, jump.at, jump.left_out, jump.filling) == ("delivered inflow", "tail water", (), False)
    assert jump.local.belanger_y2 != pytest.approx(jump.belanger_y2, rel=1e-3)
    expected = f"{jump.belanger_y2:.4f}"
    off = f"{100 * jump.belanger_deviation:+.1f}".replace("-", "−")
    assert expected in jump.headline and off in jump.headline and f"Fr = {jump.froude:.4f}" in jump.headline
    assert f"Its sequent depth is {-100 * jump.belanger_deviation:.2f} % below Bélanger’s" in verdict({"jump": found})
    boxes = tiles(rows_of([{"jump": found}]))
    assert float(boxes[0].value) == pytest.approx(jump.y2, abs=0.005)
    assert f"Bélanger {jump.belanger_y2:.2f} m" in boxes[0].against and off in boxes[0].against
    tables = tables_of(jump)
    rows = [row for table in tables for row in table.rows]
    assert sum(expected in str(cell) for row in rows for cell in row) == 1  # the states
    sill = theory.sill_holding_height(U1, 1.0)
    assert any(
        f"By energy a sill of {sill:.4g} m" in block.text for block in section(jump).blocks if isinstance(block, Text)
    )
    states = next(table for table in tables if table.header[0] == "State")
    assert states.header == ("State", "frame", "Froude number", "sequent depth by Bélanger [m]")
    assert [row[1] for row in states.rows] == ["front", "front", "laboratory", "laboratory"]


def test_a_jump_that_ends_at_the_sill_says_so():
    """A rise of 0.6 to 6 m that goes on up to the end of the bed: no level water behind it."""

    def layers(x):
        return np.where(x < 52, 3, np.minimum(3 + 27 * (np.maximum(x - 52, 0) / 8) ** 2, 30))

    frames = [flow(layers, lambda x: 12.0 * 3 / layers(x), 0.1 * k) for k in range(6)]
    jump = worded(summarise_jump(analyse_jump(compute_profiles(frames, context()), context())))
    assert jump.verdict == "jump at the sill" and np.isnan(jump.y2)
    assert "no level water behind it" in jump.reason
    assert verdict({"jump": numbers(jump)}) == "A jump that ends at the sill: no level water to compare."


def test_a_jump_that_still_fills_the_channel_says_so_on_top():
    jump = worded(summarise_jump(analyse_jump(compute_profiles(moving_step(start=52.0), context()), context())))
    assert jump.verdict == "jump" and jump.at == "depth behind the end" and jump.filling
    assert "that still fills the channel" in verdict({"jump": numbers(jump)})
    assert "The channel still fills: there is no level tail water yet" in jump.headline


@pytest.mark.parametrize(("friction", "slope", "said"), [(0.05, 0, "with friction"), (0.0, 0.5, "on a slope")])
def test_what_belanger_leaves_out_is_said_on_top(friction, slope, said):
    here = context(gravity=(slope, -G))
    scene = replace(here.scene, coefficients=replace(here.scene.coefficients, friction=friction))
    here = replace(here, scene=scene)
    jump = worded(summarise_jump(analyse_jump(compute_profiles(moving_step(), here), here)))
    title = verdict({"jump": numbers(jump)})
    assert title.startswith(f"A hydraulic jump {said}. ") and "Bélanger’s, which leaves that out" in title
    assert f"Bélanger's relation leaves out {'friction' if friction else 'the slope of the bed'}; " in jump.headline


ANGLE = radians(4.0)


def on_a_chute(frame):
    """The frame of a level bed as it stands on a bed that falls by `ANGLE` from the origin on."""
    columns = {name: np.array(values) for name, values in frame.columns.items()}
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    for a, b in (("x", "y"), ("vx", "vy")):
        columns[a], columns[b] = c * columns[a] + s * columns[b], c * columns[b] - s * columns[a]
    return make_frame(frame.step, frame.time, frame.box, columns)


def gathered_of(frames, flow):
    """What one pass over frames leaves, along a sloping stretch too."""
    stretch = sloping_stretch(flow)
    along = [AlongBed(flow, stretch)] if stretch else []
    profiles = compute_profiles(feed(frames, flow, along), flow)
    return Gathered(flow, profiles, None, {}, {}, along=along[0].result() if along else None), stretch


def test_a_jump_on_a_chute_is_that_of_a_level_bed_in_tilted_gravity():
    """Along and across the bed they are one flow: all numbers agree, but for the places, which are along x."""
    tilted = context(gravity=(G * np.sin(ANGLE), -G * np.cos(ANGLE)))
    level, _ = gathered_of(moving_step(), tilted)
    assert level.along is None
    high = 62.0 * np.cos(ANGLE)
    bed = Line("bed", ((-5.0, 5.0 * np.tan(ANGLE)), (100.0, -100.0 * np.tan(ANGLE))))
    # bins of the stretch begin at the middle of the first bin: at the origin
    upright = context(
        walls=(bed, Plane("back", "x", -0.5, "above")), x_range=(-0.5, high), domain=((-5.0, 65.0), (-9.0, 20.0))
    )
    chute, stretch = gathered_of(map(on_a_chute, moving_step()), upright)
    assert stretch.angle == pytest.approx(-ANGLE, rel=1e-9) and abs(stretch.x) < 1e-9
    straight, there = (analyse(one) for one in (level, chute))
    assert straight.verdict == there.verdict == "jump"
    assert there.bed_slope == pytest.approx(np.tan(ANGLE), rel=1e-9) == straight.bed_slope
    one, two = numbers(straight), numbers(there)
    for key in ("y1", "y2", "froude", "speed", "belanger_y2", "sloping_y2", "sloping_deviation", "length"):
        assert two[key] == pytest.approx(one[key], rel=1e-6), key
    for key in ("y1", "y2", "u1", "u2", "beta_1", "sequent_ratio", "sloping_ratio", "momentum_residual"):
        assert two["local"][key] == pytest.approx(one["local"][key], rel=1e-6, abs=1e-6), key
    for key in ("position", "toe", "end"):
        assert two[key] == pytest.approx(one[key] * np.cos(ANGLE), rel=1e-6), key
    assert two["momentum_terms"]["slope"] == pytest.approx(one["momentum_terms"]["slope"], rel=1e-6)
    # the weight of the jump's water pushes along the bed: the sequent depth is larger than Bélanger's
    assert two["sloping_y2"] > 1.001 * two["belanger_y2"]
    assert "With the weight of the jump along the bed it gives" in there.headline


@given(froude=st.floats(1.2, 15.0), weight=st.floats(-0.05, 20.0))
def test_a_weight_along_the_bed_changes_the_sequent_depth(froude, weight):
    ratio = theory.sloping_ratio(froude, weight)
    left = 2 * froude**2 * (1 - 1 / ratio) + 1 - ratio**2 + weight
    assert abs(left) < 1e-9 * (1 + 2 * froude**2 + weight)
    assert theory.sloping_ratio(froude, 0.0) == pytest.approx(theory.belanger(froude), rel=1e-9)
    # of a trapezium between the depths it is the relation with a resisting bed
    resistance = -weight / (1 + ratio)
    assert theory.sequent_ratio(froude, resistance=resistance) == pytest.approx(ratio, rel=1e-6)
    assert np.isnan(theory.sloping_ratio(froude, -2 * froude**2))


def test_growth_rate():
    time = np.array([0.0, 1.0, 2.0, 4.0])
    assert growth_rate(time, np.array([np.nan, 1.0, 7.0, 4.0])) == pytest.approx(1.0)
    assert growth_rate(time, np.full(4, np.nan)) == 0.0
