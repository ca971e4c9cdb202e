# SPDX-License-Identifier: GPL-2.0-or-later
"""Workers of a study serve the next one, too: each start costs more processor time than the runs of these tests."""

import os

import pytest

from lammps_jump.sweeps import pool as pools

_kept: list[tuple[tuple, pools.Worker]] = []


def place() -> tuple:
    """What a process takes over from the one that starts it: folder and environment."""
    told = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
    return os.getcwd(), sorted(told.items())


class KeptWorker(pools.Worker):
    """A worker that was started at the same place before, or a new one; its end keeps it for the next."""

    def __new__(cls, *modules: str):
        for number, (started, _) in enumerate(_kept):
            if started == place():
                return _kept.pop(number)[1]
        return super().__new__(cls)

    def __init__(self, *modules: str) -> None:
        if not hasattr(self, "started"):
            super().__init__(*modules)
            self.started = place()

    def end(self, *, kill: bool = False) -> int:
        if kill:
            return super().end(kill=True)
        self.deadline = float("inf")
        _kept.append((self.started, self))
        return 0


@pytest.fixture(autouse=True, scope="module")
def kept_workers(request):
    """Not where the processes themselves are tested."""
    with pytest.MonkeyPatch.context() as patch:
        if request.path.name != "test_pool.py":
            patch.setattr(pools, "Worker", KeptWorker)
            patch.setattr(pools, "_ready", [])  # those of another folder are no use here
            patch.setattr(pools.Pool, "close", lambda pool: None)  # closes the pipes of idle workers
        yield


@pytest.fixture(autouse=True, scope="session")
def end_of_workers():
    """The last of them end with the tests."""
    yield
    for _, worker in _kept:
        pools.Worker.end(worker)
