"""Scene to LAMMPS text."""

from .assemble import script_text, write_script
from .stock import DUMP_NAMES

__all__ = ["DUMP_NAMES", "script_text", "write_script"]
