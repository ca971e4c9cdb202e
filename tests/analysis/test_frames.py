# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames for the player: what is unpacked is what was packed, within half a quantum."""

import base64
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import flow_context

from lammps_jump.analysis.report import frames
from lammps_jump.analysis.report.frames import FramePacker, Packed
from lammps_jump.dump.frame import make_frame

BOX = [[0, 10], [0, 5]]


def unpack(packed: Packed) -> list[dict[str, np.ndarray]]:
    """The discs of each frame: id, radius (m), x, y (m), u, v (m/s)."""
    header = packed.header
    data, at = zlib.decompress(base64.b64decode(packed.text), -15), 0
    discs, rows, q, qv = (header[key] for key in ("discs", "rows", "q", "qv"))
    times, radii = np.array(header["times"]), np.array(header["radii"])

    def take(kind: str, count: int) -> np.ndarray:
        nonlocal at
        found = np.frombuffer(data, kind, count, at).astype(np.int64)
        at += found.size * np.dtype(kind).itemsize
        return found

    ids = np.cumsum(take("<u4", discs))
    first, count = take("<u2", discs), take("<u2", discs)
    place = [take("<i4", discs), take("<i4", discs)]
    radius = radii[take("u1", discs)] if len(radii) > 1 else np.full(discs, radii[0])
    zigzag = [take("u1", rows - discs) + 256 * take("u1", rows - discs) for _ in "xy"]
    residual = [np.where(z % 2, -(z + 1) // 2, z // 2) for z in zigzag]
    change = [take("u1", rows), take("u1", rows)]
    assert at == len(data)
    speed, found, row, late = [np.zeros(discs, np.int64), np.zeros(discs, np.int64)], [], 0, 0
    for k in range(len(times)):
        here = (first <= k) & (k < first + count)
        went_on = here & (first < k)
        there, moved = slice(row, row + here.sum()), slice(late, late + went_on.sum())
        for axis in (0, 1):
            before = np.where(went_on, speed[axis], 0)
            speed[axis][here] = (before[here] + change[axis][there] + 128) % 256 - 128
            share = qv * (times[k] - times[k - 1]) / q / 2
            place[axis] = place[axis].copy()
            step = np.floor((before + speed[axis])[went_on] * share + 0.5).astype(np.int64)
            place[axis][went_on] += residual[axis][moved] + step
        row, late = there.stop, moved.stop
        values = (ids, radius, place[0] * q, place[1] * q, speed[0] * qv, speed[1] * qv)
        found.append(dict(zip(("id", "radius", "x", "y", "u", "v"), (value[here] for value in values), strict=True)))
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
    assert result.header["q"] == 0.2 / 128
    agree(unpack(result), made, result.header)


def test_steady_flow_takes_few_bytes():
    x = np.linspace(0, 10, 1000)
    made = [(0.1 * k, columns(np.arange(1000), x + 0.3 * k, np.ones(1000), np.full(1000, 3), x)) for k in range(20)]
    assert len(packed(made).text) * 3 / 4 < 0.5 * 20_000


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


def test_no_disc_no_frames():
    assert packed([(0.0, columns([], [], [], [], []))]) is None
    assert packed([]) is None
