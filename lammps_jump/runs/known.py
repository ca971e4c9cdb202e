# SPDX-License-Identifier: GPL-2.0-or-later
"""Experience of this machine: how fast runs were and how much starts scattered; what a run and a mean will take.

Runs that end leave their speed in ``speeds.json``, studies the scatter over their starts in ``scatter.json``, in the
folder of what is kept (`compiling.cache.usual_folder`). What is reported from them is an estimate, with its source.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import inf, isfinite, sqrt
from statistics import median
from typing import Any, NamedTuple

from lammps_jump.analysis.statistics import student
from lammps_jump.case.case import ReadCase
from lammps_jump.compiling.cache import usual_folder
from lammps_jump.engines import RunResult, Setting
from lammps_jump.files import plain, read_json, write_json
from lammps_jump.identity import short_hash
from lammps_jump.quoting import visible
from lammps_jump.scene.scene import Scene

log = logging.getLogger(__name__)
SPEEDS, SCATTER = "speeds.json", "scatter.json"
LEAST_SECONDS = 1.0
"""Processor time of a run from which its speed is kept: in a shorter one the beginning counts."""
KEPT, MOST_CASES = 9, 400
"""Last times that are kept of each kind of run and case, and the most of both in a file."""
FEWEST = 3
"""Starts from which a scatter is kept."""
MOST_STARTS = 10_000
SURE = 0.9
"""Probability with which a range of starts is given."""
Entries = dict[str, Any]


def kind_of(scene: Scene, setting: Setting) -> str:
    """Kind of a run: what decides the time of a disc in a step."""
    rubs = scene.coefficients.friction or any(wall.friction for wall, _ in scene.walls)
    words = [
        scene.friction_law if rubs else "no friction",
        *(["rolling"] if scene.springs and scene.springs.rolling else []),
    ]
    flags = {"spin": scene.rotation, "sizes": scene.sizes, "stations": scene.stations}
    words += [word for word, holds in flags.items() if holds] + ([scene.touch] if scene.touch != "sharp" else [])
    ranks = f", {setting.ranks} ranks" if setting.ranks > 1 else ""
    return f"{setting.engine} ({setting.kernel}{ranks}): {', '.join(words)}"


def _read(name: str, checked: Callable[[Any], bool]) -> Entries:
    """Entries of a file of what is kept, those that mean something; none where it cannot be read."""
    with suppress(OSError, ValueError):
        data = read_json(usual_folder() / name)
        if isinstance(data, dict):
            some = [(key, one) for key, one in data.items() if len(key) <= 300 and checked(one)]
            return dict(some[-MOST_CASES:])
    return {}


def _write(name: str, entries: Entries) -> None:
    """Keeps entries, the last ones; where that is not possible nothing is reported: no result depends on it."""
    with suppress(OSError):
        place = usual_folder()
        place.mkdir(parents=True, exist_ok=True)
        write_json(place / name, dict(list(entries.items())[-MOST_CASES:]))


def _is_number(value: object, least: float, most: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= most


def _are_times(entry: Any) -> bool:
    """Tells whether an entry is a list of times of a run, or of a disc in a step, s."""
    return isinstance(entry, list) and 0 < len(entry) <= KEPT and all(_is_number(one, 1e-12, 1e9) for one in entry)


def _is_scatter(entry: Any) -> bool:
    """Tells whether an entry is the name of a case with mean, standard deviation and starts of some numbers."""
    if not (isinstance(entry, dict) and isinstance(entry.get("name"), str) and isinstance(entry.get("numbers"), dict)):
        return False
    return len(entry["name"]) <= 200 and all(
        isinstance(one, list) and len(one) == 3 and _is_number(one[0], -1e300, 1e300)
        and _is_number(one[1], 0, 1e300) and _is_number(one[2], FEWEST, MOST_STARTS)
        for one in entry["numbers"].values()
    )  # fmt: skip


def remember_run(case: ReadCase, setting: Setting, result: RunResult) -> None:
    """Keep the processor time of a run that came to its end in one go: other work of the machine moves it least."""
    seconds = result.cpu_seconds
    if result.status != "complete" or seconds < LEAST_SECONDS or not result.disc_steps or result.resumed:
        return
    entries, kind = _read(SPEEDS, _are_times), kind_of(case.scene(), setting)
    for key, value in ((kind, seconds / result.disc_steps), (f"{_seedless(case)} {kind}", seconds)):
        entries[key] = [*entries.pop(key, ()), value][-KEPT:]
    _write(SPEEDS, entries)


def expected_disc_steps(scene: Scene) -> float:
    """Sum over the steps of the discs that are foreseen.

    Of rows, half of what enters is in play in the mean. Where discs also leave and there are as many at the start as a
    jet holds on its way out, their number stays.
    """
    steps, start = scene.steps, len(scene.positions) + sum(item.count for item in scene.pours)
    entering = scene.expected_discs - start
    if entering and scene.inlets and scene.outlets:
        x, speed = scene.inlets[0].x, max(abs(row.vx) for row in scene.inlets)
        ends = [one.at for one in scene.outlets if one.axis == "x"]
        way = max((abs(end - x) for end in ends), default=inf)
        if isfinite(way) and speed and start >= entering * way / speed / scene.time(steps):
            entering = 0
    return steps * (start + 0.5 * entering)


class RunTime(NamedTuple):
    """Processor time that the engine will take for a run, s: median, least and largest; None where it is not known.

    Attributes
    ----------
    seconds, low, high : float or None
    runs : int
        It is from so many.
    source : str
        What they are, or why nothing is known.
    """

    seconds: float | None
    low: float | None
    high: float | None
    runs: int
    source: str

    def __str__(self) -> str:
        if self.seconds is None or self.low is None or self.high is None:
            return f"time of a run: not known: {self.source}"
        spread = f" ({duration(self.low)} to {duration(self.high)})" if self.runs > 1 else ""
        return f"a run takes about {duration(self.seconds)}{spread} of processor time in its engine, from {self.source}"


def duration(seconds: float) -> str:
    """A time in the unit that suits it, with two digits."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:z.2g} {unit}"
    return f"{seconds:z.2g} s"


