# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames for the player: what is unpacked is what was packed, within half a quantum."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import flow_context
from number_text import numbers_in

from lammps_jump.analysis.report import frames
from lammps_jump.analysis.report.frames import FramePacker, PackedFrames, encode
from lammps_jump.dump.frame import make_frame
from lammps_jump.scene.walls import Plane

BOX = [[0, 10], [0, 5]]


def unpack(packed: PackedFrames) -> list[dict[str, np.ndarray]]:
    """The discs of each frame: id, radius (m), x, y (m), u, v (m/s)."""
    header, number = packed.header, numbers_in(packed.text)
    q, qv, times, radii = (np.array(header[key]) for key in ("q", "qv", "times", "radii"))
    discs = np.cumsum([[number(32 * (4 + k)) for k in range(8)] for _ in range(header["discs"])], axis=0)
    unrest, found = [8] * len(discs), []
    now = discs[:, [0, 5, 3, 4, 6, 7]]  # id, radius, x, y, u, v
    for k in range(len(times)):
        here = (discs[:, 1] <= k) & (k < discs[:, 1] + discs[:, 2])
        for disc in np.flatnonzero(here & (discs[:, 1] < k)):
            felt, told = unrest[disc], []
            for column in range(4):
                told.append(number(32 * column + felt.bit_length()))
                felt += 2 * abs(told[-1]) if column < 2 else abs(told[-1]) // 2
            unrest[disc] = (felt - unrest[disc]) // 2
            before = now[disc, 4:].copy()
            now[disc, 4:] += told[:2]
            share = qv * (times[k] - times[k - 1]) / q / 2
            now[disc, 2:4] += np.floor((before + now[disc, 4:]) * share + 0.5).astype(int) + told[2:]
        ids, size, x, y, u, v = now[here].T
        found.append({"id": ids, "radius": radii[size], "x": x * q, "y": y * q, "u": u * qv, "v": v * qv})
    assert sum(len(discs["id"]) for discs in found) == header["rows"]
    if header["map"]:
        before = np.zeros(header["map"]["counts"].prod(), int)
        for frame in found:
            frame["map"] = before = before + [number(32 * 12 + int(level).bit_length()) for level in before]
    return found


def flow(diameter=0.2, **more):
    return flow_context(domain=((0, 10), (0, 5)), x_range=(0, 10), diameter=diameter, **more)


def packed(made, of=None):
    packer = FramePacker(of or flow())
    for time, columns in made:
        packer.add(make_frame(0, time, BOX, columns), time)
    return packer.result()


def columns(ids, x, y, vx, vy):
    return {"id": ids, "x": x, "y": y, "vx": vx, "vy": vy}


def agree(found, made, header):
    for discs, (_, wanted) in zip(found, made, strict=True):
        order = np.argsort(wanted["id"])
        assert np.array_equal(discs["id"], np.array(wanted["id"])[order])
        for name, key, quantum in (("x", "x", "q"), ("y", "y", "q"), ("u", "vx", "qv"), ("v", "vy", "qv")):
            wrong = np.abs(discs[name] - np.array(wanted[key], float)[order])
            assert (wrong <= (0.5 + 1e-6) * header[quantum]).all(), name


@st.composite
def histories(draw):
    """Discs that come, go, come back, jump and stand still, at uneven times."""
    made, time = [], draw(st.floats(-1, 1))
    place, speed = st.floats(-500, 500), st.floats(-30, 30)
    for _ in range(draw(st.integers(1, 6))):
        ids = draw(st.lists(st.integers(1, 9), unique=True, max_size=6))
        values = [draw(st.lists(kind, min_size=len(ids), max_size=len(ids))) for kind in (place, place, speed, speed)]
        made.append((time, columns(ids, *values)))
        time += draw(st.floats(1e-3, 2))
    return made


@given(histories())
def test_frames_come_back_within_half_a_quantum(made):
    result = packed(made)
    if result is None:
        assert not any(len(wanted["id"]) for _, wanted in made)
        return
    assert result.header["q"] == 0.2 / 64
    agree(unpack(result), made, result.header)


