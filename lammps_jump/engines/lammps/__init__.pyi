# SPDX-License-Identifier: GPL-2.0-or-later
from .drive import leave_ranks as leave_ranks
from .drive import play as play
from .drive import run_lammps as run_lammps
from .loader import load_lammps as load_lammps
from .loader import mpi_library as mpi_library
from .loader import new_engine as new_engine
from .loader import program as program
from .loader import wheel_version as wheel_version
from .outputs import explain as explain
