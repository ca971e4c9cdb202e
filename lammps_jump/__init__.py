# SPDX-License-Identifier: GPL-2.0-or-later
"""lammps-jump: free-surface flow with discs on LAMMPS, from a YAML case to a report.

``case = lammps_jump.load_case(file)`` reads a case, ``run = case.run(folder)`` runs and analyses it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
