"""The native engine: the thesis' disc model in compiled loops, independent of LAMMPS.

Reads the same `Scene` and writes the same files as the LAMMPS engine. Importing it loads the compiler (numba), so
import it where it is used.
"""

from .engine import NativeRun, run_native, simulate
from .ledger import Energy
from .simulation import NativeSimulation

__all__ = ["Energy", "NativeRun", "NativeSimulation", "run_native", "simulate"]
