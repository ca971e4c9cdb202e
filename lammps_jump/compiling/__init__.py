# SPDX-License-Identifier: GPL-2.0-or-later
"""Compiles the C++ of this project where it runs, once, and keeps it, or takes what the package carries."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
