# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin as a product of `lammps_jump.compiling`: its sources, and the wheels whose headers it includes."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from lammps_jump.compiling import Product, Wheel, library_path
from lammps_jump.compiling import availability as availability_of
from lammps_jump.core.library import CORE
from lammps_jump.system import library

PLUGIN = Product(
    "jumpplugin",
    "the compiled kernel",
    Path(__file__).resolve().parent,
    export="lammpsplugin_init",
    # reading the headers of LAMMPS takes 1.5 s a unit; those of vectors come before the core's
    groups=(("pair_*.cpp", "halo.cpp", "fix_*.cpp", "jump_plugin.cpp"), ("core_of_step.cpp",), ("core_of_pairs.cpp",)),
    also=(CORE.folder,),
    wheels=(
        Wheel("lammps", "lammps/pair.h", library("liblammps"), "LAMMPS' headers are"),
        Wheel("mpich", "mpi.h", library("libmpi", "12"), "mpi.h of mpich is"),
    ),
    advice="install the wheels with their headers: `pip install 'lammps[mpi]'`",
    levels=("x86-64-v4", "x86-64-v3"),
    forbidden="$&#\"'\\\n\r",
)

PRODUCTS = (PLUGIN, CORE)
"""All that is compiled, what takes longest first."""

plugin_path = partial(library_path, PLUGIN)
availability = partial(availability_of, PLUGIN)
