"""``python -m lammps_jump``."""

from lammps_jump.cli.app import main

main()
