# SPDX-License-Identifier: GPL-2.0-or-later
"""The five numbers that readers look for first, and what theory says: for screen, tiles and pages of one or more runs.

± is the 95 % interval over starts. One run has none.
"""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import isfinite, nan
from typing import Any, NamedTuple

from lammps_jump.analysis.budgets.depths import Depths
from lammps_jump.analysis.budgets.energy import Energy
from lammps_jump.analysis.budgets.grade import Grade
from lammps_jump.analysis.budgets.inflow import Delivery
from lammps_jump.analysis.devices.drum import Drum
from lammps_jump.analysis.devices.front import Front, MartinMoyce
from lammps_jump.analysis.devices.hopper import Hopper
from lammps_jump.analysis.devices.runup import RunUp
from lammps_jump.analysis.devices.waves import Waves
from lammps_jump.analysis.forces.history import Force
from lammps_jump.analysis.grains.heap import Heap
from lammps_jump.analysis.grains.layers import LayerProfiles
from lammps_jump.analysis.grains.rest import Rest
from lammps_jump.analysis.jump.summary import Jump
from lammps_jump.analysis.report.headline import A_JUMP, COMPARED, against_water, belongs
from lammps_jump.analysis.report.page import NumberBox, heading
from lammps_jump.analysis.statistics import Mean
from lammps_jump.analysis.verdicts import is_shown
from lammps_jump.units import ABSENT, POWERS, ROUND_OFF, numbers_of, shown

MOST = 5
FAR = 3.0
"""Factor between a measured number and theory from which on that does not apply."""
HOLDS = {
    "Bélanger": "of one jump on a level bed, with hydrostatic pressure on both sides",
    "hydrostatic": "of water at rest before an upright face",
    "piston, small waves": "of small waves of a piston",
    "rods": "of columns of rods that fall on a level bed",
    "sand": "of columns of sand that fall on a level bed",
    "Ritter": "of a wave of water on a dry, level bed without friction",
    "asked": "of an inlet that nothing holds up",
}
"""What theory is of, by its words. Lengths are not here: discs make a short jump, and the page says so beside them."""
ONE_RUN = "one run; for error bars: the same command with --members 8"
ONE_DUMP = "one dump; error bars need runs from other starts"
"""In place of error bars."""


class Wanted(NamedTuple):
    """A number of ``summary.json`` by its path, as described by `result`, and that of theory at `other`.

    Without a path of theory its `words` stand alone. `scale` and `unit` replace those of the description. The
    difference is a share of theory, or has the unit of both where `plain`.
    """

    path: str
    result: type
    words: str = ""
    other: str = ""
    label: str = ""
    scale: float = 1.0
    unit: str | None = None
    plain: bool = False


class MeasuredRow(NamedTuple):
    """A measured number, theory (at the path `held`) and their difference; NaN where there is none."""

    path: str
    held: str
    label: str
    unit: str
    measured: Mean
    words: str
    theory: Mean
    difference: Mean
    plain: bool

    def numbers(self) -> tuple[str, str, str]:
        """Measured number, theory and difference as text."""
        unit = f" {self.unit.translate(POWERS)}" if self.unit else ""
        theory = f"{self.words} {_text(self.theory, alone=True)}{unit}" if isfinite(self.theory.value) else self.words
        return f"{_text(self.measured)}{unit}", theory, self.off()

    @property
    def far(self) -> bool:
        """Whether theory is more than `FAR` times off, so that it does not apply."""
        ratio = 1.0 + self.difference.value
        return not self.plain and isfinite(ratio) and self.words in HOLDS and not 1 / FAR <= ratio <= FAR

    def reason(self) -> str:
        """Why theory does not apply, as a sentence; empty where it does."""
        if not self.far:
            return ""
        ratio = 1.0 + self.difference.value
        times = f"{ratio:z.2g} times as much" if ratio >= 1 else f"{100 * ratio:z.2g} % of it"
        what, theory = heading(self.label, ""), self.numbers()[1]
        return f"{what}: {theory} does not apply, because it is {HOLDS[self.words]}; measured is {times}."

    def off(self) -> str:
        """The difference as text, with its sign."""
        value, error = self.difference.value, self.difference.error
        if not isfinite(value):
            return ""
        if self.far:
            return "does not apply"
        scale, unit = (1.0, self.unit) if self.plain else (100.0, "%")
        if isfinite(error):
            text = shown(scale * value, error=scale * error)
        elif self.plain:
            text = f"{value:z.{len(_text(self.measured).partition('.')[2])}f}"
        else:
            text = f"{scale * value:z.{1 if abs(scale * value) < 10 else 0}f}"
        return f"{'+' if value > 0 else ''}{text} {unit}".replace("-", "−")


