# SPDX-License-Identifier: GPL-2.0-or-later
"""Beds at a chosen packing: what is reached over sizes and packings, what is refused, what the cache keeps."""

from __future__ import annotations

import numpy as np
import pytest

from lammps_jump.case import beds, discs, parse_case
from lammps_jump.case.packing import deepest_overlap
from lammps_jump.errors import CaseError
from lammps_jump.sweeps.members import started

CASE = """\
discs: {diameter: 0.1, density: 2500}
contact: {restitution: 0.5, impact_speed: 6}
walls: [{name: floor, kind: plane, axis: y, at: -1, side: above}]
initial: [{kind: packed_bed, x: [-2, 0], y: [-1, 0.5], packing: 0.6}]
run: {duration: 1}
"""
SIZES = {
    "equal": "null",
    "uniform": "{kind: uniform, spread: 0.3}",
    "two": "{kind: bidisperse, spread: 0.2}",
    "sieve": "{kind: sieve, passing: [[0.05, 0], [0.1, 0.5], [0.16, 1]]}",
}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A cache of its own, and nothing that this process still knows."""
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "cache"))
    beds._kept.cache_clear()
    yield tmp_path / "cache" / "beds"
    beds._kept.cache_clear()


def bed(*changes):
    return parse_case(CASE, "bed.yaml", changes)


RANGE = [(sizes, packing) for sizes in SIZES for packing in (0.15, 0.6, 0.8)]
CHEAP = ("equal", 0.15), ("sieve", 0.6), ("uniform", 0.8)


@pytest.mark.parametrize(
    ("sizes", "packing"), [one if one in CHEAP else pytest.param(*one, marks=pytest.mark.long) for one in RANGE]
)
def test_packing_is_reached_within_half_a_disc_without_overlaps(sizes, packing):
    case = bed(f"discs.sizes={SIZES[sizes]}", f"initial.0.packing={packing}")
    scene = case.scene()
    diameters = scene.diameters(np.arange(1, len(scene.positions) + 1))
    area = np.pi / 4 * np.sum(diameters**2)
    assert abs(area / 3.0 - packing) <= 0.5 * np.pi / 4 * scene.largest**2 / 3.0
    overlap = deepest_overlap(scene.positions, diameters)
    assert overlap is None or overlap[0] <= beds.TOUCHING * diameters[list(overlap[1:])].min() * (1 + 1e-9)
    out = np.abs(scene.positions - [-1, -0.25]) + 0.5 * diameters[:, None] - [1, 0.75]
    assert out.max() <= beds.TOUCHING * scene.smallest * (scene.largest / scene.smallest)
    numbers = case.check().numbers
    assert numbers["packing_0_asked"] == packing
    assert numbers["packing_0"] == pytest.approx(area / 3.0, rel=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("jitter", [0.01, 0.03])
@pytest.mark.parametrize("seed", [1, 2])
def test_jitter_shifts_each_disc_for_itself(jitter, seed):
    """A shift does not follow from the place, also where bed and shifts have one seed; it makes overlaps."""
    changes = "initial.0.packing=0.8", "initial.0.seed=1", f"run.seed={seed}", "initial.0.y=[-0.9, 0.6]"
    still, shaken = (bed(*changes, f"initial.0.jitter={one}").scene().positions for one in (0.0, jitter))
    shift = (shaken - still) / (0.1 * jitter)
    assert np.abs(shift).max() <= 1 + 1e-9 and np.ptp(shift, axis=0) == pytest.approx([2, 2], abs=0.1)
    for axis in (0, 1):
        assert abs(np.corrcoef(still[:, axis], shift[:, axis])[0, 1]) < 4 / np.sqrt(len(still))
    assert deepest_overlap(shaken, np.full(len(shaken), 0.1))[0] > 0.1 * jitter


def test_discs_are_at_random_and_not_a_crystal():
    """Sixfold order of the discs inside: 1 in a crystal; random beds of two sizes have about a third."""
    scene = bed(f"discs.sizes={SIZES['two']}", "initial.0.packing=0.8").scene()
    x = scene.positions
    gap = x[:, None] - x[None]
    near = (np.hypot(*gap.transpose(2, 0, 1)) < 0.14) & ~np.eye(len(x), dtype=bool)
    turned = np.where(near, np.exp(6j * np.arctan2(gap[..., 1], gap[..., 0])), 0).sum(axis=1) / np.maximum(
        near.sum(1), 1
    )
    assert abs(turned.mean()) < 0.3


def test_starts_draw_anew_and_points_of_one_seed_share_a_bed(cache):
    first = bed().scene().positions
    assert np.array_equal(bed("contact.friction=0.3", "initial.0.x=[-2, 0]").scene().positions, first)
    assert len(list(cache.glob("*.npz"))) == 1
    other = bed("run.seed=2").scene().positions
    assert len(other) == len(first) and np.abs(other - first).max() > 0.1
    held = [bed("initial.0.seed=7", f"run.seed={seed}").scene().positions for seed in (1, 2)]
    assert np.array_equal(*held)
    members = [started(bed("initial.0.seed=7"), seed).scene().positions for seed in (1, 2)]
    assert 0 < np.abs(members[0] - members[1]).max() < 1e-3


def test_a_moved_bed_is_the_same_bed():
    moved = bed("initial.0.x=[6, 8]", "initial.0.y=[0.5, 2]").scene().positions
    assert moved - [8, 1.5] == pytest.approx(bed().scene().positions, abs=1e-12)


def test_a_kept_bed_has_the_bits_of_a_grown_one_and_a_damaged_one_is_grown_anew(cache):
    made = bed().scene().positions
    (path,) = cache.glob("*.npz")
    data = path.read_bytes()

    def again():
        beds._kept.cache_clear()
        return bed().scene().positions

    assert np.array_equal(again(), made)
    for damage in (b"", data[:200], data[:-9000] + data[:9000], data.replace(data[900:916], bytes(16))):
        path.write_bytes(damage)
        assert np.array_equal(again(), made)
    assert path.read_bytes() == data
    path.unlink()
    path.parent.rmdir()
    path.parent.write_text("no folder")
    assert np.array_equal(again(), made)


def test_old_beds_leave_the_cache(cache, monkeypatch):
    monkeypatch.setattr(beds, "MOST_KEPT", 2)
    for seed in range(1, 5):
        bed(f"run.seed={seed}", "initial.0.packing=0.3").scene()
    assert len(list(cache.glob("*.npz"))) == 2


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (("initial.0.packing=0.9",), "packing"),
        (("initial.0.packing=0.05",), "packing"),
        (
            ("initial.0.packing=0.84", "initial.0.x=[-0.35, 0]", "initial.0.y=[-1, -0.6]"),
            r"is not reached: \d+ discs are jammed .* 0\.\d+ is sure",
        ),
        (("initial.0.y=[-1, -0.95]",), "does not fit into a bed of 2 by 0.05 m"),
        (("discs.diameter=0.005",), "at most 20000 of these sizes"),
        (("initial.0.x=[-0.04, 0]", "initial.0.y=[-1, -0.95]"), "less than half a disc"),
        (("initial.0.y=[-1.5, 0]",), "floor"),
    ],
)
def test_refused(changes, told):
    with pytest.raises(CaseError, match=told) as found:
        bed(*changes).scene()
    assert "initial" in str(found.value) or "floor" in str(found.value)


def test_loose_beds_are_doubted():
    assert [text for text in bed("initial.0.packing=0.7").check().warnings if "sinks to some 88 % of its depth" in text]
    assert not [text for text in bed("initial.0.packing=0.8").check().warnings if "sinks" in text]
    assert not [text for text in bed("initial.0.packing=0.7", "gravity=0").check().warnings if "sinks" in text]


def test_the_packing_that_is_sure_is_below_the_one_refused(monkeypatch):
    """An overlap of 0.13 % made 0.788 of 0.79, which was told as "0.79 is sure" beside the refusal of 0.79."""
    refused = discs.PackedBed(kind="packed_bed", x=(0, 1.2), y=(0, 1), packing=0.79)
    with monkeypatch.context() as patch:
        patch.setattr(beds, "_kept", lambda bed: beds.GrownPacking(np.zeros((1, 2)), 0.0013))
        with pytest.raises(ValueError, match=r"0\.78 is sure"):
            beds.bed_positions(refused, np.full(119, 0.1), 1)
