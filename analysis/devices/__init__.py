# SPDX-License-Identifier: GPL-2.0-or-later
"""Flows that a device makes: waves of a paddle, a drum that turns, a hopper that empties, a slope that water climbs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