WATER = "front.ritter.front_speed"
PERCENT = {"scale": 0.01, "unit": "%"}
KILO = {"scale": 1e3, "unit": "kN/m"}
FOUND = (
    *(
        Wanted(f"jump.{row.key}", Jump, row.words, f"jump.{row.theory}", row.label, plain=row.key == "speed")
        for row in COMPARED
    ),
    Wanted("jump.froude", Jump),
    Wanted("waves.height", Waves, "piston, small waves", "waves.height_piston"),
    Wanted("waves.height_last", Waves),
    Wanted("waves.depth", Waves),
    Wanted("runup.highest", RunUp, label="highest water, y"),
    Wanted("runup.run_up", RunUp, label="run-up over still water"),
    Wanted("runup.over", RunUp, label="volume over the crest"),
    Wanted("drum.angle", Drum),
    Wanted("drum.scatter", Drum),
    Wanted("drum.froude", Drum),
    Wanted("hopper.discharge", Hopper, label="discharge, per metre"),
    Wanted("hopper.beverloo", Hopper),
    Wanted("hopper.slot", Hopper, label="width of the gap"),
    Wanted("heap.run_out_over_base", Heap, "rods", "heap.rods"),
    Wanted("heap.run_out_over_base", Heap, "sand", "heap.sand"),
    Wanted("heap.height_over_base", Heap, "rods", "heap.height_rods"),
    Wanted("heap.angle", Heap),
    Wanted("rest.time", Rest),
    Wanted("heap.height", Heap),
    Wanted("hopper.slot_in_diameters", Hopper, label="width of the gap over the diameter"),
    Wanted("hopper.change", Hopper, label="discharge, second half of the window over the first", **PERCENT),
    Wanted("layers.inertial_number", LayerProfiles),
    Wanted("layers.friction", LayerProfiles),
    Wanted("layers.packing", LayerProfiles),
    Wanted("layers.velocity", LayerProfiles),
    Wanted("front.position", Front, label="front after {time}"),
    Wanted("front.speed", Front, "Ritter", WATER),
    Wanted("front.speed", Front),
    Wanted(
        "front.martin_moyce.mean_bulk", MartinMoyce, "discs: −20 to 0 %", label="off Martin & Moyce’s water", **PERCENT
    ),
    Wanted("grade.lost", Grade, label="head lost from {stations}"),
    Wanted("force.*.mean_fx", Force, "hydrostatic", "force.*.mean_hydrostatic", "mean Fx, {name}", **KILO),
    Wanted("force.*.mean_fy", Force, label="mean Fy, {name}", **KILO),
    Wanted("force.*.peak", Force, "hydrostatic", "force.*.hydrostatic", "peak {component}, {name}", **KILO),
    Wanted("front.arrival_time", Front),
    Wanted("front.column_height", Front, label="column at the back wall"),
    Wanted("front.position_99", Front),
    Wanted("energy.max_deviation", Energy, "exact: 0", label="largest change of the energy", **PERCENT),
    Wanted("energy.drift", Energy, "exact: 0", label="drift of the energy", **PERCENT),
    Wanted("energy.final", Energy, "at the start", "energy.initial"),
    Wanted("energy.kinetic", Energy),
    Wanted("energy.potential", Energy),
    Wanted("inflow.delivered", Delivery, "asked", "inflow.asked"),
    Wanted("inflow.froude", Delivery),
    Wanted("depth.mass", Depths, "surface", "depth.surface"),
)
"""In the order of the page; those that a summary holds and that go with its verdict are shown, at most `MOST`."""


