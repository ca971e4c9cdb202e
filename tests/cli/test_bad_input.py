# SPDX-License-Identifier: GPL-2.0-or-later
"""Wrong input: one paragraph that names the place, exit status 2, nothing written, no traceback."""

from __future__ import annotations

import gzip
import sys
from pathlib import Path

import pytest

from lammps_jump.case import parse_case
from lammps_jump.cli.app import main

GOOD = """\
name: good
gravity: 9.81
discs: {diameter: 0.2, density: 1000}
contact:
  restitution: 0.2
  friction: 0.1
  largest_overlap: 0.1
  impact_speed: 16
domain: {x: [-1, 20], y: [-5, 10]}
walls:
  - {name: floor, kind: block, x: [-2, 10], y: [-4, 0]}
inflow: {kind: rows, x: 0, depth: 1.0, mean_speed: 16, profile: power_law}
outflow: [{x_beyond: 15}, {y_below: -3}]
run: {duration: 0.01}
"""

# (what is wrong, text to replace, replacement, what the message must name)
WRONG_CASES = [
    ("unknown field", "friction: 0.1", "frction: 0.1", ["case.yaml:6", "contact.frction", "did you mean 'friction'"]),
    ("unknown top field", "gravity: 9.81", "gravitation: 9.81", ["case.yaml:2", "gravity"]),
    (
        "duplicate field",
        "friction: 0.1",
        "friction: 0.1\n  friction: 0.2",
        ["case.yaml:7", "contact.friction", "twice", "line 6"],
    ),
    ("missing group", "discs: {diameter: 0.2, density: 1000}\n", "", ["discs", "required"]),
    ("missing field", "diameter: 0.2, ", "", ["case.yaml:3", "discs.diameter", "required"]),
    (
        "negative diameter",
        "diameter: 0.2",
        "diameter: -0.2",
        ["case.yaml:3", "discs.diameter", "-0.2", ">= 1e-06 and <= 1e+06"],
    ),
    ("zero density", "density: 1000", "density: 0", ["discs.density", ">= 0.001"]),
    ("NaN", "friction: 0.1", "friction: .nan", ["case.yaml:6", "contact.friction", "finite"]),
    ("infinity", "impact_speed: 16", "impact_speed: .inf", ["contact.impact_speed", "finite"]),
    ("restitution above 1", "restitution: 0.2", "restitution: 1.2", ["case.yaml:5", "contact.restitution", "<= 1"]),
    ("restitution 0", "restitution: 0.2", "restitution: 0", ["contact.restitution", ">= 1e-06"]),
    ("wrong unit", "diameter: 0.2", "diameter: 20 kg", ["discs.diameter", "20 kg", "m"]),
    ("unknown unit", "diameter: 0.2", "diameter: 20 florps", ["discs.diameter", "20 florps"]),
    ("text for a number", "restitution: 0.2", "restitution: much", ["contact.restitution", "much"]),
    ("truth for a number", "friction: 0.1", "friction: true", ["contact.friction", "true"]),
    ("number for a group", "discs: {diameter: 0.2, density: 1000}", "discs: 5", ["case.yaml:3", "discs"]),
    ("unknown word", "profile: power_law", "profile: parabolic", ["inflow.profile", "parabolic", "power_law"]),
    ("unknown kind of wall", "kind: block", "kind: ellipse", ["walls[0]", "ellipse", "block"]),
    ("no kind of wall", "kind: block, ", "", ["walls[0]", "kind"]),
    ("interval backwards", "x: [-2, 10]", "x: [10, -2]", ["walls[0].x", "low < high"]),
    ("interval of three", "x: [-2, 10]", "x: [1, 2, 3]", ["walls[0].x"]),
    (
        "two walls of one name",
        "inflow:",
        "  - {name: floor, kind: block, x: [11, 12], y: [-4, 0]}\ninflow:",
        ["walls[1].name", "floor"],
    ),
    ("bad name", "name: good", "name: ../evil", ["case.yaml:1", "name", "../evil"]),
    ("bad name of a wall", "name: floor", "name: a-b.c", ["walls[0].name", "a-b.c", "letters, digits and `_`"]),
    ("name of the inlet's wall", "name: floor", "name: inlet_back", ["walls[0].name", "behind the inlet"]),
    (
        "name of a gate",
        "walls:\n  - {name: floor",
        "initial: [{kind: column, x: [5, 6], y: [0, 2], settle: 0.1}]\nwalls:\n  - {name: gate",
        ["walls[0].name", "gate"],
    ),
    (
        "name of a box's faces",
        "walls:\n  - {name: floor",
        "walls:\n  - {name: a, kind: box, x: [-1, 9], y: [-4, 9]}\n  - {name: a_x",
        ["walls[1].name", "a_x", "box 'a'"],
    ),
    (
        "endless settling",
        "inflow:",
        "initial: [{kind: column, x: [5, 6], y: [0, 2], settle: 1e9}]\ninflow:",
        ["case.yaml:12", "initial[0].settle", "1e+09", "2e+09"],
    ),
    (
        "a column that settles while it flows",
        "inflow:",
        "initial: [{kind: column, x: [5, 6], y: [0, 2], settle: 1, velocity: [2, 0]}]\ninflow:",
        ["case.yaml:12", "initial[0]", "starts at rest; drop velocity or settle"],
    ),
    ("bins wider than the domain", "run:", "analysis: {bin_width: 22}\nrun:", ["analysis.bin_width", "22", "21 m"]),
    ("zero rows", "depth: 1.0", "depth: 0.1", ["inflow.depth", "0.1", "one diameter"]),
    ("inlet in a wall", "y: [-4, 0]", "y: [-4, 0.5]", ["inflow", "row 1", "floor"]),
    ("inlet outside", "x: 0, depth", "x: 30, depth", ["inflow", "30", "domain.x"]),
    ("outlet outside", "x_beyond: 15", "x_beyond: 25", ["outflow[0].x_beyond", "25", "domain"]),
    ("two outlets in one", "{x_beyond: 15}", "{x_beyond: 15, x_before: 1}", ["outflow[0]", "exactly one"]),
    (
        "no discs at all",
        "inflow: {kind: rows, x: 0, depth: 1.0, mean_speed: 16, profile: power_law}\n",
        "",
        ["no discs"],
    ),
    (
        "unstable step",
        "duration: 0.01",
        "duration: 0.01, time_step_fraction: 0.5",
        ["run.time_step_fraction", "0.5", "allow_unstable"],
    ),
    ("no duration", "duration: 0.01", "seed: 1", ["run.duration", "required"]),
    ("zero duration", "duration: 0.01", "duration: 0", ["run.duration", ">= 1e-09"]),
    (
        "stiffness twice",
        "largest_overlap: 0.1",
        "largest_overlap: 0.1\n  stiffness: 1e7",
        ["contact", "stiffness"],
    ),
    (
        "old word of a law",
        "largest_overlap: 0.1",
        "friction_law: hooke",
        ["case.yaml:7: contact.friction_law: 'hooke' is not known"],
    ),
    (
        "old word of the overlap",
        "largest_overlap: 0.1",
        "penetration_fraction: 10",
        ["case.yaml:7: contact.penetration_fraction: unknown field; write contact.largest_overlap"],
    ),
    ("no stiffness", "  largest_overlap: 0.1\n  impact_speed: 16\n", "", ["contact", "impact_speed"]),
    ("unknown probe", "run:", "probes: {forces: [flor]}\nrun:", ["probes.forces[0]", "flor", "did you mean 'floor'"]),
    (
        "scheme of the other engine",
        "duration: 0.01",
        "duration: 0.01, integrator: leapfrog_extrapolated",
        ["run.integrator", "native"],
    ),
    (
        "law not in stock LAMMPS",
        "  friction: 0.1",
        "  friction: 0.1\n  friction_law: sign",
        ["contact.friction_law", "viscous"],
    ),
    ("half a rank", "run:", "engine: {ranks: 0}\nrun:", ["engine.ranks", "0"]),
    ("tabs", "  restitution: 0.2", "\trestitution: 0.2", ["case.yaml:5", "not YAML"]),
    ("a list", GOOD, "- 1\n- 2\n", ["case.yaml:1", "mapping"]),
    ("empty", GOOD, "", ["case.yaml", "empty"]),
    (
        "overlapping discs",
        "inflow:",
        "initial: [{kind: list, positions: [[1, 1], [1.05, 1]]}]\ninflow:",
        ["initial", "overlap", "d/n"],
    ),
    ("disc in a wall", "inflow:", "initial: [{kind: list, positions: [[1, -1]]}]\ninflow:", ["walls[0]", "floor"]),
    ("disc outside", "inflow:", "initial: [{kind: list, positions: [[50, 1]]}]\ninflow:", ["domain", "50"]),
    (
        "column too thin",
        "inflow:",
        "initial: [{kind: column, x: [5, 5.1], y: [0, 3]}]\ninflow:",
        ["initial[0]", "not one disc"],
    ),
    (
        "speeds for too few",
        "inflow:",
        "initial: [{kind: list, positions: [[1, 1], [2, 2]], velocities: [[0, 0]]}]\ninflow:",
        ["initial[0]"],
    ),
]