@given(
    st.lists(
        st.tuples(st.integers(1 - 2**31, 2**31 - 1) | st.integers(-3, 3), st.integers(0, 40)), min_size=1, max_size=300
    )
)
def test_numbers_come_back_from_text_that_a_page_may_hold(told):
    values, contexts = np.array(told, np.int64).reshape(-1, 2).T
    text = encode((values, contexts))
    assert not set(text) & set("\0\n\r<") and text.isascii()
    number = numbers_in(text)
    assert [number(context) for _, context in told] == values.tolist()


def test_numbers_of_the_least_odds_have_room():
    """Six times all bits at their least odds, each time learned anew."""
    often, worst = [0] * 300 + [2**31 - 1] * 300, [2**31 - 1, 0, 1, 3, 7, 15]
    for rare in worst:
        values = np.array([*often, rare, *([0] * 300), rare] * 6)
        text = encode((values, 0 * values))
        number = numbers_in(text)
        assert [number(0) for _ in values] == values.tolist()
        assert len(text) <= 1.2 * (np.frexp(values)[1] + 1).sum()


def test_digits_of_the_text_carry():
    """A low end that grows over 124^4 changes digits before it, over several of the highest letter."""
    values = np.random.default_rng(5).integers(-(2**20), 2**20, 30_000)
    text = encode((values, 0 * values))
    number = numbers_in(text)
    assert [number(0) for _ in values] == values.tolist()
    assert len(text) < 30_000 * 22.5 / 6.95


def test_steady_flow_takes_few_bytes():
    x, fall, still = np.linspace(0, 10, 1000), np.linspace(0, 1, 1000), np.zeros(1000)
    made = [(0.1 * k, columns(np.arange(1000), x + 0.3 * k, 9 - 0.1 * k * fall, still + 3, -fall)) for k in range(20)]
    assert len(packed(made).text) < 0.5 * 20_000


def test_a_disc_that_comes_back_or_leaps_is_another_disc():
    ids, still = [7], [0.0]
    made = [(0.0, columns(ids, [1.0], still, still, still)), (1.0, columns([], [], [], [], []))]
    made += [(2.0, columns(ids, [1.0], still, still, still)), (3.0, columns(ids, [900.0], still, still, still))]
    result = packed(made)
    assert (result.header["discs"], result.header["rows"]) == (3, 3)
    agree(unpack(result), made, result.header)


def test_each_disc_has_its_last_radius():
    sizes = np.linspace(0.08, 0.12, 600)
    ids = np.arange(1, 601)
    still = np.zeros(600)
    whole = columns(ids, np.linspace(0, 10, 600), still, still, still)
    made = [(0.0, whole | {"radius": np.full(600, 0.12)}), (0.1, whole | {"radius": sizes})]
    result = packed(made, flow(sized=True))
    assert len(result.header["radii"]) == 256
    assert np.allclose(unpack(result)[0]["radius"], sizes, rtol=0, atol=0.04 / 255 / 2 + 1e-7)


def test_long_runs_keep_every_second_frame(monkeypatch):
    monkeypatch.setattr(frames, "MOST_FRAMES", 8)
    made = [(float(k), columns([1], [k / 10], [0], [0], [0])) for k in range(21)]
    times = packed(made).header["times"]
    assert list(times) == [0.0, 4.0, 8.0, 12.0, 16.0, 20.0]


@pytest.mark.parametrize("limit", ["MOST_DISCS", "MOST_ROWS"])
def test_many_discs_are_thinned_to_the_same_ones_in_every_frame(monkeypatch, limit):
    monkeypatch.setattr(frames, limit, 300)
    many, still = np.arange(1, 1001), np.zeros(1000)
    made = [(float(k), columns(many[: 200 + 400 * k], *[still[: 200 + 400 * k]] * 4)) for k in range(3)]
    result = packed(made)
    found = unpack(result)
    kept = [set(discs["id"]) for discs in found]
    assert kept[0] <= kept[1] <= kept[2] and 0 < len(kept[2]) <= 300
    assert len(kept[2]) / 1000 == pytest.approx(result.header["share"], rel=0.1)
    assert sum(map(len, kept)) > 0.8 * 300
    assert kept[1] == {disc for disc in kept[2] if disc <= 600}


def values(frame, header):
    """The map of a frame in its unit, shape (rows, columns)."""
    about = header["map"]
    return about["unit"] * frame["map"].astype(float).reshape(about["counts"][::-1]) ** about["power"]


STIFF = 1e6


