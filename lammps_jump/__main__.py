"""``python -m lammps_jump``."""

from .cli import main

main()
