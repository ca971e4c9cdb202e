# SPDX-License-Identifier: GPL-2.0-or-later
"""The engines: LAMMPS with stock styles or the plugin, and the native one; `run` is the one way to run a scene."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
