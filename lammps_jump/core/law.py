# SPDX-License-Identifier: GPL-2.0-or-later
"""The numbers of a contact law: their names and their order, for the core, the twin, the scripts and the analysis."""

from __future__ import annotations

from ctypes import Array, c_double
from typing import ClassVar, NamedTuple

from .library import Struct


class LawNumbers(NamedTuple):
    """Numbers of the law of two discs, or of a disc and one wall, in SI units and per m of width.

    `lammps_jump.scene.scene.Scene.law_numbers` fills them, and nothing else does. ``law.h`` has the same names in
    the same order (`jump_law`).

    Attributes
    ----------
    stiffness : float
        N/m.
    damping, tangential : float
        Dashpot of the normal force and slope of LAMMPS' viscous ramp, N s/m: m_eff gamma of two discs, or of a disc at
        a wall. Where discs have radii of their own they are of a size of 1 m. The size is R at a wall and
        R_i R_j / sqrt(R_i^2 + R_j^2) of two discs: the root of the effective mass over that of a radius of 1 m.
    friction : float
        Coefficient; NaN where nothing in the scene rubs.
    sign_ramp : float
        Slip over the largest speed below which the thesis' friction falls to 0 (4.20); 0: another friction.
    touch : float
        Width of a smooth touch, m; 0: a sharp one.
    cohesion : float
        Constant attraction while the two touch, N.
    spring_ratio, spring_damping : float
        Stiffness and dashpot of the tangential spring with memory over those of the contact.
    rolling, rolling_damping, rolling_friction : float
        Stiffness (N/m), dashpot (N s/m) and friction coefficient of the spring against rolling; stiffness 0: none.
    """

    stiffness: float
    damping: float
    tangential: float
    friction: float
    sign_ramp: float = 0.0
    touch: float = 0.0
    cohesion: float = 0.0
    spring_ratio: float = 0.0
    spring_damping: float = 0.0
    rolling: float = 0.0
    rolling_damping: float = 0.0
    rolling_friction: float = 0.0


class jump_law(Struct):
    """`LawNumbers` as the core has them."""

    _fields_: ClassVar = [(name, c_double) for name in LawNumbers._fields]


def laws_of(*numbers: LawNumbers) -> Array[jump_law]:
    """Numbers of several laws, one after the other, as the core has them."""
    return (jump_law * len(numbers))(*(jump_law(*one) for one in numbers))
