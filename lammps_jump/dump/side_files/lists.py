# SPDX-License-Identifier: GPL-2.0-or-later
"""Lists of ``end.npz`` for the native engine alone, held against the discs before any of it becomes an index.

Lists come from the file of a run that may have been handed on. The engine does not look at them again: an index beyond
the discs would end it, and a pair that is missing would change the run in silence.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

LIST = ("list_start", "list_discs", "list_owner", "list_shift")
"""Neighbour list: where each row begins, the discs of rows; in a periodic channel disc and shift (m) of each row."""
BITS = ("x0", "y0", "ux", "uy", "uomega", "fx", "fy", "torque")
"""Columns of a disc that decide bits: its place when the list was made (m), velocities, force."""
ALL_BITS = ("x0", "y0", "fx", "fy")
"""Those that every scene has."""
KINDS = {
    "list_start": np.int64, "list_discs": np.int32, "list_owner": np.int32, "list_shift": float, "skin": float,
    "period": float, "fixed": float, "fixed_diameters": float,
}  # fmt: skip
"""Kind of each array but ``discs``."""
ROUND = 1e-9
"""Part of a length by which a pair at the edge of the list may lie on either side of it."""


def check_kept(kept: Mapping[str, np.ndarray], discs: np.ndarray) -> None:
    """Raise ValueError where arrays are not such as the native engine keeps of these discs.

    Parameters
    ----------
    kept : mapping of str to ndarray
        ``discs`` has a row a disc in the order of the engine's memory: ``order``, the place of the disc among `discs`
        and the fixed ones behind them, and columns of `BITS`. `LIST` is its neighbour list, up to a ``skin`` (m) beyond
        contact, in a channel of this ``period`` (m; 0: none). ``fixed`` and ``fixed_diameters`` (m) tell the discs of
        rough beds.
    discs : ndarray
        With x, y and diameter (m).
    """
    if not kept:
        return
    if missing := {"discs", "skin", "period", "fixed", "fixed_diameters", *LIST[:2]} - set(kept):
        raise ValueError(f"{min(missing)} is missing")
    for name, array in kept.items():
        if name != "discs" and (name not in KINDS or array.dtype != KINDS[name]):
            raise ValueError(f"{name} holds {array.dtype}, which no engine writes")
    own, fixed = kept["discs"], kept["fixed"]
    n = len(discs) + len(fixed)
    names = own.dtype.names or ()
    if fixed.ndim != 2 or fixed.shape[1] != 2 or kept["fixed_diameters"].shape != (len(fixed),):
        raise ValueError("the discs of rough beds have no places and diameters")
    if own.shape != (n,) or names[:1] != ("order",) or set(names[1:]) - set(BITS) or not set(ALL_BITS) <= set(names):
        raise ValueError(f"it keeps {len(own)} discs in another form than an engine")
    if own.dtype["order"] != np.int64 or not np.array_equal(np.sort(own["order"]), np.arange(n)):
        raise ValueError("the order of the discs in memory is none")
    if not all(own.dtype[name] == np.float64 and np.isfinite(own[name]).all() for name in names[1:]):
        raise ValueError("a place, velocity or force of the native engine is no number")
    skin, period = _length(kept, "skin"), _length(kept, "period")
    if skin <= 0.0:
        raise ValueError(f"the skin of its list is {skin:g} m")
    check_list(n, period, *(kept.get(name) for name in LIST))  # type: ignore[arg-type]
    places = np.concatenate([np.column_stack([discs["x"], discs["y"]]), fixed])[own["order"]]
    sizes = np.concatenate([discs["diameter"], kept["fixed_diameters"]])[own["order"]]
    listed = np.column_stack([own["x0"], own["y0"]])
    way = np.hypot(*(places - listed).T)
    if not (way <= 0.5 * skin * (1 + ROUND)).all():  # a NaN is not
        raise ValueError(
            f"a disc has gone {way.max():.3g} m since its neighbours were listed, {0.5 * skin:.3g} m at most"
        )
    if not _is_whole(kept, (listed, 0.5 * sizes), skin, period):
        raise ValueError("its neighbour list lacks discs that are close to each other")


def _length(kept: Mapping[str, np.ndarray], name: str) -> float:
    """A length, m; ValueError for an array, or a number that is no length."""
    if kept[name].shape or not 0.0 <= float(kept[name]) < np.inf:
        raise ValueError(f"{name} is no length")
    return float(kept[name])


def check_list(
    n: int,
    period: float,
    start: np.ndarray,
    discs: np.ndarray,
    owner: np.ndarray | None = None,
    shift: np.ndarray | None = None,
) -> int:
    """Number of the sorted rows of a neighbour list of n discs; ValueError where it is none.

    Rows of their numbers come first, with neighbours of higher numbers; then those of discs that came later, with lower
    ones; then, in a channel with a `period` (m), those of images. Numbers of a row ascend.
    """
    if (owner is None) != (period == 0.0) or (shift is None) != (owner is None):
        raise ValueError("its neighbour list is of another channel")
    for name, array in zip(LIST, (start, discs, owner, shift), strict=True):
        if array is not None and array.dtype != KINDS[name]:
            raise ValueError(f"{name} holds {array.dtype}, which no engine writes")
    rows = n if owner is None else owner.size
    if not (start.ndim == discs.ndim == 1 and start.size == rows + 1 and rows >= n and (n or not rows)):
        raise ValueError(f"its neighbour list has {start.size - 1} rows for {n} discs")
    counts = np.diff(start)
    if start[0] or (counts < 0).any() or start[-1] != discs.size:
        raise ValueError("rows of its neighbour list do not follow each other")
    if discs.size and not 0 <= int(discs.min()) <= int(discs.max()) < n:
        raise ValueError(f"its neighbour list names disc {int(discs.max())}, of {n}")
    row = np.repeat(np.arange(rows), counts)
    if ((np.diff(discs) <= 0) & (np.diff(row) == 0)).any():
        raise ValueError("a row of its neighbour list does not ascend")
    late = np.flatnonzero((discs < row) & (row < n))
    ordered = int(row[late[0]]) if late.size else n
    early, behind = row < ordered, (row >= ordered) & (row < n)
    if (discs[early] <= row[early]).any() or (discs[early] >= ordered).any() or (discs[behind] >= row[behind]).any():
        raise ValueError("a pair of its neighbour list stands in the wrong row")
    if owner is not None and shift is not None:
        own = np.array_equal(owner[:n], np.arange(n)) and not shift[:n].any() and shift.shape == owner.shape
        images = owner[n:]
        if (
            not own
            or (shift[n:] != period).any()
            or ((images < 0) | (images >= n)).any()
            or (np.diff(images) <= 0).any()
        ):
            raise ValueError("images of its neighbour list are none")
    return ordered


def _is_whole(kept: Mapping[str, np.ndarray], disc: tuple[np.ndarray, np.ndarray], skin: float, period: float) -> bool:
    """Tells whether the list holds all pairs whose surfaces were closer than the skin, of places (m) and radii (m)."""
    from scipy.spatial import cKDTree  # 0.1 s, which a case without an earlier run need not wait for

    places, radii = disc
    n, reach = len(radii), 2.0 * float(radii.max(initial=0.0)) + skin
    start, discs = kept["list_start"], kept["list_discs"].astype(np.int64)
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    tree = cKDTree(places)

    def lacks(one: np.ndarray, two: np.ndarray, apart: np.ndarray, listed: np.ndarray) -> bool:
        wanted = np.hypot(*apart.T) < (radii[one] + radii[two] + skin) * (1 - ROUND)
        return not np.isin((one * n + two)[wanted], listed).all()

    one, two = tree.query_pairs(reach, output_type="ndarray").T
    own = row < n
    pairs = np.minimum(row, discs)[own] * n + np.maximum(row, discs)[own]
    if lacks(one, two, places[one] - places[two], pairs):
        return False
    if not period:
        return True
    beyond = [period, 0.0]
    near = np.flatnonzero(places[:, 0] + period < places[:, 0].max(initial=-np.inf) + reach)
    found = tree.query_ball_point(places[near] + beyond, reach)
    one = np.repeat(near, [len(others) for others in found])
    two = np.array([other for others in found for other in others], np.int64)
    images = kept["list_owner"][row[~own]] * n + discs[~own]
    return not lacks(one, two, places[one] + beyond - places[two], images)
