# SPDX-License-Identifier: GPL-2.0-or-later
"""Store the results of the program, and compare them with later ones: rearranged code must give the same results.

    python tests/same_results.py store FOLDER                      # before; about three minutes on one core
    python tests/same_results.py compare FOLDER                    # after; exit status 1 where something differs
    python tests/same_results.py compare FOLDER --only quick_jump  # only the entries whose name holds this text

The program is the ``lammps-jump`` beside this Python; ``--program "path/to/lammps-jump"`` names another one.
It runs in a temporary folder, as a user runs it. There is an entry for every file of ``inputs/`` (shortened) on each of
stock LAMMPS, the plugin and the native engine. Further entries hold the other commands and short forms of the studies.
FOLDER keeps the files of each entry, and in ``screen/`` what each command printed. `MASKED_KEYS` and `MASKED_TEXT`
apply in the comparison only, so they can change without storing again. Three kinds of difference are listed:

- ``number``: a number, a name (text without a space), a key, a unit, a file, or a line of a script. The largest
  difference is relative to the largest value of its array. Where an array first differs is given in per cent of its
  values, which mostly is the share of time. Rounding that collisions amplify starts late and near 1e-16.
  Numbers in free text (screen, report) have no order here: the output lists those that are gone and those that are new.
- ``words``: other text: messages, warnings, descriptions, ``long_name``, comments. ``--numbers-only`` ignores it.
- ``picture``: the bytes of a PNG. ``--numbers-only`` ignores it, because pictures hold words.

Enter an intended difference in `ALLOWED`, with its reason. pytest does not collect this file.
"""

from __future__ import annotations

import argparse
import csv
import difflib
import gzip
import html
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
import xarray as xr

ALLOWED: dict[str, str] = {
    "wave_structure.*/run/summary.json:force.reflected_wave.bore_*": "scipy's brentq: the last bit of the root",
    "*/run/summary.json:force.identity.*": "friction at walls takes the gamma_t of walls; it took that of pairs",
    "*/summary.json:jump.* is new": "every key of a quantity is there, null where it was not measured",
    "*/summary.json:front.* is new": "every key of a quantity is there, null where it was not measured",
    "*/summary.json:energy.* is new": "every key of a quantity is there, null where it was not measured",
    "*/summary.json:force.* is new": "every key of a quantity is there, null where it was not measured",
    "*/summary.json:key": "a hash of the case and of versions",
    "*/summary.json:key is new": "the same",
    "*/summary.json:files.*": "order of the names: tables and figures in the order of the report",
    "texts/screen/00_schema.out:$defs.Block*": "definitions of walls are named after the walls: Plane, Block, Box",
    "texts/screen/00_schema.out:$defs.Box*": "the same",
    "texts/screen/00_schema.out:$defs.Plane*": "the same",
    "texts/screen/00_schema.out:properties.walls.items.*": "the same",
    "sign_law.stock/screen/*.err:*": "one sentence for all friction laws; it named an equation of the thesis",
    "cross-validate/run/members/*": "members are named after a hash of the code that makes their numbers",
    "cross-validate/run/members.json": "members are run folders now",
    "cross-validate/run/figures/*_differences.png:*": "differences are figures of their own",
    "*/run/runs/*": "runs of a study, under a hash of versions",
    "*.json:pieces*": "runs of a study are folders, not pieces of its file",
    "sensitivity/run/*.yaml*": "the study makes its cases in memory; no file is left",
}
"""Pattern (for `fnmatch`) of ``entry/file:path``, or of that with what is told of it -> why it is intended."""