def time_of(case: ReadCase, setting: Setting) -> RunTime:
    """Time that a run of a case will take here, from runs of it, else from runs of its kind."""
    kind = kind_of(case.scene(), setting)
    entries = _read(SPEEDS, _are_times)
    own, like = entries.get(f"{_seedless(case)} {kind}"), entries.get(kind)
    if own:
        return RunTime(
            median(own), min(own), max(own), len(own), f"{_count(len(own), 'run')} of this case on this machine"
        )
    if like:
        discs = expected_disc_steps(case.scene())
        times = [one * discs for one in like]
        said = f"{_count(len(like), 'run')} of this kind on this machine, {kind}; {discs:z.2g} steps of a disc foreseen"
        return RunTime(median(times), min(times), max(times), len(like), said)
    return RunTime(
        None, None, None, 0, f"no run of this kind, {kind}, has taken {LEAST_SECONDS:zg} s or more on this machine"
    )


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'s' if number > 1 else ''}"


def _seedless(case: ReadCase, **more: Any) -> str:
    """Key of a case whatever its seed, shifts at the start and number of members."""
    core: dict[str, Any] = dict(case.core)
    core["run"] = {name: value for name, value in core["run"].items() if name not in ("seed", "members")}
    core["initial"] = [
        {name: one for name, one in item.items() if name != "jitter"} for item in core.get("initial", ())
    ]
    return short_hash({"case": core, **more})


def scatter_key(case: ReadCase) -> str:
    """Key of a case whatever its seed; bins and window of its analysis count."""
    analysis = case.fields.analysis
    return _seedless(case, window=plain(analysis.window), bins=analysis.bin_width)


def remember_scatter(case: ReadCase, numbers: Mapping[str, tuple[float, float, int]]) -> None:
    """Keep mean, standard deviation and starts of numbers of a case, where there are as many starts as were known."""
    good = {path: [*one] for path, one in numbers.items() if one[2] >= FEWEST and isfinite(one[0]) and isfinite(one[1])}
    if not good:
        return
    entries, key = _read(SCATTER, _is_scatter), scatter_key(case)
    known = entries.pop(key, {"numbers": {}})["numbers"]
    good = {path: one for path, one in good.items() if path not in known or one[2] >= known[path][2]}
    entries[key] = {"name": visible(case.name)[:200], "numbers": {**known, **good}}
    _write(SCATTER, entries)


class Scatter(NamedTuple):
    """Relative standard deviation over starts: estimate, ends of its range, and what it is from."""

    value: float
    low: float
    high: float
    source: str


