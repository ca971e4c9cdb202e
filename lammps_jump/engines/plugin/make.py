# SPDX-License-Identifier: GPL-2.0-or-later
"""Compiles the products, or builds wheels that carry them; `make run` and `make wheel` run it as a module.

    python -m lammps_jump.engines.plugin.make
    python -m lammps_jump.engines.plugin.make wheels [TAG…]

The first is run while the rest of the environment is installed. It imports little: the packages that `COMPILING` of the
Makefile names are enough. The second needs the source tree, and makes one wheel a system. A platform whose compiler is
missing is left out, with a reason.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from lammps_jump.compiling.build import build_all, build_for
from lammps_jump.compiling.carried import carried_folder
from lammps_jump.compiling.compiler import PLATFORMS, Platform
from lammps_jump.core.library import CORE
from lammps_jump.errors import SetupError

from .product import PLUGIN, PRODUCTS

ROOT = Path(__file__).resolve().parents[3]
COLUMNS = ("wheel", "MB", "core", "compiled styles", "engines without a compiler")


def forget_built() -> None:
    """Delete what was built for a wheel, so that no other wheel gets it."""
    for folder in (*map(carried_folder, PRODUCTS), ROOT / "build" / "lib", *ROOT.glob("build/bdist.*")):
        shutil.rmtree(folder, ignore_errors=True)


def make_wheel(platform: Platform, folder: Path) -> tuple[str, ...]:
    """Make the wheel of a platform in a folder; its row of the table.

    Raises
    ------
    SetupError
        What `build_for` raises, or pip makes no wheel.
    """
    forget_built()
    try:
        has = {}
        for product in PRODUCTS:
            has[product] = [level for level in product.levels if level in platform.levels]
            for level in has[product]:
                print(build_for(product, platform, level), flush=True)
        options = f"--config-settings=--build-option=--plat-name={platform.tag}"
        words = ("--quiet", "--no-deps", "--wheel-dir", str(folder), options, ".")
        command = [sys.executable, "-P", "-m", "pip", "wheel", *words]
        if subprocess.run(command, cwd=ROOT).returncode != 0:
            raise SetupError(f"pip made no wheel for {platform.tag}")
    finally:
        forget_built()
    wheel = max(folder.glob(f"lammps_jump-*-{platform.tag}.whl"), key=lambda path: path.stat().st_mtime)
    engines = ("native", "compiled", "stock") if has[PLUGIN] else ("native", "stock")
    lists = (", ".join(has[product]) or "-" for product in (CORE, PLUGIN))
    return wheel.name, f"{wheel.stat().st_size / 1e6:z.2f}", *lists, ", ".join(engines)


def make_wheels(tags: list[str]) -> list[str]:
    """Make the wheels of these tags, by default of all platforms that can be built for, and print what each has.

    Returns
    -------
    list of str
        Why a wheel is not there.
    """
    rows: list[tuple[str, ...]] = [COLUMNS]
    missing = []
    for platform in PLATFORMS:
        if tags and platform.tag not in tags:
            continue
        if not platform.zig and not platform.is_here:
            missing.append(f"{platform.tag}: it is made on a machine of its kind")
            continue
        try:
            rows.append(make_wheel(platform, ROOT / "dist"))
        except SetupError as error:
            missing.append(f"{platform.tag}: {error}")
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    print("\n".join(missing))
    return missing


def main(words: list[str]) -> int:
    """Do what the words of the command line ask for; the exit status."""
    if words[:1] == ["wheels"]:
        return 1 if make_wheels(words[1:]) else 0
    for found in build_all(PRODUCTS, tell=print):
        if isinstance(found, str):
            print(found)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
