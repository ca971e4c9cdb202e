# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs at some points against what was measured: emulators of all numbers, their scatter, and the likelihood.

A curve is put into numbers by its principal components over the points: I. T. Jolliffe, Principal Component Analysis,
Springer 2002, ch. 2. Source of the likelihood: M. C. Kennedy and A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425.

The curves of the runs span a few components. What the measured curve has besides, no number of the case explains:
it tells what errors are possible. The likelihood is then a mean over these errors (A. Gelman et al., Bayesian Data
Analysis, 3rd ed., CRC 2013, sec. 3.1: a nuisance number is integrated out). An error that is alike over some length
has the covariance exp(-distance/length) (C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine
Learning, MIT Press 2006, sec. 4.2.1): the points of the curve are then fewer pieces of news than they are points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, nan

import numpy as np

from lammps_jump.errors import CaseError

from .posterior import Emulator, emulate, log_t
from .targets import FEWEST, UNSTATED_FEWEST, Target

POSSIBLE = 16
"""Possible errors that the likelihood is a mean over, all equally likely."""
LEAST, MOST = 1e-4, 0.25
"""Possible sizes, in ranges of the measured curve; who measures worse knows it, and can say it."""
SIZES, LENGTHS = 40, 5
"""Sizes, evenly in their logarithm, and lengths that are weighed."""
LONGEST = 0.5
"""Longest length over which an error is alike, in extents of the curve."""
ROUND_OFF = 1e-9
"""Added to the diagonal, in variances of the error: points may coincide."""
ROUGH = 1e-4
"""As `ROUND_OFF`, of the scatter over starts: part of its variance that each point has of its own."""


@dataclass(frozen=True)
class PossibleErrors:
    """Errors that a curve may have, all equally likely.

    Attributes
    ----------
    sizes : ndarray, shape (m,)
        Standard deviations, in the unit of the curve.
    lengths : ndarray, shape (m,)
        Over which they are alike, in the unit of the axis; 0 where each point has its own.
    at : ndarray, shape (k,)
        The axis of the curve.
    """

    sizes: np.ndarray
    lengths: np.ndarray
    at: np.ndarray

    @property
    def typical(self) -> float:
        """Median of the sizes."""
        return float(np.median(self.sizes))

    def in_numbers(self, directions: np.ndarray, scale: np.ndarray) -> np.ndarray:
        """Covariances in the numbers of a curve, shape (m, components, components).

        Parameters
        ----------
        directions : ndarray, shape (components, k)
        scale : ndarray, shape (k,)
        """
        onto = directions / scale
        shapes = {length: onto @ alike(self.at, length) @ onto.T for length in set(self.lengths)}
        return np.array([size**2 * shapes[length] for size, length in zip(self.sizes, self.lengths, strict=True)])


def alike(at: np.ndarray, length: float) -> np.ndarray:
    """Correlation of errors along a curve, shape (k, k): exp(-distance/length); each its own where the length is 0."""
    if not length:
        return np.eye(len(at))
    return np.exp(-np.abs(at[:, None] - at) / length) + ROUND_OFF * np.eye(len(at))


def possible_errors(
    at: np.ndarray, measured: np.ndarray, off_components: np.ndarray, own: np.ndarray, scatter: np.ndarray
) -> PossibleErrors:
    """Errors by how likely they make what a measured curve has outside the components of the runs.

    Parameters
    ----------
    at, measured : ndarray, shape (k,)
        The curve.
    off_components : ndarray, shape (k - components, k)
        Takes from a curve what no component explains; its rows are directions over the scales of the points.
    own : ndarray, shape (k - components,)
        What the measured curve has there.
    scatter : ndarray, shape (k, k)
        Covariance of the curve of a single run.
    """
    span = float(np.ptp(measured)) or float(np.abs(measured).max()) or 1.0
    sizes = span * np.geomspace(LEAST, MOST, SIZES)
    lengths = _lengths(at)
    known = off_components @ scatter @ off_components.T
    logs = np.array(
        [_logs(own, off_components @ alike(at, length) @ off_components.T, known, sizes) for length in lengths]
    )
    weights = np.exp(logs - logs.max()).ravel()
    drawn = np.searchsorted(np.cumsum(weights / weights.sum()), (np.arange(POSSIBLE) + 0.5) / POSSIBLE)
    length, size = np.unravel_index(np.minimum(drawn, weights.size - 1), logs.shape)
    return PossibleErrors(sizes[size], np.array(lengths)[length], at)


