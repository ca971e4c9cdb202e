# SPDX-License-Identifier: GPL-2.0-or-later
"""Profiles of made-up flows whose depth, discharge and mass are known."""

from contextlib import nullcontext
from functools import partial

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from made_up import columns_of_discs, coreless, disc_frame, examples, flow_context

from lammps_jump.analysis.profiles import FrameDiscs, add_means, bin_edges, compute_profiles, connected
from lammps_jump.analysis.statistics import block_average
from lammps_jump.dump.exports import read_netcdf, write_netcdf
from lammps_jump.dump.frame import make_frame
from lammps_jump.errors import DumpError
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.tracks import Translate
from lammps_jump.scene.walls import Block, Plane

D = 0.2
BOX = [[-5, 25], [-5, 20]]


context = partial(
    flow_context, domain=((-5.0, 25.0), (-5.0, 20.0)), x_range=(0.0, 20.0), walls=(Plane("floor", "y", 0.0, "above"),),
    bin_width=1.0,
)  # fmt: skip


def lattice(layers, x_low=-1.0, x_high=21.0, bed=0.0):
    return columns_of_discs(layers, x_low, x_high, bed=bed)


def frame(x, y, u=0.0, v=0.0, step=0, time=0.0):
    return disc_frame(x, y, u, v, box=BOX, step=step, time=time)


def test_uniform_block():
    x, y = lattice(20)
    ds = compute_profiles([frame(x, y, u=2.0, v=1.0)], context())
    expected = {
        "surface_depth": 4.0,
        "mass_depth": 4.0,
        "velocity": 2.0,
        "discharge": 8.0,
        "momentum_flux": 16.0,
        "energy_flux": 4.0 * 2.0 * 2.5,
        "packing": np.pi / 4,
        "surface_velocity": 2.0,
        "centroid_height": 2.0,
        "count": 100.0,
    }
    for name, value in expected.items():
        np.testing.assert_allclose(ds[name], value, rtol=1e-12, err_msg=name)  # round-off of 110 terms


def test_step_profile_moving_at_a_set_speed():
    """A bore of 10 above 5 layers whose toe runs at -2 m/s: found in every frame to a bin."""
    frames = []
    for i in range(5):
        toe = 15.0 - 2.0 * i
        x, y = lattice(lambda c, toe=toe: np.where(c < toe, 5, 10))
        frames.append(frame(x, y, u=np.where(x < toe, 8.0, 3.0), step=i, time=float(i)))
    ds = compute_profiles(frames, context())
    for i in range(5):
        toe = 15.0 - 2.0 * i
        upstream = ds.x.values < toe
        np.testing.assert_allclose(ds.surface_depth[i], np.where(upstream, 1.0, 2.0), rtol=1e-12)
        np.testing.assert_allclose(ds.mass_depth[i], np.where(upstream, 1.0, 2.0), rtol=1e-12)
        np.testing.assert_allclose(ds.velocity[i], np.where(upstream, 8.0, 3.0), rtol=1e-12)
        np.testing.assert_allclose(ds.discharge[i], np.where(upstream, 8.0, 6.0), rtol=1e-12)


def test_an_empty_frame_is_dry():
    ds = compute_profiles([frame([], [])], context())
    for name in ("surface_depth", "mass_depth", "discharge", "count"):
        assert (ds[name] == 0).all()
    for name in ("velocity", "packing", "surface_velocity", "centroid_height"):
        assert np.isnan(ds[name]).all()


def test_one_disc_astride_an_edge():
    """Centre at 3/10 of a diameter left of the edge: the right share is the circular segment beyond a = 0.6."""
    ds = compute_profiles([frame([5.0 - 0.3 * D], [D / 2], u=2.0)], context())
    a = 0.6
    right = 0.5 - (a * np.sqrt(1 - a**2) + np.arcsin(a)) / np.pi
    assert float(ds["count"][0, 5]) == pytest.approx(right, rel=1e-12)
    assert float(ds["count"][0, 4]) == pytest.approx(1 - right, rel=1e-12)
    assert float(ds["discharge"][0, 4]) == pytest.approx((1 - right) * D**2 * 2.0, rel=1e-12)


