# SPDX-License-Identifier: GPL-2.0-or-later
"""Whole steps of a run: how many, from frame to frame, and in a window of the probes."""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil, isqrt
from typing import NamedTuple

import numpy as np

from .scene import InitialState, Stations
from .walls import Interval

TOLD = 1e-3
"""Relative change of a requested time above which a note is printed; the duration changes by less where it can."""
WIDEST = 0.02
"""Largest relative change of the frame interval that is tried to keep the duration."""
WINDOW_WEIGHT = 0.1
"""Weight of a change of the window against one of the frame interval: forces are averaged over 0.05 s anyway."""
MOST_TRIED = 401
"""Frame intervals that are tried."""
MOST_BINS = 100_000
"""Bins of the profiles along a channel, at most."""
MOST_FRAMES = 1_000_000
"""Frames of a run, and of a dump that is read."""
MOST_FINER = 0.02
"""Largest share by which the step is made finer so that windows and frames are whole steps."""


class Schedule(NamedTuple):
    """Steps of the run, from frame to frame, and of a window of the probes; each divides the one before."""

    run: int
    output: int
    probe: int


def fitted_step(duration: float, output_interval: float, probe_interval: float | None, longest: float) -> float:
    """Time step, s, of which window, frame interval and duration are whole multiples; at most `longest`.

    It is finer than `longest` by at most `MOST_FINER`. Where that is too little for the windows of the probes, it suits
    frames and duration; where it is too little for these, it is `longest`.

    Parameters
    ----------
    duration, output_interval, longest : float
        s.
    probe_interval : float or None
        s; None where nothing is probed.
    """
    frame = duration / max(1, round(duration / output_interval))
    window = frame / max(1, round(frame / (probe_interval or frame)))
    for interval in (window, frame):
        step = interval / ceil(interval / longest * (1 - 1e-9))
        if (1 - MOST_FINER) * longest <= step < (1 - 1e-9) * longest:
            return step
    return longest


def plan_steps(duration: float, output_interval: float, probe_interval: float | None, time_step: float) -> Schedule:
    """Whole steps nearest to times in s; windows and frames are adapted before the duration is.

    Of the frame intervals near the requested one, those that keep the duration within `TOLD` are taken, else the one
    that changes it least; of them the one for which frame interval and window are nearest to the requested ones.

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
    steps_between, whole = duration / frames / time_step, duration / time_step
    wanted = min(max(1.0, probe_interval / time_step), steps_between)
    reach = min(int(WIDEST * output), MOST_TRIED // 2)
    plans = []
    for tried in range(output - reach, output + reach + 1):
        number = max(1, round(whole / tried))
        late = abs(number * tried / whole - 1.0)
        divisors = _divisors(tried)
        probe = int(divisors[np.argmin(np.abs(np.log(divisors / wanted)))])
        worst = max(abs(tried / steps_between - 1.0), WINDOW_WEIGHT * abs(probe / wanted - 1.0))
        plans.append((max(late, TOLD), worst, late, Schedule(number * tried, tried, probe)))
    return min(plans)[-1]


def _divisors(n: int) -> np.ndarray:
    low = np.arange(1, isqrt(n) + 1)
    low = low[n % low == 0]
    return np.union1d(low, n // low)


def rounding_notes(
    values: dict[str, tuple[float, float]], unit: str = "s", why: str = "time goes in whole steps"
) -> tuple[str, ...]:
    """Sentences on values that differ from the requested ones by more than `TOLD`.

    Parameters
    ----------
    values : mapping of the field's name to (requested, made)
    unit : str
    why : str
        What has changed them.
    """
    return tuple(
        f"{name}: {made:z.4g} {unit} in place of {value:z.4g} {unit}, because {why}"
        for name, (value, made) in values.items()
        if abs(made - value) > TOLD * abs(value)
    )


def windows_of(mean: float, window: float) -> int:
    """Windows (s) of a moving mean over a time (s): an odd number, so that one stands in the middle."""
    return max(1, round(mean / max(window, 1e-300))) | 1


def told_of_window(given: float, made: float, output_interval: float) -> tuple[str, ...]:
    """Sentences on a window of the probes that differs from the requested one (s), and why it does."""
    why = "windows are whole steps, and whole numbers of them make the time between frames"
    if given > (1 + TOLD) * output_interval:
        why = (
            f"a window is at most the time between frames: for {given:z.4g} s set run.output_interval to "
            f"{given:z.4g} s or a multiple of it"
        )
    return rounding_notes({"probes.interval": (given, made)}, why=why)


def plan_stations(
    x: Interval, speed: float, window: Interval, scene: InitialState, places: Iterable[float]
) -> Stations:
    """Stations at `x` (m) that move at `speed` (m/s) from the first to the last frame of a window (s).

    Discs come and go at `places` (m).

    Raises
    ------
    ValueError
        The window holds no two frames of the run, the stations are too close, or discs come or go between them.
    """
    dt, least = scene.time_step, 2 * scene.largest
    frames = (round((time / dt + scene.settle_steps) / scene.output_steps) for time in window)
    first, last = (frame * scene.output_steps for frame in frames)
    if not 0 <= first < last <= scene.steps:
        raise ValueError(
            f"window [{window[0]:zg}, {window[1]:zg}] s; allowed are times of two frames or more within "
            f"[{scene.time(0):zg}, {scene.time(scene.steps):zg}] s"
        )
    if x[1] - x[0] < least:
        raise ValueError(f"x [{x[0]:zg}, {x[1]:zg}] m; allowed is a distance of {least:zg} m, two discs, or more")
    moved = speed * (last - first) * dt
    low, high = x[0] + min(0.0, moved), x[1] + max(0.0, moved)
    for place in places:
        if low - least < place < high + least:
            raise ValueError(
                f"the stations pass x = {low:z.4g} to {high:z.4g} m, and discs come or go at {place:zg} m; "
                f"allowed is a stretch that stays {least:zg} m away from it: move the stations or shorten the window"
            )
    return Stations(x, speed, first, last)
