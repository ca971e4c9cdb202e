# SPDX-License-Identifier: GPL-2.0-or-later
"""The local page of one case, run or study: `lammps-jump open`.

The server is that of the standard library. One person looks, at one address of this machine, and few requests come a
second: a framework would bring a loop of events, several packages, and ways in that have to be shut.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