def test_a_splashing_disc_does_not_raise_the_surface():
    x, y = lattice(10)
    quiet = compute_profiles([frame(x, y)], context())
    splash = compute_profiles([frame(np.append(x, 10.5), np.append(y, 2.0 + 3.0 * D))], context())
    np.testing.assert_array_equal(quiet.surface_depth, splash.surface_depth)
    assert float(splash["count"].sum()) == pytest.approx(float(quiet["count"].sum()) + 1, rel=1e-12)
    # a disc that lies on the surface does count, on the lines that it covers: 8 of 40
    resting = compute_profiles([frame(np.append(x, 10.5), np.append(y, 2.0 + 0.5 * D))], context())
    assert float(resting.surface_depth[0, 10]) == pytest.approx(2.0 + D * 8 / 40, rel=1e-12)


def test_depth_is_measured_from_the_sill_and_not_at_all_beyond_the_floor():
    walls = (Block("floor", (-10, 12), (-10, 0)), Block("sill", (8, 10), (-10, 1)))
    low, high = lattice(5, -1, 8), lattice(5, 8, 10, bed=1.0)
    behind = lattice(5, 10, 20)
    x, y = (np.concatenate(parts) for parts in zip(low, high, behind, strict=True))
    ds = compute_profiles([frame(x, y, u=1.0)], context(walls=walls))
    np.testing.assert_allclose(ds.bed[:12], [0] * 8 + [1, 1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(ds.surface_depth[0, :12], 1.0, rtol=1e-12)
    np.testing.assert_allclose(ds.centroid_height[0, :12], 0.5, rtol=1e-12)
    assert np.isnan(ds.surface_depth[0, 12:]).all()
    np.testing.assert_allclose(ds.discharge[0], 1.0, rtol=1e-12)  # mass needs no floor


def travelling_sill(speed=4.0, **more):
    """A block of 1 m on the floor from x = 2 to 4 m at t = 0, and frames of discs 1 m deep above it and the floor."""
    motion = Motion(kind=Translate((speed, 0.0)), time_step=1.0)
    walls = (Plane("floor", "y", 0.0, "above"), MovingWall(Block("sill", (2, 4), (0, 1)), motion))
    frames = []
    for step in range(4):
        low = 2.0 + speed * step
        parts = lattice(5, -1, low), lattice(5, low, low + 2, bed=1.0), lattice(5, low + 2, 21)
        x, y = (np.concatenate(part) for part in zip(*parts, strict=True))
        frames.append(frame(x, y, u=2.0, step=step, time=float(step)))
    return frames, context(walls=walls, time_step=1.0, **more)


def test_the_bed_is_where_a_sill_is_at_the_time_of_the_frame():
    """Depths above a sill that travels 12 m are those of its place in each frame; `bed` is the mean of the window."""
    frames, flow = travelling_sill(window=(2.0, 3.0))
    ds = compute_profiles(frames, flow)
    for step in range(4):
        above = (ds.x.values > 2 + 4 * step) & (ds.x.values < 4 + 4 * step)
        np.testing.assert_allclose(ds.bed_at[step], above, atol=1e-12)
    np.testing.assert_allclose(ds.surface_depth, 1.0, rtol=1e-12)
    np.testing.assert_allclose(ds.centroid_height, 0.5, rtol=1e-12)
    np.testing.assert_allclose(ds.bed, 0.5 * (ds.bed_at[2] + ds.bed_at[3]), atol=1e-12)
    assert "bed_at" not in compute_profiles(frames, context())


points = st.lists(
    st.tuples(st.floats(-4, 24), st.floats(0.05, 6), st.floats(-20, 20), st.floats(-5, 5)), min_size=0, max_size=60
)


@examples(80)
@given(points=points, width=st.floats(0.03, 5.0), diameter=st.floats(0.05, 2.0))
def test_mass_over_bins_and_outside_is_the_mass_of_the_discs(points, width, diameter):
    x, y, u, v = np.array(points, float).reshape(-1, 4).T
    c = context(diameter=diameter, mass=1000 * diameter**2, bin_width=width)
    columns = {"id": np.arange(len(x)), "x": x, "y": y, "vx": u, "vy": v}
    ds = compute_profiles([make_frame(0, 0.0, BOX, columns)], c)
    binned = float((ds.mass_depth * c.scene.density * width).sum() + ds.mass_left[0] + ds.mass_right[0])
    # round-off: one unit in the last place a share
    assert binned == pytest.approx(len(x) * c.scene.mass, rel=1e-13, abs=1e-12)
    assert float(ds["count"].min()) >= -1e-15


@examples(60)
@given(points=points, width=st.floats(0.03, 5.0), seed=st.integers(0, 2**31))
def test_discs_of_several_sizes_keep_their_mass_and_momentum(points, width, seed):
    x, y, u, v = np.array(points, float).reshape(-1, 4).T
    radius = np.random.default_rng(seed).uniform(0.02, 0.8, len(x))
    c = context(bin_width=width, sized=True)
    columns = {"id": np.arange(len(x)), "x": x, "y": y, "vx": u, "vy": v, "radius": radius}
    ds = compute_profiles([make_frame(0, 0.0, BOX, columns)], c)
    mass = 1000 * (2 * radius) ** 2
    assert float(ds.mass_total[0]) == pytest.approx(mass.sum(), rel=1e-13, abs=1e-12)
    binned = float((ds.mass_depth * 1000 * width).sum() + ds.mass_left[0] + ds.mass_right[0])
    assert binned == pytest.approx(mass.sum(), rel=1e-12, abs=1e-12)
    edges = ds.attrs["x_low"], ds.attrs["x_high"]
    within = (x - radius >= edges[0]) & (x + radius <= edges[1])
    if within.all():
        assert float(ds.discharge.sum()) * 1000 * width == pytest.approx((mass * u).sum(), rel=1e-12, abs=1e-9)
        assert float(ds["count"].sum()) == pytest.approx(len(x), rel=1e-12)
        assert float((ds.packing * ds.surface_depth).sum()) * width <= np.pi * np.sum(radius**2) * (1 + 1e-12)


@examples(60)
@given(seed=st.integers(0, 2**31), count=st.integers(1, 60))
def test_the_surface_is_the_highest_top_over_each_line(seed, count):
    """Against trying every disc; all lie so low that they hang together with the bed; one line a bin."""
    rng = np.random.default_rng(seed)
    radius = rng.uniform(0.05, 0.3, count)
    radius[0] = 0.3
    x, y = rng.uniform(0.5, 9.5, count), rng.uniform(-0.05, 0.6, count) + radius
    columns = {"id": np.arange(count), "x": x, "y": y, "vx": np.arange(count), "vy": 0 * x, "radius": radius}
    ds = compute_profiles([make_frame(0, 0.0, BOX, columns)], context(x_range=(0.0, 10.0), bin_width=0.025, sized=True))
    cut = np.abs(ds.x.values[:, None] - x) <= radius
    top = np.where(cut, y + radius, 0.0)
    np.testing.assert_allclose(ds.surface_depth.values[0], top.max(axis=1), atol=1e-12)
    np.testing.assert_array_equal(ds.surface_velocity.values[0], np.where(cut.any(axis=1), top.argmax(axis=1), np.nan))


def test_the_surface_is_the_highest_top_edge():
    """A small disc beside the upper half of a large one: its centre is higher, its top is lower."""
    columns = {"id": [1, 2], "x": [0.5, 0.8], "y": [0.3, 0.42], "vx": [1.0, 2.0], "vy": [0, 0], "radius": [0.3, 0.02]}
    ds = compute_profiles([make_frame(0, 0.0, BOX, columns)], context(bin_width=0.1, sized=True))
    # lines every 25 mm: that at 0.7875 m cuts both discs, that at 0.8125 m the small one
    expected = [0, 0, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6, 0.44 / 4, 0]
    assert ds.surface_depth.values[0, :10] == pytest.approx(expected, abs=1e-12)
    np.testing.assert_array_equal(ds.surface_velocity.values[0, 2:9], [1, 1, 1, 1, 1, 1, 2])


def test_discs_two_of_the_largest_diameters_apart_are_connected():
    y = np.array([0.3, 1.4, 2.7, 4.2])
    columns = {"id": [1, 2, 3, 4], "x": 0 * y + 5.0, "y": y, "vx": 0 * y, "vy": 0 * y, "radius": [0.3, 0.05, 0.05, 0.3]}
    ds = compute_profiles([make_frame(0, 0.0, BOX, columns)], context(bin_width=0.01, sized=True))
    # 1.1 m lie between the first two, 1.3 m between the second and the third
    assert float(ds.surface_depth.max()) == pytest.approx(1.45)


@examples(60)
@given(points=points, width=st.sampled_from([0.25, 0.5, 1.0, 2.5]))
def test_mirror_symmetry(points, width):
    x, y, u, v = np.array(points, float).reshape(-1, 4).T
    x = np.round(x * 64) / 64  # so that 20 - x is exact
    here = compute_profiles(
        [make_frame(0, 0.0, BOX, {"id": np.arange(len(x)), "x": x, "y": y, "vx": u, "vy": v})], context(bin_width=width)
    )
    there = compute_profiles(
        [make_frame(0, 0.0, BOX, {"id": np.arange(len(x)), "x": 20 - x, "y": y, "vx": -u, "vy": v})],
        context(bin_width=width),
    )
    for name, sign in (("mass_depth", 1), ("discharge", -1), ("momentum_flux", 1), ("count", 1)):
        # shares are differences of segments of order one
        np.testing.assert_allclose(here[name], sign * there[name][:, ::-1], rtol=1e-9, atol=1e-11, err_msg=name)
    # a line that is tangent to a disc may fall on either side: one line of 8 a diameter, and then only its height
    moved = np.abs(here.surface_depth.values - there.surface_depth.values[:, ::-1])
    assert np.median(moved) < 1e-12


def test_connection_is_the_transitive_closure_of_nearness():
    """Against a plain graph search with scipy, strays far away included (coarser grid)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(6)
    x = np.append(rng.uniform(0, 8, 150), [1e4, -1e4])
    y = np.append(rng.uniform(0.1, 4, 150), [5e3, 1.0])
    nothing = np.zeros(152)
    joined = connected(FrameDiscs.of(x, y, nothing, nothing, np.full(152, 0.1), nothing), nothing, 0.4)
    pairs = cKDTree(np.column_stack([x, y])).query_pairs(0.4, output_type="ndarray")
    _, label = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), shape=(152, 152)), directed=False)
    grounded = set(label[y <= 0.3])
    np.testing.assert_array_equal(joined, [piece in grounded for piece in label])
    assert 0 < joined.sum() < 152


def test_netcdf_round_trip_with_units(tmp_path):
    x, y = lattice(5)
    frames = [frame(x, y, u=float(i), step=i, time=0.1 * i) for i in range(20)]
    ds = compute_profiles(frames, context(window=(0.5, 1.9)))
    path = write_netcdf(ds, tmp_path / "profiles.nc")
    again = read_netcdf(path)
    assert again.identical(ds)
    with xr.open_dataset(path) as opened:  # as anyone would
        assert opened.identical(ds)
    assert again.discharge.attrs["units"] == "m2 s-1" and "discharge" in again.discharge.attrs["long_name"]
    assert again.attrs["window_frames"] == 15
    with pytest.raises(DumpError, match="cannot be read"):
        read_netcdf(tmp_path / "none.nc")
    with pytest.raises(DumpError, match="cannot be written"):
        write_netcdf(ds, tmp_path / "no" / "profiles.nc")


def test_steps_beyond_32_bits_are_kept(tmp_path):
    x, y = lattice(5)
    frames = [frame(x, y, step=3 * 10**9 + i, time=0.1 * i) for i in range(2)]
    again = read_netcdf(write_netcdf(compute_profiles(frames, context()), tmp_path / "profiles.nc"))
    assert again.step.values.tolist() == [3 * 10**9, 3 * 10**9 + 1]


def test_a_damaged_netcdf_file_is_told(tmp_path):
    x, y = lattice(5)
    path = write_netcdf(compute_profiles([frame(x, y, step=i) for i in range(3)], context()), tmp_path / "p.nc")
    whole = path.read_bytes()
    for kept in (0, 3, 4, 20, 100, len(whole) // 2, len(whole) - 8):
        path.write_bytes(whole[:kept])
        with pytest.raises(DumpError, match="cannot be read"):
            read_netcdf(path)
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + whole)
    with pytest.raises(DumpError, match="lammps-jump analyze"):
        read_netcdf(path)


def test_window_of_the_means():
    x, y = lattice(5)
    frames = [frame(x, y, u=2.0 if i >= 10 else 0.0, step=i, time=0.1 * i) for i in range(20)]
    ds = compute_profiles(frames, context(window=(1.0, 5.0)))
    np.testing.assert_allclose(ds.velocity_mean, 2.0)
    np.testing.assert_allclose(ds.velocity_stderr, 0.0, atol=0)
    few = add_means(ds, (1.5, 1.9))
    assert np.isnan(few.velocity_stderr).all() and few.attrs["window_frames"] == 5
    with pytest.raises(DumpError, match="no frame between"):
        add_means(ds, (7.0, 8.0))


def test_the_mean_velocity_is_the_mean_discharge_over_the_mean_depth():
    """A deep stream of 1 m/s and a shallow one of 5 m/s in turn, and frames without a disc."""
    deep, shallow = lattice(5), lattice(1)
    frames = [frame(*(shallow if i % 2 else deep), u=5.0 if i % 2 else 1.0, step=i, time=0.1 * i) for i in range(20)]
    ds = compute_profiles(frames, context(window=(0.0, 1.9)))
    np.testing.assert_allclose(ds.velocity_mean, (5 * 1 + 1 * 5) / 6)
    np.testing.assert_allclose(ds.velocity_mean * ds.mass_depth_mean, ds.discharge_mean)
    assert ds.velocity_mean.long_name == "mean discharge over mean mass depth"
    assert (ds.velocity_stderr >= 0).all()


def test_bins_and_what_cannot_be_binned():
    np.testing.assert_allclose(bin_edges((0.0, 1.0), 0.1), np.arange(11) / 10)
    np.testing.assert_allclose(bin_edges((0.0, 1.05), 0.5), [0, 0.5, 1.0])
    assert len(bin_edges((0.0, 0.3), 0.5)) == 2
    with pytest.raises(DumpError, match="bin_width"):
        bin_edges((0.0, 1.0), 0.0)
    with pytest.raises(DumpError, match="makes 1000000 bins"):
        bin_edges((0.0, 1.0), 1e-6)
    with pytest.raises(DumpError, match="x_range"):
        bin_edges((1.0, 1.0), 0.1)
    with pytest.raises(DumpError, match="no frame"):
        compute_profiles([], context())


def test_a_disc_without_a_velocity_counts_in_no_mean():
    """Its mass counts; what moves in its bin is the mean of the others, and a frame of such discs alone is left out."""
    x, u = [0.5, 0.5, 1.5], np.array([[np.nan, 2.0, np.nan], [4.0, 4.0, 3.0]])
    frames = [frame(x, [0.1, 0.3, 0.1], speeds, step=k) for k, speeds in enumerate(u)]
    flow = context(x_range=(0.0, 2.0), bin_width=1.0)
    for calls in (nullcontext, coreless):
        with calls():
            found = compute_profiles(frames, flow)
        np.testing.assert_allclose(found["velocity"], [[2.0, np.nan], [4.0, 3.0]])
        np.testing.assert_allclose(found["surface_velocity"], [[2.0, np.nan], [4.0, 3.0]])
        assert found["velocity_mean"].values == pytest.approx([3.0, 3.0])
        assert found["discharge_mean"].values == pytest.approx(found["mass_depth"].values[0] * [3.0, 3.0])
        assert (found["mass_depth"].values[0] == found["mass_depth"].values[1]).all()


def ar1(n, phi, rng):
    noise = rng.normal(size=n)
    out = np.empty(n)
    out[0] = noise[0] / np.sqrt(1 - phi**2)
    for i in range(1, n):
        out[i] = phi * out[i - 1] + noise[i]
    return out


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.9])
def test_standard_error_of_a_correlated_series(phi):
    """AR(1): the variance of the mean tends to sigma^2 / (1 - phi)^2 / n."""
    rng = np.random.default_rng(11)
    n, repeats = 4096, 60
    series = np.column_stack([ar1(n, phi, rng) for _ in range(repeats)])
    error = block_average(series)[1]
    exact = 1.0 / (1 - phi) / np.sqrt(n)
    assert np.isfinite(error).mean() > 0.8
    # the plateau's own error is 1/sqrt(2 blocks), 5-15 % here; the median of 60 is well inside 15 %
    assert np.nanmedian(error) == pytest.approx(exact, rel=0.15)


def test_standard_error_of_few_samples():
    """Neighbours of opposite sign: no longer block varies more, so the samples themselves give the error."""
    series = np.tile([2.0, -1.0], 8)
    assert block_average(series)[1] == pytest.approx(np.std(series, ddof=1) / 4, rel=1e-12)


def test_no_standard_error_from_too_little():
    rng = np.random.default_rng(12)
    for drift in (rng.normal(size=7), rng.normal(size=12), np.linspace(0, 1, 64)):
        assert np.isnan(block_average(drift)[1])
    for constant in (np.ones((20, 3)), np.ones((8, 3))):
        assert block_average(constant)[1].tolist() == [0, 0, 0]
    assert np.isnan(block_average(np.array([1.0] * 20 + [np.nan]))).all()
