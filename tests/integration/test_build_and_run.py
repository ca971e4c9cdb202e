# SPDX-License-Identifier: GPL-2.0-or-later
"""The whole job on LAMMPS: every scene of inputs/ shortened, the contract, balances, interruption and failure."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from children import run_program
from made_up import INPUTS, SCENES, analysed_again, call, plugin_or_skip, run_case

import lammps_jump as lj
from lammps_jump.case import load_case, parse_case
from lammps_jump.cli.run import build
from lammps_jump.cli.run import run as run_built
from lammps_jump.dump.read import open_dump
from lammps_jump.engines.choice import choose_setting
from lammps_jump.engines.lammps.drive import plugin_arguments
from lammps_jump.engines.lammps.loader import program
from lammps_jump.engines.launch import Setting, run
from lammps_jump.errors import RunError, RunInterrupted
from lammps_jump.files import SCENE_FILE
from lammps_jump.runs import results, start

pytestmark = pytest.mark.lammps

CONTRACT_FILES = ("case.yaml", "in.lammps", "log.lammps", "summary.json", "profiles.nc", "report.html")
OF_LAMMPS = ("in.lammps", "log.lammps")
CONTRACT_KEYS = {
    "name",
    "engine",
    "kernel",
    "versions",
    "coefficients",
    "steps",
    "wall_seconds",
    "disc_steps_per_second",
    "discs",
}


FORMATS = [("gz", "dump.lammpstrj.gz"), pytest.param("binary", "dump.lammpsbin", marks=pytest.mark.long)]


PLAIN = "analysis.figures=none"
"""Drawing takes longer than these runs; other tests look at pictures and pages."""


def job(name: str, folder: Path, *assignments: str, kernel: str = "stock", **options):
    return run_case(INPUTS / f"{name}.yaml", folder, [f"engine.kernel={kernel}", PLAIN, *assignments], **options)


def numbers(tree):
    if isinstance(tree, dict):
        for value in tree.values():
            yield from numbers(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from numbers(value)
    elif isinstance(tree, float):
        yield tree


ALL_KINDS = {"quick_jump"}
"""Inlets, outlets and sizes. `test_killed` and `test_stock_walls` run a gate; the native engine, the scripts and the
other tests see the other scenes."""
NOT_STOCK = {"heap", "spillway", "tailgate"}
"""Scenes with what LAMMPS' own styles lack: turned walls, springs at a polyline, a tailgate that holds a flow."""


@pytest.mark.parametrize(
    "name",
    [path.stem if path.stem in ALL_KINDS else pytest.param(path.stem, marks=pytest.mark.long) for path in SCENES],
)
def test_every_scene_leaves_the_contract(name, tmp_path):
    settled = load_case(INPUTS / f"{name}.yaml").fields.settling[0] > 0
    settle = ["initial.0.settle=0.05"] if settled else []
    kernel = "compiled" if name in NOT_STOCK and plugin_or_skip() else "stock"
    job(
        name,
        tmp_path,
        "run.duration=0.2",
        "run.output_interval=0.05",
        "analysis.figures=default",
        *settle,
        kernel=kernel,
    )
    native = load_case(INPUTS / f"{name}.yaml").fields.engine.name == "native"  # it writes neither script nor log
    for file in CONTRACT_FILES:
        if not native or file not in OF_LAMMPS:
            assert (tmp_path / file).stat().st_size > 0
    assert list((tmp_path / "figures").glob("*.png"))
    summary = json.loads((tmp_path / "summary.json").read_text(), parse_constant=pytest.fail)  # NaN is no JSON
    assert CONTRACT_KEYS <= set(summary)
    assert all(np.isfinite(value) for value in numbers(summary))
    discs = summary["discs"]
    assert discs["inserted"] == discs["present"] + discs["removed"] and discs["lost"] == 0
    assert discs["inserted"] > 0 and summary["status"] == "complete"
    assert (tmp_path / "forces.csv").exists() == bool(load_case(INPUTS / f"{name}.yaml").fields.probes.forces)


