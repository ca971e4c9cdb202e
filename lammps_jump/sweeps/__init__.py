# SPDX-License-Identifier: GPL-2.0-or-later
"""Many runs as one: points and members of a study, a pool of processes, one folder for all, statistics over members."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
