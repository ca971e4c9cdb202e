# SPDX-License-Identifier: GPL-2.0-or-later
from .engine import EnginePart as EnginePart
from .engine import run_native as run_native
from .engine import take_frame as take_frame
from .image import WithoutDiscs as WithoutDiscs
from .ledger import EnergyNow as EnergyNow
from .simulation import NativeSimulation as NativeSimulation
