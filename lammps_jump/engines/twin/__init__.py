# SPDX-License-Identifier: GPL-2.0-or-later
"""The twin: every step of the native engine in plain Python, to be read together with the thesis.

It shares no line with the core. The law and its springs are `lammps_jump.physics.law`, walls are
`scene.faces`. Tests hold it against the core on random states. It needs no compiler, and is slow.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
