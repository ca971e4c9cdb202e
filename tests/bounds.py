# SPDX-License-Identifier: GPL-2.0-or-later
"""Do the oldest versions that pyproject.toml allows do, and the newest? `make bounds` runs it, some minutes a row.

    python tests/bounds.py                     # oldest and newest, with each Python from 3.11 to 3.14 that is here
    python tests/bounds.py --python 3.12 --resolution highest

Each row is a fresh environment with this project and its extras, resolved by uv, in which `TESTS` run. No interpreter
is fetched: one that is not here is told. The exit status is 1 where a row fails. pytest does not collect this file.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
RESOLUTIONS = {"lowest-direct": "oldest", "highest": "newest"}
EXTRAS = ("movie", "mdanalysis", "notebook", "drawings", "calibrate")
"""What users install; tools of tests and pages are the newest in all rows."""
TOOLS = ("pytest", "hypothesis", "pytest-xdist", "mpmath", "psutil")
TESTS = (
    "tests/test_units.py",
    "tests/test_files.py",
    "tests/case/test_case.py",
    "tests/drawings",
    "tests/dump/test_exports.py",
    "tests/dump/test_mdanalysis.py",
    "tests/analysis/test_profiles.py",
    "tests/analysis/test_figures.py",
    "tests/analysis/test_report.py",
    "tests/analysis/test_notebook.py",
    "tests/calibration/test_posterior.py",
    "tests/integration/test_build_and_run.py",
    "tests/integration/test_quick_jump.py",
)
"""Some of what each library is for: cases, units, tables, NetCDF, pictures, pages, drawings, posteriors, engines."""


def uv(*words: str) -> subprocess.CompletedProcess[str]:
    """Run uv, that of this environment or of the system; it fetches no interpreter."""
    found = shutil.which("uv", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}") or "uv"
    return subprocess.run([found, *words], capture_output=True, text=True, cwd=ROOT)


def interpreter(version: str) -> str:
    """Path of a Python of this version, on the path or of pyenv; empty where there is none."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    here = [shutil.which(f"python{version}"), *pyenv.glob(f"versions/{version}.*/bin/python{version}")]
    return next((str(path) for path in here if path and works(str(path), version)), "")


def works(path: str, version: str) -> bool:
    """Whether a program is a Python of this version."""
    code = "import sys; print('{}.{}'.format(*sys.version_info))"
    done = subprocess.run([path, "-c", code], capture_output=True, text=True)
    return done.stdout.strip() == version


def direct() -> set[str]:
    """Names of what pyproject.toml asks for, as uv writes them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lines = [*project["dependencies"], *(line for name in EXTRAS for line in project["optional-dependencies"][name])]
    names = (line.partition(";")[0].partition("[")[0] for line in lines)
    return {name.partition(">")[0].strip().lower().replace("_", "-") for name in names}


def row(version: str, resolution: str, tests: list[str]) -> str:
    """What came of one environment, the last line of its tests; begins with ``failed`` where one did."""
    path = interpreter(version)
    if not path:
        return "left out: no such interpreter here"
    with tempfile.TemporaryDirectory(prefix="bounds-") as place:
        python = f"{place}/bin/python"
        locked = Path(place) / "versions.txt"
        steps = [
            ("venv", "--quiet", "--no-python-downloads", "--python", path, "--allow-existing", place),
            ("pip", "compile", "--quiet", "--python", python, "--resolution", resolution, "--no-header",
             "--no-annotate", *(word for name in EXTRAS for word in ("--extra", name)), "--output-file", str(locked),
             "pyproject.toml"),
            ("pip", "install", "--quiet", "--python", python, "--requirement", str(locked), *TOOLS),
            ("pip", "install", "--quiet", "--python", python, "--no-deps", "--editable", "."),
        ]  # fmt: skip
        for step in steps:
            done = uv(*step)
            if done.returncode:
                return f"failed: uv {' '.join(step[:2])}: {done.stderr.strip()}"
        chosen = [line for line in locked.read_text().splitlines() if line.partition("==")[0] in direct()]
        print(f"{version} {resolution}: {' '.join(chosen)}", flush=True)
        # old versions of some libraries call what newer ones of others deprecate, which no user sees
        warnings = ("-o", "filterwarnings=default")
        command = [python, "-m", "pytest", "-p", "no:cacheprovider", "-n", "1", *warnings, *tests]
        done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True)
        said = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR")) or " passed" in line]
        return (
            f"{'failed: ' if done.returncode else ''}{chr(10).join(said) or done.stdout[-2000:] + done.stderr[-2000:]}"
        )


def main() -> int:
    """Run the rows, and print them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", nargs="*", default=list(PYTHONS), choices=PYTHONS)
    parser.add_argument("--resolution", nargs="*", default=list(RESOLUTIONS), choices=list(RESOLUTIONS))
    parser.add_argument("tests", nargs="*", default=list(TESTS))
    asked = parser.parse_args()
    wrong = 0
    for version in asked.python:
        for resolution in asked.resolution:
            found = row(version, resolution, asked.tests)
            wrong += found.startswith("failed")
            print(f"Python {version}, {RESOLUTIONS[resolution]}: {found}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
