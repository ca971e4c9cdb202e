# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a study: points that are run or computed, results and pages that are made of what was found."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