def _lengths(at: np.ndarray) -> list[float]:
    """Lengths over which errors along a curve may be alike; 0 is the first."""
    extent = float(np.ptp(at))
    return [0.0, *np.geomspace(extent / (len(at) - 1), LONGEST * extent, LENGTHS - 1)] if extent else [0.0]


def scatter_of(at: np.ndarray, off: np.ndarray, freedom: float) -> np.ndarray:
    """Covariance of the curve of a single run, shape (k, k), by what its starts differ from their mean.

    Of k points with f degrees of freedom the part k/(k + f) is that of a curve whose scatter is alike over the length
    that the starts tell.

    Parameters
    ----------
    at : ndarray, shape (k,)
    off : ndarray, shape (n, k)
    freedom : float
        Of `off`; 0 where no point of the ranges has two starts, and nothing is known.
    """
    covariance = off.T @ off / max(freedom, 1.0)
    sd = np.sqrt(np.diag(covariance))
    if not sd.any():
        return covariance
    some = sd > 0
    own, best, most = off[:, some] / sd[some], 0.0, -np.inf
    for length in _lengths(at):
        shape = alike(at[some], length) + ROUGH * np.eye(some.sum())
        log = -0.5 * (freedom * np.linalg.slogdet(shape)[1] + np.sum(own * np.linalg.solve(shape, own.T).T))
        if log > most:
            best, most = length, log
    keep = freedom / (freedom + len(at))
    return keep * covariance + (1 - keep) * alike(at, best) * np.outer(sd, sd)


