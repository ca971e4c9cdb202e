# SPDX-License-Identifier: GPL-2.0-or-later
"""Case files: YAML to a validated, frozen `Case`, and on to a `Scene`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
