# SPDX-License-Identifier: GPL-2.0-or-later
"""Benchmark arithmetic: settings, errors, Pareto fronts, choices, storage; nothing is run."""

from dataclasses import replace
from functools import partial

import cell_search
import numpy as np
import pytest
from made_up import INPUTS
from taking_turns import in_turn

from lammps_jump import load_case
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.errors import CaseError, RunInterrupted
from lammps_jump.studies import bench
from lammps_jump.studies.bench import (
    QUICK,
    SPEED,
    Axes,
    QuantityError,
    StudySetting,
    collision_scene,
    make_settings,
    read_axes,
    reference_setting,
    stable,
)
from lammps_jump.studies.cross_validation.trajectories import with_discs_of
from lammps_jump.studies.runs import middle
from lammps_jump.sweeps.members import JITTER, started


def test_only_stable_steps_are_settings():
    found = make_settings(Axes(("f", "kernel", "touch")), 0.2)
    # docs/theory.md, stability: 0.280 for velocity Verlet, 0.167 for the thesis' scheme
    assert max(s.fraction for s in found if s.kernel != "native") == 0.2
    assert max(s.fraction for s in found if s.kernel == "native") == 0.1
    assert {s.family for s in found} == {"stock", "compiled", "native", "compiled smooth"}
    assert len({s.label for s in found}) == len(found)


def test_axes_add_their_settings():
    names = ("f", "n", "correction", "skin", "ranks", "diameter")
    every = make_settings(Axes(names, diameters=(0.1,)), 0.2)
    assert {s.penetration for s in every} >= {5.0, 20.0, 40.0}
    assert any(not s.correction for s in every) and any(s.skin == 0.1 for s in every)
    assert any(s.ranks == 2 for s in every) and any(s.diameter == 0.1 for s in every)
    # restitution 1 has nothing to correct
    assert all(s.correction for s in make_settings(Axes(("f", "correction")), 1.0))


