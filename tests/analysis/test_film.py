# SPDX-License-Identifier: GPL-2.0-or-later
"""Films and the painter behind them: true circles, the right pixels, files that decode."""

import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from free_bodies import body
from made_up import disc_frame, flow_context

from lammps_jump.analysis.draw import film, painter
from lammps_jump.analysis.draw.arrows import ForceArrows, entry, rounded
from lammps_jump.analysis.draw.film import animate, still
from lammps_jump.analysis.draw.painter import View, blank, coloured, paint_arrow, paint_discs, paint_walls
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import PoseFile, StretchForces
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import DumpError
from lammps_jump.scene.pressed import FaceStretch
from lammps_jump.scene.walls import Block, Box, Plane

CONTEXT = flow_context(
    domain=((0.0, 8.0), (0.0, 4.0)),
    x_range=(0.0, 8.0),
    walls=(Plane("floor", "y", 0.0, "above"), Block("sill", (6.0, 6.5), (0.0, 1.0))),
)


@pytest.fixture
def dump(tmp_path):
    path = tmp_path / "dump"
    with DumpWriter(path, ("id", "x", "y", "vx", "vy"), "binary") as writer:
        for step in range(12):
            n = 40 + step
            x, y = 0.3 + 0.1 * np.arange(n), 0.1 + 0.2 * (np.arange(n) % 9)
            columns = {"id": np.arange(n), "x": x, "y": y, "vx": 0 * x + step, "vy": 0 * x}
            writer.write_frame(make_frame(step, 0.1 * step, [[0, 8], [0, 4]], columns))
    return open_dump(path)


def test_a_disc_is_a_true_circle_of_its_size():
    view = View((0.0, 4.0), (0.0, 3.0), 400, 300)
    picture = blank(view)
    paint_discs(picture, view, np.array([2.0]), np.array([1.0]), 0.5, np.array([[0, 0, 0]]))
    ink = 1 - picture[..., 0] / 255
    # area pi R^2 in pixels; the linear rim makes it (R^2 + 1/12) pi, rounding to bytes 1/510 a rim pixel
    assert ink.sum() == pytest.approx(np.pi * (50**2 + 1 / 12), rel=1e-3)
    rows, columns = np.nonzero(ink > 0.5)
    assert (rows.mean() + 0.5, columns.mean() + 0.5) == (pytest.approx(200), pytest.approx(200))
    assert np.ptp(rows) == np.ptp(columns) == 99
    np.testing.assert_array_equal(picture, picture[:, ::-1][:, list(range(400))])  # mirror in x = 2


def test_discs_smaller_than_a_pixel_keep_their_ink_and_those_outside_none():
    view = View((0.0, 10.0), (0.0, 10.0), 50, 50)
    picture = blank(view)
    paint_discs(picture, view, np.array([5.0]), np.array([5.0]), 0.05, np.array([[0, 0, 0]]))
    ink = (1 - picture[..., 0] / 255).sum()
    assert 0.2 < ink / (np.pi * 0.25**2) < 1.6  # radius a quarter pixel: a grey dot, not a black one
    picture = blank(view)
    far = np.array([-5.0, 20.0, np.nan, 1e300])
    paint_discs(picture, view, far, np.array([5.0, 5.0, 5.0, -1e300]), 0.5, np.zeros((4, 3)))
    assert (picture == 255).all()


def test_walls_and_arrows():
    view = View((0.0, 4.0), (0.0, 4.0), 40, 40)
    picture = blank(view)
    paint_walls(picture, view, (Box("box", (1.0, 3.0), (1.0, 3.0)),))
    white = (picture == 255).all(axis=2)
    assert white.sum() == 20 * 20 and white[10:30, 10:30].all()
    picture = blank(view)
    paint_walls(picture, view, (Plane("top", "y", 3.0, "below"), Plane("left", "x", 1.0, "above")))
    assert (picture == 255).all(axis=2).sum() == 30 * 30
    picture = blank(view)
    paint_arrow(picture, (5, 20), (35, 20), 3.0, (255, 0, 0))
    red = (picture[..., 1] < 128) & (picture[..., 0] > 200)
    assert red[19:21, 6:33].all() and not red[:, 37:].any() and red[:, 24].sum() > red[:, 10].sum()
    gated = blank(view)
    paint_walls(gated, view, (), (Plane("gate", "x", 2.0, "below"),))
    closed = ~(gated == 255).all(axis=2)
    assert closed[:, 20:25].all() and closed.sum() == 5 * 40  # a bar, not half a plane
    untouched = blank(view)
    paint_arrow(untouched, (5, 20), (5, 20), 3.0, (255, 0, 0))
    assert (untouched == 255).all()


