# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a case estimated from measurements: points, an emulator of the runs, posterior of the numbers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
