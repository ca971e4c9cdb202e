# SPDX-License-Identifier: GPL-2.0-or-later
"""Rating curves on the page of a study with the law of water beside them, and where a structure holds."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up import BOX

from lammps_jump.physics.jump import critical_discharge, gate_discharge
from lammps_jump.sweeps import page, rating
from lammps_jump.sweeps.study import Collected, read_study

G = 9.81


def study_of(monkeypatch, *keys, **columns):
    """A study that collects numbers of ``overtopping.weir`` with these means at its points; intervals are 0.1 wide."""
    paths = [f"overtopping.weir.{key}" for key in keys]
    frame = {}
    for path, key in zip(paths, keys, strict=True):
        mean = np.asarray(columns[key], float)
        frame |= {path: mean, f"{path}_low": mean - 0.05, f"{path}_high": mean + 0.05}
    case = read_study({"case": {**BOX, "gravity": G}}).case
    collect = [SimpleNamespace(path=path) for path in paths]
    monkeypatch.setattr(rating, "flat", lambda *_: Frame(frame))
    return SimpleNamespace(study=SimpleNamespace(collect=collect, case=case), table=None)


class Frame(dict):
    """Columns of one length."""

    def __len__(self):
        return len(next(iter(self.values())))


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_a_weir_of_critical_flow_has_its_power_and_ratio(monkeypatch, share):
    head = np.array([0.2, 0.5, 1.0, 1.7])
    rate = share * np.array([critical_discharge(one, G) for one in head])
    depth = 2 / 3 * head * share ** (2 / 3)
    found = study_of(monkeypatch, "head", "discharge", "depth", head=head, discharge=rate, depth=depth)
    (one,) = rating.ratings(found)
    k, n = one.power
    assert n == pytest.approx(1.5) and k == pytest.approx(share * critical_discharge(1.0, G))
    assert one.ratio == pytest.approx(np.full(4, share)) and one.crest_ratio == pytest.approx(np.ones(4))
    said, table = rating.section(found).blocks
    assert f"weir: the discs carry {share:.2f} of critical flow" in said.text and "H^1.50" in said.text
    assert "1.00 to 1.00 times as deep" in said.text and len(table.rows) == 4
    ((name, caption, figure),) = rating.figures(found)
    assert (
        name == "sweep_rating_weir"
        and "weir" in caption
        and figure.axes[0].get_xlabel().startswith("Head over the crest")
    )


def test_a_gate_is_held_against_water_of_each_opening(monkeypatch):
    head, opening = np.array([2.0, 2.0, 2.0]), np.array([0.5, 0.7, 0.9])
    rate = 0.5 * np.array([gate_discharge(a, 2.0, G) for a in opening])
    found = study_of(monkeypatch, "below_head", "below", "opening", below_head=head, below=rate, opening=opening)
    (one,) = rating.ratings(found)
    assert one.law is rating.GATE and one.ratio == pytest.approx(np.full(3, 0.5))
    assert one.power is None  # one head: no power of it
    said, table = rating.section(found).blocks
    assert "0.50 of water under a gate" in said.text and table.header[1] == "Opening [m]"


def test_a_gate_whose_heads_are_below_the_jet_has_no_ratio(monkeypatch):
    given = {"below_head": [0.2, 0.3], "below": [0.1, 0.2], "opening": [0.9, 0.9]}
    said, table = rating.section(study_of(monkeypatch, *given, **given)).blocks
    assert "no head is above the jet of water under a gate" in said.text and "nan" not in said.text
    assert all("nan" not in cell for row in table.rows for cell in row)


@pytest.mark.parametrize("keys", [("head",), ("discharge",), ("below_head", "below"), ("depth", "brink")])
def test_without_head_and_discharge_there_is_no_curve(monkeypatch, keys):
    found = study_of(monkeypatch, *keys, **{key: [1.0, 2.0] for key in keys})
    assert rating.ratings(found) == [] and rating.section(found).blocks == [] and not list(rating.figures(found))


def test_points_over_which_nothing_goes_are_left_out(monkeypatch):
    nan = np.nan
    found = study_of(monkeypatch, "head", "discharge", head=[nan, 0.5, 1.0], discharge=[nan, 0.2, 0.6])
    (one,) = rating.ratings(found)
    assert one.head[:, 0].tolist() == [0.5, 1.0] and one.power is None


@pytest.mark.parametrize(
    ("key", "level"),
    [("sliding_factor", 1.0), ("tipping_factor_least_mean", 1.0), ("sliding_factor_least_at", None),
     ("sliding_factor_time_below_1", None), ("weight", None)],
)  # fmt: skip
def test_a_factor_of_safety_has_the_level_1(key, level):
    assert Collected(f"stability.sill.{key}", "", "").level == level and Collected("jump.y2", "m", "").level is None


def test_what_holds_at_95_per_cent_is_told_with_what_holds_by_the_mean_alone(monkeypatch):
    path = "stability.wall.sliding_factor_least_mean"
    frame = Frame({path: np.array([0.8, 1.1, 1.4]), f"{path}_low": np.array([0.7, 0.9, 1.2])})
    monkeypatch.setattr(page, "flat", lambda *_: frame)
    monkeypatch.setattr(page, "point_name", lambda _, index: f"width = {index} m")
    collect = [Collected(path, "", "least factor"), Collected("jump.y2", "m", "depth")]
    found = SimpleNamespace(study=SimpleNamespace(collect=collect, axes=[1], fields=SimpleNamespace(confidence=0.95)))
    found.table = None
    (said,) = page.holding(found)
    assert (
        said.endswith("at 1 of 3 points (width = 2 m). By the mean alone it is so at 1 more.")
        and "sure to 95 %" in said
    )


@pytest.mark.parametrize(("low", "lines"), [(-0.5, 2), (-3.0, 1)])
def test_a_map_of_a_factor_has_contours_at_1(low, lines):
    """A solid one of the mean, and a dashed one of the lower end of its interval, where the map holds them."""
    from matplotlib.figure import Figure

    panel, bar = Figure().subplots(1, 2)
    mean = np.add.outer([0.0, 1.0], [0.5, 1.0])
    page._draw_level(panel, bar, 1.0, mean, mean + low)
    drawn = [one for one in panel.collections if any(len(path.vertices) for path in one.get_paths())]
    assert len(drawn) == lines
    places = np.concatenate([path.vertices for path in drawn[0].get_paths()])
    assert 0.5 + 0.5 * places[:, 0] + places[:, 1] == pytest.approx(np.ones(len(places)))
