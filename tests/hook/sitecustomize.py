# SPDX-License-Identifier: GPL-2.0-or-later
"""What tests do at a step of an engine, set by the environment; and compiled code that all processes share.

Python runs this file when it starts with this folder on its path, as all processes do that tests start. `conftest` runs
it for the processes of the tests themselves. The program itself reads none of these variables.

JUMP_TEST_SIGNAL : ``NUMBER@STEP@WHO``; the engine's process sends this signal at the first step from STEP on, and waits
    until it is asked to end. WHO is the process that gets it: ``first``, the ``engine`` itself, or ``all``.
JUMP_TEST_SAVE : numbers of steps with commas between; a checkpoint is due at each.
JUMP_TEST_SLEEP : seconds to sleep at every step.
JUMP_TEST_FULL : ``FIRST-LAST``; files of the engine's process cannot grow in these steps, as on a full disk.
JUMP_TEST_PROCESS : the first process; set here.
"""

import fcntl
import importlib.util
import os
import resource
import sys
import threading
import time

signal_at, sleep = os.environ.get("JUMP_TEST_SIGNAL"), float(os.environ.get("JUMP_TEST_SLEEP", 0))
full = [int(step) for step in os.environ.get("JUMP_TEST_FULL", "").split("-") if step]
save_at = {int(step) for step in os.environ.get("JUMP_TEST_SAVE", "").split(",") if step}
LIMIT = 600

if signal_at or sleep or save_at or full:
    from lammps_jump.engines import step_hook
    from lammps_jump.engines.interrupts import save_request, stop_request

    first = int(os.environ.setdefault("JUMP_TEST_PROCESS", str(os.getpid())))
    left = [signal_at.split("@")] if signal_at else []

    def at_step(step):
        time.sleep(sleep)
        if step in full:
            largest = 0 if step == full[0] else resource.RLIM_INFINITY
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest, resource.RLIM_INFINITY))
        if step in save_at:
            save_request.make()
        if left and step >= int(left[0][1]):
            number, _, who = left.pop()
            for process in {"first": [first], "engine": [os.getpid()], "all": [first, os.getpid()]}[who]:
                os.kill(process, int(number))
            if os.getpid() != first:
                stop_request.wait(LIMIT)

    step_hook.at_step = at_step


threads, holding = threading.RLock(), []


def one_at_a_time(compile_or_load):
    """The method of a jitted function, while no other process is in it; it calls itself for functions inside."""

    def call(function, signature):
        with threads:
            if holding:
                return compile_or_load(function, signature)
            with open(os.path.join(os.environ["NUMBA_CACHE_DIR"], "lock"), "w") as file:
                fcntl.flock(file, fcntl.LOCK_EX)
                holding.append(file)
                try:
                    return compile_or_load(function, signature)
                finally:
                    holding.clear()

    return call


class CompiledOnce:
    """Puts a lock around the look into the cache, the compilation and the way into the cache, all in one.

    Each function is compiled by one process, while the others wait and then load it. Without the lock every process
    compiles on its own, and two can take each other's code.
    """

    def find_spec(self, name, path=None, target=None):
        if name != "numba.core.dispatcher":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        execute = spec.loader.exec_module

        def exec_module(module):
            execute(module)
            module.Dispatcher.compile = one_at_a_time(module.Dispatcher.compile)

        spec.loader.exec_module = exec_module
        return spec


# a worker of pytest runs this file twice: as it starts, and by `conftest`
if "NUMBA_CACHE_DIR" in os.environ and "CompiledOnce" not in {type(finder).__name__ for finder in sys.meta_path}:
    sys.meta_path.insert(0, CompiledOnce())
