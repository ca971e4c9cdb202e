# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of the readers runs; its rates are for people, the floor here only catches a collapse."""

from dump_reader import benchmark


def test_small_run():
    rates = benchmark(discs=2000, frames=5, repeats=3)
    assert {"text %.10g", "text %.17g", "gzip %.10g", "binary"} <= set(rates)
    # a hundred times below what an idle core does, and still above MDAnalysis' 0.3 M rows/s: a plain Python loop fails
    assert rates["binary"] > 3e5 and rates["text %.10g"] > 3e5
