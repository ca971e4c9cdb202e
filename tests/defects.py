# SPDX-License-Identifier: GPL-2.0-or-later
"""Seeded defects, and whether the tests catch them: ``python tests/defects.py``, about a quarter of an hour.

Each defect is one line of the program that is changed in a copy of the tree. The tests named beside it run first, and
all other tests of the default run where none of those fails. ``--long`` then runs the tests marked ``long`` too, for
what the default run did not catch. Numbers after the options choose defects.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
COPIED = ("lammps_jump", "analysis", "inputs", "tests", "docs", "benchmarks")
FILES = ("pyproject.toml", "Makefile", "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "LICENSE")


LIMIT = 1200
"""Seconds; ends a hang and nothing else."""


class Defect(NamedTuple):
    """A text that stands once in a file, what takes its place, and the tests (below ``tests/``) that run first."""

    kind: str
    file: str
    old: str
    new: str
    tests: str


CONTACT, JUMP, LAW = (f"lammps_jump/physics/{name}.py" for name in ("contact", "jump", "law"))
LEDGER, EVENTS, STATE = (f"lammps_jump/engines/native/{name}.py" for name in ("ledger", "events", "state"))
CORE_LAW, CORE_CONTACT, CORE_FACES, CORE_NEAR, CORE_SLOTS, CORE_MOTION, CORE_WALL = (
    f"lammps_jump/core/{name}.h"
    for name in (
        "contact/law",
        "contact/contact",
        "walls/faces",
        "walls/near",
        "contact/history",
        "walls/motion",
        "walls/wall",
    )
)
CORE_DRIFT, CORE_PAIRS, CORE_LISTS, CORE_SUMS = (
    f"lammps_jump/core/{name}.cpp" for name in ("step/integrate", "step/pair_forces", "step/lists", "sums/sums")
)
CORE_PARTITION, CORE_RELIST = "lammps_jump/core/step/thread_partition.h", "lammps_jump/core/step/relist.cpp"
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
PLUGIN_TESTS = "integration/test_compiled_kernel.py integration/test_compiled_sizes.py"
NATIVE_TESTS = "contacts/test_contacts.py engines"
MOTION, TRACKS = "lammps_jump/scene/motion.py", "lammps_jump/scene/tracks.py"
HYDROGRAPH, DEVICES = "lammps_jump/physics/hydrograph.py", "lammps_jump/physics/devices.py"
MOVING_TESTS = "contacts/test_moving_forms.py engines/test_moving_walls.py"
CHAINS, FACES, NEAR, SHAPES = (f"lammps_jump/scene/{name}.py" for name in ("chains", "faces", "near", "shapes"))
SLOTS = "lammps_jump/physics/slots.py"
SHEAR, SLOSH = (f"lammps_jump/studies/fluid/{name}.py" for name in ("shear", "slosh"))
LIST_TESTS = f"{TWIN_TESTS} engines/test_native_contacts.py engines/test_native_sizes.py"
RULE_TESTS = f"scene/test_faces.py {TWIN_TESTS}"
MOVING_PLUGIN_TESTS = "contacts/test_moving_forms.py integration/test_compiled_moving_walls.py integration/test_lids.py"

DEFECTS = [
    Defect("factor", CONTACT, "return density * (diameter * diameter)", "return density * (diameter * diameter) * 0.78",
           "physics"),
    Defect("factor", CONTACT, "return 2.0 * damping_ratio(restitution) *", "return damping_ratio(restitution) *",
           "physics"),
    Defect("sign", CONTACT, "2.0 * (sqrt(1.0 + xi * xi) - xi)\n", "2.0 * (sqrt(1.0 + xi * xi) + xi)\n", "physics"),
    Defect("power", JUMP, "1.0 + 8.0 * froude_1**2) - 1.0", "1.0 + 8.0 * froude_1) - 1.0", "physics"),
    Defect("sign", LAW, "return -bound * min(max(slip", "return bound * min(max(slip", "physics/test_law.py"),
    Defect("factor", LAW, "+ touch * touch / 3.0)", "+ touch * touch / 2.0)", "physics/test_law.py"),
    Defect("time level", CORE_DRIFT, "seen_y = 1.5 * new_y - 0.5 * old_y", "seen_y = 1.5 * new_y - 0.5 * new_y",
           TWIN_TESTS),
    Defect("sign", CORE_CONTACT, "-out.lever_b * out.tangential - rolls", "-out.lever_b * out.tangential + rolls",
           TWIN_TESTS),
    Defect("sign", CORE_PAIRS, "force(j) -= *rein", "force(j) += *rein", TWIN_TESTS),
    Defect("off by one", CORE_PARTITION, "part.first_row = reaching(s, own);", "part.first_row = own;", THREAD_TESTS),
    Defect("left out", CORE_PARTITION, "? reaching(s, part.end_row) : part.end_row;", "? part.end_row : part.end_row;",
           THREAD_TESTS),
    Defect("written twice", CORE_PAIRS, "b.slot[c] = FULL;", "b.slot[c] = memory.look(s).place();", THREAD_TESTS),
    Defect("factor", CORE_LAW, "plain * root(0.75 * overlap / width)", "plain * root(overlap / width)", TWIN_TESTS),
    Defect("factor", CORE_LAW, "0.5 * k * overlap * overlap / width", "k * overlap * overlap / width", TWIN_TESTS),
    Defect("bound", CORE_LAW, "stretch = over ? left : stretch;", "", TWIN_TESTS),
    Defect("lever", CORE_CONTACT, "way_to_middle(pair.a, out.overlap)", "pair.a", TWIN_TESTS),
    Defect("corner", CORE_FACES, "(joint == CORNER && front && !shared)", "false", TWIN_TESTS),
    Defect("joint", CORE_FACES, "if (joint == FREE || (shared && behind)", "if (joint == FREE || shared", TWIN_TESTS),
    Defect("tie", CORE_FACES, "if (c.gap < 0.0) off += TIE * radius;", "if (c.gap < 0.0) off += radius;", TWIN_TESTS),
    Defect("reach", CORE_NEAR, "return away < reach &&", "return away < 0.1 * reach &&", TWIN_TESTS),
    Defect("ends", CORE_NEAR, "- f.y1) < -margin);", "- f.y1) < margin);", TWIN_TESTS),
    Defect("partner", CORE_SLOTS, "row.partner(s) != partner ||", "row.partner(s) == 0 ||", TWIN_TESTS),
    Defect("foot", CORE_SLOTS, "return least(rest, around - rest);", "return rest;", TWIN_TESTS),
    Defect("candidates", CORE_RELIST, "add(s.x[i], s.y[i], far, low, high,", "add(s.x[i], s.y[i], far, low + 1, high,",
           TWIN_TESTS),
    Defect("pose", CORE_MOTION, "x = cx + wall.c * dx + wall.s * dy;", "x = cx + wall.c * dx - wall.s * dy;",
           TWIN_TESTS),
    Defect("kick", CORE_MOTION, "(first ? 0.5 * clock.dt : clock.dt)", "clock.dt", TWIN_TESTS),
    Defect("power", CORE_SUMS, "power -= out.torque * at_step.spin[i];", "", TWIN_TESTS),
    Defect("factor", LEDGER, "return -0.5 * scene.time_step * np", "return -1.0 * scene.time_step * np",
           "engines/test_native_ledger.py"),
    Defect("factor", LEDGER, "kinetic += 0.5 * inertia(scene)", "kinetic += 0.25 * inertia(scene)",
           "engines/test_native_ledger.py engines"),
    Defect("off by one", CORE_EVENTS, "((step - first) / every + 1) * every", "((step - first) / every + 2) * every",
           ALONE_TESTS),
    Defect("left out", CORE_EVENTS, "  s.wall_sum[wall] = {};\n", "", ALONE_TESTS),
    Defect("number", CORE_PARTITION, "  return --last;", "  return last;", ALONE_TESTS),
    Defect("off by one", EVENTS, "// self.every + 1) * self.every", "// self.every + 2) * self.every",
           "engines/test_native_inlets.py"),
    Defect("factor", EVENTS, "speed_down**2 + 2 * self.gravity", "speed_down**2 + self.gravity",
           "engines/test_native_inlets.py"),
    Defect("state lost", STATE, 'boundaries.rng.bit_generator.state = plain.random', "pass",
           "engines/test_native_resume.py"),
    Defect("state lost", STATE, 'windows.begin = plain.window_begin', "pass",
           "engines/test_native_resume.py"),
    Defect("not cut", FILES_PY, "        file.truncate(size)", "        pass", "engines/test_native_resume.py"),
    Defect("kept too little", CHECKPOINT, "kept = {*states, *(before.state if before else ())}", "kept = {*states}",
           "faults/test_power.py engines/test_checkpoint.py"),
    Defect("missing flush", FILES_PY, "        if not staged:\n            flush(new)\n", "",
           "faults/test_power.py faults/test_files.py"),
    Defect("lock", FOLDERS, "fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)\n            taken",
           "fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)\n            taken", "runs/test_lock.py"),
    Defect("another's file", FOLDERS, "set(patterns) & set(marker.files if marker else ())", "set(patterns)",
           "runs/test_ours.py runs"),
    Defect("off by one", "lammps_jump/dump/check.py", "steps // self.scene.output_steps + 1",
           "steps // self.scene.output_steps", "runs/test_complete.py"),
    Defect("tolerance", "lammps_jump/dump/check.py", "NEAR = 0.01", "NEAR = 1e12", "runs/test_complete.py"),
    Defect("digits", WRITE, "{low:.16e} {high:.16e}", "{low:.2e} {high:.2e}", "dump engines/test_native_output.py"),
    Defect("status", "lammps_jump/runs/conclude.py", 'if stored.get("status") == "complete" and (changed',
           'if stored.get("status") == "failed" and (changed', "runs/test_complete.py"),
    Defect("exit status", "lammps_jump/errors.py", "exit_status = 75", "exit_status = 1", "engines runs"),
    Defect("signal", "lammps_jump/engines/interrupts.py", "signal.SIGUSR2, signal.SIGXCPU)", "signal.SIGUSR2)",
           "engines/test_native_resume.py engines/test_interrupts.py"),
    Defect("sign", STOCK, "vector {numbers(*scene.gravity)} 0", "vector {numbers(*(-g for g in scene.gravity))} 0",
           "golden"),
    Defect("axis", STOCK, 'if outlet.axis == "x" else', 'if outlet.axis == "y" else', "golden"),
    Defect("off by one", "lammps_jump/engines/lammps/log.py", "0.5 * (previous[1] + summary.discs)",
           "0.5 * (summary.discs + summary.discs)", "runs/test_while_running.py"),
    Defect("factor", CORE_LAW, "root(0.75 * overlap", "root(0.5 * overlap", PLUGIN_TESTS),
    Defect("sign", CORE_CONTACT, "- vx * ny - at.rim;", "- vx * ny + at.rim;", PLUGIN_TESTS),
    Defect("sign", CORE_CONTACT, "at.radius - at.gap, at.nx", "at.radius - magnitude(at.gap), at.nx", PLUGIN_TESTS),
    Defect("off by one", WALLS_CPP, "update->ntimestep < wall.until;", "update->ntimestep <= wall.until;",
           PLUGIN_TESTS),
    Defect("sign", WALLS_CPP, "* out.fy - (a.y", "* out.fy + (a.y", PLUGIN_TESTS),
    Defect("sign", PAIR_CPP, "batch.spin[1][c] = omega[j];", "batch.spin[1][c] = -omega[j];", PLUGIN_TESTS),
    Defect("left out", FIX_CPP, "  if (lammps_is_stale) end_steps();\n  lammps_is_stale = false;",
           "  lammps_is_stale = false;", ARRAY_TESTS),
    Defect("left out", FIX_CPP, "others_look || step == output->next || step", "others_look || step", ARRAY_TESTS),
    Defect("left out", PAIR_CPP, "if (sizes) radii[to] = radii[from];", "", "integration/test_threads.py"),
    Defect("formula", "lammps_jump/core/analysis/circular_segment.h", "(a * std::sqrt(1.0 - a * a)",
           "(a * std::sqrt(1.0 - a)", "analysis/test_profiles.py"),
    Defect("left out", "analysis/profiles.py", "np.where(some, height / safe, np.nan) - bed",
           "np.where(some, height / safe, np.nan)", "analysis/test_profiles.py"),
    Defect("off by one", "analysis/profiles.py", "(time >= window[0] - slack)", "(time >= window[0] + slack)",
           "analysis/test_profiles.py analysis"),
    Defect("sign", "analysis/budgets/energy.py", "potential = 0.0 - mass", "potential = 0.0 + mass",
           "analysis/test_energy.py"),
    Defect("sign", "analysis/forces/impulse.py", "float(ends[a] - ends[b])", "float(ends[b] - ends[a])",
           "analysis/test_forces.py"),
    Defect("inverted", "analysis/devices/front.py", '"T": sqrt(height / base) * tau', '"T": sqrt(base / height) * tau',
           "analysis/test_front.py"),
    Defect("off by one", "analysis/statistics.py", "np.var(block, axis=0) / (n - 1)", "np.var(block, axis=0) / n",
           "analysis/test_profiles.py analysis"),
    Defect("left out", "lammps_jump/core/analysis/pairs.cpp", "UP[] = {0, 1, -1, 0, 1}", "UP[] = {0, 1, 0, 0, 1}",
           "analysis/test_contacts.py"),
    Defect("factor", "analysis/budgets/head.py", "energy = 0.5 * (u * u", "energy = 1.0 * (u * u",
           "analysis/test_budget.py"),
    Defect("rate", "analysis/report/coder.py", "ahead > 1 else -(ones >> 5)", "ahead > 1 else -(ones >> 4)",
           "analysis/test_player.py analysis"),
    Defect("off by one", "lammps_jump/sweeps/table.py", "sd = x.std(ddof=1)", "sd = x.std(ddof=0)",
           "sweeps/test_table.py"),
    Defect("quoting", QUOTING, '("=", "+", "-", "@")', '("=", "+", "-")',
           "sweeps/test_table.py faults/test_text.py"),
    Defect("quoting", QUOTING, 'return visible(text).replace("$", r"\\$")', "return visible(text)",
           "faults/test_text.py"),
    Defect("factor", PROGRESS, "* (report.steps - report.step) / here", "* report.steps / here",
           "runs/test_while_running.py"),
    Defect("sign", CORE_WALL, "{rate.x - rate.angle * (y", "{rate.x + rate.angle * (y", TWIN_TESTS),
    Defect("sign", CORE_MOTION, "y * rate.y + moment * rate.angle", "y * rate.y - moment * rate.angle", TWIN_TESTS),
    Defect("derivative", TRACKS, "3 * a * s + 6 * b * s**2, a +", "3 * a * s + 4 * b * s**2, a +",
           f"scene {MOVING_TESTS}"),
    Defect("off by one", MOTION, "if step >= self.gone:", "if step > self.gone:", f"scene {MOVING_TESTS} golden"),
    Defect("derivative", CORE_MOTION, "rate = {(wall.now.x - before.x) / dt,", "rate = {(behind.x - before.x) / dt,",
           MOVING_PLUGIN_TESTS),
    Defect("factor", CORE_MOTION, ": clock.dt) * force / load.res", ": clock.dt) * 0.5 * force / load.res",
           MOVING_PLUGIN_TESTS),
    Defect("factor", HYDROGRAPH, "+ h0 * u1 + h1 * u0 +", "+ 2 * h0 * u1 + h1 * u0 +",
           "physics/test_inlet.py case/test_inflow_table.py"),
    Defect("interpolation", "lammps_jump/case/parts/rows.py", "graph.speed((steps - settle) * dt)",
           "graph.speed(steps * dt)", "case/test_inflow_table.py"),
    Defect("interpolation", "analysis/devices/waves.py", "np.interp(place, x, row)", "row[np.searchsorted(x, place)]",
           "analysis/test_devices.py"),
    Defect("sign", "analysis/devices/drum.py", "(1.0 if rate > 0 else -1.0)", "(1.0 if rate < 0 else -1.0)",
           "analysis/test_devices.py"),
    Defect("sign", DEVICES, "/ (sinh(twice) + twice)", "/ (sinh(twice) - twice)", "analysis/test_devices.py"),
    Defect("factor", DEVICES, "(slot - BEVERLOO_K * diameter) ** 1.5", "(slot - BEVERLOO_K * diameter) ** 0.5",
           "analysis/test_devices.py"),
    Defect("pieces", CHAINS, "ceil(abs(sweep) / (0.5 * pi) - 1e-9)", "ceil(abs(sweep) / pi - 1e-9)",
           "scene/test_chains.py"),
    Defect("pose", CHAINS, "oy + py + s * dx + c * dy", "oy + py - s * dx + c * dy", "scene/test_chains.py"),
    Defect("unwrapped", CHAINS, "            phi += turns[i]\n", "", "scene/test_chains.py"),
    Defect("sign", FACES, "return INSIDE, rho - r, -dx", "return INSIDE, r - rho, -dx", RULE_TESTS),
    Defect("corner", FACES, "(joint == CORNER and front and not shared)", "False", RULE_TESTS),
    Defect("depth", FACES, "if gap >= 0.0 and gap < radius:", "if gap > 0.0 and gap < 0.5 * radius:", RULE_TESTS),
    Defect("ends", NEAR, "(py - shape[f, Y1]) < -margin", "(py - shape[f, Y1]) < margin", RULE_TESTS),
    Defect("reach", NEAR, "far = reach + sqrt(0.5) / inverse", "far = 0.5 * reach", RULE_TESTS),
    Defect("behind", NEAR, "faces.deep[wall] == 1 or gap > -reach", "gap > -reach", RULE_TESTS),
    Defect("factor", SHAPES, "0.5 * bend * bend * (sweep", "bend * bend * (sweep", "scene/test_chains.py"),
    Defect("sign", SHAPES, "(apart * apart + p * p - q * q)", "(apart * apart - p * p + q * q)",
           "scene/test_chains.py"),
    Defect("foot", SLOTS, "    slots.sigma[i, best] = foot\n", "", "physics/test_slots.py"),
    Defect("taken twice", SLOTS, "if held != partner or slots.used[i, s] == 1:", "if held != partner:",
           "physics/test_slots.py"),
    Defect("sizes", CORE_LISTS, "apart = radius ? far + radius[j] : far;", "apart = far;", LIST_TESTS),
    Defect("cells", CORE_LISTS, "last(least((int64_t) (place + reach), end))", "last(least((int64_t) place, end))",
           LIST_TESTS),
    Defect("sign", SHEAR, "-float(means[loops.SXY]) / pressure", "float(means[loops.SXY]) / pressure",
           "studies/test_fluid.py"),
    Defect("factor", SLOSH, "* pi / (8.0 * depth)", "* pi / (4.0 * depth)", "studies/test_fluid.py"),
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


class Changed:
    """A defect in the copy while the block runs; dates of files come back, so that caches stay good."""

    def __init__(self, tree: Path, defect: Defect):
        self.path, self.before = tree / defect.file, ROOT / defect.file
        text = self.path.read_text(encoding="utf-8")
        assert text.count(defect.old) == 1, (defect.file, defect.old, text.count(defect.old))
        self.text = text.replace(defect.old, defect.new)

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
