# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene before it is run, described once: drawn by matplotlib for files, as SVG for pages."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
