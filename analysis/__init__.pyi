# SPDX-License-Identifier: GPL-2.0-or-later
from . import pipeline as pipeline
from . import profiles as profiles
from . import quantities as quantities
from . import report as report
from . import tables as tables
from . import verdicts as verdicts
from .budgets.energy import Energy as Energy
from .devices.front import Front as Front
from .flow import Flow as Flow
from .flow import from_scene as from_scene
from .forces.history import Force as Force
from .guess import from_dump as from_dump
from .jump.found import Jump as Jump
from .pipeline import analyse as analyse
from .quantities import QUANTITIES as QUANTITIES
from .tables import main_numbers as main_numbers
