# SPDX-License-Identifier: GPL-2.0-or-later
"""A page that holds the core, the start of a case and sliders: the flow runs in the reader's browser, without a server.

What the sliders do is kept as tables of motion and inflow. A run of that case by the native engine has the numbers of
the page to the last bit.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