# far too small or large for any calculation, or a truth where a number belongs: (assignment, what the message names)
ABSURD = [
    ("gravity=1e-300", ["gravity", "0 for none"]),
    ("gravity=1e300", ["gravity", "<= 1e+06"]),
    ("discs.diameter=1e-300", ["discs.diameter", ">= 1e-06"]),
    ("discs.diameter=1e300", ["discs.diameter", "<= 1e+06"]),
    ("discs.diameter=1e-9", ["discs.diameter", ">= 1e-06"]),
    ("discs.diameter=1e-6", ["inflow.depth", "rows", "10000"]),
    ("discs.density=1e300", ["discs.density", "<= 1e+06"]),
    ("contact.largest_overlap=1e300", ["contact.largest_overlap", "<= 1"]),
    ("contact.impact_speed=1e300", ["contact.impact_speed", "<= 1e+06"]),
    ("contact.impact_speed=1e-300", ["contact.impact_speed", ">= 1e-06"]),
    ("inflow.mean_speed=1e300", ["inflow.mean_speed", "<= 1e+06"]),
    ("inflow.mean_speed=1e-300", ["inflow.mean_speed", ">= 1e-06"]),
    ("inflow.mean_speed=1e-6", ["inflow.mean_speed", "steps", "2e+09"]),
    ("inflow.depth=1e9", ["inflow.depth", "<= 1e+06"]),
    ("inflow.depth=1e6", ["inflow.depth", "5500000 rows"]),
    ("inflow.x=1e300", ["inflow.x", "<= 1"]),
    ("domain.x=[-1,1e300]", ["domain.x", "<= 1"]),
    ("domain={x: [-1e6, 1e6], y: [-1e6, 1e6]}", ["domain", "1e+14 discs", "5e+08"]),
    ("initial=[{kind: lattice, nx: 1000000000, ny: 1, spacing: 1, origin: [0, 0]}]", ["initial", "1000000000 discs"]),
    ("initial=[{kind: lattice, nx: 1, ny: 1000000000, spacing: 1, origin: [0, 0]}]", ["initial", "1000000000 discs"]),
    ("initial=[{kind: column, x: [0, 1e6], y: [0, 1e6]}]", ["initial", "25000000000000 discs"]),
    ("initial=[{kind: lattice, nx: 400, ny: 400, spacing: 1e-6, origin: [1, 1]}]", ["initial", "overlap"]),
    ("initial=[{kind: column, x: [1, 1.3], y: [1, 1e5]}]", ["initial", "its own weight"]),
    (
        "run={duration: 2, output_interval: 1e-6, time_step_fraction: 1e-3}",
        ["run.output_interval", "frames; allowed are 1000000"],
    ),
    ("run.duration=1e300", ["run.duration", "<= 1e+09"]),
    ("run.time_step_fraction=1e-300", ["run.time_step_fraction", ">= 1e-06"]),
    ("run.seed=true", ["run.seed", "true", "whole number"]),
    ("engine.ranks=true", ["engine.ranks", "true", "whole number"]),
    ("initial=[{kind: lattice, nx: true, ny: 1, spacing: 1, origin: [0, 0]}]", ["initial[0].nx", "whole number"]),
    ("initial=[{kind: lattice, nx: 1, ny: true, spacing: 1, origin: [0, 0]}]", ["initial[0].ny", "whole number"]),
]

