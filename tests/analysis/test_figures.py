# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures: labelled, sized, drawn from the data, without touching matplotlib's global state."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from made_up import flow_context
from matplotlib._pylab_helpers import Gcf
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from lammps_jump.analysis.draw import depth_profile, film, painter, xt_map
from lammps_jump.analysis.draw import style as figures
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.analysis.report.page import picture, smaller
from lammps_jump.dump.frame import make_frame
from lammps_jump.errors import DumpError
from lammps_jump.scene.walls import Block

CONTEXT = flow_context(
    domain=((0.0, 20.0), (0.0, 5.0)),
    x_range=(0.0, 20.0),
    walls=(Block("floor", (-1, 15), (-1, 0)), Block("sill", (14, 15), (-1, 1))),
    bin_width=1.0,
)


def frames(n=12):
    x, y = (part.ravel() for part in np.meshgrid((np.arange(60) + 0.5) * 0.2, (np.arange(5) + 0.5) * 0.2))
    columns = {"id": np.arange(len(x)), "x": x, "y": y, "vx": 0 * x + 3.0, "vy": 0 * x + 4.0}
    return [make_frame(i, 0.5 * i, [[0, 20], [0, 5]], columns) for i in range(n)]


@pytest.fixture(scope="module")
def profiles():
    return compute_profiles(frames(), CONTEXT)


def texts(figure):
    figure.canvas.draw()
    return [t.get_text() for axes in figure.axes for t in (axes.xaxis.label, axes.yaxis.label, axes._left_title)]


def test_depth_profile(profiles, tmp_path):
    before = dict(mpl.rcParams)
    figure = figures.drawn(
        replace(
            depth_profile(profiles, CONTEXT, lines={"Bélanger": 4.2, "critical": 2.0}, marks={"toe": 5.0}),
            name="made-up",
        )
    )
    labels = " ".join(texts(figure))
    for word in ("[m]", "[m/s]", "Distance x", "made-up", "frames"):
        assert word in labels
    upper = figure.axes[0]
    surface = upper.lines[0].get_ydata()
    np.testing.assert_allclose(surface[:12], 1.0)
    levels = {round(float(line.get_ydata()[0]), 6) for line in upper.lines if len(set(line.get_ydata())) == 1}
    assert {4.2, 2.0} <= levels
    assert any("Bélanger" in text.get_text() for text in upper.texts)
    path = figures.save(figure, tmp_path / "depth.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    assert dict(mpl.rcParams) == before
    assert not Gcf.figs  # pyplot's list of open figures


def test_xt_map(profiles, tmp_path):
    figure = figures.drawn(xt_map(profiles, toe=(np.array([5.0, 6.0]), np.array([1.0, 2.0]))))
    assert "Time t [s]" in texts(figure) and any("Depth" in text for text in texts(figure))
    mesh = figure.axes[0].collections[0]
    np.testing.assert_allclose(mesh.get_array().reshape(12, 13)[:, :12], 1.0)  # and one bin without discs
    figures.save(figure, tmp_path / "xt.svg")
    one = compute_profiles(frames(1), CONTEXT)
    figures.save(figures.drawn(xt_map(one, "velocity")), tmp_path / "one.png")


@pytest.mark.parametrize("larger", [1, 2])
def test_a_painted_picture_fills_its_axes_pixel_for_pixel(larger):
    picture = np.random.default_rng(1).integers(0, 256, (40, 60, 3), np.uint8)
    figure = Figure(figsize=(1.0, 1.0), dpi=100 * larger)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.2, 0.3, 0.6, 0.4))
    axes.add_image(film.RasterImage(picture, axes, painter.View((0.0, 6.0), (0.0, 4.0), 60, 40)))
    axes.set_axis_off()
    figure.canvas.draw()
    drawn = np.asarray(figure.canvas.buffer_rgba())[30 * larger : 70 * larger, 20 * larger : 80 * larger, :3]
    assert np.array_equal(drawn, picture.repeat(larger, axis=0).repeat(larger, axis=1))


def test_what_the_page_shows_of_a_picture_is_the_same_from_memory_and_from_its_file(tmp_path):
    figure, seen = Figure(figsize=(3.0, 2.0)), []
    FigureCanvasAgg(figure)
    figure.figimage(np.random.default_rng(1).integers(0, 256, (300, 400, 3), np.uint8))
    path = figures.save(figure, tmp_path / "discs.png", seen.append)
    assert np.array_equal(np.asarray(seen[0]), np.asarray(Image.open(path)))
    shown = picture(path, "discs", smaller(seen[0]))
    assert shown == picture(path, "discs") and shown.source.startswith("data:image/webp;base64,")