def test_pressure_of_two_discs_pressed_together():
    """Overlap 0.002 m: 2 kN over 0.198 m between the centres, in one cell of 0.77 x 0.71 m; and later apart."""
    still = np.zeros(2)
    made = [
        (0.0, columns([1, 2], np.array([4.9, 5.098]), still + 2.5, still, still)),
        (0.1, columns([1, 2], np.array([4.9, 5.2]), still + 2.5, still, still)),
    ]
    result = packed(made, flow(stiffness=STIFF))
    assert result.header["map"]["name"] == "pressure"
    pressed, apart = (values(frame, result.header) for frame in unpack(result))
    by_hand = STIFF * 0.002 * 0.198 / 2 / (10 / 13 * 5 / 7)
    assert not apart.any() and np.count_nonzero(pressed) == 1
    step = result.header["map"]["unit"] ** 0.5
    assert abs(pressed[3, 6] ** 0.5 - by_hand**0.5) <= 0.5 * step


def test_pressure_under_stacks_is_that_of_their_weight():
    """A stack pushes along y alone: the mean of both normal stresses is half of the weight above, in whole steps."""
    count, d, weight = 16, 0.25, 40 * 9.81
    load = np.arange(count, 0, -1) * weight / STIFF
    y = np.cumsum(np.r_[-load[0], d - load[1:]])  # four contacts in a cell of 1 m, at its eighths
    x = (np.arange(40) + 0.5) * d * (1 + 1e-6)  # a hair apart
    still = np.zeros(x.size * count)
    made = [(0.0, columns(np.arange(still.size), np.repeat(x, count), np.tile(y, x.size), still, still))]
    result = packed(made, flow(d, stiffness=STIFF, walls=(Plane("floor", "y", -d / 2, "above"),)))
    found = values(unpack(result)[0], result.header)
    wanted = weight / d / 2 * np.array([13.5, 9.5, 5.5, 1.5, 0])  # discs above the middle of a cell
    step = result.header["map"]["unit"] ** 0.5
    assert found.shape == (5, 10) and (abs(found.T**0.5 - wanted**0.5) <= 0.51 * step).all()


def test_no_stiffness_no_pressure():
    made = [(0.0, columns([1], [1.0], [1.0], [0.0], [0.0]))]
    assert packed(made).header["map"] is None


def test_many_discs_have_a_map_of_the_area_that_they_cover(monkeypatch):
    monkeypatch.setattr(frames, "MANY", 300)
    monkeypatch.setattr(frames, "MOST_DISCS", 100)
    dense = np.meshgrid(np.arange(0.1, 5, 0.2), np.arange(0.1, 4, 0.2))
    x, y = (np.append(side.ravel(), [9.0]) for side in dense)
    still = np.zeros(x.size)
    whole = np.arange(x.size), x, y, still, still
    made = [(float(k), columns(*(part[: 100 + 500 * k] for part in whole))) for k in range(2)]
    result = packed(made, flow(stiffness=STIFF))
    assert result.header["map"]["name"] == "packing" and result.header["share"] < 0.25
    early, late = (values(frame, result.header) for frame in unpack(result))
    cell = 10 / 13 * 5 / 7
    for found, (_, wanted) in zip((early, late), made, strict=True):
        assert abs(found.sum() * cell - np.pi * 0.01 * len(wanted["id"])) < found.size * cell / 64
    assert late[1:5, 1:6].mean() == pytest.approx(np.pi / 4, rel=0.05) and early[-1].max() == 0


@pytest.mark.long
def test_two_hundred_thousand_discs():
    rng = np.random.default_rng(2)
    still, ids = np.zeros(200_000), np.arange(200_000)
    made = [(float(k), columns(ids, *rng.uniform(0, 5, (2, 200_000)), still, still)) for k in range(3)]
    result = packed(made, flow(diameter=0.01, stiffness=STIFF))
    assert result.header["map"]["name"] == "packing" and 10_000 < result.header["rows"] / 3 <= 25_000
    covered = values(unpack(result)[2], result.header)
    assert covered[:, :100].mean() == pytest.approx(np.pi / 4 * 0.01**2 * 200_000 / 25, abs=1 / 64)


def test_no_disc_no_frames():
    assert packed([(0.0, columns([], [], [], [], []))]) is None
    assert packed([]) is None
