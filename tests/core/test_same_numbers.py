# SPDX-License-Identifier: GPL-2.0-or-later
"""The analysis has one plain path for machines without the core: the same numbers, to rounding where sums are ordered
otherwise, else to the last bit.
"""

from math import nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import coreless

from lammps_jump.analysis import fields
from lammps_jump.analysis.contacts import close_pairs
from lammps_jump.analysis.draw.painter import View, blank, paint_discs
from lammps_jump.analysis.grains.layers import add_discs
from lammps_jump.analysis.profiles import FrameDiscs, OpenEnds, bin_discs, connected, surface_of
from lammps_jump.analysis.report.frames import encode
from lammps_jump.analysis.report.handed_on import holds_frames
from lammps_jump.dump import formats

pytestmark = pytest.mark.usefixtures("compiled_core")
seeds, counts = st.integers(0, 2**31), st.integers(0, 60)


def both(function, *arguments):
    """What a function gives with the core and without it."""
    found = function(*arguments)
    with coreless():
        return found, function(*arguments)


def discs_of(seed, count):
    """Discs of 3 sizes in and beside a stretch from 0 to 5 m."""
    draw = np.random.default_rng(seed)
    x, y = draw.uniform(-1, 6, count), draw.uniform(0.0, 2, count)
    u, v = draw.normal(size=(2, count))
    radius = draw.choice([0.05, 0.1, 0.3], count)
    return FrameDiscs.of(x, y, u, v, radius, radius**2)


@given(seeds, counts, st.sampled_from([0.05, 0.5, 3.0]))
def test_sums_of_bins(seed, count, width):
    bins = int(5 / width)
    one, two = both(bin_discs, discs_of(seed, count), 0.0, width, bins)
    np.testing.assert_allclose(one[0], two[0], rtol=1e-12, atol=1e-13)  # shares are differences of order one
    np.testing.assert_allclose(one[1], two[1], rtol=1e-12, atol=1e-13)


@given(seeds, counts, st.sampled_from([0.05, 0.5, 3.0]), st.sampled_from([nan, 0.0, 5.0]))
def test_sums_of_bins_over_the_ways_of_discs(seed, count, width, inlet):
    draw, discs = np.random.default_rng(seed), discs_of(seed, count)
    half = np.where(draw.random(count) < 0.3, 0.0, draw.uniform(0.0, 0.4, count))
    ways = OpenEnds(0.0, 5.0, inlet).ways(discs.x, half)
    one, two = both(bin_discs, discs, 0.0, width, int(5 / width), ways)
    np.testing.assert_allclose(one[0], two[0], rtol=1e-11, atol=1e-12)  # shares are differences of order one
    np.testing.assert_allclose(one[1], two[1], rtol=1e-11, atol=1e-12)
    assert one[0][0].sum() + one[1].sum() == pytest.approx(discs.mass.sum(), rel=1e-12, abs=1e-13)


