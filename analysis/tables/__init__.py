# SPDX-License-Identifier: GPL-2.0-or-later
"""The numbers that readers look for first, for screen, tiles and pages."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
