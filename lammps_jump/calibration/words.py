# SPDX-License-Identifier: GPL-2.0-or-later
"""Result of a calibration, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, sqrt
from typing import Any

from lammps_jump.sweeps import words as fields
from lammps_jump.units import shown

UNKNOWN_SCATTER = (
    "The scatter over starts is not known: every point has one start. What the emulator leaves unexplained stands for "
    "it. Take --members 2 or more."
)


def named(path: str) -> str:
    """A varied number in words, with its path where the words are others."""
    return fields.words(path)


def short(path: str) -> str:
    """A varied number on a line of progress: its path without the first part."""
    return path.partition(".")[2] or path


def brief(value: float) -> str:
    """A number with three digits, without a power of ten."""
    return shown(float(f"{value:z.3g}"))


def ranged(path: str, found: Mapping[str, Any]) -> str:
    """Best value and 95 % range."""
    unit = fields.unit(path)
    half = max(0.5 * (found["high"] - found["low"]), 1e-12)
    best, low, high = (shown(found[key], error=half, alone=True) for key in ("best", "low", "high"))
    return f"{named(path)} {best}{f' {unit}' if unit else ''} (95 %: {low} to {high})"


def verdict_of(data: Mapping[str, Any]) -> str:
    """The answer in a few sentences, of the content of ``calibration.json`` without its verdict."""
    told = [(path, one) for path, one in data["parameters"].items() if one["identified"]]
    hidden = [(path, one) for path, one in data["parameters"].items() if not one["identified"]]
    said = []
    if data["unmet"]:
        said.append("The model cannot meet the data: " + "; ".join(map(unmet_text, data["unmet"])) + ".")
        said += [
            f"{one['name']} is moved by the {' and the '.join(named(change['path']) for change in one['moved_by'])}."
            for one in data["unmet"]
            if one["moved_by"]
        ]
        if told:
            said.append("Nearest to the data: " + "; ".join(ranged(path, one) for path, one in told) + ".")
    elif told:
        said.append("The measurements give: " + "; ".join(ranged(path, one) for path, one in told) + ".")
    for path, one in hidden:
        low, high = one["prior"]
        said.append(
            f"The {named(path)} is not identified: its 95 % range, {brief(one['low'])} to "
            f"{brief(one['high'])}, is more than half of {low:zg} to {high:zg}."
        )
    return " ".join(said)


def unmet_text(one: Mapping[str, Any]) -> str:
    """A target that no point comes near, and what the runs reach."""
    if one["curve"]:
        told = f"{one['name']} stays {one['distance']:z.1f} errors from the measured curve (root mean square)"
        sides = [f"{side} all runs at {one[side]}" for side in ("above", "below") if one[side]]
        return f"{told}, which lies {' and '.join(sides)} of its {one['points']} points" if sides else told
    told = f"{one['name']} was measured as {shown(one['measured'])} ± {shown(one['error'], digits=2)}"
    low, high = map(shown, one["runs"])
    if one["above"] or one["below"]:
        return f"{told}, and no run of the ranges reaches it: they have {low} to {high}"
    near = f"the nearest value is {shown(one['at_nearest'])}"
    return f"{told}, and {near}; there are runs that reach it ({low} to {high}), and miss another target"


def moved_text(data: Mapping[str, Any]) -> list[str]:
    """Sentence on other numbers of the case that move unmet targets, and on those that could not be tried."""
    if not data["unmet"]:
        return []
    tried, left = data["besides"]["tried"], data["besides"]["left"]
    said = []
    for one in data["unmet"]:
        if one["moved_by"]:
            each = "; ".join(_moved(change) for change in one["moved_by"])
            said.append(f"What moves {one['name']}, at the nearest point: {each}.")
        elif tried:
            said.append(f"{one['name']}: none of these numbers moves it: {', '.join(map(named, tried))}.")
    helps = next((change for one in data["unmet"] for change in one["moved_by"] if change["closes"] > 0), None)
    if helps:
        ends = sorted((helps["before"], helps["after"] + (helps["after"] - helps["before"])))
        said.append(f"Vary such a number too, for example --vary {helps['path']}={ends[0]:z.3g}:{ends[1]:z.3g}.")
    if left:
        said.append(
            f"The budget had no runs left to try whether it is moved by: {', '.join(map(named, left))}. A larger "
            "--budget tries them."
        )
    return said


def _moved(change: Mapping[str, Any]) -> str:
    """A change and what it does to a target."""
    told = f"{named(change['path'])} {brief(change['before'])} to {brief(change['after'])} "
    part = f"{100 * abs(change['closes']):z.0f} % of the gap"
    toward = f"closes {part}" if change["closes"] > 0 else f"widens it by {part}"
    if "from_value" not in change:
        return told + toward
    return f"{told}{toward} ({shown(change['from_value'])} to {shown(change['to_value'])})"


def notes(data: Mapping[str, Any]) -> list[str]:
    """Notes beside the verdict: edges, ridges, advice, the emulator, failed runs, errors not given."""
    said = moved_text(data)
    for path, one in data["parameters"].items():
        if one["at_edge"]:
            side = "upper" if one["edge"] == "high" else "lower"
            end = one["prior"][1 if side == "upper" else 0]
            wider = ": values behind it may be as likely. Widen the range (--vary)" if end or side == "upper" else ""
            said.append(f"What is likely of the {named(path)} reaches the {side} edge of its range, {end:zg}{wider}.")
        if not one["identified"]:
            said += hidden_text(path, data)
    for name, loo in data["loo"].items():
        if loo["too_large"]:
            said.append(
                f"{name}: the emulator is off by {shown(loo['emulator'], digits=2)} where a point is left out, more "
                f"than the error of the target, {shown(loo['allowed'], digits=2)}. A larger --budget or narrower "
                "ranges help."
            )
    said += [UNKNOWN_SCATTER] if data["scatter_known"] is False else []
    for name, target in data["targets"].items():
        if target.get("error_stated") is False:
            said.append(estimated_text(name, target))
    said += failed_text(data["failures"])
    return said


def estimated_text(name: str, target: Mapping[str, Any]) -> str:
    """Sentence on the error that is assumed of a curve that was measured without one."""
    error, values = target["error"][0], target["measured"]
    share = 100 * error / ((max(values) - min(values)) or 1.0)
    spread = [one for one in target["spread"] if one is not None and isfinite(one)]
    scatter = sqrt(sum(one * one for one in spread) / len(spread)) if spread else 0.0
    hides = f"; the scatter over starts, {shown(scatter, digits=2)}, hides smaller ones" if scatter > error else ""
    return (
        f"{name}: no error was given. About {shown(error, digits=2)} is estimated ({share:z.0f} % of the range of the "
        f"curve{hides}), from what the curves of the runs cannot follow; the 95 % ranges are as wide as that is "
        "uncertain. Write the error behind the column where it is known: h ± 0.01."
    )


def hidden_text(path: str, data: Mapping[str, Any]) -> list[str]:
    """Why a number is not identified, and what to measure."""
    one, said = data["parameters"][path], []
    other = one["hidden_by"]
    if (
        other
        and data["parameters"][other]["hidden_by"] == path
        and list(data["parameters"]).index(other) < list(data["parameters"]).index(path)
    ):
        return []  # told of the other one
    if other:
        first, second = one["ridge"]
        pair = [f"{brief(a)} with {brief(b)}" for a, b in (first, second)]
        said.append(
            f"The {named(path)} and the {named(other)} hide each other (correlation "
            f"{data['correlation'][path][other]:z.2f}): {pair[0]} (A) fits about as well as "
            f"{pair[1]} (B)."
        )
    else:
        said.append(f"The targets tell little of the {named(path)}.")
    if one["measure"]:
        first = one["measure"][0]
        said.append(
            f"Measure {first['key']} too: it is expected to take {100 * first['reduction']:z.0f} % off the range of "
            f"the {named(path)}."
        )
    else:
        said.append(f"No other number of these runs would tell the {named(path)} apart.")
    return said


def failed_text(failures: Sequence[Mapping[str, Any]]) -> list[str]:
    """Points that are out: how many, and each with its values and its reason."""
    if not failures:
        return []
    count = len(failures)
    head = f"{count} run{'s' * (count > 1)} {'are' if count > 1 else 'is'} left out:"
    return [head] + [f"{point_text(one['values'])}, start {one['seed']}: {one['message']}" for one in failures]


def point_text(values: Mapping[str, float]) -> str:
    """Values of a point in words."""
    return ", ".join(f"{named(path)} = {shown(value, fields.unit(path))}" for path, value in values.items())
