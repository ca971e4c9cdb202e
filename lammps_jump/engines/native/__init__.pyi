# SPDX-License-Identifier: GPL-2.0-or-later
from .engine import run_native as run_native
from .ledger import EnergyNow as EnergyNow
from .simulation import NativeSimulation as NativeSimulation
