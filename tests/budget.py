# SPDX-License-Identifier: GPL-2.0-or-later
"""Processor time of the suite, counted in runs of a fixed loop on the same machine, and its budget.

Seconds of a shared machine swell by up to four. So the loop runs in each worker while the tests run, and the seconds of
the tests are divided by its median. The closing line of a run tells both. ``JUMP_BUDGET=enforce``, as in ``.ci/run``,
fails a whole run that takes a quarter more than its budget; ``JUMP_BUDGET=show`` lists the tests that cost most.
"""

from __future__ import annotations

import os
import statistics
import time
from pathlib import Path

import pytest

BUDGETS = {"cold": 34_000, "warm": 30_000}
"""Loops that a whole run may take, with empty caches of the tests and with those of the run before.

A whole run took 29,995 of 12.6 ms on two busy cores, beside the compiling of other work.
"""
SLACK = 1.25
"""Share of the budget at which ``.ci/run`` fails: repeated runs of one commit differ by about a tenth."""
EVERY = 150
"""Tests of a worker between two runs of the loop."""
SHOWN = 40
"""Tests of a worker that ``JUMP_BUDGET=show`` lists."""
CACHE = "LAMMPS_JUMP_TESTS_COLD"
"""Variable by which the process that hands out tests tells its workers whether the caches were empty."""


def fixed_loop() -> float:
    """Processor seconds of a fixed piece of work: integers, strings and a mapping, as most tests have them."""
    begin = time.process_time()
    total, words = 0, {}
    for number in range(60_000):
        total += number * number % 7
        words[str(number % 512)] = total
    return time.process_time() - begin


def processor_seconds(children: bool = True) -> float:
    """Of this process, and of those that it started and that have ended."""
    return sum(os.times()[: 4 if children else 2])


class Budget:
    """Hooks of pytest that measure loop and tests, in each worker, and tell the sum.

    Parameters
    ----------
    config : pytest.Config
    caches : Path
        Folder of the caches of the tests; empty before a cold run.
    """

    def __init__(self, config: pytest.Config, caches: Path):
        self.config, self.worker = config, hasattr(config, "workerinput")
        self.hands_out = not self.worker and bool(config.getoption("numprocesses", None))
        if not self.worker:
            os.environ[CACHE] = "warm" if any(caches.rglob("*.so")) else "cold"
        self.kind = os.environ[CACHE]
        self.loops, self.seconds, self.tests = [fixed_loop()], 0.0, {}

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item):
        """Time a test, and the loop now and then."""
        begin = processor_seconds()
        try:
            return (yield)
        finally:
            self.tests[item.nodeid] = processor_seconds() - begin
            if len(self.tests) % EVERY == 0:
                self.loops.append(fixed_loop())

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session):
        """Send what a worker took, or judge the whole."""
        self.seconds += processor_seconds(children=not self.hands_out)  # workers tell theirs
        if self.worker:
            dearest = dict(sorted(self.tests.items(), key=lambda test: -test[1])[:SHOWN])
            self.config.workeroutput["budget"] = self.seconds, self.loops, dearest
        elif os.environ.get("JUMP_BUDGET") == "enforce" and self.is_over:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node):
        """Take in what a worker took."""
        seconds, loops, tests = getattr(node, "workeroutput", {}).get("budget", (0.0, [], {}))
        self.seconds += seconds
        self.loops += loops
        self.tests |= tests

    @property
    def taken(self) -> float:
        """Processor seconds of the run over the median of the loop."""
        return self.seconds / statistics.median(self.loops)

    @property
    def is_over(self) -> bool:
        """Whether the run took more than a quarter above its budget."""
        return self.taken > SLACK * BUDGETS[self.kind]

    def pytest_terminal_summary(self, terminalreporter):
        """Tell what the run took."""
        if os.environ.get("JUMP_BUDGET") == "show":
            for name, seconds in sorted(self.tests.items(), key=lambda test: -test[1])[:SHOWN]:
                terminalreporter.write_line(f"{seconds:7.2f} s  {name}")
        terminalreporter.write_line(
            f"processor time: {self.seconds:.0f} s, {self.taken:,.0f} times the fixed loop of "
            f"{1000 * statistics.median(self.loops):.1f} ms; "
            f"{'far above the' if self.is_over else 'the'} budget of a whole {self.kind} run is {BUDGETS[self.kind]:,}"
        )


def main() -> None:
    """Say what the tests take on this machine."""
    loop = statistics.median(fixed_loop() for _ in range(15))
    cold, warm = (loop * BUDGETS[kind] / 60 for kind in ("cold", "warm"))
    print(
        f"the fixed loop takes {1000 * loop:.1f} ms here: the tests take at most {warm:.1f} minutes of processor time, "
        f"{cold:.1f} the first time; two free cores need half of that"
    )


if __name__ == "__main__":
    main()