POUR = "inflow: {kind: pour, x: [1, 3], y: [5, 7], count: 20}"

WRONG_POURS = [
    ("no gravity", "gravity: 9.81", "gravity: 0", ["case.yaml:2: gravity", "fall", "> 0"]),
    ("slope", "gravity: 9.81", "gravity: 9.81\nslope: 5", ["case.yaml:3: slope", "5", "straight down"]),
    ("thin in x", "x: [1, 3]", "x: [1, 1.1]", ["inflow.x", "0.1 m", "0.2 m", "widen"]),
    ("thin in y", "y: [5, 7]", "y: [5, 5.1]", ["inflow.y", "0.1 m", "0.2 m", "widen"]),
    ("outside in x", "x: [1, 3]", "x: [1, 30]", ["inflow.x", "domain", "[-1, 20]"]),
    ("outside in y", "y: [5, 7]", "y: [-50, 7]", ["inflow.y", "domain", "[-5, 10]"]),
    ("holds no disc", "count: 20", "count: 20, volume_fraction: 1e-3", ["inflow.volume_fraction", "one disc"]),
]


def attempt(monkeypatch, capsys, folder: Path, *arguments: str) -> tuple[int, str]:
    """Run the command line in `folder`; exit status and what went to stderr."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["lammps-jump", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    captured = capsys.readouterr()
    return int(stop.value.code or 0), captured.err


def refused(what: str, named: list[str], status: int, message: str) -> None:
    """Exit status 2 and one paragraph that holds these texts; `what` is told where that is not so."""
    assert status == 2 and message.count("\n") == 1 and "Traceback" not in message, (what, message)
    assert [text for text in named if text not in message] == [], (what, message)


def test_wrong_cases_are_refused(monkeypatch, capsys, tmp_path):
    for what, old, new, named in WRONG_CASES:
        assert old in GOOD
        (tmp_path / "case.yaml").write_text(GOOD.replace(old, new, 1))
        extra = ["--kernel", "stock"] if "sign" in new else []
        refused(what, named, *attempt(monkeypatch, capsys, tmp_path, "build-and-run", "case.yaml", *extra))
        assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"], f"nothing may be written: {what}"


def test_absurd_numbers_are_refused(monkeypatch, capsys, tmp_path):
    (tmp_path / "case.yaml").write_text(GOOD)
    for assignment, named in ABSURD:
        refused(assignment, named, *attempt(monkeypatch, capsys, tmp_path, "check", "case.yaml", "--set", assignment))


def test_wrong_pours_are_refused(monkeypatch, capsys, tmp_path):
    inflow = next(line for line in GOOD.splitlines() if line.startswith("inflow"))
    good = GOOD.replace(inflow, POUR)
    parse_case(good).scene()
    for what, old, new, named in WRONG_POURS:
        assert old in good
        (tmp_path / "case.yaml").write_text(good.replace(old, new, 1))
        refused(what, named, *attempt(monkeypatch, capsys, tmp_path, "check", "case.yaml"))


WRONG_ASSIGNMENTS = [
    ("contact.friction_law=hooke", ["--set contact.friction_law=hooke", "is not known"]),
    ("contact.penetration_fraction=20", ["write contact.largest_overlap"]),
    ("contact.frction=0", ["--set contact.frction=0", "did you mean 'friction'"]),
    ("contact.friction", ["path=value"]),
    ("walls.sill.y=[-10,3]", ["walls", "no item 'sill'", "floor"]),
    ("name.x=1", ["single value"]),
    ("contact.friction=[", ["not YAML"]),
    ("walls.²=1", ["walls", "no item '²'", "floor"]),
    ("walls.99999999999999999999=1", ["walls", "no item", "floor"]),
    ("discs=&a {diameter: *a}", ["--set discs=&a {diameter: *a}", "alias"]),
    ("discs=" + 3000 * "[", ["--set discs=[", "deep"]),
    ("contact.friction=-1", ["--set contact.friction=-1", ">= 0"]),
    ("walls.floor.motion={kind: translate, velocity: [1, 0], begin: 5}", ["begin", "unknown field"]),
    ("walls.floor.motion={kind: rotate, rate: 1, amplitude: [1, 0]}", ["motion.amplitude: unknown field; known here"]),
]


def test_wrong_assignments_are_refused(monkeypatch, capsys, tmp_path):
    (tmp_path / "case.yaml").write_text(GOOD)
    for assignment, named in WRONG_ASSIGNMENTS:
        words = ("build-and-run", "case.yaml", "--set", assignment)
        refused(assignment, named, *attempt(monkeypatch, capsys, tmp_path, *words))
        assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"], assignment


BOMB = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"a{i}: &a{i} [{', '.join(10 * [f'*a{i - 1}'])}]\n" for i in range(1, 10)
)


@pytest.mark.parametrize(
    "text, named",
    [
        ("name: a\ndiscs: &a {diameter: *a}\n", ["case.yaml:2", "alias"]),
        ("name: a\ndiscs: &a [*a, *a]\n", ["case.yaml:2", "alias"]),
        ("name: a\n\ndiscs: " + 3000 * "[" + 3000 * "]", ["case.yaml:3", "deep"]),
        ("discs: " + 3000 * "{a: ", ["case.yaml:1", "deep"]),
        (BOMB, ["case.yaml:", "300,000 values", "aliases"]),
        ("a0: &a0 [1]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 3000)), ["case.yaml:", "deep"]),
        ("name: !!bool maybe\n", ["case.yaml:1", "name"]),
        ("name: !!int ''\n", ["case.yaml:1", "name"]),
    ],
    ids=["self", "self twice", "brackets", "braces", "aliases of aliases", "chain of aliases", "no truth", "no number"],
)
def test_yaml_that_does_not_end_is_refused(monkeypatch, capsys, tmp_path, text, named):
    (tmp_path / "case.yaml").write_text(text)
    status, message = attempt(monkeypatch, capsys, tmp_path, "check", "case.yaml")
    assert status == 2 and len(message) < 500, message
    for word in named:
        assert word in message


def test_files_that_are_no_case(monkeypatch, capsys, tmp_path):
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    (tmp_path / "nul.yaml").write_bytes(b"name: a\x00b\n")
    (tmp_path / "folder.yaml").mkdir()
    for name, words in [
        ("binary.yaml", "not text"),
        ("nul.yaml", "binary"),
        ("folder.yaml", "is a folder"),
        ("absent.yaml", "no such case file"),
    ]:
        status, message = attempt(monkeypatch, capsys, tmp_path, "build-and-run", name)
        assert status == 2 and name in message and words in message


def test_folder_that_cannot_be_written(monkeypatch, capsys, tmp_path):
    (tmp_path / "case.yaml").write_text(GOOD)
    (tmp_path / "occupied").write_text("a file stands where the folder should be")
    status, message = attempt(
        monkeypatch,
        capsys,
        tmp_path,
        "build-and-run",
        "case.yaml",
        "--out",
        "occupied/run",
        "--kernel",
        "stock",
        "--quiet",
    )
    assert status == 2 and "occupied/run" in message and "--out" in message


def test_things_that_are_no_dump(monkeypatch, capsys, tmp_path):
    (tmp_path / "words.txt").write_text("this is not a dump\n")
    (tmp_path / "empty.lammpstrj").write_text("")
    (tmp_path / "zip.gz").write_bytes(gzip.compress(b"still not a dump\n"))
    (tmp_path / "nothing_here").mkdir()
    for name in ("words.txt", "empty.lammpstrj", "zip.gz", "nothing_here", "absent"):
        status, message = attempt(monkeypatch, capsys, tmp_path, "analyze", name)
        assert status == 2 and name in message, message
    assert not list(tmp_path.glob("*_analysis"))


def test_unknown_scene_names_the_nearest(monkeypatch, capsys, tmp_path):
    status, message = attempt(monkeypatch, capsys, tmp_path, "new", "dam_brake")
    assert status == 2 and "dam_break" in message


@pytest.mark.parametrize("command", ["build-and-run", "build", "check"])
def test_bin_wider_than_the_domain(monkeypatch, capsys, tmp_path, command):
    (tmp_path / "case.yaml").write_text(GOOD + "analysis: {bin_width: 22}\n")
    status, message = attempt(monkeypatch, capsys, tmp_path, command, "case.yaml")
    assert status == 2 and "analysis.bin_width" in message and "22 m" in message and "21 m" in message
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


@pytest.mark.parametrize("command", ["build-and-run", "build", "bench", "cross-validate"])
def test_out_without_a_name(monkeypatch, capsys, tmp_path, command):
    (tmp_path / "case.yaml").write_text(GOOD)
    status, message = attempt(monkeypatch, capsys, tmp_path, command, "case.yaml", "--out", "")
    assert status == 2 and "--out is empty" in message
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


@pytest.mark.parametrize(
    "arguments",
    [("bench", "case.yaml", "--members", "0"), ("bench", "case.yaml", "--members", "-3"), ("stress", "--random", "-1"),
     ("stress", "--seed", "-1"), ("sensitivity", "--only", ""), ("bench", "case.yaml", "--axes", ",")],
)  # fmt: skip
def test_counts_of_studies(monkeypatch, capsys, tmp_path, arguments):
    (tmp_path / "case.yaml").write_text(GOOD)
    status, message = attempt(monkeypatch, capsys, tmp_path, *arguments)
    assert status == 2 and arguments[-2] in message and "Traceback" not in message
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


def test_unknown_option_is_a_usage_error(monkeypatch, capsys, tmp_path):
    status, message = attempt(monkeypatch, capsys, tmp_path, "check", "--bogus")
    assert status == 2 and "bogus" in message


def test_dump_with_a_nan_is_refused_with_step_and_row(monkeypatch, capsys, tmp_path):
    rows = "1 0 0 0 0\n2 nan 1 0 0\n"
    (tmp_path / "bad.lammpstrj").write_text(
        "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff pp\n0 2\n0 2\n-1 1\n"
        f"ITEM: ATOMS id x y vx vy\n{rows}"
    )
    for extra in ([], ["--diameter", "0.1"]):
        status, message = attempt(monkeypatch, capsys, tmp_path, "analyze", "bad.lammpstrj", *extra)
        assert status == 2 and "step 7" in message and "nan" in message and "Traceback" not in message
    assert [path.name for path in tmp_path.iterdir()] == ["bad.lammpstrj"]
