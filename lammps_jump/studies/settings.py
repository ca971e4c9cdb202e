# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings of a benchmark, the axes that they come from, and which of them are stable."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from lammps_jump.case.to_scene import INTEGRATORS
from lammps_jump.errors import CaseError
from lammps_jump.physics import contact

from .runs import KERNELS

AXES = ("f", "n", "touch", "kernel", "correction", "skin", "diameter", "ranks")
BASE = 0.05
"""Time-step fraction of the settings that vary another axis."""
SKINS = (0.1, 0.2, 0.3, 0.5, 0.7)
FIELDS = {
    "ranks": "engine.ranks", "fraction": "run.time_step_fraction", "touch": "contact.touch",
    "correction": "contact.correct_restitution", "diameter": "discs.diameter",
}  # fmt: skip
"""Fields of a case by what a `StudySetting` calls them; skin, kernel and n are none of them."""
MEASURED_KERNELS = tuple(name for name in KERNELS if name != "twin")


class Axes(NamedTuple):
    """Values that a benchmark varies.

    Attributes
    ----------
    names : tuple of str
        Of `AXES`.
    fractions, diameters : tuple of float
        Time steps over 2/omega; disc diameters, m.
    kernels : tuple of str
    members : int
        Starts of each setting. The reference gets as many.
    penetrations : tuple of float
        n of thesis (3.20).
    finest : float
        Time step of the reference.
    """

    names: tuple[str, ...] = ("f", "touch", "kernel", "correction", "n", "skin")
    fractions: tuple[float, ...] = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
    kernels: tuple[str, ...] = MEASURED_KERNELS  # the twin takes hours: asked for by name
    diameters: tuple[float, ...] = ()
    members: int = 5
    penetrations: tuple[float, ...] = (5.0, 10.0, 20.0, 40.0)
    finest: float = 0.01


QUICK = Axes(("f", "touch", "kernel"), (0.05, 0.1, 0.2), members=2, penetrations=(5.0, 20.0), finest=0.02)


@dataclass(frozen=True)
class StudySetting:
    """One way to compute a case; None leaves a value as the case has it.

    Attributes
    ----------
    kernel : {'stock', 'compiled', 'native'}
    touch : {'sharp', 'smooth'}
    fraction : float
        Time step over 2/omega.
    penetration : float or None
        n of thesis (3.20): the diameter over the largest overlap.
    correction : bool
        Restitution corrected for the integrator's bias.
    skin : float or None
        Over the disc diameter.
    diameter : float or None
        m.
    ranks : int
    """

    kernel: str
    fraction: float
    touch: str = "sharp"
    penetration: float | None = None
    correction: bool = True
    skin: float | None = None
    diameter: float | None = None
    ranks: int = 1

    @property
    def label(self) -> str:
        """Short and unique among the settings of a case."""
        words = [self.family, f"f={self.fraction:zg}"]
        words += [f"n={self.penetration:zg}"] if self.penetration is not None else []
        words += [] if self.correction else ["uncorrected"]
        words += [f"skin={self.skin:zg}d"] if self.skin is not None else []
        words += [f"d={self.diameter:zg}"] if self.diameter is not None else []
        words += [f"{self.ranks} ranks"] if self.ranks > 1 else []
        return " ".join(words)

    @property
    def family(self) -> str:
        """Kernel and touch; a figure gives each family its mark."""
        return self.kernel + (" smooth" if self.touch == "smooth" else "")

    @property
    def plain(self) -> bool:
        """Tells whether nothing but kernel, touch and step is varied."""
        return self == StudySetting(self.kernel, self.fraction, self.touch)

    def changes(self, diameter: float) -> dict[str, object]:
        """Return the values of a case that this setting changes; `diameter` (m) is that of the case."""
        fields = {path: getattr(self, name) for name, path in FIELDS.items()}
        skin = None if self.skin is None else self.skin * (self.diameter or diameter)
        overlap = None if self.penetration is None else 1 / self.penetration
        changed = {**KERNELS[self.kernel], **fields, "contact.largest_overlap": overlap, "engine.skin": skin}
        return {path: value for path, value in changed.items() if value is not None}


def listed(option: str, text: str | None, allowed: Collection[str]) -> tuple[str, ...]:
    """Return the words of an option, ``f,n,touch``, each once; none where it was not given.

    Raises
    ------
    CaseError
        A word that is not allowed, or an option without a word.
    """
    words = tuple(dict.fromkeys(word.strip() for word in (text or "").split(",") if word.strip()))
    if text is not None and not words:
        raise CaseError(f"{option}: '{text}' names nothing; allowed are {', '.join(allowed)}")
    for word in words:
        if word not in allowed:
            raise CaseError(f"{option}: '{word}' is not known; allowed are {', '.join(allowed)}")
    return words


def stable(setting: StudySetting, restitution: float) -> bool:
    """Return whether the step is below the limit of a dense packing (`contact.stable_fraction`)."""
    integrator = INTEGRATORS[KERNELS[setting.kernel]["engine.name"]]
    return setting.fraction <= contact.stable_fraction(contact.damping_ratio(restitution), integrator)


def make_settings(axes: Axes, restitution: float) -> list[StudySetting]:
    """Return stable settings: step, kernel and touch are crossed, the other axes vary one at a time from `BASE`.

    Parameters
    ----------
    axes : Axes
        With kernels that are usable here.
    restitution : float
        Decides which steps are stable.
    """
    names, kernels, first = axes.names, axes.kernels, axes.kernels[0]
    families = [(kernel, "sharp") for kernel in (kernels if "kernel" in names else [first])]
    quickest = reference_setting(BASE, kernels).kernel
    if "touch" in names and quickest != "stock":
        families.append((quickest, "smooth"))
    steps = list(axes.fractions) if "f" in names else [BASE]
    found = [StudySetting(kernel, step, touch) for kernel, touch in families for step in steps]
    if "correction" in names and restitution < 1:
        found += [StudySetting(first, step, correction=False) for step in steps]
    if "n" in names:
        found += [StudySetting(quickest, step, penetration=n) for n in axes.penetrations for step in (BASE, 2 * BASE)]
    if "skin" in names:
        found += [StudySetting(kernel, BASE, skin=skin) for kernel in kernels[:2] for skin in SKINS]
    if "diameter" in names:
        found += [StudySetting(quickest, BASE, diameter=d) for d in axes.diameters]
    if "ranks" in names:
        found += [StudySetting(first, BASE), StudySetting(first, BASE, ranks=2)]
    return list(dict.fromkeys(setting for setting in found if stable(setting, restitution)))


def reference_setting(fraction: float, kernels: Iterable[str]) -> StudySetting:
    """Return the reference of all errors: the finest step with sharp touch on the fastest usable kernel."""
    usable = list(kernels)
    fast = next((kernel for kernel in ("compiled", "native") if kernel in usable), usable[0])
    return StudySetting(fast, fraction)
