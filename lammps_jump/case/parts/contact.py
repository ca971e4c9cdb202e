# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact of two discs in a case."""

from __future__ import annotations

from typing import Literal

from pydantic import Field
from pydantic.functional_validators import model_validator

from lammps_jump import units
from lammps_jump.physics.contact import material_stiffness
from lammps_jump.physics.slip import FRICTION_LAWS, Rolling, Springs

from .base import FINE_LENGTH, SPEED, STIFFNESS, Strict


class RollingResistance(Strict):
    """Rolling resistance: a spring and a dashpot against rolling, which slide at friction times the normal force."""

    friction: units.Plain = Field(ge=0, le=1000, description="coefficient of rolling friction")
    stiffness_ratio: units.Plain = Field(default=0.1, gt=0, le=1, description="stiffness over that of two discs")
    damping: units.Plain = Field(default=1.0, ge=0, le=100, description="dashpot over that of two nominal discs")


class Material(Strict):
    """Elastic constants of the discs, which are cylinders that touch along a line."""

    young: units.Pascal = Field(ge=1e-4, le=1e24, description="modulus of elasticity E, Pa")
    poisson: units.Plain = Field(ge=0, le=0.5, description="Poisson's ratio")


class ShareOfWeight(Strict):
    """A force as a share of the weight of a nominal disc."""

    weight: units.Plain = Field(ge=0, le=1e6, description="force over the weight of a nominal disc (Bond number)")


class Contact(Strict):
    """Contact of two discs: coefficients of the thesis and further options."""

    restitution: units.Plain = Field(ge=1e-6, le=1)
    friction: units.Plain = Field(default=0.0, ge=0, le=1000)
    friction_law: Literal["viscous", "sign", "history"] = "viscous"
    largest_overlap: units.Plain | None = Field(
        default=None, ge=1e-6, le=1, description="at v0, over the diameter: 1/n of (3.20)"
    )
    impact_speed: units.MetrePerSecond | None = Field(default=None, **SPEED, description="v0 of (3.20)")
    stiffness: units.Stiffness | None = Field(default=None, **STIFFNESS)
    from_material: Material | None = Field(default=None, description="stiffness of elastic cylinders")
    stiffness_wall: units.Stiffness | None = Field(default=None, **STIFFNESS)
    cohesion: units.Stiffness | ShareOfWeight | None = Field(
        default=None, description="constant attraction while two touch, N per m of width, or {weight: share}"
    )
    rotation: bool = False
    correct_restitution: bool = Field(default=True, description="remove the restitution bias of velocity Verlet")
    tangential_damping: units.PerSecond | None = Field(
        default=None, ge=1e-9, le=1e24, description="gamma_t, 1/s; default by rule"
    )
    tangential_ratio: units.Plain | None = Field(
        default=None, ge=0, le=1, description="history: stiffness of the tangential spring over the normal one, 2/7"
    )
    tangential_damping_ratio: units.Plain | None = Field(
        default=None, ge=0, le=100, description="history: tangential dashpot over the normal one, 1"
    )
    rolling: RollingResistance | None = Field(default=None, description="history: a spring against rolling")
    touch: Literal["sharp", "smooth"] = "sharp"
    touch_width: units.Metre | None = Field(
        default=None, **FINE_LENGTH, description="smooth touch: width of the soft start, m"
    )

    @model_validator(mode="after")
    def _stiffness_given_once(self) -> Contact:
        if self.own_stiffness is None and self.impact_speed is None:
            raise ValueError(
                "needs impact_speed (with largest_overlap, default 0.1), or stiffness or from_material in place of the "
                "two"
            )
        given = [name for name in ("stiffness", "from_material", "largest_overlap") if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"{given[0]} and {given[1]} both fix the stiffness; keep one of them")
        if self.touch == "sharp" and self.touch_width is not None:
            raise ValueError("touch_width has no meaning for touch: sharp; write touch: smooth or drop it")
        return self

    @model_validator(mode="after")
    def _attraction_pulls(self) -> Contact:
        if isinstance(self.cohesion, float) and not 0 <= self.cohesion <= 1e24:
            raise ValueError(f"cohesion {self.cohesion:zg} N/m is not allowed; give 0 to 1e+24, or {{weight: share}}")
        return self

    @model_validator(mode="after")
    def _springs_of_one_law(self) -> Contact:
        if not FRICTION_LAWS[self.friction_law].remembers:
            for name in ("tangential_ratio", "tangential_damping_ratio", "rolling"):
                if getattr(self, name) is not None:
                    raise ValueError(
                        f"{name} has no meaning for friction_law: {self.friction_law}; write friction_law: history or "
                        "drop it"
                    )
            return self
        if self.tangential_damping is not None:
            raise ValueError(
                "tangential_damping has no meaning for friction_law: history; give tangential_damping_ratio, the "
                "tangential dashpot over the normal one"
            )
        if self.touch == "smooth":
            raise ValueError("touch: smooth is not there for friction_law: history; write touch: sharp")
        if self.rolling is not None and not (self.rotation and self.friction > 0):
            raise ValueError("rolling needs discs that turn: write rotation: true and a friction above 0")
        return self

    @property
    def own_stiffness(self) -> float | None:
        """Stiffness that is given, or that of the material, N/m."""
        if self.from_material is not None:
            return material_stiffness(self.from_material.young, self.from_material.poisson)
        return self.stiffness

    def attraction(self, mass: float, gravity: float) -> float:
        """Attraction of what touches, N per m of width, for nominal discs of this mass (kg/m)."""
        if isinstance(self.cohesion, ShareOfWeight):
            return self.cohesion.weight * mass * gravity
        return self.cohesion or 0.0

    @property
    def stiffer(self) -> str:
        """What makes the contacts stiffer in this case, as an advice."""
        if self.from_material is not None:
            return "raise contact.from_material.young"
        if self.stiffness is not None:
            return "raise contact.stiffness"
        return "raise contact.impact_speed or lower contact.largest_overlap"

    def stiff_for(self, speed: float, factor: float) -> str:
        """Advice with the value that suits a speed (m/s), at which overlaps are to be smaller by a factor."""
        if self.from_material is not None:
            return f"take contact.from_material.young: {self.from_material.young * factor**2:z.2g} or more"
        if self.stiffness is not None:
            return f"take contact.stiffness: {self.stiffness * factor**2:z.2g} or more"
        return f"take contact.impact_speed: {speed:z.3g}"

    @property
    def springs(self) -> Springs | None:
        """Springs with memory of the law."""
        if not FRICTION_LAWS[self.friction_law].remembers:
            return None
        known = {name: getattr(self, name) for name in ("tangential_ratio", "tangential_damping_ratio")}
        asked = self.rolling
        roll = None if asked is None else Rolling(asked.friction, asked.stiffness_ratio, asked.damping)
        return Springs(**{name: value for name, value in known.items() if value is not None}, rolling=roll)