MASKED_KEYS = {
    "versions": "versions of the program and its libraries; no result",
    "seconds|wall_seconds|cpu_seconds|analysis_seconds": "clock: how long a run and its parts took",
    "breakdown|breakdown_seconds": "clock: how long the parts of an engine took",
    "disc_steps_per_second": "clock: speed",
    "outputs|analysed": "checksums of files that are compared themselves",
}
"""Keys of JSON files that are left out -> reason."""
MASKED_TEXT = {
    ("*", r"^time: .*$"): "clock: seconds and speed, on the screen",
    ("*", r"[\d.]+ s of computing"): "clock: a stored result tells how long it took; so does the page of a study",
    ("*", r"^.*\d s left$"): "clock: a line of progress appears after some seconds, on the screen",
    ("*.html", r"^ *(Wall time|Disc-steps per second).*$"): "clock: rows of the report",
    ("*.html", r"^ *SHA-256 of log\.lammps.*$"): "clock: the log of LAMMPS tells how long it took",
    ("cross-validate/*", r"(?<=, member \d: )[\d.]+ s"): "clock: how long a member took",
    ("sensitivity/*", r"[\d.]+ \|$"): "clock: the table's last column is processor time",
    ("*.html", r"^ *Version of .*$|versions: [^;]*"): "versions of the program and its libraries; no result",
    ("*", r"lammps-jump \d[\w.]*"): "version of the program, in the head of a script",
    ("*", r"\S+/\w+\.so\b"): "path of the plugin: the cache's folder and a hash of the plugin's source",
}
"""(Pattern of ``entry/file``, regular expression) that is taken out of text -> reason."""

INPUTS = Path(__file__).resolve().parents[1] / "inputs"
ENGINES = {"stock": ["--kernel", "stock"], "plugin": ["--kernel", "compiled"], "native": ["--engine", "native"]}
JET = "run.time_step_fraction=0.1; analysis.window"
POUR = "initial=[]; analysis.window=null; inflow={kind: pour, x: [1, 5], y: [1, 4], count: 100}"
SIGN = "contact.friction_law=sign; contact.friction=0.3; contact.rotation=true; contact.touch=smooth"
SHORT = "run.duration=0.2"  # for a file of inputs/ that is not in RUNS
RUNS = {  # name: (file of inputs/, changes). The times are just long enough for jump, front and reflected wave.
    "column_collapse": ("column_collapse", "run.duration=0.5; initial.0.settle=0.1; analysis.fields=true"),
    "dam_break": ("dam_break", "run.duration=2"),
    "energy_box_16": ("energy_box_16", "run.duration=10"),
    "energy_box_7": ("energy_box_7", "run.duration=10"),
    "hydraulic_jump": ("hydraulic_jump", f"run.duration=6; {JET}=[4, 6]"),
    "hydraulic_jump_frictionless": ("hydraulic_jump_frictionless", f"run.duration=8; {JET}=[6, 8]"),
    "quick_jump": ("quick_jump", "run.duration=6"),
    "wave_structure": ("wave_structure", "run.duration=5; initial.0.settle=0.3"),
    # what no file of inputs/ uses; stock LAMMPS refuses the first; the last ends with exit status 1
    "sign_law": ("dam_break", f"run.duration=0.2; slope=2; run.dump_format=binary; {SIGN}"),
    "pour": (
        "quick_jump",
        f"run.duration=2; run.dump_format=gz; outflow=[{{x_beyond: 25}}, {{x_before: -0.5}}]; {POUR}",
    ),
    "lost_disc": ("quick_jump", f"run.duration=1; {POUR}"),
}
WRONG_VALUES = (
    "contact.frction=0.1; contact.restitution=2; contact.restitution=high; walls.sil.y=[0, 1]; probes.forces=[weir]; "
    "discs.diameter=2 kg; run.time_step_fraction=0.9; analysis.bin_width=1000; analysis.window=[8, 7]; engine.ranks=0; "
    "outflow=[{}]; walls.floor.kind=circle; no assignment"
)
WRONG_COMMANDS = (
    "check mistake.yaml; check nothing.yaml; check inputs; check inputs/quick_jump.yaml --kernel fast; new dam_brake; "
    "check inputs/quick_jump.yaml --accuracy high; run nothing; analyze nothing; analyze mistake.yaml; wander"
)
STUDIES = (
    "cross-validate inputs/energy_box_7.yaml --set run.duration=5",
    "stress --random 2",
    "sensitivity",
)
MISTAKE = "discs: {diameter: 0.2}\ncontact:\n  restitution: 0.5\n  frction: 0.1\nrun: {duration: 1, seed: none}\n"


