# SPDX-License-Identifier: GPL-2.0-or-later
"""``python -m lammps_jump``."""

from lammps_jump.cli.app import main

main()
