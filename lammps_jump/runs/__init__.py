# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a case: start, resume, analyse again, and look at."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
