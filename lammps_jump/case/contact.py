# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact of two discs in a case."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag
from pydantic.functional_validators import model_validator

from lammps_jump.physics.contact import material_stiffness
from lammps_jump.physics.slip import FRICTION_LAWS, Rolling, Springs
from lammps_jump.units import Friction, NewtonPerMetre, Pascal, PerSecond, Plain, Restitution, Stiffness

from .base import FineLength, Speed, Strict


class RollingResistance(Strict):
    """Rolling resistance: a spring and a dashpot against rolling, which slide at friction times the normal force."""

    friction: Friction = Field(
        title="rolling friction coefficient", description="a disc rolls from the angle with this tangent on"
    )
    stiffness_ratio: Plain = Field(
        default=0.1, gt=0, le=1, description="spring against rolling, over the normal one of two nominal discs"
    )
    damping: Plain = Field(
        default=1.0, ge=0, le=100, description="dashpot against rolling, over the normal one of two nominal discs"
    )


class Material(Strict):
    """Elastic constants of the discs, which are cylinders that touch along a line."""

    young: Pascal = Field(ge=1e-4, le=1e24, title="modulus of elasticity", description="Young's modulus E")
    poisson: Plain = Field(ge=0, le=0.5, description="Poisson's ratio ν")  # noqa: RUF001


class ShareOfWeight(Strict):
    """A force as a share of the weight of a nominal disc."""

    weight: Plain = Field(ge=0, le=1e6, description="attraction over the weight of a nominal disc, its Bond number")


def _attraction(value: object) -> str:
    return "<share>" if isinstance(value, dict | ShareOfWeight) else "<force>"


Attraction = Annotated[
    Annotated[NewtonPerMetre, Field(ge=0, le=1e24), Tag("<force>")] | Annotated[ShareOfWeight, Tag("<share>")],
    Discriminator(_attraction),
]


class Contact(Strict):
    """Contact of two discs: coefficients of the thesis and further options."""

    restitution: Restitution = Field(
        title="restitution coefficient", description="restitution coefficient e of a collision"
    )
    friction: Friction = Field(
        default=0.0, title="friction coefficient", description="friction coefficient μ of Coulomb's law"
    )
    friction_law: Literal["viscous", "sign", "history"] = Field(
        default="viscous",
        description="`viscous`: friction of LAMMPS (`linear_nohistory`), proportional to slip up to Coulomb's limit; "
        "`sign`: friction of the thesis (native engine or compiled kernel); `history`: a tangential spring that "
        "remembers, so that grains rest (theory.md)",
    )
    largest_overlap: Annotated[Plain, Field(ge=1e-6, le=1)] | None = Field(
        default=None,
        title="largest overlap over diameter",
        description="share of the diameter by which a disc that hits a wall at v0 overlaps it: 1/n of the thesis. "
        "Without it and a stiffness, 0.1",
    )
    impact_speed: Speed | None = Field(
        default=None,
        title="impact speed",
        description="v0: about the speed of the fastest collision. Beside a given stiffness it says for which speed "
        "`check` tells overlaps; without it, v0 is the fastest collision that fall heights, inflow and motions lead to",
    )
    stiffness: Stiffness | None = Field(
        default=None, title="stiffness", description="of the spring of two discs, in place of `largest_overlap`"
    )
    from_material: Material | None = Field(
        default=None,
        description="`{young: 5 MPa, poisson: 0.3}`, in place of `stiffness` and `largest_overlap`: "
        "k = π E / (8 (1 - ν²)), the line contact of two equal cylinders 1 m long "
        "(theory.md#stiffness-of-a-material). `tangential_ratio` is a field of its own: ν does not change it",  # noqa: RUF001
    )
    stiffness_wall: Stiffness | None = Field(
        default=None, description="of the spring of a disc and a wall. Without it, that of two discs"
    )
    cohesion: Attraction | None = Field(
        default=None,
        description="attraction F_c of two discs, or of a disc and a wall, while they touch, per metre of width; or "
        "`{weight: 0.5}`, a share of the weight of a nominal disc. Friction is bounded by the normal force without it. "
        "Native engine, twin and compiled kernel",
    )
    rotation: bool = Field(default=False, description="discs spin; this matters only with friction")
    correct_restitution: bool = Field(
        default=True, description="scale the dashpot so that LAMMPS' integrator gives the wanted e"
    )
    tangential_damping: Annotated[PerSecond, Field(ge=1e-9, le=1e24)] | None = Field(
        default=None,
        description="gamma_t of law `viscous`. Without it, 3 ω, and with spin ω, where ω is the contact frequency",
    )
    tangential_ratio: Annotated[Plain, Field(ge=0, le=1)] | None = Field(
        default=None,
        description="law `history`: stiffness of the tangential spring over the normal one. Without it, 2/7",
    )
    tangential_damping_ratio: Annotated[Plain, Field(ge=0, le=100)] | None = Field(
        default=None, description="law `history`: tangential dashpot over the normal one. Without it, 1"
    )
    rolling: RollingResistance | None = Field(
        default=None,
        description="law `history`: `{friction: 0.1, stiffness_ratio: 0.1, damping: 1}`: a spring and a dashpot "
        "against rolling, which slide at `friction` times the normal force. Needs `rotation: true`",
    )
    touch: Literal["sharp", "smooth"] = Field(
        default="sharp",
        description="`sharp`: spring of the thesis; `smooth`: a soft start of the contact, for larger steps at e near "
        "1 (native engine or compiled kernel; kernels.md)",
    )
    touch_width: FineLength | None = Field(
        default=None, description="width of the soft start of `smooth`. Without it, the distance of two steps at v0"
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

    def law_fields(self, *, rubs: bool, width: float, weight: float) -> dict[str, Any]:
        """All fields of `Scene` that define the law, except its coefficients, walls and sizes; nothing else fills them.

        Parameters
        ----------
        rubs : bool
            Anything in the scene has friction.
        width : float
            Of a smooth touch for which the case gives none, m.
        weight : float
            Of a nominal disc, N per m of width.
        """
        smooth, pull = self.touch == "smooth", self.cohesion
        return {
            "friction_law": self.friction_law,
            "springs": self.springs if rubs else None,
            "rotation": self.rotation and rubs,
            "touch": self.touch,
            "touch_width": (self.touch_width or width) if smooth else 0.0,
            "cohesion": pull.weight * weight if isinstance(pull, ShareOfWeight) else pull or 0.0,
        }

    @property
    def stiffer(self) -> str:
        """Advice on what makes the contacts stiffer in this case."""
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
        given = self.rolling
        roll = None if given is None else Rolling(given.friction, given.stiffness_ratio, given.damping)
        return Springs(**{name: value for name, value in known.items() if value is not None}, rolling=roll)
