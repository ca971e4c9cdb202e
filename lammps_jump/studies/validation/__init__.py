# SPDX-License-Identifier: GPL-2.0-or-later
"""Results of this program held against published laws: what a law is, how its points are run, the page."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