def lone(values: Sequence[float]) -> Mean:
    """The number of one run."""
    return Mean(values[0], nan)


def rows_of(
    summaries: Sequence[Mapping], mean: Callable[[Sequence[float]], Mean] = lone, *, most: int = MOST
) -> list[MeasuredRow]:
    """The numbers of one run, or their means over starts of one case.

    Parameters
    ----------
    summaries : sequence of mapping
        As in ``summary.json``.
    mean : callable
        Mean and half the interval of numbers.
    most : int
        Rows; a number that is held against two theories has two.
    """
    found = (row for wanted in FOUND for row in _rows(wanted, summaries, mean))
    return [row for row, _ in zip(found, range(most), strict=False)]


def _rows(
    wanted: Wanted, summaries: Sequence[Mapping], mean: Callable[[Sequence[float]], Mean]
) -> Iterator[MeasuredRow]:
    first = summaries[0] if summaries else {}
    key = wanted.path.rpartition(".")[2]
    for name, component in _structures(key, first).items() if "*" in wanted.path else [("", "")]:
        path = wanted.path.replace("*", name)
        other = wanted.other.replace("*", name) if component != "fy" else ""  # water at rest pushes along x
        pairs = [(_at(one, path), _at(one, other)) for one in summaries if _goes(wanted, one)]
        known = [(value / wanted.scale, theory) for value, theory in pairs if isinstance(value, int | float)]
        if not known:
            continue
        both = [(value, theory / wanted.scale) for value, theory in known if isinstance(theory, int | float)]
        off = [value - theory if wanted.plain else abs(value) / abs(theory) - 1.0 for value, theory in both if theory]
        number, absent = numbers_of(wanted.result)[key], Mean(nan, nan)
        time = _at(first, "front.time")
        when = {"time": f"{time:z.3g} s" if isinstance(time, int | float) else "the last frame", "name": name}
        ends = [_at(first, f"grade.{key}") for key in ("upstream", "downstream")]
        when["stations"] = " to ".join(f"{x:z.3g}" for x in ends if isinstance(x, int | float)) + " m"
        when |= {"component": component.replace("f", "F")}
        yield MeasuredRow(
            path,
            other,
            (wanted.label or number.meaning).format(**when),
            number.unit if wanted.unit is None else wanted.unit,
            mean([value for value, _ in known]),
            wanted.words if both or not wanted.other else "",
            mean([theory for _, theory in both]) if both else absent,
            mean(off) if off else absent,
            wanted.plain,
        )


def _structures(key: str, summary: Mapping) -> dict[str, str]:
    """Structures of which a number of the force is shown, and their components: those that something touched.

    A stream has a mean of the component, an impact its peak.
    """
    found = {
        name: str(values.get("component") or "fx")
        for name, values in (summary.get("force") or {}).items()
        if isinstance(values, Mapping) and not values.get("reason")
    }
    if not summary.get("inflow"):
        return found if key == "peak" else {}
    return {name: component for name, component in found.items() if key == f"mean_{component}"}


def _goes(wanted: Wanted, summary: Mapping) -> bool:
    quantity, _, key = wanted.path.partition(".")
    if quantity == "energy":
        return bool(_at(summary, "energy.conservative"))
    if quantity == "heap" and wanted.other:
        return _at(summary, wanted.other) is not None
    if quantity == "front":
        water = wanted.other == WATER
        known = is_shown("front", summary) and (key != "speed" or water == against_water(summary.get("front") or {}))
        return known and _at(summary, "jump.verdict") not in A_JUMP
    return quantity != "jump" or (is_shown("jump", summary) and belongs(key, _at(summary, "jump") or {}))


def _at(summary: Mapping, path: str) -> Any:
    """What stands at a path of keys; None where there is nothing."""
    found: object = summary
    for key in path.split("."):
        found = found.get(key) if isinstance(found, Mapping) else None
    return found


