# SPDX-License-Identifier: GPL-2.0-or-later
"""Grains that rest, and grains that shear: when they rest, the shape of their heap, profiles over layers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