def _logs(own: np.ndarray, shape: np.ndarray, known: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Log density of normal numbers of the covariance ``size^2 shape + known``, of each size."""
    from scipy.linalg import eigh

    # one decomposition for all sizes: in its basis both parts are diagonal
    values, vectors = eigh(known, shape + ROUND_OFF * np.trace(shape) / len(shape) * np.eye(len(shape)))
    variances = sizes[:, None] ** 2 + np.maximum(values, 0.0)
    turned = vectors.T @ own
    logs: np.ndarray = -0.5 * np.sum(turned**2 / variances + np.log(variances), axis=1)
    return logs + float(np.linalg.slogdet(vectors)[1])


def together(curves: Sequence[PossibleErrors]) -> np.ndarray:
    """Order in which possible errors of the curves go together, shape (m, curves): a Latin hypercube."""
    rng = np.random.default_rng(0)
    return np.array([rng.permutation(POSSIBLE) if k else np.arange(POSSIBLE) for k in range(len(curves))]).T


EXPLAINED = 0.99
"""Share of the variance over the points that the components of a curve hold."""
MOST_COMPONENTS = 4
MOST_POINTS = 400
"""Of a curve without a stated error; of more points every so manieth counts."""


@dataclass(frozen=True)
class TargetPart:
    """A target as numbers that the emulators hold: one of a number, components of a curve.

    Attributes
    ----------
    target : Target
        With the measured points that every run reaches; its error is the typical one of `possible` where there is one.
    centre, scale : ndarray, shape (k,)
        Subtracted from the values, and divided by.
    directions : ndarray, shape (components, k)
        Orthonormal.
    scatter : ndarray, shape (k,)
        Standard deviation over starts; NaN where it is not known.
    possible : PossibleErrors or None
        Errors that a curve may have which was measured without one.
    kept : ndarray of bool, shape (points of the measurement,)
        Those points that the model has: every run reaches them.
    """

    target: Target
    centre: np.ndarray
    scale: np.ndarray
    directions: np.ndarray
    scatter: np.ndarray
    possible: PossibleErrors | None = None
    kept: np.ndarray = field(default_factory=lambda: np.ones(1, bool))

    def into(self, values: np.ndarray) -> np.ndarray:
        """Numbers of values of shape (…, k): shape (…, components)."""
        return ((values - self.centre) / self.scale) @ self.directions.T

    @property
    def error_covariances(self) -> np.ndarray:
        """Of the measurement, in the numbers, shape (m, components, components): one, or those of possible errors."""
        if self.possible is not None:
            return self.possible.in_numbers(self.directions, self.scale)
        return ((self.directions * (self.target.error / self.scale) ** 2) @ self.directions.T)[None]

    def values(self, numbers: np.ndarray, variances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values and their variances, shape (…, k), of numbers and theirs, shape (…, components)."""
        return (
            self.centre + self.scale * (numbers @ self.directions),
            self.scale**2 * (variances @ self.directions**2),
        )


@dataclass(frozen=True)
class Model:
    """Emulators of all targets, and what the measurements say of a place.

    Attributes
    ----------
    parts : tuple of TargetPart
    emulators : tuple of Emulator
        Of all numbers of all parts, in their order.
    measured : ndarray, shape (numbers,)
    errors : ndarray, shape (m, numbers, numbers)
        Covariances of the measurement: one, or as many as are possible and equally likely, where a curve has none.
    scatter : ndarray, shape (numbers, numbers)
        Covariance of a single run.
    freedom : float
        Degrees of freedom of the scatter; 0 where no point has two starts.
    places : ndarray, shape (points, varied)
        In the unit cube: the points whose runs have all numbers.
    means : tuple of ndarray, shape (points, k)
        Of each target there.
    values : tuple of ndarray, shape (points, starts, k)
        Of the runs, NaN where one has none.
    """

    parts: tuple[TargetPart, ...]
    emulators: tuple[Emulator, ...]
    measured: np.ndarray
    errors: np.ndarray
    scatter: np.ndarray
    freedom: float
    places: np.ndarray
    means: tuple[np.ndarray, ...]
    values: tuple[np.ndarray, ...]

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Emulated numbers and their variances, shape (n, numbers)."""
        predictions = [one.at(places) for one in self.emulators]
        return np.array([mean for mean, _ in predictions]).T, np.array([variance for _, variance in predictions]).T

    def log_likelihood(self, places: np.ndarray) -> np.ndarray:
        """Of places in the unit cube, shape (n,), but for a constant.

        The scatter is known by its degrees of freedom alone: Student's t, with more of them where it is a smaller
        part of all (F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110).
        """
        mean, variance = self.at(places)
        return self.log_density(self.measured - mean, variance)

    def log_density(self, off: np.ndarray, variance: np.ndarray) -> np.ndarray:
        """As `log_likelihood`, of differences and emulators' variances, shape (n, numbers)."""
        densities = np.array([self._log_density(off, variance, error) for error in self.errors])
        most = densities.max(axis=0)
        return most + np.log(np.mean(np.exp(densities - most), axis=0))

    def _log_density(self, off: np.ndarray, variance: np.ndarray, error: np.ndarray) -> np.ndarray:
        """As `log_density`, for one covariance of the measurement."""
        whole = error + self.scatter + np.einsum("ni,ij->nij", variance, np.eye(len(self.measured)))
        total = np.trace(whole, axis1=1, axis2=2)
        share = np.trace(self.scatter) / total
        freedom = self.freedom / share**2 if self.freedom and np.trace(self.scatter) > 0 else np.full(len(off), inf)
        return log_t(off, whole, freedom)

    def target_at(self, number: int, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A target in its own unit and the emulator's standard deviation, shape (n, k)."""
        start = sum(len(part.directions) for part in self.parts[:number])
        own = slice(start, start + len(self.parts[number].directions))
        mean, variance = self.at(places)
        values, spread = self.parts[number].values(mean[:, own], variance[:, own])
        return values, np.sqrt(spread)

    def distances(self, places: np.ndarray) -> np.ndarray:
        """Distance of each target from its measurement, in errors of all kinds, shape (n, targets).

        Of a curve the root mean square over its points.
        """
        distances = []
        for number, part in enumerate(self.parts):
            values, sd = self.target_at(number, places)
            variance = part.target.error**2 + np.nan_to_num(part.scatter) ** 2 + sd**2
            distances.append(np.sqrt(np.mean((values - part.target.measured) ** 2 / variance, axis=1)))
        return np.array(distances).T

    def distances_of_points(self) -> np.ndarray:
        """As `distances`, of the runs themselves, shape (points, targets)."""
        distances = []
        for part, means in zip(self.parts, self.means, strict=True):
            variance = part.target.error**2 + np.nan_to_num(part.scatter) ** 2 + 1e-300
            distances.append(np.sqrt(np.mean((means - part.target.measured) ** 2 / variance, axis=1)))
        return np.array(distances).T

    def left_out(self, number: int) -> tuple[float, float]:
        """Leave-one-out error of a target: root mean square, and the same without the scatter of the point itself.

        In the unit of the target; of a curve over its points.
        """
        start = sum(len(part.directions) for part in self.parts[:number])
        part = self.parts[number]
        own = self.emulators[start : start + len(part.directions)]
        off = np.array([one.left_out for one in own]).T @ part.directions * part.scale
        noise = np.array([np.mean(one.process.alpha) * one.scale**2 for one in own]) @ part.directions**2
        noise = np.mean(noise * part.scale**2)
        square = float(np.mean(off**2))
        return float(np.sqrt(square)), float(np.sqrt(max(square - noise, 0.0)))


def model_of(places: np.ndarray, targets: Sequence[Target], values: Mapping[str, np.ndarray]) -> Model:
    """The model of runs at places of the unit cube.

    Parameters
    ----------
    places : ndarray, shape (points, varied)
    targets : sequence of Target
    values : mapping of str to ndarray, shape (points, starts, k)
        Of each target, NaN where a run has none; each point has a start that has all.

    Raises
    ------
    CaseError
        A curve that fewer than two measured points meet.
    """
    parts, numbers, means, kept = [], [], [], []
    for target in targets:
        target, known, reached = _reached(target, values[target.name])
        parts.append(replace(_part(target, known), kept=reached))
        numbers.append(parts[-1].into(known))
        means.append(np.nanmean(known, axis=1))
        kept.append(known)
    every = np.concatenate(numbers, axis=2)
    whole = np.isfinite(every).all(axis=2)
    starts = whole.sum(axis=1)
    centres = np.nanmean(np.where(whole[..., None], every, nan), axis=1)
    off = np.where(whole[..., None], every - centres[:, None], 0.0).reshape(-1, every.shape[2])
    freedom = float(np.sum(starts - 1))
    scatter = _pooled(off, freedom) if freedom else None
    emulators = tuple(
        emulate(places, centres[:, k], None if scatter is None else scatter[k, k] / starts)
        for k in range(every.shape[2])
    )
    if scatter is None:
        scatter = np.diag([one.scatter for one in emulators])
    measured = np.concatenate([part.into(part.target.measured) for part in parts])
    shared = emulators, measured, _errors(parts), scatter, freedom, places
    return Model(tuple(parts), *shared, tuple(means), tuple(kept))


def _errors(parts: Sequence[TargetPart]) -> np.ndarray:
    """Covariances of the measurement of all numbers, shape (m, numbers, numbers)."""
    curves = [part.possible for part in parts if part.possible is not None]
    which = together(curves) if curves else np.zeros((1, 0), int)
    covariances, column, start = np.zeros((len(which), *[sum(len(part.directions) for part in parts)] * 2)), 0, 0
    for part in parts:
        own = slice(start, start := start + len(part.directions))
        if part.possible is None:
            covariances[:, own, own] = part.error_covariances
        else:
            covariances[:, own, own] = part.error_covariances[which[:, column]]
            column += 1
    return covariances


def _reached(target: Target, values: np.ndarray) -> tuple[Target, np.ndarray, np.ndarray]:
    """A target at the measured points that all runs reach, their values there, and which points these are.

    A start without any is left out.
    """
    some = np.isfinite(values).any(axis=2)
    reached = np.isfinite(values[some]).all(axis=0)
    if reached.sum() < min(FEWEST, len(target.measured)):
        raise CaseError(
            f"{target.name}: {reached.sum()} of {len(reached)} measured points lie where every run has its curve; "
            f"{FEWEST} are needed; are the units the same (SI)?"
        )
    if not target.stated:
        reached &= np.arange(len(reached)) % -(-len(reached) // MOST_POINTS) == 0
        if reached.sum() < UNSTATED_FEWEST:
            raise CaseError(
                f"{target.name}: {reached.sum()} measured points lie where every run has its curve; {UNSTATED_FEWEST} "
                "are needed to estimate their error; write it behind the column: h ± 0.01"
            )
    at = target.at[reached] if target.axis else target.at
    found = Target(target.name, target.measured[reached], target.error[reached], target.axis, at)
    return found, values[..., reached], reached


def _part(target: Target, values: np.ndarray) -> TargetPart:
    """The components of a target over the points."""
    means = np.nanmean(values, axis=1)
    whole = np.isfinite(values).all(axis=2)
    freedom = float(np.sum(whole.sum(axis=1) - 1))
    off = np.where(whole[..., None], values - means[:, None], 0.0).reshape(-1, values.shape[2])
    scatter = np.sqrt(np.sum(off**2, axis=0) / freedom) if freedom else np.full(len(target.measured), nan)
    centre = means.mean(axis=0)
    if not target.axis:
        return TargetPart(target, centre, np.ones(1), np.ones((1, 1)), scatter)
    # without an error what the nearest run leaves is used for it, until the components are known
    error = target.error if target.stated else np.sqrt(np.mean((means - target.measured) ** 2, axis=1).min())
    spread = np.sqrt(error**2 + np.nan_to_num(scatter) ** 2)
    scale = np.maximum(spread, 1e-3 * means.std(axis=0).max() + 1e-300)
    _, sizes, directions = np.linalg.svd((means - centre) / scale, full_matrices=False)
    share = np.cumsum(sizes**2) / max(np.sum(sizes**2), 1e-300)
    most = MOST_COMPONENTS if target.stated else min(MOST_COMPONENTS, (len(target.at) - 1) // 2)
    count = min(int(np.searchsorted(share, EXPLAINED)) + 1, most, len(directions))
    part = TargetPart(target, centre, scale, directions[:count], scatter)
    return part if target.stated else _estimated(part, scatter_of(target.at, off, freedom))


def _estimated(part: TargetPart, scatter: np.ndarray) -> TargetPart:
    """A curve without an error, with those that it may have; `scatter` is the covariance of a single run, (k, k)."""
    target = part.target
    count = len(part.directions)
    off_components = np.linalg.qr(part.directions.T, mode="complete")[0].T[count:]
    own = off_components @ ((target.measured - part.centre) / part.scale)
    possible = possible_errors(target.at, target.measured, off_components / part.scale, own, scatter)
    known = replace(target, error=np.full(len(target.at), possible.typical))
    return replace(part, target=known, possible=possible)


def _pooled(off: np.ndarray, freedom: float) -> np.ndarray:
    """Covariance of single runs, pooled over the points; nearer to a diagonal one where it is known badly.

    Of k numbers with f degrees of freedom the part k/(k + f) of what is off the diagonal is left out.
    """
    covariance = off.T @ off / freedom
    keep = freedom / (freedom + len(covariance))
    return keep * covariance + (1 - keep) * np.diag(np.diag(covariance))