def _text(found: Mean, *, alone: bool = False) -> str:
    """A number in three digits, or cut to its error; `alone` leaves the error out."""
    if isfinite(found.error) and found.error > ROUND_OFF * abs(found.value):
        return shown(found.value, error=found.error, alone=alone).replace("-", "−")
    if not isfinite(found.value):
        return ABSENT
    whole = abs(found.value) >= 999.5 or not found.value
    return (f"{found.value:z.0f}" if whole else f"{found.value:z#.3g}".rstrip(".")).replace("-", "−")


def tiles(rows: Sequence[MeasuredRow]) -> list[NumberBox]:
    """The numbers at the top of a page; a number that is held against two theories stands once."""
    boxes: dict[str, NumberBox] = {}
    for row in rows:
        against = ", ".join(filter(None, row.numbers()[1:]))
        against += f", because it is {HOLDS[row.words]}" if row.far else ""
        if before := boxes.get(row.label):
            boxes[row.label] = before._replace(against="; ".join(filter(None, (before.against, against))))
            continue
        value, _, error = _text(row.measured).partition(" ± ")
        boxes[row.label] = NumberBox(heading(row.label, ""), value, row.unit.translate(POWERS), error, against)
    return list(boxes.values())


def table(rows: Sequence[MeasuredRow], width: int) -> list[str]:
    """The numbers as lines of a screen of so many columns."""
    labels = [row.label if k == 0 or row.label != rows[k - 1].label else "" for k, row in enumerate(rows)]
    cells = [("", "measured", "theory", "difference")]
    cells += [
        (label, measured if label else "", theory, off)
        for label, (measured, theory, off) in zip(labels, (row.numbers() for row in rows), strict=True)
    ]
    wide = [max(len(line[k]) for line in cells) for k in range(4)]
    wide[0] = max(8, min(wide[0], width - sum(wide[1:]) - 6))
    cut = [(label if len(label) <= wide[0] else f"{label[: wide[0] - 1]}…", *rest) for label, *rest in cells]
    return ["  ".join(cell.ljust(size) for cell, size in zip(line, wide, strict=True)).rstrip() for line in cut]


def at_gauges(summary: Mapping) -> str:
    """A line on the depths at the gauges of the case; empty where there are none."""
    waves = summary.get("waves") or {}
    columns = [waves.get(key) or () for key in ("gauges", "means", "largest")]
    each = [f"x = {x:zg} m {mean:z.2f} ({most:z.2f})" for x, mean, most in zip(*columns, strict=False)]
    return f"depth at gauges, mean of the window (largest), m: {', '.join(each)}" if each else ""


def sure(summary: Mapping) -> str:
    """In place of error bars of one run."""
    return ONE_DUMP if "given" in summary else ONE_RUN


def together(summaries: Sequence[Mapping], mean: Callable[[Sequence[float]], Mean]) -> dict[str, Any]:
    """One summary of starts of one case: means of those with the commonest verdict on a jump, errors half intervals.

    ``starts`` holds how many they are, and how many of them have the verdict.
    """
    kinds = [_at(one, "jump.verdict") for one in summaries]
    kind = Counter(kinds).most_common(1)[0][0]
    same = [one for one, its in zip(summaries, kinds, strict=True) if its == kind]
    return {**_means(same, mean), "starts": (len(same), len(summaries))}


def _means(found: Sequence[Mapping], mean: Callable[[Sequence[float]], Mean]) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for key, value in found[0].items():
        values = [one.get(key) for one in found]
        if isinstance(value, Mapping):
            made[key] = _means([one for one in values if isinstance(one, Mapping)], mean)
        elif isinstance(value, float) and not key.endswith("_error"):
            middle = mean([one for one in values if isinstance(one, float)])
            made |= {key: middle.value, f"{key}_error": middle.error if isfinite(middle.error) else None}
        elif not key.endswith("_error"):
            made[key] = value
    return made
