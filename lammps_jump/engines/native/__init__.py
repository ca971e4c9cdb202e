# SPDX-License-Identifier: GPL-2.0-or-later
"""The native engine: the thesis' disc model in compiled loops, independent of LAMMPS.

It reads the same `Scene` and writes the same files as the LAMMPS engine.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