def scatter_of(case: ReadCase, path: str) -> Scatter | None:
    """Scatter of a number over starts, over its mean: of this case, else of cases of its name, else of all."""
    entries, key = _read(SCATTER, _is_scatter), scatter_key(case)
    if path in entries.get(key, {"numbers": {}})["numbers"]:
        mean, sd, n = entries[key]["numbers"][path]
        return scatter_of_starts(mean, sd, int(n), f"{int(n)} starts of this case")
    like = [one for one in entries.values() if path in one["numbers"]]
    named = [one for one in like if one["name"] == case.name]
    some = [one["numbers"][path] for one in named or like]
    shares = [sd / abs(mean) for mean, sd, _ in some if mean]
    if not shares:
        return None
    names = ", ".join(sorted({one["name"] for one in like})[:5])
    said = f"starts of {case.name} with other values" if named else f"starts of other cases ({names})"
    wide = 2.0 if len(shares) == 1 else 1.0
    return Scatter(
        float(median(shares)), min(shares) / wide, max(shares) * wide, f"{said}, {_count(len(shares), 'study')}"
    )


def scatter_of_starts(mean: float, sd: float, starts: int, source: str) -> Scatter | None:
    """Scatter of some starts, with the range in which that of many lies with the probability `SURE` (chi squared)."""
    from scipy.special import chdtri  # 0.1 s

    if not mean:
        return None
    share, freedom = sd / abs(mean), starts - 1
    low, high = (float(sqrt(freedom / chdtri(freedom, tail))) for tail in (0.5 - 0.5 * SURE, 0.5 + 0.5 * SURE))
    return Scatter(share, share * low, share * high, source)


def starts_for(scatter: float, within: float) -> int | None:
    """Starts from which half of the 95 % interval of the mean is within a share of it; None above `MOST_STARTS`.

    The least n with t(0.975, n - 1) s / sqrt(n) <= share, where s is the standard deviation over the mean.
    """
    low, high = 1, 2
    while high <= MOST_STARTS and student(high - 1, 0.975) * scatter > within * sqrt(high):
        low, high = high, 2 * high
    if high > MOST_STARTS:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        enough = student(middle - 1, 0.975) * scatter <= within * sqrt(middle)
        low, high = (low, middle) if enough else (middle, high)
    return high


class StartsNeeded(NamedTuple):
    """Starts that a number will take to be known within a share of itself; estimate, range and time.

    Attributes
    ----------
    path : str
    within : float
    starts, low, high : int or None
        None: more than `MOST_STARTS`, or not known.
    seconds : float or None
        Of so many starts, one after the other.
    source : str
        What it is from, or why nothing is known.
    """

    path: str
    within: float
    starts: int | None
    low: int | None
    high: int | None
    seconds: float | None
    source: str

    def __str__(self) -> str:
        claim = f"{self.path} within ± {100 * self.within:zg} %"
        if self.low is None:
            return f"{claim}: not known: {self.source}"
        most = f"over {MOST_STARTS}"
        middle, high = (most if one is None else f"{one}" for one in (self.starts, self.high))
        time = "" if self.seconds is None else f", {duration(self.seconds)} one after the other"
        return (
            f"{claim} takes about {middle} starts ({100 * SURE:zg} %: {self.low} to {high}){time}: an estimate, from "
            f"the scatter of {self.source}"
        )


def power_of(case: ReadCase, path: str, within: float, time: RunTime) -> StartsNeeded:
    """Starts and time that a number of a case will take, from the scatter that is known here."""
    scatter = scatter_of(case, path)
    if scatter is None:
        said = f"no starts that have {path} are known on this machine; --pilot 4 runs some, which a study goes on with"
        return StartsNeeded(path, within, None, None, None, None, said)
    starts, low, high = (starts_for(one, within) for one in (scatter.value, scatter.low, scatter.high))
    if low is None:
        return StartsNeeded(
            path, within, None, None, None, None, f"it takes over {MOST_STARTS} starts, by {scatter.source}"
        )
    seconds = None if time.seconds is None or starts is None else time.seconds * starts
    return StartsNeeded(path, within, starts, low, high, seconds, scatter.source)


def as_data(time: RunTime, powers: Sequence[StartsNeeded]) -> dict[str, Any]:
    """Plain data of ``check --json``."""
    data: dict[str, Any] = {"run_time": time._asdict()}
    return data | ({"power": [one._asdict() for one in powers]} if powers else {})
