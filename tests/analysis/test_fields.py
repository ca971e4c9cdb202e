# SPDX-License-Identifier: GPL-2.0-or-later
"""Coarse-grained fields: conservation, hydrostatics of a column with known overlaps, contacts in closed form."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import disc_frame, examples, flow_context

from lammps_jump.analysis import fields as module
from lammps_jump.analysis.contacts import Touching, find_contacts, normal_forces
from lammps_jump.analysis.fields import compute_fields, mean_fields
from lammps_jump.errors import DumpError
from lammps_jump.scene.walls import Block, Box, Plane

D, M, K, G = 0.2, 40.0, 2.56e7, 9.81
BOX = [[0, 10], [0, 10]]
HERE = {"x": (0.0, 4.0), "y": (0.0, 4.0)}


context = partial(
    flow_context, domain=((0.0, 4.0), (0.0, 6.0)), x_range=(0.0, 4.0), walls=(Box("box", (0.0, 4.0), (0.0, 6.0)),),
    stiffness=K, stiffness_wall=K,
)  # fmt: skip


def frame(x, y, u=0.0, v=0.0, time=0.0):
    return disc_frame(x, y, u, v, box=BOX, time=time)


points = st.lists(st.tuples(st.floats(0.01, 3.99), st.floats(0.01, 5.5)), min_size=1, max_size=40)


@examples(10)
@given(
    points=points,
    spacing=st.sampled_from([0.1, 0.2, 0.5]),  # 0.05 m takes four times as long as 0.1 m, in the same lines
    reach=st.floats(0.05, 1.5),
    seed=st.integers(0, 1000),
)
def test_mass_and_momentum_are_conserved_at_walls(points, spacing, reach, seed):
    x, y = np.array(points).T
    u, v = np.random.default_rng(seed).normal(size=(2, len(x)))
    c = context(walls=(Box("box", (0.0, 4.0), (0.0, 6.0)), Block("sill", (2.0, 2.5), (0.0, 1.0))), stiffness=None)
    fields = compute_fields(frame(x, y, u, v), c, x=(0.0, 4.0), y=(0.0, 6.0), spacing=spacing, reach=reach)
    area = spacing**2
    # a disc inside the sill without an open cell in reach stays in its own, closed cell: taken out of the count
    counted = ~((np.abs(x - 2.25) < 0.26) & (y < 1.01))
    mass = np.nansum(fields.density) * area
    if counted.all():
        assert mass == pytest.approx(M * len(x), rel=1e-12)  # round-off of a normalised sum
        momentum = np.nansum((fields.density * fields.velocity_x).values) * area
        assert momentum == pytest.approx(M * u.sum(), rel=1e-9, abs=1e-9 * M * len(x))
    else:
        assert mass <= M * len(x) * (1 + 1e-12)
    assert np.isnan(fields.density.sel(x=2.25, y=0.5, method="nearest"))


def test_uniform_flow_has_its_density_and_speed_and_no_kinetic_stress():
    x, y = (part.ravel() for part in np.meshgrid((np.arange(20) + 0.5) * D, (np.arange(20) + 0.5) * D))
    fields = compute_fields(frame(x, y, u=3.0, v=-1.0), context(), **HERE, reach=0.6)
    inner = fields.sel(x=slice(0.7, 3.3), y=slice(0.7, 3.3))
    # a lattice under a smooth kernel three diameters wide: ripple below 1 %
    np.testing.assert_allclose(inner.density, 1000.0, rtol=0.01)
    np.testing.assert_allclose(inner.velocity_x, 3.0, rtol=1e-12)
    np.testing.assert_allclose(inner.velocity_y, -1.0, rtol=1e-12)
    # round-off of rho v^2 = 9000
    np.testing.assert_allclose(inner.kinetic_xx, 0.0, atol=1e-9)


def test_kinetic_stress_of_two_streams_is_density_times_variance():
    x, y = (part.ravel() for part in np.meshgrid((np.arange(40) + 0.5) * D / 2, (np.arange(40) + 0.5) * D / 2))
    u = np.where((np.arange(len(x)) + np.arange(len(x)) // 40) % 2 == 0, 2.0, -2.0)
    fields = compute_fields(frame(x, y, u=u), context(), **HERE, reach=1.0)
    inner = fields.sel(x=slice(1.2, 2.8), y=slice(1.2, 2.8))
    np.testing.assert_allclose(inner.kinetic_xx / inner.density, 4.0, rtol=0.01)


def columns(n=25, stacks=20):
    """Stacks in equilibrium under their weight: overlap of contact i with i discs above is i m g / k."""
    load = np.arange(n, 0, -1) * M * G / K  # under disc 0: n discs
    y = np.cumsum(np.r_[D / 2 - load[0], D - load[1:]])
    x = (np.arange(stacks) + 0.5) * D
    return np.repeat(x, n), np.tile(y, stacks)


def test_bed_pressure_of_resting_columns_is_hydrostatic():
    x, y = columns()
    # stacks must not touch sideways: discs a hair apart
    c = context(diameter=D, walls=(Plane("floor", "y", 0.0, "above"),))
    x = x * (1 + 1e-6)
    found = find_contacts(frame(x, y), c)
    assert found.force[found.is_wall].sum() == pytest.approx(500 * M * G, rel=1e-9)
    fields = compute_fields(frame(x, y), c, x=(0.0, 4.0), y=(0.0, 5.0), reach=0.4)
    interior = fields.sel(x=slice(0.5, 3.5))
    weight_above = (25 - interior.y / D) * M * G / D
    mean = interior.contact_yy.mean("x")
    middle = slice(0.5, 4.3)
    # the load falls by one weight a contact; a smooth kernel makes it linear, to the height d/2 of a branch's middle
    np.testing.assert_allclose(mean.sel(y=middle), weight_above.sel(y=middle), atol=0.6 * M * G / D)
    np.testing.assert_allclose(mean.sel(y=middle), interior.hydrostatic.mean("x").sel(y=middle), atol=0.6 * M * G / D)
    # at the bed the one-sided kernel looks up by a third of its reach: 0.15 m of 5 m
    assert float(mean[0]) == pytest.approx(25 * M * G / D, rel=0.04)
    assert float(interior.density.mean("x")[0]) == pytest.approx(1000.0, rel=0.04)
    np.testing.assert_allclose(interior.contact_xx, 0.0, atol=1e-6 * 25 * M * G / D)
    # the integral of the stress is the sum of force times branch, exactly
    branch = np.hypot(*(found.start - found.end).T)
    # at x = 0 and 4 kernels reach out of the grid: a wider grid holds all
    whole = compute_fields(frame(x, y), c, x=(-1.0, 5.0), y=(-0.5, 5.5), reach=0.4)
    assert np.nansum(whole.contact_yy) * 0.01 == pytest.approx(float((found.force * branch).sum()), rel=1e-12)


def test_contacts_of_a_pair_and_a_wall_with_dashpots():
    c = context(dashpot=100.0, dashpot_wall=50.0, walls=(Plane("left", "x", 0.0, "above"),))
    found = find_contacts(frame([0.09, 0.28], [1.0, 1.0], u=np.array([-2.0, -5.0])), c)
    np.testing.assert_allclose(found.overlap, [0.01, 0.01], rtol=1e-9)
    # the pair closes at 3 m/s, the wall contact at 2 m/s
    order = np.argsort(found.is_wall)
    np.testing.assert_allclose(found.force[order], [K * 0.01 + 300, K * 0.01 + 100], rtol=1e-9)
    assert list(found.is_wall[order]) == [False, True]
    np.testing.assert_allclose(found.normal[order][1], [1, 0])
    np.testing.assert_allclose(found.end[order][1], [0, 1], atol=1e-15)
    elastic = find_contacts(frame([0.09, 0.28], [1.0, 1.0], u=np.array([-2.0, -5.0])), c, damping=False)
    np.testing.assert_allclose(elastic.force, K * 0.01, rtol=1e-9)
    with pytest.raises(DumpError, match="stiffness"):
        find_contacts(frame([1.0], [1.0]), context(stiffness=None))


def test_smooth_touch_is_the_derivative_of_its_potential():
    delta = np.linspace(0, 0.02, 2001)
    rest = np.zeros_like(delta)
    contacts = Touching(*[rest] * len(Touching._fields))._replace(overlap=delta)
    force = normal_forces(context(touch="smooth", touch_width=0.005), contacts, rest)
    assert force[0] == 0 and np.all(np.diff(force) > 0)
    np.testing.assert_allclose(force[delta >= 0.005], K * (delta[delta >= 0.005] - 0.0025), rtol=1e-12)
    np.testing.assert_allclose(force[delta < 0.005], K * delta[delta < 0.005] ** 2 / 0.01, rtol=1e-12)
    np.testing.assert_array_equal(normal_forces(context(), contacts, rest), K * delta)


def test_the_balance_keeps_a_uniform_fluid_uniform_up_to_a_wall():
    """a(r) sum W a = 1 everywhere beside a wall with a corner: then a uniform density is reproduced."""
    open_ = np.ones((40, 40), bool)
    open_[:10] = False
    open_[:20, :15] = False
    table = module._kernel_table(0.1, 0.4)
    a = module.balance(open_, table, module.BALANCING_ROUNDS)
    k = table.shape[0] // 2
    padded = np.pad(a, k, constant_values=1.0)
    smoothed = sum(table[i, j] * padded[i : i + 40, j : j + 40] for i in range(2 * k + 1) for j in range(2 * k + 1))
    away = np.zeros_like(open_)
    away[:-6, :-6] = True  # off the grid counts as open, and the wall ends there
    np.testing.assert_allclose((a * smoothed)[open_ & away], 1.0, atol=2e-3)


def test_an_empty_frame_and_one_disc():
    empty = compute_fields(frame([], []), context(), **HERE)
    assert float(empty.density.sum()) == 0 and np.isnan(empty.velocity_x).all()
    one = compute_fields(frame([2.0], [2.0], u=1.5), context(), **HERE)
    assert float(one.density.sum()) * 0.01 == pytest.approx(M, rel=1e-12)
    assert float(one.velocity_x.max()) == pytest.approx(1.5, rel=1e-12)


def test_mean_of_frames():
    x, y = columns()
    frames = [frame(x, y, u=1.0), frame(x, y, u=3.0)]
    options = {"x": (0.0, 4.0), "y": (0.0, 5.0)}
    mean, one = mean_fields(frames, context(), **options), compute_fields(frames[0], context(), **options)
    np.testing.assert_allclose(mean.contact_yy, one.contact_yy, rtol=1e-12)
    np.testing.assert_allclose(mean.velocity_x.values[np.isfinite(mean.velocity_x.values)], 2.0, rtol=1e-12)
    assert mean.attrs["frames"] == 2
    with pytest.raises(DumpError, match="no frame"):
        mean_fields([], context(), **options)


def test_pressure_at_the_bed_and_its_figures(tmp_path):
    from lammps_jump.analysis.draw import maps as field_figures
    from lammps_jump.analysis.draw import style as figures

    x, y = columns()
    c = context(walls=(Plane("floor", "y", 0.0, "above"),))
    fields = compute_fields(frame(x * (1 + 1e-6), y), c, x=(0.0, 4.0), y=(-0.4, 5.0))
    pressure = field_figures.bed_pressure(fields).sel(x=slice(0.5, 3.5))
    # the first open cell stands 0.05 m above the floor, under 24.75 discs; the kernel blurs it by half a disc
    np.testing.assert_allclose(pressure.hydrostatic, 24.75 * M * G / D, rtol=0.03)
    assert float(pressure.stress.mean()) == pytest.approx(25 * M * G / D, rel=0.04)
    box = field_figures.field_map(fields, context())
    assert [line.x.tolist() for line in box.lines] == [[0.0, 4.0, 4.0, 0.0, 0.0]]  # walls around discs are outlined
    for shown in (box, field_figures.field_map(fields, c), field_figures.bed_pressure_chart(fields)):
        figure = figures.drawn(shown)
        labels = [axes.get_xlabel() for axes in figure.axes] + [axes.get_ylabel() for axes in figure.axes]
        assert any("[m]" in label for label in labels) and any("[kPa]" in label for label in labels)
        figures.save(figure, tmp_path / "field.png")


def test_what_cannot_be_computed_is_an_error():
    for bad, message in (({"reach": 0.0}, "reach"), ({"spacing": 0.0}, "spacing"), ({"spacing": 1e-5}, "too fine")):
        with pytest.raises(DumpError, match=message):
            compute_fields(frame([1.0], [1.0]), context(), **HERE, **bad)


def test_weights_of_cells_are_those_of_a_plain_loop():
    rng = np.random.default_rng(8)
    open_ = rng.random((12, 15)) > 0.3
    table = module._kernel_table(0.1, 0.25)
    weight, (rows, columns), k = np.where(open_, 1.0, 0.0), open_.shape, len(table) // 2
    for _ in range(3):
        beyond = np.pad(weight, k, constant_values=1.0)
        total = sum(w * beyond[i : i + rows, j : j + columns] for (i, j), w in np.ndenumerate(table))
        weight = np.where(open_, np.sqrt(weight / total), 0.0)
    np.testing.assert_allclose(module.balance(open_, table, 3), weight, rtol=1e-12)
