# SPDX-License-Identifier: GPL-2.0-or-later
"""Flows seen along and across a sloping bed."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
