# SPDX-License-Identifier: GPL-2.0-or-later
"""Budget of a flow: discs of the inflow, counted."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
