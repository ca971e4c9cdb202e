# SPDX-License-Identifier: GPL-2.0-or-later
"""Players on the page of a study: of the members of a case by a list, of the points of a study by sliders."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