@pytest.mark.parametrize("kernel", [pytest.param("stock", marks=pytest.mark.long), "compiled"])
def test_the_folder_runs_alone_elsewhere_with_the_same_dump(kernel, tmp_path):
    """Both scripts stand in the folder and name no place of this machine; `lmp` is told where the plugin is."""
    plugin = plugin_or_skip() if kernel == "compiled" else None
    job("quick_jump", tmp_path / "run", "run.duration=0.3", kernel=kernel)
    scripts = sorted(path.name for path in (tmp_path / "run").glob("in.*"))
    assert scripts == ["in.lammps", "in.plugin.lammps"][: 1 + (kernel == "compiled")]
    alone = tmp_path / "alone"
    alone.mkdir()
    image = [SCENE_FILE] if kernel == "compiled" else []
    for name in (*scripts, *image, "disk.mol", "discs.data"):
        shutil.copy(tmp_path / "run" / name, alone)
        assert str(plugin).encode() not in (alone / name).read_bytes()
    subprocess.run(
        [program("lmp"), "-in", scripts[-1], *plugin_arguments(plugin)], cwd=alone, check=True, capture_output=True
    )
    assert (alone / "dump.lammpstrj").read_bytes() == (tmp_path / "run" / "dump.lammpstrj").read_bytes()
    if kernel == "compiled":  # without the plugin the folder holds the same run of the stock styles
        subprocess.run([program("lmp"), "-in", "in.lammps"], cwd=alone, check=True, capture_output=True)
        first, second = (list(lj.read_dump(folder / "dump.lammpstrj")) for folder in (alone, tmp_path / "run"))
        assert [frame.step for frame in first] == [frame.step for frame in second] and first[-1].n == second[-1].n > 0


