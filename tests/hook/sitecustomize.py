# SPDX-License-Identifier: GPL-2.0-or-later
"""What tests do at a step of an engine, set by the environment.

Python runs this file when it starts with this folder on its path, as all processes do that tests start. The program
itself reads none of these variables.

JUMP_TEST_SIGNAL : ``NUMBER@STEP@WHO``; the engine's process sends this signal at the first step from STEP on, and waits
    until it is asked to end. WHO is the process that gets it: ``first``, the ``engine`` itself, or ``all``.
JUMP_TEST_REACHED : a named pipe, in which the engine's process writes a byte before it waits there.
JUMP_TEST_SAVE : numbers of steps with commas between; a checkpoint is due at each.
JUMP_TEST_SLEEP : seconds to sleep at every step.
JUMP_TEST_FULL : ``FIRST-LAST``; files of the engine's process cannot grow in these steps, as on a full disk.
JUMP_TEST_LOADS : a module; its import in another thread of the first process waits until the main thread has ended.
JUMP_TEST_PROCESS : the first process; set here.
"""

import os
import resource
import time

signal_at, sleep = os.environ.get("JUMP_TEST_SIGNAL"), float(os.environ.get("JUMP_TEST_SLEEP", 0))
full = [int(step) for step in os.environ.get("JUMP_TEST_FULL", "").split("-") if step]
save_at = {int(step) for step in os.environ.get("JUMP_TEST_SAVE", "").split(",") if step}
LIMIT = 600

if signal_at or sleep or save_at or full:
    from lammps_jump.engines import interrupts
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
                if pipe := os.environ.get("JUMP_TEST_REACHED"):
                    with open(pipe, "wb") as file:
                        file.write(b".")
                stop_request.wait(LIMIT)

    interrupts.at_step = at_step

loads = os.environ.get("JUMP_TEST_LOADS")
if loads and os.environ.setdefault("JUMP_TEST_PROCESS", str(os.getpid())) == str(os.getpid()):
    import sys
    import threading

    reached, main, shut_down = threading.Event(), threading.main_thread(), threading._shutdown

    class Finder:
        """Lets an import in another thread than the main one wait for the end of that."""

        def find_spec(self, name, path=None, target=None):
            if name == loads and threading.current_thread() is not main:
                reached.set()
                while main.is_alive():
                    time.sleep(0.001)

    def end():
        while not reached.is_set() and threading.active_count() > 1:
            time.sleep(0.001)
        shut_down()

    sys.meta_path.insert(0, Finder())
    threading._shutdown = end