def entries() -> dict[str, list[list[str]]]:
    """Name of an entry -> the commands of the program that run for it, one after another in one folder."""
    scenes = {
        path.stem: (path.stem, SHORT)
        for path in sorted(path for path in INPUTS.glob("*.yaml") if "kind: run" not in path.read_text())
    }
    found = {}
    for name, (scene, changes) in {**scenes, **RUNS}.items():
        for engine, options in ENGINES.items():
            case = [f"inputs/{scene}.yaml", *options, *changed(changes)]
            whole = ["build-and-run", *case, "--ranks", "1", "--out", "run"]
            found[f"{name}.{engine}"] = [["check", *case], ["check", *case, "--json"], whole]
    jump, dump = "inputs/quick_jump.yaml", "run/dump.lammpstrj"
    brief = [jump, "--kernel", "stock", "--ranks", "1", *changed("run.duration=5"), "--out"]
    found["mistakes"] = [["check", jump, "--set", value] for value in WRONG_VALUES.split("; ")]
    found["mistakes"] += [command.split() for command in WRONG_COMMANDS.split("; ")]
    found["texts"] = [["schema"], ["new"], *(["new", name] for name in scenes)]
    found["texts"] += [["check", f"inputs/{name}.yaml", "--accuracy", "1%"] for name in scenes]
    found["analyze"] = [
        ["build", *brief, "built", "--slurm"],
        ["build", *brief, "run"],
        ["run", "run"],
        ["build-and-run", *brief, "run"],  # the result is there already
        ["analyze", dump, "--out", "bare"],
        ["analyze", dump, "--out", "told", "--diameter", "0.15", "--density", "900", "--bin-width", "1"],
        ["analyze", dump, "--out", "cased", "--case", jump, *changed("analysis.window=[3, 5]")],
        ["analyze", "run", "--bin-width", "1"],
    ]
    return found | {study.split()[0]: [[*study.split(), "--quick", "--out", "run"]] for study in STUDIES}


def changed(changes: str) -> list[str]:
    """Options that change values of a case."""
    return [word for change in changes.split("; ") for word in ("--set", change)]


def run_entry(program: list[str], commands: list[list[str]], folder: Path) -> None:
    """Run the commands in a folder; leave there what they write, and what they print in ``screen/``."""
    shutil.copytree(INPUTS, folder / "inputs")
    (folder / "mistake.yaml").write_text(MISTAKE)
    (folder / "screen").mkdir()
    one = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    environment = {**os.environ, **one, "MPLBACKEND": "Agg", "COLUMNS": "120", "NO_COLOR": "1", "TERM": "dumb"}
    for number, words in enumerate(commands):
        done = subprocess.run(
            [*program, *words], cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True
        )
        name = folder / "screen" / f"{number:02d}_{words[0]}"
        name.with_suffix(".out").write_text(done.stdout.replace(str(folder), "FOLDER"))
        errors = f"exit status {done.returncode}\n{done.stderr}"
        name.with_suffix(".err").write_text(errors.replace(str(folder), "FOLDER"))
    shutil.rmtree(folder / "inputs")


class Words(str):
    """Text that may be reworded without a change of results."""


class Picture(bytes):
    """A picture, as its file."""


NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?", re.IGNORECASE)


def leaves(path: Path, name: str) -> dict[str, object]:
    """Path inside a file -> number, array, name (str, all of which must stay), `Words` or `Picture`."""
    kind, data = path.suffix, path.read_bytes()
    if kind == ".gz":
        kind, data = path.with_suffix("").suffix, gzip.decompress(data)
    if kind == ".png":
        return {"": Picture(data)}
    if kind in (".nc", ".npz"):
        return arrays(path)
    if kind == ".lammpsbin":
        return {"": np.frombuffer(data, dtype=np.uint8)}  # byte by byte: says where, not how much
    text = data.decode().replace("\N{MINUS SIGN}", "-")
    if kind == ".csv":
        head, *rows = csv.reader(text.splitlines())
        columns = zip(*rows, strict=True) if rows else [[]] * len(head)
        return {"columns": " ".join(head), **{key: column(cells) for key, cells in zip(head, columns, strict=True)}}
    if kind == ".lammpstrj":
        return dump_columns(text)
    if kind in (".json", ".out") and text.startswith(("{", "[")):
        return flat(json.loads(text))
    if path.name == "log.lammps":  # rows of thermo output; the rest is in.lammps and clock
        text = "\n".join(line for line in text.splitlines() if re.fullmatch(r"[-+.\de\s]+", line))
    text = masked(page_text(text) if kind == ".html" else text, name)
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if kind in (".lammps", ".data", ".mol", ".yaml", ".slurm"):
        comments = Words("\n".join(line for line in lines if line.startswith("# ")))
        return {"": "\n".join(line for line in lines if not line.startswith("# ")), "comments": comments}
    return {"": Words("\n".join(lines)), "numbers": Counter(NUMBER.findall(text))}


