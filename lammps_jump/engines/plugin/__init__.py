"""LAMMPS plugin of this project: styles made for equal discs in 2-D, compiled on demand and cached."""

from .build import KernelStatus, availability, plugin_path

__all__ = ["KernelStatus", "availability", "plugin_path"]