def test_ten_snapshots(tmp_path):
    figure = film.snapshots(frames(21), CONTEXT)
    titles = [axes.texts[0].get_text() for axes in figure.axes if axes.images]
    assert len(titles) == 10 and titles[0].startswith("t = 0.00 s") and titles[-1].startswith("t = 10.00 s")
    picture = figure.axes[0].images[0].get_array()
    blue = (np.abs(picture.astype(int) - painter.colour_table()[-1]).sum(axis=2) < 30).mean()
    assert blue > 0.05  # all discs move at 5 m/s, the top of the scale
    figures.save(figure, tmp_path / "ten.png")
    assert len([axes for axes in film.snapshots(frames(3), CONTEXT).axes if axes.images]) == 3
    with pytest.raises(DumpError, match="no frame"):
        film.snapshots([], CONTEXT)


def test_empty_flow_can_be_drawn(tmp_path):
    empty = [
        make_frame(i, float(i), [[0, 20], [0, 5]], {c: [] for c in ("id", "x", "y", "vx", "vy")}) for i in range(3)
    ]
    profiles = compute_profiles(empty, CONTEXT)
    figures.save(figures.drawn(depth_profile(profiles, CONTEXT, lines={}, marks={})), tmp_path / "a.png")
    figures.save(figures.drawn(xt_map(profiles)), tmp_path / "b.png")
    figures.save(film.snapshots(empty, CONTEXT), tmp_path / "c.png")


def test_end_of_a_colour_scale():
    assert painter.top_of([np.full(1000, 18.2)]) == 20.0
    assert painter.top_of([np.full(1000, 0.31)]) == pytest.approx(0.35)
    assert painter.top_of([np.zeros(3)]) == 1.0 and painter.top_of([]) == 1.0
    assert painter.top_of([np.append(np.full(1000, 1.0), 500.0)]) == 1.0


def test_a_figure_that_cannot_be_written(profiles, tmp_path):
    figure = figures.drawn(xt_map(profiles))
    for name in ("no/a.png", "a.xyz"):
        with pytest.raises(DumpError, match="cannot be written"):
            figures.save(figure, tmp_path / name)


@pytest.mark.parametrize(
    ("pictures", "wide", "columns"), [(10, 12.0, 1), (10, 2.0, 2), (10, 1.0, 5), (3, 1.0, 3), (10, 0.1, 5)]
)
def test_pictures_do_not_overlap(pictures, wide, columns):
    """Places lie inside the figure, apart from each other, above the colour bar, and in the true proportion."""
    figure, found, width = film.layout(pictures, wide)
    places = [place.get_position(figure).bounds for place in found]
    across, high = figure.get_size_inches()
    assert found[0].get_gridspec().ncols == columns and across <= 9.6 + 1e-9
    for left, bottom, share, height in places:
        assert left > 0 and left + share < 1 and bottom + height < 1
        assert share * across == pytest.approx(width) and width / (height * high) == pytest.approx(wide)
        assert bottom * high > sum(film.BAR)
    for i, one in enumerate(places):
        for two in places[:i]:
            apart = [one[k] >= two[k] + two[k + 2] or two[k] >= one[k] + one[k + 2] for k in (0, 1)]
            assert any(apart)


def test_png_is_drawn_at_the_saved_resolution(tmp_path):
    """One drawing at savefig's dots per inch; the figure keeps its own."""
    from PIL import Image

    with figures.drawing(4.0, 3.0) as (figure, axes):
        axes.plot([0, 1])
    before = figure.get_dpi()
    with Image.open(figures.save(figure, tmp_path / "a.png")) as picture:
        assert picture.size == (520, 390) and picture.mode == "RGB"
        assert np.asarray(picture).min() < 100 and picture.info["dpi"][0] == pytest.approx(130, abs=0.1)
    assert figure.get_dpi() == before


def test_a_map_shows_where_discs_were(profiles):
    """Bins that never held a disc are left out, but for one to either side."""
    bins = profiles.sizes["x"]
    assert bins > 8
    lone = profiles.copy()
    lone["mass_depth"] = profiles["mass_depth"] * 0.0 + np.where(np.isin(np.arange(bins), (3, 5)), 0.1, 0.0)
    shown = xt_map(lone)
    assert shown.values.shape[1] == 5 and len(shown.x) == 6
    assert np.array_equal(shown.values, lone["surface_depth"].values[:, 2:7])
    assert xt_map(lone.assign(mass_depth=0.0 * lone["mass_depth"])).values.shape[1] == bins  # none at all