def page_text(page: str) -> str:
    """What a reader of a page sees, a line for each row or paragraph; <pre> holds case.yaml and summary.json."""
    text = re.sub(r"(?s)<style.*?</style>|<script.*?</script>|<pre.*?</pre>", "", page)
    text = re.sub(r"</(tr|p|h\d|div|li|table|figcaption|summary)>|<br>", "\n", text)
    return re.sub(r"(?<=\d)[\u2009\u202f\u00a0](?=\d{3})", "", html.unescape(re.sub(r"<[^>]+>", " ", text)))


def masked(text: str, name: str) -> str:
    """Text of an ``entry/file`` without clock, versions and paths."""
    for (pattern, taken_out), _ in MASKED_TEXT.items():
        if fnmatch(name, pattern):
            text = re.sub(taken_out, "", text, flags=re.MULTILINE)
    return text


def dump_columns(text: str) -> dict[str, np.ndarray]:
    """Columns of a text dump by their names, all frames one after another."""
    found = defaultdict(list)
    for item, values in re.findall(r"ITEM: (.*)\n([^I]*)", text):
        names, cells = item.split()[1:] if item.startswith("ATOMS") else [item], values.split()
        for place, name in enumerate(names):
            found[name] += cells[place :: len(names)]
    return {name: column(cells) for name, cells in found.items()}


def arrays(path: Path) -> dict[str, object]:
    """Variables of a NetCDF or npz file, with their dimensions and attributes."""
    if path.suffix == ".npz":
        with np.load(path) as file:
            return {name: file[name] for name in file.files}
    with xr.open_dataset(path, engine="scipy", decode_times=False) as file:
        found = {f"attributes.{key}": named(value) for key, value in file.attrs.items()}
        for name, variable in file.variables.items():
            found |= {name: np.asarray(variable.values), f"{name}.dimensions": " ".join(variable.dims)}
            for key, value in variable.attrs.items():
                found[f"{name}.{key}"] = value if key == "units" else named(value)
    return found


def named(value: object) -> object:
    """A text with a space is `Words`; one without stays a name."""
    return Words(value) if isinstance(value, str) and " " in value else value


def column(cells) -> np.ndarray:
    """Cells of a table as numbers, empty ones as NaN; as text where they are no numbers."""
    try:
        return np.array([cell or "nan" for cell in cells], dtype=float)
    except ValueError:
        return np.array(cells)


def flat(tree: object, path: str = "") -> dict[str, object]:
    """Leaves of a JSON tree by their path; a list of numbers is one leaf."""
    if isinstance(tree, list) and tree and all(isinstance(item, int | float) for item in tree):
        return {path: np.array(tree)}
    if not isinstance(tree, dict | list) or not tree:
        return {path: named(tree) if tree not in ({}, []) else str(tree)}
    found = {}
    for key, item in tree.items() if isinstance(tree, dict) else enumerate(tree):
        if not any(re.fullmatch(masked, str(key)) for masked in MASKED_KEYS):
            found |= flat(item, f"{path}.{key}" if path else str(key))
    return found


