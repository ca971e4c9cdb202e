"""The native engine: the thesis' disc model in compiled loops, independent of LAMMPS.

Reads the same `Scene` and writes the same files as the LAMMPS engine. Importing it loads the compiler (numba), so
import it where it is used.
"""

from .engine import frames, run_native
from .ledger import Energy
from .output import Frame
from .simulation import NativeSimulation

__all__ = ["Energy", "Frame", "NativeSimulation", "frames", "run_native"]
