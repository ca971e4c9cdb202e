# SPDX-License-Identifier: GPL-2.0-or-later
from . import accuracy as accuracy
from . import lammps as lammps
from . import plugin as plugin
from .checkpoint import Checkpoint as Checkpoint
from .checkpoint import read_checkpoint as read_checkpoint
from .child import prepare_worker as prepare_worker
from .choice import choose as choose
from .choice import choose_setting as choose_setting
from .choice import usable_kernels as usable_kernels
from .launch import run as run
from .launch import write_inputs as write_inputs
from .result import NATIVE_KERNELS as NATIVE_KERNELS
from .result import Progress as Progress
from .result import ProgressCallback as ProgressCallback
from .result import RunResult as RunResult
from .setting import Job as Job
from .setting import Setting as Setting