def difference(old: object, new: object) -> tuple[str, str] | None:
    """Kind and description of the difference of two leaves, None where they are equal."""
    if isinstance(old, str) and isinstance(new, str):
        lines = list(difflib.unified_diff(old.splitlines(), new.splitlines(), n=0, lineterm=""))[2:]
        lines = [line for line in lines if not line.startswith("@@")]
        told = "\n".join(["", *lines[:6], *([f"… {len(lines)} lines in all"] if len(lines) > 6 else [])])
        return None if old == new else ("words" if isinstance(old, Words) or isinstance(new, Words) else "number", told)
    if type(old) is not type(new):
        return "number", f"{old!r:.60} -> {new!r:.60}"
    if isinstance(old, Picture):
        return None if old == new else ("picture", "other bytes")
    if isinstance(old, Counter):
        gone, extra = (" ".join((a - b).elements()) for a, b in ((old, new), (new, old)))
        return ("number", f"gone: {gone[:200] or '-'}; new: {extra[:200] or '-'}") if gone or extra else None
    a, b = np.ravel(old), np.ravel(new)
    if np.shape(old) != np.shape(new) or a.dtype != b.dtype:
        return "number", f"{np.shape(old)} {a.dtype} -> {np.shape(new)} {b.dtype}"
    same = (a == b) | ((a != a) & (b != b))
    if same.all():
        return None
    first = int(np.argmin(same))
    if a.dtype.kind not in "uif":
        return "number", f"{a[first]} -> {b[first]}, {np.count_nonzero(~same)} of {same.size} values"
    a, b = a.astype(float), b.astype(float)
    gap = np.where(same, 0, np.nan_to_num(np.abs(a - b), nan=np.inf)) / np.nanmax(np.abs([a, b]))
    if same.size == 1:
        return "number", f"{gap.max():.1e} ({old} -> {new})"
    return "number", f"{gap.max():.1e} (first after {first / same.size:.0%} of the values: {gap[first]:.1e})"


def compare(stored: Path, folder: Path, entry: str) -> list[tuple[str, str, str]]:
    """Path, kind and description of every difference between the files of two folders."""
    old, new = (
        {str(f.relative_to(top)) for f in top.rglob("*") if f.is_file() and f.name != ".lammps-jump"}
        for top in (stored, folder)
    )
    found = [(f"{entry}/{name}:", "number", "file is gone" if name in old else "file is new") for name in old ^ new]
    for name in sorted(old & new):
        if (stored / name).read_bytes() == (folder / name).read_bytes():
            continue
        try:
            a, b = (leaves(top / name, f"{entry}/{name}") for top in (stored, folder))
        except (ValueError, OSError) as error:
            found.append((f"{entry}/{name}:", "number", f"cannot be read any more: {error}"))
            continue
        before = len(found)
        for path in {**a, **b}:
            if path not in a or path not in b:
                found.append((f"{entry}/{name}:{path}", "number", "is gone" if path in a else "is new"))
            elif told := difference(a[path], b[path]):
                found.append((f"{entry}/{name}:{path}", *told))
        if len(found) == before and name.endswith((".csv", ".lammpstrj")):
            found.append((f"{entry}/{name}:", "number", "equal values are written in another way"))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["store", "compare"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default=shlex.quote(str(Path(sys.executable).with_name("lammps-jump"))))
    parser.add_argument("--only", default="", help="part of an entry's name")
    parser.add_argument("--numbers-only", action="store_true", help="ignore words and pictures")
    arguments = parser.parse_args()
    program, failed, start = shlex.split(arguments.program), False, time.monotonic()
    subprocess.run([*program, "kernels", "build"], check=True, capture_output=True)  # not during the first entry
    chosen = {entry: commands for entry, commands in entries().items() if arguments.only in entry}
    if not chosen:
        parser.error(f"--only {arguments.only}: no entry has this in its name; there are {', '.join(entries())}")
    for entry, commands in chosen.items():
        stored = arguments.folder / entry
        with tempfile.TemporaryDirectory(prefix="same_") as temporary:
            run_entry(program, commands, Path(temporary))
            if arguments.what == "store":
                shutil.rmtree(stored, ignore_errors=True)
                shutil.copytree(temporary, stored)
                print(f"{entry}: stored", flush=True)
                continue
            found = compare(stored, Path(temporary), entry) if stored.is_dir() else [(entry, "number", "is not stored")]
        counted, lines = 0, []
        for path, kind, told in sorted(found, key=lambda one: one[1]):
            both = (path, f"{path} {told}")
            reasons = [reason for pattern, reason in ALLOWED.items() if any(fnmatch(one, pattern) for one in both)]
            if kind == "number" or not arguments.numbers_only:
                counted += not reasons
                note = f"allowed: {reasons[0]}" if reasons else told
                lines.append(f"  {kind:8}{path.removeprefix(f'{entry}/')} {note}".replace("\n", "\n          "))
        print("\n".join([f"{entry}: {f'{counted} differences' if counted else 'equal'}", *lines]), flush=True)
        failed |= counted > 0
    print(f"{time.monotonic() - start:.0f} s")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