def test_colours_run_from_zero_to_the_top():
    table = painter.colour_table()
    assert table.shape == (256, 3)
    np.testing.assert_array_equal(coloured(np.array([0.0, 5.0, 99.0, np.nan]), 5.0), table[[0, 255, 255, 0]])
    # readable in grey: brightness rises all the way
    assert np.all(np.diff(table @ [0.299, 0.587, 0.114]) > -1)


def decoded(path):
    """ffmpeg's description of a film, and its frames."""
    from imageio_ffmpeg import get_ffmpeg_exe

    command = [get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    text = done.stderr.decode()
    width, height = (int(v) for v in re.search(r"Video: .*?, (\d+)x(\d+)", text).groups())
    return text, np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)


def inside(frames):
    """Frames without the strip above, which tells time and scale."""
    return frames[:, film.ABOVE :]


def test_mp4_decodes_to_the_frames_of_the_dump(dump, tmp_path):
    seen = []
    forces = {
        "sill": ForceHistory(np.array([0.0, 1.1]), np.array([0.0, 5e4]), np.array([0.0, 1e4]), np.zeros(2)),
        "gone": ForceHistory(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0)),
    }
    out = animate(
        dump,
        CONTEXT,
        tmp_path / "a.mp4",
        fps=10,
        arrows=ForceArrows(CONTEXT, forces),
        progress=lambda done, total: seen.append((done, total)),
    )
    text, frames = decoded(out)
    assert "h264" in text and "yuv420p" in text and "10 fps" in text
    assert len(frames) == 12 and seen[-1] == (12, 12)
    height, width, _ = frames[0].shape
    assert height % 2 == 0 and width % 2 == 0 and width <= 1280
    # the first frame's discs rest (dark blue), the last one's move (yellow); the arrow grows red on the sill
    reddish = [((f[..., 0] > 150) & (f[..., 1] < 90) & (f[..., 2] < 110)).sum() for f in inside(frames)[[0, -1]]]
    assert reddish[0] == 0 and reddish[1] > 200


def test_a_body_is_filmed_where_it_is_with_the_arrow_of_its_force(dump, tmp_path):
    """A block of 1 m moves by 4 m above the discs; a force upwards pushes the middle of its underside."""
    (tmp_path / "walls.csv").write_text("time,wall,x,y,angle\n0,box,0,0,0\n1.1,box,4,0,0\n")
    scene = replace(CONTEXT.scene, walls=(*CONTEXT.scene.walls, body(Block("box", (0.5, 1.5), (2.2, 2.8)))))
    flow = replace(CONTEXT, scene=scene, poses=PoseFile(tmp_path / "walls.csv", scene.lids))
    forces = {"box": ForceHistory(np.array([0.0, 1.1]), np.zeros(2), np.full(2, 1e4), np.zeros(2))}
    _, frames = decoded(animate(dump, flow, tmp_path / "a.mp4", arrows=ForceArrows(flow, forces)))
    first, last = inside(frames)[[0, -1]].astype(int)
    red = [np.flatnonzero(((f[..., 0] > 150) & (f[..., 1:] < 110).all(axis=2)).any(axis=0)) for f in (first, last)]
    solid = [(np.abs(f - painter.SOLID) < 6).all(axis=2) for f in (first, last)]
    came = np.flatnonzero((solid[1] & ~solid[0]).sum(axis=0) > 20)
    width = np.ptp(came)
    assert width > 50 and red[1].mean() == pytest.approx(came.mean(), abs=3)  # pixels; colours are those of 2 by 2
    assert 4 * width <= red[1].mean() - red[0].mean() <= 4 * (width + 4)  # its edges are drawn 2 pixels wide


