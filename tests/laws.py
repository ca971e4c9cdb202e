# SPDX-License-Identifier: GPL-2.0-or-later
"""Every slot of the contact law, as arguments of `handmade_scene`."""

from lammps_jump.physics.slip import Rolling, Springs

SPIN = {"friction": 0.4, "rotation": True}
EXTRAPOLATED = {"integrator": "leapfrog_extrapolated"}
ROLLING = Springs(rolling=Rolling(0.2, 0.5, 0.3))
LAWS = {
    "frictionless": {"friction": 0.0},
    "viscous": {"friction": 0.4},
    "viscous, spin": SPIN | EXTRAPOLATED,
    "sign": {"friction": 0.4, "friction_law": "sign"},
    "sign, spin": SPIN | EXTRAPOLATED | {"friction_law": "sign"},
    "springs": {"friction": 0.4, "friction_law": "history", "springs": Springs()},
    "rolling": SPIN | {"friction_law": "history", "springs": ROLLING},
    "smooth": {"friction": 0.0, "touch": "smooth", "touch_width": 2e-3} | EXTRAPOLATED,
    "smooth, spin": SPIN | {"touch": "smooth", "touch_width": 2e-3},
}