@pytest.mark.parametrize("change", ["contact.touch=smooth", "contact.friction_law=sign"])
def test_what_stock_styles_lack_is_said_in_a_script_without_a_run(change, tmp_path, capsys):
    plugin_or_skip()
    build(INPUTS / "hydraulic_jump.yaml", out=tmp_path, set_=[change])
    assert "lmp -in" not in capsys.readouterr().out
    lines = (tmp_path / "in.lammps").read_text().splitlines()
    said = change.removeprefix("contact.").replace("=", ": ")
    assert said in lines[1] and "No run" in lines[1] and "in.plugin.lammps" in lines[1]
    assert not any(line.startswith("run ") for line in lines)
    done = subprocess.run([program("lmp"), "-in", "in.lammps"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and said in done.stdout
    assert (tmp_path / "in.plugin.lammps").read_text().count("\nrun ") == 1


def test_energy_box_starts_at_5760_joules_and_stays_near(tmp_path):
    """Thesis: 5760 J; 3 % at f = 0.05 is the bound for 120 s, and 10 s see fewer collisions."""
    summary = job("energy_box_16", tmp_path, "run.duration=10")
    assert summary["energy"]["initial"] == pytest.approx(5760, rel=1e-9)
    assert summary["energy"]["max_deviation"] < 0.03


@pytest.mark.long
@pytest.mark.parametrize("fraction, bound", [(0.05, 0.03), (0.01, 0.002)])
def test_energy_box_whole(tmp_path, fraction, bound):
    """The contract's bounds: 3 % at f = 0.05, 0.2 % at f = 0.01, elastic energy included."""
    summary = job("energy_box_16", tmp_path, f"run.time_step_fraction={fraction}")
    assert summary["energy"]["initial"] == pytest.approx(5760, rel=1e-9)
    assert summary["energy"]["max_deviation"] < bound


def test_row_speeds_and_counts_while_the_inlet_is_free(tmp_path):
    """floor(u t / (s d)) + 1 discs a row to within one, at the row speeds of the 1/7 profile (4.1)."""
    summary = job("hydraulic_jump", tmp_path, "run.duration=0.4")
    scene = load_case(INPUTS / "hydraulic_jump.yaml", ["run.duration=0.4"]).scene()
    theory = summary["theory"]  # docs/theory.md, printed digits
    assert theory["froude"] == pytest.approx(5.108, abs=5e-4)
    assert theory["belanger_y2"] == pytest.approx(6.742, abs=5e-4)
    assert theory["jump_length"] == pytest.approx(40.63, abs=5e-3)
    exact = [scene.steps * scene.time_step * row.vx / (1.02 * scene.diameter) for row in scene.inlets]
    assert abs(summary["discs"]["inserted"] - sum(np.floor(exact) + 1)) <= len(scene.inlets)


def test_discs_enter_with_their_rows_speed(tmp_path):
    """vx is the row's speed. The rows touch: in a millisecond the weight on their slanting contact adds at most
    g t times the slope (2 m/s * 1 ms / 0.2 m), 1e-4 m/s, so 1e-5 of the speed for each row above."""
    job("hydraulic_jump", tmp_path, "run.duration=0.001", "run.output_interval=0.001")
    speeds = [row.vx for row in load_case(INPUTS / "hydraulic_jump.yaml").scene().inlets]
    last = list(open_dump(tmp_path / "dump.lammpstrj"))[-1].sorted()
    assert last.n == 5
    assert last.vx == pytest.approx(speeds, rel=5e-5)


SETTLED = """\
name: tank
discs: {diameter: 0.1, density: 1000}
contact: {restitution: 0.2, friction: 0, impact_speed: 6}
walls:
  - {name: left, kind: plane, axis: x, at: 0, side: above}
  - {name: right, kind: plane, axis: x, at: 1.0, side: below}
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
initial: [{kind: column, x: [0, 1], y: [0, 1], hydrostatic: true, jitter: 0.002, gate: false}]
domain: {x: [-0.5, 1.5], y: [-0.5, 3]}
run: {duration: 3, time_step_fraction: 0.1, output_interval: 0.5}
probes: {forces: [floor, left, right], interval: 0.5}
"""


@pytest.mark.parametrize("kernel", [pytest.param("stock", marks=pytest.mark.long), "compiled"])
def test_floor_carries_the_weight_of_a_settled_tank(tmp_path, kernel):
    """N m g to 0.1 % (an identity of equilibrium), and the side walls push alike."""
    if kernel == "compiled":
        plugin_or_skip()
    (tmp_path / "tank.yaml").write_text(SETTLED)
    run_case(tmp_path / "tank.yaml", tmp_path / "run", [f"engine.kernel={kernel}", PLAIN])
    last = {}
    for line in (tmp_path / "run" / "forces.csv").read_text().splitlines()[1:]:
        time, name, fx, fy, _ = line.split(",")
        last[name] = (float(time), float(fx), float(fy))
    assert last["floor"][2] == pytest.approx(-100 * 10 * 9.81, rel=1e-3)
    assert last["left"][1] + last["right"][1] == pytest.approx(0, abs=1e-3 * abs(last["floor"][2]))


def test_stored_result_is_returned_and_force_runs_again(tmp_path, caplog):
    caplog.set_level("INFO", "lammps_jump")

    def again(**options):
        return job("energy_box_7", tmp_path, "run.duration=1", **options)

    first = again()
    stamp = (tmp_path / "dump.lammpstrj").stat().st_mtime_ns
    assert again() == json.loads((tmp_path / "summary.json").read_text())
    assert (tmp_path / "dump.lammpstrj").stat().st_mtime_ns == stamp
    assert any("already holds" in text for text in caplog.messages)
    assert again(force=True)["steps"] == first["steps"]
    assert (tmp_path / "dump.lammpstrj").stat().st_mtime_ns != stamp


def test_interrupted_run_keeps_its_frames(tmp_path):
    scene = load_case(INPUTS / "energy_box_16.yaml", ["run.duration=20000"]).scene()
    result = run(scene, tmp_path, Setting(stop_at=20_000))
    assert result.status == "interrupted" and result.steps == 20_000
    assert 0 < result.steps < scene.steps
    assert result.inserted == result.present == 16 and result.lost == 0
    frames = list(open_dump(tmp_path / "dump.lammpstrj"))
    assert len(frames) > 1 and frames[-1].step <= result.steps


def test_lost_disc_is_named_and_the_folder_kept(tmp_path):
    case = tmp_path / "leak.yaml"
    case.write_text(
        "discs: {diameter: 0.2}\ncontact: {restitution: 0.5, impact_speed: 5}\ngravity: 0\n"
        "domain: {x: [-1, 2], y: [-1, 1]}\n"
        "initial: [{kind: list, positions: [[0, 0], [0, 0.5]], velocities: [[4.9, 0], [0, 0]]}]\nrun: {duration: 2}\n"
    )
    with pytest.raises(RunError, match=r"lost.*disc 1, last seen at \(\d\.\d+, 0\).*widen domain") as error:
        run_case(case, tmp_path / "run", ["engine.kernel=stock", PLAIN])
    assert error.value.exit_status == 1
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["status"] == "failed" and summary["discs"]["lost"] == 1
    assert (tmp_path / "run" / "dump.lammpstrj").exists()


def test_deep_overlap_ends_the_run_and_names_the_discs(tmp_path):
    """Two discs at 40 times the design speed would pass through each other."""
    case = parse_case(
        "discs: {diameter: 0.2}\ncontact: {restitution: 1, impact_speed: 1}\ngravity: 0\n"
        "initial: [{kind: list, positions: [[0, 0], [1, 0]], velocities: [[40, 0], [-40, 0]]}]\n"
        "domain: {x: [-5, 6], y: [-1, 1]}\nrun: {duration: 0.02, output_interval: 0.0002}\n"
    )
    scene = case.scene()
    result = run(scene, tmp_path)
    assert result.status == "failed"
    assert "overlap too deeply at t = 0.0" in result.message and "discs" in result.message and "2 d/n" in result.message


def test_a_run_that_blows_up_is_reported(tmp_path):
    """Beyond the stable step the motion diverges; the run must end with a message, not with NaN in its files."""
    case = parse_case(
        "discs: {diameter: 0.2}\ncontact: {restitution: 0.2, impact_speed: 16, correct_restitution: false}\n"
        "walls: [{name: box, kind: box, x: [0, 1], y: [0, 1]}]\n"
        "initial: [{kind: lattice, nx: 5, ny: 5, spacing: 0.198, origin: [0.1, 0.1], jitter: 0.001}]\n"
        "run: {duration: 5, time_step_fraction: 1.2, allow_unstable: true}\n"
    )
    scene = case.scene()
    result = run(scene, tmp_path)
    assert (result.status == "failed" and "time_step_fraction" in result.message) or "domain" in result.message
    assert "nan" not in (tmp_path / "dump.lammpstrj").read_text().lower()


@pytest.mark.long
def test_two_ranks_balance_and_agree_with_one(tmp_path):
    results = {}
    for ranks in (1, 2):
        # text holds ten digits: less than is compared
        changes = ("run.duration=0.1", "run.output_interval=0.05", "run.dump_format=binary", f"engine.ranks={ranks}")
        summary = job("dam_break", tmp_path / str(ranks), *changes)
        assert summary["discs"] == {"inserted": 1200, "present": 1200, "removed": 0, "lost": 0}
        results[ranks] = list(open_dump(tmp_path / str(ranks) / "dump.lammpsbin"))[-1].sorted()
    # 1,090 steps of a column just released: sums in another order, not yet amplified by chaos
    assert np.abs(results[1].x - results[2].x).max() < 1e-9 * 0.2
    assert np.abs(results[1].y - results[2].y).max() < 1e-9 * 0.2


@pytest.mark.parametrize("dump_format, name", FORMATS)
def test_other_dump_formats_hold_the_same_frames(tmp_path, dump_format, name):
    frames = {}
    for kind, file in (("text", "dump.lammpstrj"), (dump_format, name)):
        job("energy_box_7", tmp_path / kind, "run.duration=1", f"run.dump_format={kind}")
        frames[kind] = list(open_dump(tmp_path / kind / file))
    assert len(frames["text"]) == len(frames[dump_format]) == 11
    for text, other in zip(frames["text"], frames[dump_format], strict=True):
        assert text.step == other.step and text.time == pytest.approx(other.time)
        assert text.sorted().x == pytest.approx(other.sorted().x, rel=1e-9)  # ten digits in text


def test_command_line_exit_status(tmp_path, monkeypatch, capsys, blank_pictures_here):
    case = INPUTS / "energy_box_7.yaml"
    options = ["--out", tmp_path / "run", "--set", "run.duration=0.5", "--kernel", "stock"]
    status, output, _ = call(monkeypatch, capsys, "build-and-run", case, *options)
    assert status == 0
    assert "0 lost" in output and "report.html" in output


def test_build_then_run(tmp_path):
    case = load_case(INPUTS / "energy_box_7.yaml", ["run.duration=0.5", "engine.kernel=stock", PLAIN])
    setting = start.build(case, tmp_path)
    assert not (tmp_path / "dump.lammpstrj").exists()
    assert choose_setting(load_case(tmp_path)) == (case, setting, ())
    run_built(tmp_path)
    summary = lj.open_run(tmp_path).summary
    assert summary["discs"]["lost"] == 0


@pytest.mark.long
def test_build_with_a_job_file(tmp_path):
    status, output = run_program(
        "build", INPUTS / "energy_box_7.yaml", "--out", tmp_path, "--kernel", "stock", "--slurm"
    )
    assert status == 0 and f"job file: {tmp_path / 'job.slurm'}" in output
    assert (tmp_path / "job.slurm").exists() and (tmp_path / "in.lammps").exists()


def test_interruption_is_an_error_of_its_own():
    assert issubclass(RunInterrupted, RunError) and RunInterrupted.exit_status == 75


POUR = """\
name: pour
discs: {diameter: 0.1, density: 1000}
contact: {restitution: 0.3, friction: 0.2, impact_speed: 6}
walls: [{name: tank, kind: box, x: [0, 1.5], y: [0, 6]}]
domain: {x: [-0.5, 2], y: [-0.5, 6.5]}
inflow: {kind: pour, x: [0.1, 1.4], y: [4, 5.5], count: 60, volume_fraction: 0.3}
run: {duration: 3, time_step_fraction: 0.1, output_interval: 0.5}
"""


@pytest.mark.parametrize("engine", [pytest.param("stock", marks=pytest.mark.long), "compiled", "native"])
def test_poured_discs_all_come_and_stay(tmp_path, engine):
    """Places differ (each engine draws its own), the count does not; masses are the case's."""
    if engine == "compiled":
        plugin_or_skip()
    (tmp_path / "pour.yaml").write_text(POUR)
    choice = "engine.name=native" if engine == "native" else f"engine.kernel={engine}"
    summary = run_case(tmp_path / "pour.yaml", tmp_path / "run", [choice, PLAIN])
    assert summary["discs"] == {"inserted": 60, "present": 60, "removed": 0, "lost": 0}


@pytest.mark.long
def test_killed_run_is_counted_from_what_it_wrote(tmp_path):
    job("quick_jump", tmp_path, "run.duration=1")
    whole = json.loads((tmp_path / "summary.json").read_text())
    (tmp_path / "summary.json").unlink()  # a killed run writes none
    found = analysed_again(tmp_path)
    assert found["status"] == "complete" and found["discs"] == whole["discs"] and found["steps"] == whole["steps"]
    assert any("reached its end" in text for text in found["warnings"])
    log = (tmp_path / "log.lammps").read_text()
    (tmp_path / "log.lammps").write_text(log[: log.rindex("Loop time of")].rsplit("\n", 2)[0])
    (tmp_path / "summary.json").unlink()
    found = analysed_again(tmp_path)
    assert found["status"] == "interrupted" and 0 < found["steps"] < whole["steps"]
    assert any("cut off" in text for text in found["warnings"])


@pytest.mark.long
def test_film_of_a_run_with_forces(tmp_path):
    job("dam_break", tmp_path, "run.duration=0.1", "run.output_interval=0.02")
    for name in ("film.gif", "film.mp4"):
        assert results.animate(tmp_path, tmp_path / name, 10).stat().st_size > 1000


def test_refusal_leaves_an_earlier_result_alone(tmp_path):
    from lammps_jump.errors import CaseError

    job("energy_box_7", tmp_path, "run.duration=0.5")
    before = (tmp_path / "summary.json").read_bytes()
    for wrong in ("run.duration=1e99", "analysis.bin_width=1e-9"):
        with pytest.raises(CaseError, match="allowed"):
            job("energy_box_7", tmp_path, wrong)
    assert (tmp_path / "summary.json").read_bytes() == before


@pytest.mark.parametrize("kernel", ["stock", "compiled"])
def test_positions_that_are_no_numbers_end_the_run(tmp_path, kernel):
    """Two discs at one place have no normal: LAMMPS itself would run on with NaN to a complete end."""
    plugin = plugin_or_skip() if kernel == "compiled" else None
    scene = load_case(INPUTS / "energy_box_7.yaml", ["run.duration=1"]).scene()
    together = scene.positions.copy()
    together[1] = together[0]
    scene = replace(scene, positions=together)
    result = run(scene, tmp_path, Setting(kernel=kernel, plugin=plugin))
    assert result.status == "failed"
    assert "no longer a number" in result.message or "overlap too deeply" in result.message


TWO_SIDED = """
name: wet_bed
discs: {diameter: 0.1}
contact: {restitution: 0.5, impact_speed: 5}
walls:
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
  - {name: back, kind: plane, axis: x, at: 0, side: above}
  - {name: front, kind: plane, axis: x, at: 3, side: below}
initial:
  - {kind: column, x: [0, 1], y: [0, 1], settle: 0.05}
  - {kind: list, positions: [[1.049, 0.05], [2, 0.05]], velocities: [[-1, 0], [0, 0]]}
run: {duration: 0.05, output_interval: 0.01}
"""


def test_discs_beyond_a_gate_meet_the_same_sheet_on_every_engine(tmp_path):
    """They were pushed out of the half-space that the gate was: 2 m away by the plugin, not at all by stock LAMMPS."""
    case = tmp_path / "wet.yaml"
    case.write_text(TWO_SIDED)
    plugin_or_skip()
    ends = {}
    for engine, kernel in (("lammps", "stock"), ("lammps", "compiled"), ("native", "auto")):
        out = tmp_path / f"{engine} {kernel}"
        texts = [f"engine.name={engine}", f"engine.kernel={kernel}", "run.integrator=velocity_verlet", PLAIN]
        summary = run_case(case, out, texts)
        assert summary["status"] == "complete"
        frames = [frame.sorted() for frame in open_dump(out / "dump.lammpstrj")]
        # the first thing that the disc at the gate does is to bounce off it
        assert 0 < frames[1].vx[-2] < 1 and frames[1].x[-2] > 1.05 and frames[1].x[-1] == 2
        ends[engine, kernel] = frames[-1]
    one = ends["lammps", "stock"]
    for other in ends.values():
        # ten digits in the dump, and 0.1 s of a column that falls apart
        assert max(np.abs(one.x - other.x).max(), np.abs(one.y - other.y).max()) < 1e-7


def test_the_newest_disc_may_leave_first(tmp_path):
    """Its id is given again: the count of discs must not fall behind, nor the run be called failed."""
    case = tmp_path / "short.yaml"
    case.write_text(
        """
name: short
discs: {diameter: 0.15}
contact: {restitution: 0.5, impact_speed: 5}
domain: {x: [-1, 4], y: [-3, 10]}
walls: [{name: floor, kind: plane, axis: y, at: 0, side: above}]
inflow: {kind: rows, x: 0, depth: 0.15, mean_speed: 3, spacing: 5, profile: uniform}
outflow: [{x_beyond: 0.6}]
run: {duration: 1, time_step_fraction: 0.1}
"""
    )
    summary = run_case(case, tmp_path / "out", ["engine.kernel=stock", PLAIN])
    assert summary["status"] == "complete"
    discs = summary["discs"]
    assert discs["removed"] >= 3 and discs["lost"] == 0
    assert discs["inserted"] == discs["present"] + discs["removed"]


def test_plugin_in_a_folder_with_a_blank(tmp_path):
    library = tmp_path / "my cache" / "plugin.so"
    library.parent.mkdir()
    shutil.copy(plugin_or_skip(), library)
    scene = load_case(INPUTS / "energy_box_7.yaml", ["run.duration=0.1"]).scene()
    assert run(scene, tmp_path, Setting(kernel="compiled", plugin=library)).status == "complete"