@given(seeds, counts)
def test_surface(seed, count):
    discs, bed, lines = discs_of(seed, count), np.zeros(count), np.where(np.arange(200) < 190, 0.0, np.nan)
    bed[: count // 10] = np.nan
    joined, plain = both(connected, discs, bed, 0.6)
    np.testing.assert_array_equal(joined, plain)
    one, two = both(surface_of, discs, joined, lines, 0.0, 1.0, 5)
    np.testing.assert_array_equal(one, two)
    assert np.isnan(one[0][-1]) and not np.isnan(one[0][:-1]).any()


@given(seeds, counts, st.sampled_from([0.1, 1.0, 1e6]))
def test_pairs(seed, count, width):
    x, y = np.random.default_rng(seed).uniform(-width, width, (2, count))
    x[: count // 4], y[: count // 4] = 0.0, 0.0  # at one place
    one, two = (sorted(map(sorted, np.transpose(found).tolist())) for found in both(close_pairs, x, y, 0.2))
    assert one == two


@given(seeds, counts)
def test_layers(seed, count):
    def sums():
        found = np.zeros((15, 8))
        add_discs(discs_of(seed, count), np.array([0.5, 4.0, 0.0, 0.25]), found)
        return found

    one, two = both(sums)
    np.testing.assert_allclose(one, two, rtol=1e-11, atol=1e-13)


@given(seeds, counts)
def test_fields(seed, count):
    draw = np.random.default_rng(seed)
    where, weights, open_ = draw.uniform(-1, 2.5, (count, 2)), draw.normal(size=(count, 2)), draw.random((12, 15))

    def sums():
        found = np.zeros((2, 12, 15))
        fields.spread(where, weights, np.where(open_ > 0.3, open_, 0.0), (0.0, 0.0, 0.1, 0.25), found)
        return found

    one, two = both(sums)
    np.testing.assert_allclose(one, two, rtol=1e-11, atol=1e-11)


@given(seeds, counts)
def test_pictures_have_the_same_bytes(seed, count):
    draw = np.random.default_rng(seed)
    x, y, radius = draw.uniform(-1, 3, count), draw.uniform(-1, 2, count), draw.choice([0.002, 0.05, 0.4], count)
    colours, view = draw.integers(0, 255, (count, 3)), View((0.0, 2.0), (0.0, 1.0), 60, 30)

    def picture():
        found = blank(view)
        paint_discs(found, view, x, y, radius, colours)
        return found

    np.testing.assert_array_equal(*both(picture))


@given(seeds, counts)
def test_packed_numbers_have_the_same_letters(seed, count):
    draw = np.random.default_rng(seed)
    numbers = draw.integers(-(2**31) + 1, 2**31, count) >> draw.integers(0, 31, count)
    one, two = both(encode, (numbers, draw.integers(0, 5, count)))
    assert one == two


@given(st.data())
def test_packed_frames_are_known_again(data):
    """Four discs in three frames with a map of two cells, right or with a letter changed."""
    life, frames = 3, 3
    table = np.zeros((4, 8), int)
    table[:, 2] = life
    parts = [(np.diff(table, axis=0, prepend=0), 32 * np.arange(4, 12))]
    # a disc that does not change feels half of what it felt before: contexts are lengths of 8, 0, 0
    still = np.zeros((2, 4, 4), int), 32 * np.arange(4) + np.array([4, 0])[:, None, None] * np.ones((1, 4, 1), int)
    parts += [still, (np.zeros((3, 2), int), 32 * 12)]
    text = encode(*parts)
    counts = 4, 12, frames, 1, 2
    assert both(holds_frames, text, *counts) == (True, True)
    place = data.draw(st.integers(0, len(text) - 1))
    other = text[:place] + data.draw(st.sampled_from("!aZ~")) + text[place + 1 :]
    one, two = both(holds_frames, other, *counts)
    assert one is two
    one, two = both(holds_frames, text[:place], *counts)
    assert one is two


NUMBERS = st.one_of(
    st.floats().map(repr), st.floats().map("{:.17g}".format), st.integers().map(str),
    st.sampled_from(["1e5", "-.5", "+2.", "nan", "C", "1_0", "1e", "--1", "1e-400", "123456789012345678901"]),
)  # fmt: skip


@given(st.lists(st.lists(NUMBERS, min_size=1, max_size=3), max_size=6), st.booleans(), st.integers(0, 12))
def test_rows_of_text(lines, item, cut):
    """Also rows that are short, long, no numbers, or cut off: both stop at the same place, or the plain one goes on."""
    text = "".join(" ".join(line) + "\n" for line in lines) + ("ITEM: TIMESTEP\n" if item else "")
    data = np.frombuffer(text[: len(text) - cut].encode(), np.uint8)

    def read():
        out = np.full((2, 5), -1.0)
        return out, formats.parse_rows(data, (0, len(data)), out, 0, np.array([False, False]))

    (one, reached), (two, plain) = both(read)
    np.testing.assert_array_equal(one[:, : reached[0]], two[:, : reached[0]])
    assert reached == plain or (reached[2] == formats.NOT_PLAIN and plain[0] >= reached[0])


@pytest.mark.parametrize(
    ("text", "status"),
    [
        ("1 2\n3 4\n", formats.ROWS_DONE),
        ("1 2\n3 4", formats.NEED_MORE),
        ("1 2\nITEM: X\n", formats.NEW_ITEM),
        ("1 2\nITEM", formats.NEW_ITEM),
        ("1 2\n3\n", formats.NOT_PLAIN),
    ],
)
def test_rows_stop_where_they_should(text, status):
    data = np.frombuffer(text.encode(), np.uint8)
    one, two = both(lambda: formats.parse_rows(data, (0, len(data)), np.zeros((2, 2)), 0, np.zeros(2, bool)))
    assert one == two and one[2] == status
    assert status == formats.NOT_PLAIN or formats.skip_rows(data, (0, len(data)), 0, 2) == one
