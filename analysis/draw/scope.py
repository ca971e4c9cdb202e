# SPDX-License-Identifier: GPL-2.0-or-later
"""Part of the plane, and range of the speeds, in pictures of discs: the same for figures, films and the page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame
from lammps_jump.scene.walls import Interval

TALLEST = 20
"""Most height of what is shown, in its lengths."""


def disc_speeds(frame: Frame) -> np.ndarray:
    """Speeds for the colours of a picture, m/s; zero where they are not known."""
    if "vx" in frame.columns and "vy" in frame.columns:
        return np.nan_to_num(np.hypot(frame.vx, frame.vy))
    return np.zeros(frame.n)


def top_of(speeds: Sequence[np.ndarray], step: float = 0.5) -> float:
    """End of a colour scale: the 99.5 % quantile of all speeds, so that one fast disc does not darken all.

    It is rounded up to a multiple of `step` of its power of ten.
    """
    together = np.concatenate(list(speeds)) if speeds else np.zeros(0)
    together = together[np.isfinite(together)]
    high = float(np.quantile(together, 0.995)) if together.size else 0.0
    if not high > 0:
        return 1.0
    unit = step * 10.0 ** np.floor(np.log10(high))
    return float(np.ceil(high / unit) * unit)


def seen(frames: Sequence[Frame], flow: Flow) -> tuple[Interval, Interval]:
    """Part of the plane that is worth showing, m.

    Along x the studied stretch, cut short where the frames hold neither a disc nor a block; along y from just below the
    floor to just above nearly all discs there.
    """
    (low, high), diameter = flow.x_range, flow.scene.diameter
    standing = {wall for frame in frames for wall in flow.standing_at(flow.time(frame))}
    blocks = [wall.extent for wall in standing if wall.finite]
    parts = [frame.x[(frame.x >= low) & (frame.x <= high)] for frame in frames]
    ends = [float(np.quantile(part, q)) for part in parts if part.size for q in (0.0, 0.999)]
    ends += [end for sides, _ in blocks for end in sides if low < end < high]
    if ends:
        margin = 0.02 * (max(ends) - min(ends)) + 2 * diameter
        low, high = max(low, min(ends) - margin), min(high, max(ends) + margin)
    floors = flow.bed_height(np.linspace(low, high, 200))
    bottom = float(np.min(floors[np.isfinite(floors)], initial=np.inf))
    bottom = bottom if np.isfinite(bottom) else flow.scene.domain[1][0]
    heights = [frame.y[(frame.x >= low) & (frame.x <= high)] for frame in frames]
    tops = [float(np.quantile(part, 0.995)) for part in heights if part.size]
    tops += [highest for (start, end), (_, highest) in blocks if end > low and start < high]
    top = max([*tops, bottom + 5 * diameter])
    top = min(top, bottom + TALLEST * (high - low))  # a disc that flew away does not make the picture
    margin = 0.06 * (top - bottom) + diameter
    return (low, high), (bottom - margin, top + margin)
