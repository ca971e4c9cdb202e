# SPDX-License-Identifier: GPL-2.0-or-later
"""Run the test suite many times, under conditions that must not matter: ``python tests/repeat.py 20``.

Half of the runs have two endless loops of the same priority beside them. Of each half one run ignores Ctrl-C, as a job
in the background of a shell does, one has a single worker, and one takes the files in the opposite order.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
BUSY = "while True: pass"


@contextmanager
def busy_cores(busy: bool):
    """Two endless loops while the block runs."""
    loops = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(2 if busy else 0)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def conditions(number: int) -> list[tuple[bool, str]]:
    """(busy, what is special) of each run."""
    half = number // 2
    return [
        (busy, dict(enumerate(("SIGINT ignored", "one worker", "files reversed"))).get(k, ""))
        for busy, count in ((False, number - half), (True, half))
        for k in range(count)
    ]


def run_once(busy: bool, special: str, log: Path) -> tuple[int, float]:
    """Exit status and seconds of one run; its output goes to `log`."""
    files = sorted((ROOT / "tests").rglob("test_*.py"), reverse=True) if special == "files reversed" else []
    workers = "1" if special == "one worker" else "2"
    command = [sys.executable, "-m", "pytest", "-n", workers, *map(str, files)]
    before = signal.signal(signal.SIGINT, signal.SIG_IGN if special == "SIGINT ignored" else signal.SIG_DFL)
    try:
        begin = time.monotonic()
        with busy_cores(busy), log.open("w") as output:
            status = subprocess.run(command, cwd=ROOT, stdout=output, stderr=subprocess.STDOUT).returncode
        return status, time.monotonic() - begin
    finally:
        signal.signal(signal.SIGINT, before)


def main() -> int:
    """Print a line a run; the status is 1 where one failed."""
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    logs = ROOT / ".pytest_cache" / "repeat"
    logs.mkdir(parents=True, exist_ok=True)
    passed = 0
    for k, (busy, special) in enumerate(conditions(number), 1):
        log = logs / f"{k}.log"
        status, seconds = run_once(busy, special, log)
        passed += status == 0
        last = log.read_text().strip().splitlines()[-1:] or [""]
        cores = "busy cores" if busy else "free cores"
        print(f"{k:3} {cores:10} {special:14} {seconds:5.0f} s  {last[0]}", flush=True)
        if status:
            print(f"    failed: {os.path.relpath(log, ROOT)}", flush=True)
    print(f"{passed} of {number} runs passed")
    return 0 if passed == number else 1


if __name__ == "__main__":
    sys.exit(main())
