# SPDX-License-Identifier: GPL-2.0-or-later
"""Fluid that the discs of a case are: viscosity, yield, speed of sound, packing."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
