# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole steps of a run: how many, from frame to frame, and in a window of the probes."""

from __future__ import annotations

from collections.abc import Iterable
from math import isqrt
from typing import NamedTuple

import numpy as np

from .scene import Stations
from .walls import Interval

TOLD = 1e-3
"""Relative change of an asked time from which on it is told; the duration is not changed by more where that can be."""
WIDEST = 0.02
"""Largest relative change of the frame interval that is tried to keep the duration."""
WINDOW_WEIGHT = 0.1
"""Weight of a change of the window against one of the frame interval: forces are averaged over 0.05 s anyway."""
MOST_TRIED = 401
"""Frame intervals that are tried."""


class Schedule(NamedTuple):
    """Steps of the run, from frame to frame, and of a window of the probes; each divides the one before."""

    run: int
    output: int
    probe: int


def plan_steps(duration: float, output_interval: float, probe_interval: float | None, time_step: float) -> Schedule:
    """Whole steps nearest to times in s; windows and frames are adapted before the duration is.

    Of the frame intervals near the one asked for, those that keep the duration within `TOLD` are taken, else the one
    that changes it least; of them the one for which frame interval and window are nearest to what was asked.

    Parameters
    ----------
    duration, output_interval, time_step : float
        s.
    probe_interval : float or None
        s; None where nothing is probed: a window is a frame interval then.
    """
    frames = max(1, min(round(duration / output_interval), round(duration / time_step)))
    output = max(1, round(duration / (frames * time_step)))
    if probe_interval is None:
        return Schedule(frames * output, output, output)
    asked, whole = duration / frames / time_step, duration / time_step
    wanted = min(max(1.0, probe_interval / time_step), asked)
    reach = min(int(WIDEST * output), MOST_TRIED // 2)
    plans = []
    for tried in range(output - reach, output + reach + 1):
        number = max(1, round(whole / tried))
        late = abs(number * tried / whole - 1.0)
        divisors = _divisors(tried)
        probe = int(divisors[np.argmin(np.abs(np.log(divisors / wanted)))])
        worst = max(abs(tried / asked - 1.0), WINDOW_WEIGHT * abs(probe / wanted - 1.0))
        plans.append((max(late, TOLD), worst, late, Schedule(number * tried, tried, probe)))
    return min(plans)[-1]


def _divisors(n: int) -> np.ndarray:
    low = np.arange(1, isqrt(n) + 1)
    low = low[n % low == 0]
    return np.union1d(low, n // low)


def told(asked: dict[str, tuple[float, float]], unit: str = "s") -> tuple[str, ...]:
    """Sentences on values that differ from what was asked by more than `TOLD`.

    Parameters
    ----------
    asked : mapping of the field's name to (asked, made)
    """
    return tuple(
        f"{name}: {made:.4g} {unit} in place of {value:.4g} {unit}, because time goes in whole steps"
        for name, (value, made) in asked.items()
        if abs(made - value) > TOLD * abs(value)
    )


def plan_stations(
    x: Interval, speed: float, window: Interval, time_step: float, steps: Schedule, settle_steps: int,
    barred: Iterable[float], least: float,
) -> Stations:  # fmt: skip
    """Stations at `x` (m) that move at `speed` (m/s) from the first to the last frame of a window (s).

    Parameters
    ----------
    time_step : float
        s.
    barred : iterable of float
        Places along x where discs come or go, m; they keep a distance of `least` from the stretch between the stations.
    least : float
        Least distance of the two stations, m.

    Raises
    ------
    ValueError
        The window holds no two frames of the run, or the stations are too close, or a barred place is between them.
    """
    first, last = (round((time / time_step + settle_steps) / steps.output) * steps.output for time in window)
    if not 0 <= first < last <= settle_steps + steps.run:
        raise ValueError(
            f"window [{window[0]:g}, {window[1]:g}] s; allowed are times of two frames or more within "
            f"[{-settle_steps * time_step:g}, {steps.run * time_step:g}] s"
        )
    if x[1] - x[0] < least:
        raise ValueError(f"x [{x[0]:g}, {x[1]:g}] m; allowed is a distance of {least:g} m, two discs, or more")
    moved = speed * (last - first) * time_step
    low, high = x[0] + min(0.0, moved), x[1] + max(0.0, moved)
    for place in barred:
        if low - least < place < high + least:
            raise ValueError(
                f"the stations pass x = {low:.4g} to {high:.4g} m, and discs come or go at {place:g} m; allowed is a "
                f"stretch that stays {least:g} m away from it: move the stations or shorten the window"
            )
    return Stations(x, speed, first, last)
