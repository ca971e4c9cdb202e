# SPDX-License-Identifier: GPL-2.0-or-later
"""Results of a study in one file: pieces are made once, by hand or by calls in a pool."""

import json
import os
from functools import partial

import pytest

from lammps_jump.errors import RunError
from lammps_jump.sweeps import Pool
from lammps_jump.sweeps.pool import CallOutcome
from lammps_jump.sweeps.store import Store

pytestmark = pytest.mark.usefixtures("kept_workers")


def test_store_goes_on_where_it_was(tmp_path):
    made = []
    store = Store(tmp_path / "s" / "bench.json")
    for _ in range(2):
        store.piece("a", lambda: made.append(1) or {"x": float("nan")})
    again = Store(tmp_path / "s" / "bench.json")
    assert again.piece("a", lambda: made.append(2)) == {"x": None}  # NaN is null in JSON
    assert made == [1]
    json.loads((tmp_path / "s" / "bench.json").read_text())
    assert Store(tmp_path / "s" / "bench.json", fresh=True).pieces == {}
    (tmp_path / "broken.json").write_text("{")
    assert Store(tmp_path / "broken.json").pieces == {}


def test_calls_are_made_once_and_kept_as_they_come(tmp_path):
    said, calls = [], [partial(pow, 2, 3), partial(int, "11", base=3)]
    with Pool(1) as pool:
        assert Store(tmp_path / "s.json").call(calls, pool, said=said.append) == said == [8, 4]
        again = Store(tmp_path / "s.json")
        assert again.call([calls[1], partial(pow, 2, 4), calls[0]], pool, said=said.append) == [4, 16, 8]
    assert said == [8, 4, 16]  # what was there is not made again


class Crashing:
    """A pool whose first call is a crash; `test_pool` sees those of processes."""

    def run(self, calls, *, done, **_):
        done(0, CallOutcome("crash", "the process ended with status 3"))
        for number, call in enumerate(calls[1:], 1):
            done(number, CallOutcome("done", call()))


def test_a_call_that_fails_is_an_error_or_an_outcome_and_the_others_are_kept(tmp_path):
    store, calls = Store(tmp_path / "s.json"), [partial(os._exit, 3), partial(int, "1")]
    with pytest.raises(RunError, match="status 3"):
        store.call(calls, Crashing())
    assert list(Store(tmp_path / "s.json").pieces.values()) == [1]
    assert store.call(calls, Crashing(), otherwise=lambda outcome: outcome.kind) == ["crash", 1]
