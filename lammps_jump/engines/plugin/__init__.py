# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS plugin of this project: styles for equal discs in two dimensions, compiled on demand and cached."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
