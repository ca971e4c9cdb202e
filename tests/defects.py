# SPDX-License-Identifier: GPL-2.0-or-later
"""Seeded defects, and whether the tests catch them: ``python tests/defects.py``, about a quarter of an hour.

Each defect is a piece of a function that is changed in a copy of the tree. The tests named beside it run first, and
all other tests of the default run where none of those fails. ``--long`` then runs the tests marked ``long`` too, for
what the default run did not catch. Numbers after the options choose defects.
"""

from __future__ import annotations

import argparse
import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from function_sizes import spans

ROOT = Path(__file__).parents[1]
COPIED = ("lammps_jump", "analysis", "inputs", "tests", "docs", "benchmarks")
FILES = ("pyproject.toml", "Makefile", "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "LICENSE")


LIMIT = 1200
"""Seconds; ends a hang and nothing else."""


class Defect(NamedTuple):
    """A piece of a function, what takes its place, and the tests (below ``tests/``) that run first.

    Attributes
    ----------
    kind, file : str
    where : str
        The function, of Python with its classes, ``Motion.pose``; or the name that is given a value.
    old, new : str
        The least piece that occurs once there, whatever its spaces and ends of lines, and what takes its place.
    tests : str
    """

    kind: str
    file: str
    where: str
    old: str
    new: str
    tests: str


CONTACT, JUMP, LAW = (f"lammps_jump/physics/{name}.py" for name in ("contact", "jump", "law"))
LEDGER, EVENTS, STATE = (f"lammps_jump/engines/native/{name}.py" for name in ("ledger", "events", "state"))
CORE_LAW, CORE_CONTACT, CORE_FACES, CORE_MOTION, CORE_WALL = (
    f"lammps_jump/core/{name}.h"
    for name in ("contact/law", "contact/contact", "walls/faces", "walls/motion", "walls/wall")
)
CORE_DRIFT, CORE_PAIRS, CORE_LISTS, CORE_SUMS = (
    f"lammps_jump/core/{name}"
    for name in ("step/integrate.cpp", "step/pair_sums.cpp", "step/lists.cpp", "sums/sums.cpp")
)
CORE_PARTITION, CORE_SEARCH = "lammps_jump/core/step/thread_partition.h", "lammps_jump/core/step/pair_search.h"
CORE_EVENTS = "lammps_jump/core/step/events.cpp"
TWIN_TESTS = "engines/test_twin.py"
ALONE_TESTS = "engines/test_native_alone.py"
THREAD_TESTS = "engines/test_native_threads.py"
CHECKPOINT = "lammps_jump/engines/checkpoint.py"
WALLS_CPP = "lammps_jump/engines/plugin/fix_jump_step_walls.cpp"
PAIR_CPP = "lammps_jump/engines/plugin/pair_jump_disc_forces.cpp"
FIX_CPP = "lammps_jump/engines/plugin/fix_jump_step.cpp"
ARRAY_TESTS = "integration/test_compiled_arrays.py"
STOCK, WRITE = "lammps_jump/script/stock.py", "lammps_jump/dump/write.py"
FOLDERS, FILES_PY = "lammps_jump/folders.py", "lammps_jump/files.py"
QUOTING, PROGRESS = "lammps_jump/quoting.py", "lammps_jump/cli/progress.py"
PLUGIN_TESTS = "engines/test_hosts.py integration/test_compiled_kernel.py"
NATIVE_TESTS = "contacts/test_contacts.py engines"
MOTION, TRACKS = "lammps_jump/scene/motion.py", "lammps_jump/scene/tracks.py"
HYDROGRAPH, DEVICES = "lammps_jump/physics/inlet.py", "lammps_jump/physics/devices.py"
MOVING_TESTS = "contacts/test_moving_forms.py engines/test_moving_walls.py"
CHAINS, FACES, SHAPES = (f"lammps_jump/scene/{name}.py" for name in ("chains", "faces", "shapes"))
SLOTS = LAW
FLUID = "lammps_jump/studies/fluid/box.py"
LIST_TESTS = f"{TWIN_TESTS} engines/test_native_contacts.py engines/test_native_sizes.py"
RULE_TESTS = f"scene/test_faces.py {TWIN_TESTS}"
MOVING_PLUGIN_TESTS = "contacts/test_moving_forms.py engines/test_hosts.py integration/test_lids.py"

DEFECTS = [
    Defect("factor", CONTACT, "disc_mass", "diameter * diameter)", "diameter * diameter) * 0.78", "physics"),
    Defect("factor", CONTACT, "damping", "2.0 *", "", "physics"),
    Defect("sign", CONTACT, "lagged_stable_h", "* xi) -", "* xi) +", "physics"),
    Defect("power", JUMP, "belanger", "**2", "", "physics"),
    Defect("sign", LAW, "friction_force", "return -", "return", "physics/test_law.py"),
    Defect("factor", LAW, "stored_energy", "/ 3.0", "/ 2.0", "physics/test_law.py"),
    Defect("time level", CORE_DRIFT, "each_four", "* old_y", "* new_y", TWIN_TESTS),
    Defect("sign", CORE_CONTACT, "pair_contact", "out.tangential -", "out.tangential +", TWIN_TESTS),
    Defect("sign", CORE_PAIRS, "take_off", "-= *", "+= *", TWIN_TESTS),
    Defect("off by one", CORE_PARTITION, "divide", "reaching(s, own)", "own", THREAD_TESTS),
    Defect("left out", CORE_PARTITION, "divide", "reaching(s, part.end_row)", "part.end_row", THREAD_TESTS),
    Defect("seen across a cut", CORE_PAIRS, "across", "memory->see(p, touches)", "void()", THREAD_TESTS),
    Defect("factor", CORE_LAW, "force", "0.75 *", "", TWIN_TESTS),
    Defect("factor", CORE_LAW, "force", "0.5 * k", "k", TWIN_TESTS),
    Defect("bound", CORE_LAW, "slide", "stretch = over ? left : stretch;", "", TWIN_TESTS),
    Defect("lever", CORE_CONTACT, "pair_contact", "way_to_middle(pair.a, out.overlap)", "pair.a", TWIN_TESTS),
    Defect("corner", CORE_FACES, "at_end", "(joint == CORNER && front && !shared)", "false", TWIN_TESTS),
    Defect("joint", CORE_FACES, "at_end", "(shared && behind)", "shared", TWIN_TESTS),
    Defect("tie", CORE_FACES, "touching", "TIE *", "", TWIN_TESTS),
    Defect("reach", CORE_FACES, "is_near", "away <", "away < 0.1 *", TWIN_TESTS),
    Defect("ends", CORE_FACES, "is_plain", "< -", "<", TWIN_TESTS),
    Defect("partner", CORE_CONTACT, "held", "!= partner", "== 0", TWIN_TESTS),
    Defect("foot", CORE_CONTACT, "way_of", "least(rest, around - rest)", "rest", TWIN_TESTS),
    Defect("candidates", CORE_SEARCH, "list", "far, low", "far, low + 1", TWIN_TESTS),
    Defect("pose", CORE_MOTION, "inward", "+ wall.s * dy", "- wall.s * dy", TWIN_TESTS),
    Defect("kick", CORE_MOTION, "drift", "(first ? 0.5 * clock.dt : clock.dt)", "clock.dt", TWIN_TESTS),
    Defect("power", CORE_SUMS, "each_wall_contact", "power -= out.torque * at_step.spin[i];", "", TWIN_TESTS),
    Defect("factor", LEDGER, "half_work", "return -0.5", "return -1.0", "engines/test_native_ledger.py"),
    Defect("factor", LEDGER, "energy_of", "+= 0.5", "+= 0.25", "engines/test_native_ledger.py engines"),
    Defect("off by one", CORE_EVENTS, "next_of", "+ 1", "+ 2", ALONE_TESTS),
    Defect("left out", CORE_EVENTS, "take_sums", "s.wall_sum[wall] = {};", "", ALONE_TESTS),
    Defect("number", CORE_PARTITION, "next_list", "--", "", ALONE_TESTS),
    Defect("off by one", EVENTS, "InsertionSchedule.next_after", "+ 1", "+ 2", "engines/test_native_inlets.py"),
    Defect("factor", EVENTS, "PourState.places", "2 *", "", "engines/test_native_inlets.py"),
    Defect("state lost", STATE, "_loaded", "boundaries.rng.bit_generator.state = plain.random", "pass",
           "engines/test_native_resume.py"),
    Defect("state lost", STATE, "_loaded", "windows.begin = plain.window_begin", "pass",
           "engines/test_native_resume.py"),
    Defect("not cut", FILES_PY, "cut_to", "file.truncate(size)", "pass", "engines/test_native_resume.py"),
    Defect("kept too little", CHECKPOINT, "CheckpointWriter._write.kept", ", *(before.state if before else ())", "",
           "faults/test_power.py engines/test_checkpoint.py"),
    Defect("missing flush", FILES_PY, "whole", "if not staged:\n            flush(new)", "",
           "faults/test_power.py faults/test_files.py"),
    Defect("lock", FOLDERS, "_take", "lock(place)", "lock(place, shared=True)", "runs/test_lock.py"),
    Defect("another's file", FOLDERS, "clear", "& set(marker.files if marker else ())", "", "runs/test_ours.py runs"),
    Defect("off by one", "lammps_jump/dump/check.py", "FrameCheck.result.expected", "+ 1", "",
           "runs/test_complete.py"),
    Defect("tolerance", "lammps_jump/dump/check.py", "NEAR", "= 0.01", "= 1e12", "runs/test_complete.py"),
    Defect("digits", WRITE, "DumpWriter._text", "16e} {high:.16e", "2e} {high:.2e",
           "dump engines/test_native_output.py"),
    Defect("status", "lammps_jump/runs/conclude.py", "Conclusion.check", '"complete', '"failed',
           "runs/test_complete.py"),
    Defect("exit status", "lammps_jump/errors.py", "RunInterrupted.exit_status", "= 75", "= 1", "engines runs"),
    Defect("signal", "lammps_jump/engines/interrupts.py", "SIGNALS", ", signal.SIGXCPU", "",
           "engines/test_native_resume.py engines/test_interrupts.py"),
    Defect("sign", STOCK, "gravity", "*scene.gravity", "*(-g for g in scene.gravity)", "golden"),
    Defect("axis", STOCK, "outlets.extent", '"x', '"y', "golden"),
    Defect("off by one", "lammps_jump/engines/lammps/outputs.py", "read_log", "previous[1]", "summary.discs",
           "runs/test_while_running.py"),
    Defect("factor", CORE_LAW, "force", "0.75 *", "0.5 *", PLUGIN_TESTS),
    Defect("sign", CORE_CONTACT, "contact_force", "ny -", "ny +", PLUGIN_TESTS),
    Defect("sign", CORE_CONTACT, "wall_contact", "- at.gap", "- magnitude(at.gap)", PLUGIN_TESTS),
    Defect("off by one", WALLS_CPP, "FixJumpStep::take_away", "ntimestep < ", "ntimestep <= ", PLUGIN_TESTS),
    Defect("formula", WALLS_CPP, "FixJumpStep::close_window", "values[c] / steps", "values[c]", PLUGIN_TESTS),
    Defect("sign", CORE_PAIRS, "add_all", "-= push", "+= push", PLUGIN_TESTS),
    Defect("left out", FIX_CPP, "FixJumpStep::post_run", "pair->put_motion_of_step();", "{}", ARRAY_TESTS),
    Defect("left out", FIX_CPP, "FixJumpStep::is_seen_at_end", "== output->next || step", "", ARRAY_TESTS),
    Defect("left out", PAIR_CPP, "PairJumpDisc::hand_over_forces", "- s.weight_y * square", "", ARRAY_TESTS),
    Defect("formula", "lammps_jump/core/analysis/profiles.cpp", "circular_segment_area", "* a", "",
           "analysis/test_profiles.py"),
    Defect("left out", "analysis/profiles.py", "_values.values", "- bed", "", "analysis/test_profiles.py"),
    Defect("off by one", "analysis/profiles.py", "within", "] -", "] +", "analysis/test_profiles.py analysis"),
    Defect("sign", "analysis/budgets/energy.py", "EnergyLedger.add.potential", "0.0 -", "0.0 +",
           "analysis/test_energy.py"),
    Defect("sign", "analysis/forces/impulse.py", "impulse_identity", "a] - ends[b", "b] - ends[a",
           "analysis/test_forces.py"),
    Defect("inverted", "analysis/devices/front.py", "dimensionless", "height / base", "base / height",
           "analysis/test_front.py"),
    Defect("off by one", "analysis/statistics.py", "block_average", "/ (n - 1)", "/ n",
           "analysis/test_profiles.py analysis"),
    Defect("left out", "lammps_jump/core/analysis/cells.cpp", "jump_close_pairs", "-1", "0",
           "analysis/test_contacts.py"),
    Defect("factor", "analysis/budgets/head.py", "EnergyFluxes.add.energy", "= 0.5", "= 1.0",
           "analysis/test_budget.py"),
    Defect("rate", "analysis/report/frames.py", "_digits_of_each", "ones >> 5", "ones >> 4",
           "analysis/test_player.py analysis"),
    Defect("off by one", "lammps_jump/sweeps/table.py", "statistics.sd", "=1", "=0", "sweeps/test_table.py"),
    Defect("quoting", QUOTING, "csv_cell", ', "@"', "", "sweeps/test_table.py faults/test_text.py"),
    Defect("quoting", QUOTING, "figure_text", '.replace("$", r"\\$")', "", "faults/test_text.py"),
    Defect("factor", PROGRESS, "ProgressLine.__call__.left", "(report.steps - report.step)", "report.steps",
           "runs/test_while_running.py"),
    Defect("sign", CORE_WALL, "velocity", "rate.x -", "rate.x +", TWIN_TESTS),
    Defect("sign", CORE_MOTION, "power", "rate.y +", "rate.y -", TWIN_TESTS),
    Defect("derivative", TRACKS, "_way", "+ 6", "+ 4", f"scene {MOVING_TESTS}"),
    Defect("off by one", MOTION, "Motion.pose", ">=", ">", f"scene {MOVING_TESTS} golden"),
    Defect("derivative", CORE_MOTION, "follow", "wall.now.x -", "behind.x -", MOVING_PLUGIN_TESTS),
    Defect("factor", CORE_MOTION, "drift", "* force", "* 0.5 * force", MOVING_PLUGIN_TESTS),
    Defect("factor", HYDROGRAPH, "_parabola", "+ h0", "+ 2 * h0", "physics/test_inlet.py case/test_inflow_table.py"),
    Defect("interpolation", "lammps_jump/case/channel.py", "_rows_against_time.speeds", "(steps - settle)",
           "steps", "case/test_inflow_table.py"),
    Defect("interpolation", "analysis/devices/waves.py", "analyse.records", "np.interp(place, x, row)",
           "row[np.searchsorted(x, place)]", "analysis/test_devices.py"),
    Defect("sign", "analysis/devices/drum.py", "SurfaceAngles.add", "rate >", "rate <", "analysis/test_devices.py"),
    Defect("sign", DEVICES, "piston_wave_height", "+ twice", "- twice", "analysis/test_devices.py"),
    Defect("factor", DEVICES, "beverloo_number", "* 1.5", "* 0.5", "analysis/test_devices.py"),
    Defect("pieces", CHAINS, "_arc.pieces", "(0.5 * pi)", "pi", "scene/test_chains.py"),
    Defect("pose", CHAINS, "moved", "py +", "py -", "scene/test_chains.py"),
    Defect("unwrapped", CHAINS, "_chain_rows", "phi += turns[i]", "", "scene/test_chains.py"),
    Defect("sign", FACES, "_candidate", "rho - r", "r - rho", RULE_TESTS),
    Defect("corner", FACES, "_candidate", "(joint == CORNER and front and not shared)", "False", RULE_TESTS),
    Defect("depth", FACES, "touching", "= 0.0 and gap <", "0.0 and gap < 0.5 *", RULE_TESTS),
    Defect("ends", FACES, "_plain.end", "< -", "<", RULE_TESTS),
    Defect("reach", FACES, "mark_cells.far", "reach + sqrt(0.5) / inverse", "0.5 * reach", RULE_TESTS),
    Defect("behind", FACES, "list_near", "faces.deep[wall] == 1 or", "", RULE_TESTS),
    Defect("factor", SHAPES, "Path.area", "0.5 * bend", "bend", "scene/test_chains.py"),
    Defect("sign", SHAPES, "_of_circles.along", "+ p * p -", "- p * p +", "scene/test_chains.py"),
    Defect("foot", SLOTS, "slot_of", "slots.sigma[i, best] = foot", "", "physics/test_slots.py"),
    Defect("taken twice", SLOTS, "slot_of", "or slots.used[i, s] == 1", "", "physics/test_slots.py"),
    Defect("sizes", CORE_LISTS, "add", "radius ? far + radius[j] :", "", "engines/test_native_lists.py"),
    Defect("cells", CORE_LISTS, "Span", "(place + reach)", "place", LIST_TESTS),
    Defect("sign", FLUID, "of_record", "-float", "float", "studies/test_fluid.py"),
    Defect("factor", FLUID, "coulomb_friction", "8.0 *", "4.0 *", "studies/test_fluid.py"),
]  # fmt: skip


def copy_of_tree() -> Path:
    """The tree in a folder that keeps its caches; there, ``inputs`` too is found inside ``lammps_jump``."""
    tree = ROOT / ".pytest_cache" / "defects"
    for name in COPIED:
        shutil.rmtree(tree / name, ignore_errors=True)
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"), symlinks=True)
    for name in FILES:
        shutil.copy2(ROOT / name, tree)
    (tree / "lammps_jump" / "inputs").symlink_to("../inputs")
    return tree


def fails(tree: Path, tests: list[str], *options: str) -> str:
    """The first of the tests (all where none are named) that fails, or what ended pytest; empty where all pass."""
    paths = [f"tests/{name}" for name in tests]
    command = [sys.executable, "-m", "pytest", "-x", "--tb=no", "-p", "no:cacheprovider", "-n", "0", *options, *paths]
    options_of_run = {"cwd": tree, "env": {**os.environ, "PYTHONPATH": str(tree)}, "capture_output": True}
    try:
        done = subprocess.run(command, **options_of_run, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return "pytest ended with a hang"
    if done.returncode in (0, 5):
        return ""
    lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    if not lines:
        return f"pytest ended with {done.returncode}: {done.stdout[-300:]}"
    return lines[0].split(" - ")[0].partition(" tests/")[2]


WORDS = re.compile(r"\w+(?:\.\w+)*|[^\w\s]")


def piece(text: str) -> re.Pattern[str]:
    """The words and signs of a text, with any space between them."""
    words = WORDS.findall(text)
    begin = r"(?<!\w)" if re.match(r"\w", words[0]) else ""
    end = r"(?!\w)" if re.match(r"\w", words[-1]) else ""
    return re.compile(begin + r"\s*".join(map(re.escape, words)) + end)


def named_lines(file: str, text: str) -> Iterator[tuple[str, int, int]]:
    """Functions of a file, and of Python names that are given a value, with first and last line."""
    if not file.endswith(".py"):
        yield from ((one.shape.name, one.first, one.last) for one in spans(text))
        return
    nodes: list[tuple[str, ast.AST]] = [("", ast.parse(text))]
    while nodes:
        above, node = nodes.pop()
        for inner in ast.iter_child_nodes(node):
            target = inner.targets[0] if isinstance(inner, ast.Assign) else getattr(inner, "target", None)
            name = getattr(inner, "name", "") or (target.id if isinstance(target, ast.Name) else "")
            if name and isinstance(inner, ast.stmt):
                yield f"{above}{name}", inner.lineno, inner.end_lineno or inner.lineno
            nodes.append((f"{above}{name}." if name else above, inner))


def places(defect: Defect, text: str) -> list[tuple[int, int]]:
    """Where in the text of its file the piece of a defect occurs; once, in a defect of today."""
    begins = [0, *(found.end() for found in re.finditer("\n", text))]
    ends = [*begins[1:], len(text)]
    return [
        found.span()
        for name, first, last in named_lines(defect.file, text)
        if name == defect.where
        for found in piece(defect.old).finditer(text, begins[first - 1], ends[last - 1])
    ]


class Changed:
    """A defect in the copy while the block runs; dates of files come back, so that caches stay good."""

    def __init__(self, tree: Path, defect: Defect):
        self.path, self.before = tree / defect.file, ROOT / defect.file
        text = self.path.read_text(encoding="utf-8")
        found = places(defect, text)
        assert len(found) == 1, (defect.file, defect.where, defect.old, len(found))
        ((begin, end),) = found
        self.text = text[:begin] + defect.new + text[end:]

    def __enter__(self) -> None:
        self.path.write_text(self.text, encoding="utf-8")

    def __exit__(self, *error: object) -> None:
        shutil.copy2(self.before, self.path)


def verdict(tree: Path, defect: Defect, options: argparse.Namespace) -> str:
    """How a defect was caught, in words; empty where it was not."""
    with Changed(tree, defect):
        found = fails(tree, defect.tests.split())
        if not (found or options.first):
            found = fails(tree, [], "-n", "2")
        if found or not options.long:
            return found
        return f"long: {found}" if (found := fails(tree, [], "-n", "2", "-m", "long")) else ""


def main() -> int:
    """Print a line a defect, and the share that is caught; the status is 1 below 95 %."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", action="store_true", help="only the tests that are named beside the defect")
    parser.add_argument("--long", action="store_true", help="also the long tests, where no other fails")
    parser.add_argument("numbers", nargs="*", type=int)
    options = parser.parse_args()
    chosen = options.numbers or range(1, len(DEFECTS) + 1)
    tree, caught, long = copy_of_tree(), [], 0
    for k in chosen:
        defect = DEFECTS[k - 1]
        found = verdict(tree, defect, options)
        print(f"{k:3} {defect.kind:15} {defect.file:52} {found or 'NOT CAUGHT'}", flush=True)
        if found.startswith("long"):
            long += 1
        elif found:
            caught.append(found)
    if broken := fails(tree, [name for name in dict.fromkeys(caught) if not name.startswith("pytest ended")]):
        sys.exit(f"this fails without a defect: {broken}")
    print(f"{len(caught)} of {len(chosen)} caught by the default run, {long} more by the long one")
    return 0 if len(caught) >= 0.95 * (len(caught) + long) else 1


if __name__ == "__main__":
    sys.exit(main())
