# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls from drawings: DXF, SVG, GeoJSON and tables of a survey become entries of a case."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