def test_gif_has_its_frames(dump, tmp_path):
    from PIL import Image

    out = animate(dump, CONTEXT, tmp_path / "a.gif", fps=20, width=400)
    with Image.open(out) as image:
        assert image.n_frames == 12 and image.info["duration"] == 50


def test_without_ffmpeg_a_gif_takes_the_place_of_an_mp4(dump, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "has_ffmpeg", lambda: False)
    out = animate(dump, CONTEXT, tmp_path / "a.mp4", width=400)
    assert out == tmp_path / "a.gif" and out.stat().st_size > 1000
    assert [path.name for path in tmp_path.glob("a.*")] == ["a.gif"]
    assert "lammps-jump[movie]" in film.NO_FFMPEG


def test_a_still_shows_walls_discs_and_a_gate(dump, tmp_path):
    from PIL import Image

    frame = next(iter(dump))
    out = still(frame, CONTEXT, tmp_path / "now.png", width=640)
    with Image.open(out) as image:
        picture = np.asarray(image)
    assert picture.shape[1] <= 640
    assert ((picture == painter.SOLID).all(axis=2)).sum() > 200
    assert not (tmp_path / "now.png.part").exists()


def test_what_cannot_be_filmed_is_an_error(dump, tmp_path):
    with pytest.raises(DumpError, match=r"\.mp4 or \.gif"):
        animate(dump, CONTEXT, tmp_path / "a.avi")
    with pytest.raises(DumpError, match="cannot be written"):
        animate(dump, CONTEXT, tmp_path / "no" / "a.mp4")
    with pytest.raises(DumpError, match="cannot be written"):
        animate(dump, CONTEXT, tmp_path / "no" / "a.gif")


def test_discs_have_their_own_size():
    view = View((0.0, 10.0), (0.0, 5.0), 500, 250)
    picture = blank(view)
    radii = np.array([0.5, 1.0, 2.0])
    paint_discs(picture, view, np.array([1.0, 3.0, 7.0]), np.full(3, 2.5), radii, np.zeros((3, 3)))
    ink = 1.0 - picture[..., 0] / 255.0
    for left, right, radius in ((0, 90, 25), (91, 220, 50), (230, 480, 100)):
        # the ink is the area, the rim a pixel wide
        assert ink[:, left:right].sum() == pytest.approx(np.pi * radius**2, rel=5e-3)
        assert np.flatnonzero(ink[:, left:right].max(axis=0) > 0.5).size == 2 * radius


def test_a_still_shows_the_radii_of_the_dump(tmp_path):
    from PIL import Image

    flow = replace(CONTEXT, sized=True)
    shown = {}
    for radius in (0.1, 0.4):
        columns = {"id": [1], "x": [5.0], "y": [1.0], "vx": [9.0], "vy": [0.0], "radius": [radius]}
        frame = make_frame(0, 0.0, [[0, 10], [0, 5]], columns)
        with Image.open(still(frame, flow, tmp_path / "a.png", width=1280)) as image:
            picture = np.asarray(image).astype(int)
        # the fastest disc has the top of the scale, which is yellow: red, no blue; the scale itself is on the right
        shown[radius] = ((picture[:, :1000, 0] > 200) & (picture[:, :1000, 2] < 120)).any(axis=0).sum()
    assert shown[0.4] / shown[0.1] == pytest.approx(4, rel=0.05)  # columns of pixels: the rim is one of a hundred


SQUARE = np.array([[2.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.0, 2.0]])


