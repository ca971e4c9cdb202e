# SPDX-License-Identifier: GPL-2.0-or-later
"""Answer of ``calibration.json``: numbers that the measurements tell, what hides the others, what to measure besides.

The expected variance after another measurement is a mean over the posterior of what it would then be: D. V. Lindley,
Ann. Math. Statist. 27 (1956) 986, with the variance in place of the entropy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isfinite, sqrt
from typing import Any

import numpy as np

from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.statistics import student
from lammps_jump.sweeps import study as fields
from lammps_jump.sweeps.table import number_at
from lammps_jump.units import numbers_of, shown

from .besides import NearestEffects, movers
from .model import Model, TargetPart
from .posterior import Posterior, emulate, sobol
from .study import Calibration

WIDE = 0.5
"""A 95 % range of more than this part of the prior tells nothing of its number."""
EDGE, BINS = 0.5, 20
"""A posterior whose outermost of so many bins holds this part of its fullest one continues beyond its range."""
RIDGE = 0.5
"""Size of a correlation, or of a correlation ratio, at which one number compensates another."""
AS_GOOD = 0.6
"""Part of the largest likelihood that fits about as well: one standard deviation of one number."""
WORTH = 0.2
"""Least part of the standard deviation that a further measurement must take away."""
NOT_MEASURED = ("inflow", "energy", "state")
"""Quantities of the runs that no laboratory measures."""
FIRST, KNOWN, LISTED = 24, 0.8, 3
"""Truths that are tried for each measurement; least part of the points that have its number; measurements listed."""
LOOKED_AT = 2048
"""Places of the ranges where the model is looked for that meets the data best."""


@dataclass(frozen=True)
class Parameter:
    """Knowledge of one varied number.

    Attributes
    ----------
    best, low, high : float
        Best value and 95 % range.
    prior : (float, float)
        The range that the study gives.
    identified : bool
        The 95 % range is at most half as wide as the prior.
    at_edge : bool
        The best values lie at one end of the prior, so that better ones may lie beyond it.
    edge : str
        'low', 'high' or ''.
    """

    best: float
    low: float
    high: float
    prior: tuple[float, float]
    identified: bool
    at_edge: bool
    edge: str


def parameter(posterior: Posterior, number: int, prior: tuple[float, float]) -> Parameter:
    """A varied number by its posterior; `prior` is its range."""
    wide = prior[1] - prior[0]
    low, high = posterior.range_of(number)
    counts, _ = np.histogram(posterior.places[:, number], BINS, (0.0, 1.0), weights=posterior.weights)
    ends = counts[0] >= EDGE * counts.max(), counts[-1] >= EDGE * counts.max()
    edge = "" if ends[0] == ends[1] else ("low" if ends[0] else "high")
    best, low, high = (float(prior[0] + wide * value) for value in (posterior.best[number], low, high))
    return Parameter(best, low, high, prior, high - low <= WIDE * wide, bool(edge), edge)


def partner(posterior: Posterior, number: int) -> tuple[int, float] | None:
    """The varied number that hides another one: its number and how much of it; None where none does.

    How much is the size of their correlation, or, where a ridge is bent, the correlation ratio: the square root of the
    part of the variance that a mean at each value of the other one explains.
    """
    correlations = {
        other: max(abs(float(posterior.correlation[number, other])), _ratio(posterior, number, other))
        for other in range(len(posterior.best)) if other != number
    }  # fmt: skip
    other = max(correlations, key=lambda one: correlations[one], default=None)
    return (other, correlations[other]) if other is not None and correlations[other] > RIDGE else None


def _ratio(posterior: Posterior, number: int, other: int) -> float:
    """Correlation ratio of a varied number over another one (K. Pearson, 1905), by bins of the other one."""
    w, x = posterior.weights, posterior.places[:, number]
    bins = np.minimum((posterior.places[:, other] * BINS).astype(int), BINS - 1)
    mass = np.bincount(bins, w, BINS)
    means = np.bincount(bins, w * x, BINS) / np.maximum(mass, 1e-300)
    return float(np.sqrt(np.sum(mass * (means - w @ x) ** 2) / posterior.covariance[number, number]))


def along(posterior: Posterior, number: int, other: int) -> list[tuple[float, float]]:
    """Two places of the unit cube that fit about as well as the best: one low and one high along a varied number.

    Among the places of at least `AS_GOOD` of the largest likelihood these are the likeliest of the lowest and of the
    highest part.
    """
    good = np.flatnonzero(posterior.weights >= AS_GOOD * posterior.weights.max())
    order = good[np.argsort(posterior.places[good, number], kind="stable")]
    some = max(1, len(order) // 10)
    ends = [part[int(np.argmax(posterior.weights[part]))] for part in (order[:some], order[-some:])]
    return [(float(posterior.places[one, number]), float(posterior.places[one, other])) for one in ends]


def candidates(summaries: Mapping[int, Sequence[Mapping[str, Any]]], taken: Sequence[str]) -> dict[str, np.ndarray]:
    """Numbers of the runs that could be measured: shape (points, starts), NaN where a run has none.

    Parameters
    ----------
    summaries : mapping of int to sequence of mapping
        Summaries of the starts of each point.
    taken : sequence of str
        Keys that are measured already.
    """
    by_candidate: dict[str, np.ndarray] = {}
    starts = max(map(len, summaries.values()))
    for name, quantity in ((name, one) for name, one in QUANTITIES.items() if name not in NOT_MEASURED):
        for key, number in numbers_of(quantity.result).items():
            path = f"{name}.{key}"
            if path in taken or number.meaning.startswith("standard error") or key.endswith(("_interval", "_error")):
                continue
            rows = [[number_at(one, path) for one in group] for group in summaries.values()]
            values = np.array([row + [np.nan] * (starts - len(row)) for row in rows])
            if np.isfinite(values).any(axis=1).mean() >= KNOWN:
                by_candidate[path] = values
    return by_candidate


def reduction(posterior: Posterior, number: int, places: np.ndarray, values: np.ndarray) -> float:
    """Part of the standard deviation of a varied number that a measurement of `values` is expected to take away.

    Its error is the scatter over starts, as of one experiment. Numbers that are the varied number itself, or do not
    vary, tell nothing.

    Parameters
    ----------
    posterior : Posterior
    number : int
    places : ndarray, shape (points, varied)
        In the unit cube.
    values : ndarray, shape (points, starts)
        Of the runs, NaN where there is none.
    """
    some = np.isfinite(values).any(axis=1)
    places, values = places[some], values[some]
    means, starts = np.nanmean(values, axis=1), np.isfinite(values).sum(axis=1)
    freedom = np.sum(starts - 1)
    scatter = float(np.nansum((values - means[:, None]) ** 2) / freedom) if freedom else np.nan
    if np.ptp(means) <= 1e-9 * np.abs(means).max() or np.abs(np.corrcoef(means, places.T)[0, 1:]).max() > 1 - 1e-9:
        return 0.0
    emulator = emulate(places, means, None if np.isnan(scatter) else scatter / starts)
    drawn = posterior.drawn(400)
    mean, variance = emulator.at(drawn)
    variance = variance + (emulator.scatter if np.isnan(scatter) else scatter) + 1e-12 * np.ptp(means) ** 2
    own, left = drawn[:, number], []
    for truth in np.linspace(0, len(drawn) - 1, FIRST).astype(int):
        off = np.array([-1.0, 0.0, 1.0])[:, None] * np.sqrt(variance[truth])
        log = -0.5 * ((mean[truth] + off - mean) ** 2 / variance + np.log(variance))
        weights = np.exp(log - log.max(axis=1, keepdims=True))
        weights /= weights.sum(axis=1, keepdims=True)
        spread = np.sum(weights * own**2, axis=1) - np.sum(weights * own, axis=1) ** 2
        left.append(spread @ np.array([0.25, 0.5, 0.25]))
    return float(1.0 - np.sqrt(max(np.mean(left), 0.0) / max(np.var(own), 1e-300)))


def best_measurements(
    posterior: Posterior, number: int, places: np.ndarray, known: Mapping[str, np.ndarray]
) -> list[dict[str, Any]]:
    """The measurements that tell most of a varied number: key and `reduction`, the best first."""
    reductions = {path: reduction(posterior, number, places, values) for path, values in known.items()}
    order = sorted(reductions, key=lambda path: -reductions[path])[:LISTED]
    return [{"key": path, "reduction": reductions[path]} for path in order if reductions[path] >= WORTH]


def unmet(
    model: Model, posterior: Posterior, near: int = 0, besides: NearestEffects | None = None
) -> list[dict[str, Any]]:
    """Targets that are not within their errors where the model comes nearest to all of them; none where one place is.

    Within means the 95 % of Student's t or a normal number, shared among the targets (Bonferroni).

    Parameters
    ----------
    model : Model
    posterior : Posterior
    near : int
        Point of the model at which other numbers were changed.
    besides : Besides, optional
        Runs with these changes.
    """
    limit = student(model.freedom or 1e6, 1.0 - 0.025 / len(model.parts))
    places = np.vstack([posterior.drawn(LOOKED_AT), sobol(LOOKED_AT, posterior.places.shape[1], 0)])
    distances = model.distances(places)
    of_runs = model.distances_of_points()
    if min(distances.max(axis=1).min(), of_runs.max(axis=1).min()) <= limit:
        return []
    nearest = int(np.argmin(distances.max(axis=1)))
    unmet_targets = []
    for number, part in enumerate(model.parts):
        if distances[nearest, number] > limit:
            values, _ = model.target_at(number, places)
            at = values[int(np.argmin(distances[:, number]))] if len(model.parts) == 1 else values[nearest]
            one = _unmet(part, at, float(distances[nearest, number]))
            moving = movers(model, part, near, besides) if besides is not None else []
            unmet_targets.append({**one, **_reach(part, model.values[number], limit), "moved_by": moving})
    return unmet_targets


def _unmet(part: TargetPart, near: np.ndarray, distance: float) -> dict[str, Any]:
    target, curve = part.target, bool(part.target.axis)
    numbers = {"measured": None, "error": None, "at_nearest": None} if curve else {
        "measured": float(target.measured[0]), "error": float(target.error[0]), "at_nearest": float(near[0])
    }  # fmt: skip
    return {"name": target.name, "curve": curve, "distance": distance, **numbers}


def _reach(part: TargetPart, values: np.ndarray, limit: float) -> dict[str, Any]:
    """Range that all runs of a target reach: least and largest number, and how many measured points lie beyond them."""
    target = part.target
    low, high = (take(values, axis=(0, 1)) for take in (np.nanmin, np.nanmax))
    below, above = (low - limit * target.error > target.measured), (high + limit * target.error < target.measured)
    runs = None if target.axis else [float(low[0]), float(high[0])]
    return {"runs": runs, "points": len(target.measured), "above": int(above.sum()), "below": int(below.sum())}


def answer(
    study: Calibration, model: Model, posterior: Posterior, summaries: Mapping[int, Sequence[Mapping[str, Any]]],
    not_met: list[dict[str, Any]],
) -> dict[str, Any]:  # fmt: skip
    """Result of the runs, as plain data: parameters, correlation, targets, leave-one-out, unmet targets.

    Parameters
    ----------
    study : Calibration
    model : Model
    posterior : Posterior
    summaries : mapping of int to sequence of mapping
        Of the starts of each of the model's points.
    not_met : list of dict
        As of `unmet`.
    """
    paths, parameters = study.paths, {}
    known: dict[str, np.ndarray] | None = None
    for number, path in enumerate(paths):
        one = parameter(posterior, number, study.vary[path])
        parameters[path] = {**asdict(one), "hidden_by": None, "ridge": None, "measure": []}
        if one.identified:
            continue
        if known is None:
            known = candidates(summaries, [target.name for target in study.targets])
        parameters[path]["measure"] = best_measurements(posterior, number, model.places, known)
        if other := partner(posterior, number):
            ends = along(posterior, number, other[0])
            pairs = [[_back(study, number, a), _back(study, other[0], b)] for a, b in ends]
            parameters[path] |= {"hidden_by": paths[other[0]], "ridge": pairs}
    correlation = posterior.correlation
    return {
        "parameters": parameters,
        "correlation": {
            a: {b: float(correlation[i, j]) for j, b in enumerate(paths) if j != i} for i, a in enumerate(paths)
        },
        "targets": {part.target.name: _target(model, number, posterior) for number, part in enumerate(model.parts)},
        "loo": {part.target.name: _loo(model, number) for number, part in enumerate(model.parts)},
        "unmet": not_met,
        "scatter_known": model.freedom > 0,
    }


def _back(study: Calibration, number: int, value: float) -> float:
    low, high = study.bounds[number]
    return float(low + value * (high - low))


def _target(model: Model, number: int, posterior: Posterior) -> dict[str, Any]:
    """A target as it was measured, at the best place, and its scatter over starts."""
    part = model.parts[number]
    values, sd = model.target_at(number, posterior.best[None])
    lists = {"measured": part.target.measured, "error": part.target.error, "at_best": values[0], "emulator": sd[0],
             "spread": part.scatter}  # fmt: skip
    if part.target.axis:
        return {**lists, "axis": part.target.axis, "at": part.target.at, "error_stated": part.possible is None}
    return {key: float(one[0]) for key, one in lists.items()}


def _loo(model: Model, number: int) -> dict[str, Any]:
    """Leave-one-out error of a target, compared with the error that it may have."""
    part = model.parts[number]
    whole, own = model.left_out(number)
    allowed = float(np.sqrt(np.mean(part.target.error**2 + np.nan_to_num(part.scatter) ** 2)))
    return {"rms": whole, "emulator": own, "allowed": allowed, "too_large": bool(own > allowed > 0)}


def no_answer(study: Calibration, points: int, good: int, needed: int) -> dict[str, Any]:
    """As `answer`, where too few points have all the targets."""
    nothing = {"best": None, "low": None, "high": None, "identified": False, "at_edge": False, "edge": ""}
    said = f"No answer: {good} of {points} points have all the targets, and {needed} are needed."
    return {
        "parameters": {path: {**nothing, "prior": list(prior)} for path, prior in study.vary.items()},
        "correlation": {},
        "targets": {},
        "loo": {},
        "unmet": [],
        "scatter_known": None,
        "verdict": said,
    }


def with_words(data: dict[str, Any]) -> dict[str, Any]:
    """The answer with its verdict and notes in front."""
    if "verdict" in data:
        return {**data, "notes": failed_text(data["failures"])}
    return {"verdict": verdict_of(data), "notes": notes(data), **data}


# --- result of a calibration, in sentences ----------------------------------------------------------------------------


UNKNOWN_SCATTER = (
    "The scatter over starts is not known: every point has one start. What the emulator leaves unexplained stands for "
    "it. Take --members 2 or more."
)


def named(path: str) -> str:
    """A varied number in words, with its path where the words are others."""
    return fields.axis_words(path)


def short(path: str) -> str:
    """A varied number on a line of progress: its path without the first part."""
    return path.partition(".")[2] or path


def brief(value: float) -> str:
    """A number with three digits, without a power of ten."""
    return shown(float(f"{value:z.3g}"))


def ranged(path: str, parameter: Mapping[str, Any]) -> str:
    """Best value and 95 % range."""
    unit = fields.axis_unit(path)
    half = max(0.5 * (parameter["high"] - parameter["low"]), 1e-12)
    best, low, high = (shown(parameter[key], error=half, alone=True) for key in ("best", "low", "high"))
    return f"{named(path)} {best}{f' {unit}' if unit else ''} (95 %: {low} to {high})"


def verdict_of(data: Mapping[str, Any]) -> str:
    """The answer in a few sentences, of the content of ``calibration.json`` without its verdict."""
    identified = [(path, one) for path, one in data["parameters"].items() if one["identified"]]
    hidden = [(path, one) for path, one in data["parameters"].items() if not one["identified"]]
    said = []
    if data["unmet"]:
        said.append("The model cannot meet the data: " + "; ".join(map(unmet_text, data["unmet"])) + ".")
        said += [
            f"{one['name']} is moved by the {' and the '.join(named(change['path']) for change in one['moved_by'])}."
            for one in data["unmet"]
            if one["moved_by"]
        ]
        if identified:
            said.append("Nearest to the data: " + "; ".join(ranged(path, one) for path, one in identified) + ".")
    elif identified:
        said.append("The measurements give: " + "; ".join(ranged(path, one) for path, one in identified) + ".")
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
        sentence = f"{one['name']} stays {one['distance']:z.1f} errors from the measured curve (root mean square)"
        sides = [f"{side} all runs at {one[side]}" for side in ("above", "below") if one[side]]
        return f"{sentence}, which lies {' and '.join(sides)} of its {one['points']} points" if sides else sentence
    sentence = f"{one['name']} was measured as {shown(one['measured'])} ± {shown(one['error'], digits=2)}"
    low, high = map(shown, one["runs"])
    if one["above"] or one["below"]:
        return f"{sentence}, and no run of the ranges reaches it: they have {low} to {high}"
    near = f"the nearest value is {shown(one['at_nearest'])}"
    return f"{sentence}, and {near}; there are runs that reach it ({low} to {high}), and miss another target"


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
    sentence = f"{named(change['path'])} {brief(change['before'])} to {brief(change['after'])} "
    part = f"{100 * abs(change['closes']):z.0f} % of the gap"
    toward = f"closes {part}" if change["closes"] > 0 else f"widens it by {part}"
    if "from_value" not in change:
        return sentence + toward
    return f"{sentence}{toward} ({shown(change['from_value'])} to {shown(change['to_value'])})"


def notes(data: Mapping[str, Any]) -> list[str]:
    """Notes in addition to the verdict: edges, ridges, advice, emulator, failed runs, errors not given."""
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
        return []  # reported for the other one
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
    return ", ".join(f"{named(path)} = {shown(value, fields.axis_unit(path))}" for path, value in values.items())
