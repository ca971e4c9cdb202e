"""Scene to LAMMPS text."""

from .blocks import DUMP_NAMES
from .write import script_text, write_script

__all__ = ["DUMP_NAMES", "script_text", "write_script"]
