# SPDX-License-Identifier: GPL-2.0-or-later
"""What comes in, goes out and stays: discs of the inflow, energy and momentum."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
