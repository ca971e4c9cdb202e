# SPDX-License-Identifier: GPL-2.0-or-later
"""Cross-validation on the real engines, shortened; the long ones are `make cross-validation`."""

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from lammps_jump import load_case
from lammps_jump.cli.app import app
from lammps_jump.studies.cross_validation import study as cross_validation
from lammps_jump.studies.cross_validation.study import friction_scene, micro_scenes
from lammps_jump.studies.cross_validation.trajectories import check_scene

pytestmark = pytest.mark.lammps

COLUMN = """
name: small_column
discs: {diameter: 0.2, density: 1000}
contact: {restitution: 0.4, friction: 0, impact_speed: 5}
domain: {x: [-1, 12], y: [-1, 5]}
walls:
  - {name: back, kind: plane, axis: x, at: 0, side: above}
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
initial: [{kind: column, x: [0, 0.8], y: [0, 1.6], hydrostatic: true, gate: true}]
run: {duration: 0.6, time_step_fraction: 0.1, output_interval: 0.02}
probes: {forces: [back]}
analysis: {bin_width: 0.4, front: true}
"""


@pytest.mark.long
@pytest.mark.parametrize("scene", micro_scenes(), ids=lambda scene: scene.name)
def test_stock_lammps_walks_the_native_engines_path(scene):
    check = check_scene(scene)
    assert check.agrees, check


@pytest.mark.parametrize("scene", [*micro_scenes(), friction_scene("sign")], ids=lambda scene: scene.name)
def test_the_compiled_kernel_walks_the_native_engines_path(plugin, scene):
    check = check_scene(scene, kernel="compiled")
    assert check.agrees, check


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """One short study, run through the command line, and again."""
    folder = tmp_path_factory.mktemp("cross")
    case = folder / "small_column.yaml"
    case.write_text(COLUMN)
    arguments = ["cross-validate", str(case), "--out", str(folder / "out"), "--quick", "--kernel", "stock"]
    with pytest.MonkeyPatch.context() as patch:
        # two of the small scenes; each has a test of its own above
        patch.setattr(cross_validation, "micro_scenes", lambda: micro_scenes()[:2])
        first = CliRunner().invoke(app, arguments)
    return folder / "out", arguments, first


@pytest.mark.long
def test_study_leaves_report_json_and_figures(study):
    folder, _, first = study
    assert first.exit_code == 0, first.output
    report = json.loads((folder / "cross_validation.json").read_text())
    assert report["passed"] and report["lammps_kernel"] == "stock"
    assert report["divergence"]["first_step_beyond"]["1e-12"] is not None
    names = {quantity["name"] for quantity in report["statistics"]["quantities"]}
    wanted = {"mass_depth profile", "front history", "impulse on back, x", "kinetic energy, mean", "energy at the end"}
    assert wanted <= names
    html = (folder / "cross_validation.html").read_text()
    assert "http" not in html.replace("http-equiv", "") and html.count("data:image/png") >= 4
    assert {path.name for path in (folder / "figures").iterdir()} >= {"divergence.png", "profiles.png", "front.png"}


@pytest.fixture
def numbers_only(monkeypatch):
    """Small scenes and figures have their tests above."""
    monkeypatch.setattr(cross_validation, "micro_scenes", tuple)
    monkeypatch.setattr(cross_validation.page, "draw_all", lambda chart, found, laws, folder: {})


@pytest.mark.long
def test_study_goes_on_where_it_was_interrupted(study, numbers_only):
    folder, arguments, _ = study
    members = sorted((folder / "runs").iterdir())
    assert len(members) == 2 * cross_validation.QUICK_MEMBERS
    shutil.rmtree(members[0])
    again = CliRunner().invoke(app, arguments)
    assert again.exit_code == 0, again.output
    assert again.output.count("was there") == len(members) - 1
    assert (members[0] / "summary.json").exists()
    assert not list(folder.rglob("dump.*"))  # what is compared does not need them


@pytest.mark.long
def test_exit_status_is_one_where_the_engines_differ(study, monkeypatch, numbers_only):
    """The native engine is handed a floor that is 5 % softer: both parts must notice."""
    from dataclasses import replace

    from lammps_jump.engines.native import simulation

    _, arguments, _ = study
    real = simulation.NativeSimulation.__init__

    def softer(self, scene, **options):
        c = scene.coefficients
        real(self, replace(scene, coefficients=replace(c, stiffness_wall=0.95 * c.stiffness_wall)), **options)

    monkeypatch.setattr(simulation.NativeSimulation, "__init__", softer)
    outcome = CliRunner().invoke(app, arguments)
    assert outcome.exit_code == 1, outcome.output
    assert "The engines differ" in outcome.output


@pytest.mark.long
@pytest.mark.parametrize("name", ["energy_box_16", "dam_break", "quick_jump"])
def test_the_scenes_agree(name, tmp_path):
    case = load_case(Path("inputs") / f"{name}.yaml")
    report = cross_validation.cross_validate(case, out=tmp_path, members=6, quick=True)
    assert report["passed"], report["statistics"]