@pytest.mark.parametrize(
    ("force", "moment", "at"),
    [
        ((5.0, 0.0), -5.0 * 0.7, (2.0, 0.7)),  # from the left, 0.7 m above the point of the moment
        ((-5.0, 0.0), 5.0 * 0.7, (3.0, 0.7)),
        ((0.0, -4.0), -4.0 * 0.25, (2.25, 2.0)),  # from above, right of it
        ((3.0, -3.0), -3.0 * 1.5, (2.0, 1.5)),  # slanting, into the left face
        ((5.0, 0.0), -5.0 * 9.0, (2.0, 2.0)),  # passes above it: the corner next to the line
    ],
)
def test_a_resultant_stands_where_its_moment_is_that_of_the_record(force, moment, at):
    found = np.array(entry(SQUARE, (2.0, 0.0), force, moment))
    assert found[1] == pytest.approx(at[1]) and (found[0] == pytest.approx(at[0]) or at[1] == 2.0)
    if at != (2.0, 2.0):
        arm = found - (2.0, 0.0)
        assert arm[0] * force[1] - arm[1] * force[0] == pytest.approx(moment)


def test_the_force_of_still_water_stands_at_a_third_of_its_depth(tmp_path):
    """On a block, and on the same block that has come along and turned; a face that is pressed has its arrows."""
    wall = Block("sill", (6.0, 7.0), (0.0, 3.0))
    one = body(wall)
    stretch = FaceStretch("sill", 0.0, 0.5, (6.0, 0.25), (0.0, 1.0))
    scene = replace(CONTEXT.scene, walls=(one,), pressure=(stretch,))
    (tmp_path / "walls.csv").write_text(f"time,wall,x,y,angle\n0,sill,0,0,0\n1,sill,3,1,{np.pi / 2}\n")
    flow = replace(CONTEXT, scene=scene, poses=PoseFile(tmp_path / "walls.csv", scene.lids))
    force = 1e3 * 9.81 * 3.0**2 / 2
    time, moment = np.array([0.0, 1.0]), np.full(2, (one.motion.about[1] - 1.0) * force)
    history = ForceHistory(time, np.array([force, 0.0]), np.array([0.0, force]), moment)  # it turns with the block
    pressed = StretchForces(time, np.full((2, 1), 1e4), np.zeros((2, 1)), np.zeros((2, 1)))
    arrows = ForceArrows(flow, {"sill": history, "gone": history}, pressed)
    for now, tip, middle, way in ((0.0, (6, 1), (6, 0.25), (1, 0)), (1.0, (10, 2), (10.75, 2), (0, 1))):
        (whole,) = arrows.resultants(now, flow.standing_at(now), (0.0, 20.0), (0.0, 9.0))
        assert whole.tip == pytest.approx(tip) and whole.size == pytest.approx(force * np.array(way))
        (part,) = arrows.pressures(now, flow.standing_at(now))
        assert part.tip == pytest.approx(middle) and part.size == pytest.approx(2e4 * np.array(way), abs=1e-6)
    assert arrows.pressures(0.5, ()) == []


def test_the_scale_of_arrows_is_round_and_stands_in_the_picture():
    assert [rounded(value) for value in (1.0, 4.99, 7e4, 0.03)] == [1.0, 2.0, 5e4, pytest.approx(0.02)]
    history = ForceHistory(np.array([0.0, 1.1]), np.full(2, 5e4), np.zeros(2), np.zeros(2))
    arrows = ForceArrows(CONTEXT, {"sill": history})
    view = View.fitted((0.0, 10.0), (0.0, 3.0), 800)
    ((text, length, _),) = arrows.scales(view)
    assert text == "20 kN/m" and length == pytest.approx(20 / 50 * 10.0 / 9)  # the longest is a ninth of the width
    assert ForceArrows(CONTEXT, {}).scales(view) == []
    figure = film.snapshots([disc_frame([1.0], [0.5], box=[[0, 8], [0, 4]])], CONTEXT, arrows)
    assert "20 kN/m" in [text.get_text() for text in figure.texts]


def test_a_film_without_arrows_shows_none(dump, tmp_path):
    _, frames = decoded(animate(dump, CONTEXT, tmp_path / "a.mp4", width=400))
    red = (frames[..., 0] > 150) & (frames[..., 1] < 90) & (frames[..., 2] < 110)
    assert not red.any()