def test_assignments_make_the_case(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(
        "name: t\ngravity: 0\ndiscs: {diameter: 0.4}\ncontact: {restitution: 0.5, impact_speed: 5}\n"
        "walls: [{name: b, kind: box, x: [0, 2], y: [0, 2]}]\n"
        "initial: [{kind: lattice, nx: 2, ny: 2, spacing: 0.8, origin: [0.5, 0.5]}]\nrun: {duration: 1}\n"
    )
    setting = StudySetting("native", 0.02, "smooth", penetration=20.0, correction=False, skin=0.2)
    changed = load_case(path).replace(setting.changes(0.4))
    case = changed.fields
    assert case.engine.name == "native" and case.run.time_step_fraction == 0.02
    assert case.contact.touch == "smooth" and case.contact.largest_overlap == 0.05
    assert case.contact.correct_restitution is False and case.engine.skin == pytest.approx(0.08)
    moved = started(load_case(path), 3).fields
    assert moved.run.seed == 3 and moved.initial[0].jitter == JITTER


def test_collisions_have_the_contact_of_a_case():
    """Half of the lag's correction and a width of two steps at v0 for a smooth touch, whatever speed is tried."""
    sharp, smooth = (collision_scene(0.1, 0.2, touch=touch, speed=3.0, phases=4) for touch in ("sharp", "smooth"))
    assert sharp.touch_width == 0 and smooth.touch_width == pytest.approx(2 * SPEED * smooth.time_step, rel=1e-12)
    lag = 1 - sharp.coefficients.correction
    assert lag > 0.03 and 1 - smooth.coefficients.correction == pytest.approx(0.5 * lag, rel=1e-12)
    assert collision_scene(0.1, 0.2, correct=False, phases=4).coefficients.correction == 1
    # first touch falls at shares 1/8, 3/8, 5/8, 7/8 of a step, one step and more after the start
    gaps = smooth.positions[1::2, 0] - smooth.positions[::2, 0] - smooth.diameter
    assert gaps / (3.0 * smooth.time_step) == pytest.approx([1.125, 1.375, 1.625, 1.875], rel=1e-9)
    assert smooth.output_steps == 1 and smooth.steps * smooth.time_step > 1.6 * smooth.coefficients.contact_duration


def test_unknown_axis_is_named():
    with pytest.raises(CaseError, match="--axes: 'g' is not known; allowed are f, n"):
        read_axes(axes="f,g")
    with pytest.raises(CaseError, match="--kernels: 'fast' is not known"):
        read_axes(kernels="stock,fast")
    assert read_axes(axes="f, n,f", diameters="0.1", members=3) == Axes(("f", "n"), diameters=(0.1,), members=3)
    assert read_axes(quick=True, fractions="0.1") == QUICK._replace(fractions=(0.1,))


def test_reference_is_the_fastest_kernel():
    assert reference_setting(0.01, ["stock", "compiled", "native"]).kernel == "compiled"
    assert reference_setting(0.01, ["stock", "native"]).kernel == "native"
    assert stable(StudySetting("stock", 0.279), 0.2) and not stable(StudySetting("stock", 0.281), 0.2)


def test_error_against_an_ensemble():
    found = bench.quantity_error("sequent depth", [1.0, 1.2], [2.0, 2.2])
    assert found.error == pytest.approx(1.0 / 2.1)
    # both ensembles have a variance of 0.02: sqrt(0.02/2 + 0.02/2) over 2.1
    assert found.floor == pytest.approx(np.sqrt(0.02) / 2.1)
    assert found.value == pytest.approx(1.1)


def test_error_of_curves_is_root_mean_square():
    ours, theirs = [[1.0, 3.0], [1.0, 3.0]], [[1.0, 1.0], [1.0, 1.0]]
    found = bench.quantity_error("front position", ours, theirs)
    assert found.error == pytest.approx(np.sqrt(2.0))
    assert found.floor == 0.0


def test_exact_quantities_use_the_median():
    found = bench.quantity_error("energy deviation", [0.01, 0.02, 0.5], None)
    assert found.error == 0.02 and found.floor == 0.0


def test_missing_values_leave_no_number():
    assert bench.quantity_error("sequent depth", [None], [1.0]).error is None
    assert bench.quantity_error("sequent depth", [1.0], []).error is None
    assert bench.names_of([{"sequent depth": None, "shock speed": 1.0}, {"curve": [1.0]}]) == [
        "shock speed",
        "curve",
    ]


def row(label, seconds, error, floor=0.0, **setting):
    """What `summarise_quantity` reads of a row."""
    errors = {"q": QuantityError(error, floor)._asdict()}
    return {"label": label, "seconds": seconds, "setting": setting, "errors": errors}


def test_pareto_front():
    points = [(1.0, 0.5), (2.0, 0.1), (3.0, 0.2), (4.0, 0.05), (1.5, 0.6)]
    rows = [row(f"{seconds:g} s", seconds, error) for seconds, error in points]
    assert bench.summarise_quantity(rows, "q")["pareto"] == ["1 s", "2 s", "4 s"]
    unknown = [row("without an error", 0.5, None), row("not run", None, 0.01)]
    assert bench.summarise_quantity([*rows, *unknown], "q")["pareto"] == ["1 s", "2 s", "4 s"]
    assert bench.summarise_quantity(unknown, "q") == {
        "pareto": [], "cheapest": {"0.01": None, "0.05": None}, "floor": None
    }  # fmt: skip


def test_cheapest_needs_error_and_floor_within():
    rows = [row("quick", 1.0, 0.001, floor=0.2), row("good", 2.0, 0.009, floor=0.005), row("slow", 3.0, 0.001)]
    found = bench.summarise_quantity(rows, "q")
    assert found["cheapest"] == {"0.01": "good", "0.05": "good"} and found["floor"] == 0.005
    assert bench.summarise_quantity(rows[:1], "q")["cheapest"] == {"0.01": None, "0.05": None}
    other_flow = row("coarse", 0.1, 0.001, diameter=0.4)
    assert bench.summarise_quantity([other_flow, *rows], "q")["cheapest"]["0.01"] == "good"


def test_turns_go_to_and_fro():
    calls = []
    found = in_turn("ab", 3, lambda item, number: calls.append((number, item)) or f"{item}{number}")
    assert calls == [(0, "a"), (0, "b"), (1, "b"), (1, "a"), (2, "a"), (2, "b")]
    assert found == {"a": ["a0", "a1", "a2"], "b": ["b0", "b1", "b2"]}
    assert middle([3.0, None, 1.0]) == 2.0 and middle([None]) is None


def json_row(label, seconds, error, **others):
    return {"label": label, "seconds": seconds, "errors": {"q": {"error": error, "floor": 0.0}}, **others}


def test_table_names_choices():
    data = {
        "case": "box", "duration": 1.0, "members": 2, "reference": "compiled f=0.01", "time": "seconds",
        "machine": {"processor": "p"},
        "rows": [
            json_row("stock f=0.05", 4.0, 0.02, failed=[], disc_steps_per_second=1e6),
            json_row("compiled f=0.1", 1.0, 0.008, failed=["x"], disc_steps_per_second=5e6),
        ],
        "quantities": {"q": {"cheapest": {"0.01": "compiled f=0.1", "0.05": "compiled f=0.1"}, "pareto": []}},
    }  # fmt: skip
    text = "\n".join(bench.page(data))
    assert "compiled f=0.1: 1.00 s, 4.0x (0.80 %)" in text
    assert "| compiled f=0.1 (1 failed) | 1.00 | 5.0 | 0.80 % |" in text


def test_a_setting_without_any_error_is_cheapest_and_has_no_place_on_a_logarithmic_axis(tmp_path):
    rows = [json_row("stock f=0.05", 4.0, 0.02, family="stock", plain=True)]
    rows += [json_row("compiled f=0.1", 1.0, 0.0, family="compiled", plain=True)]
    summary = {"cheapest": {"0.01": "compiled f=0.1", "0.05": "compiled f=0.1"}, "pareto": ["compiled f=0.1"]}
    for some in (rows, rows[1:]):
        data = {"case": "box", "rows": some, "quantities": {"q": {**summary, "floor": None}}}
        assert bench.draw_quantity(data, "q", tmp_path).stat().st_size > 5000


def test_a_developed_flow_keeps_the_sizes_of_its_discs():
    """Ids begin anew, and with them the sizes: each disc gets an id whose size is all but its own."""
    scene = load_case(INPUTS / "quick_jump.yaml", {"run.duration": 2, "initial": []}).scene()
    simulation = NativeSimulation(replace(scene, probes=()), ledger=False)
    simulation.run(scene.steps)
    started = with_discs_of(simulation, scene)
    ids = np.arange(1, len(started.positions) + 1)
    place = {tuple(position): radius for position, radius in zip(simulation.positions, simulation.radii, strict=True)}
    was = 2 * np.array([place[tuple(position)] for position in started.positions])
    # the range is 0.06 m; ids in turn fill it evenly, those of 500 discs leave gaps of up to 2 / 500 of it
    assert np.abs(started.diameters(ids) - was).max() < 0.01 * (scene.largest - scene.smallest)
    assert {row.first_step for row in started.inlets} == {scene.size_steps}
    assert (with_discs_of(started, scene).positions == started.positions).all()


def test_a_search_that_the_user_ended_is_no_time(monkeypatch):
    # its time was kept as that of a whole run, and the next search began
    scene = load_case(INPUTS / "energy_box_16.yaml", ["run.duration=0.5"]).scene()
    ended = partial(cell_search.run_native, should_stop=lambda: True)
    monkeypatch.setattr(cell_search, "run_native", ended)
    with pytest.raises(RunInterrupted, match="the study was ended"):
        cell_search.cell_time(scene, None)
