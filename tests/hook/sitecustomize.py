"""What tests do at a step of an engine, set by the environment.

Python runs this file when it starts with this folder on its path, as the children of `children.run_child` do.
`conftest` runs it for the processes of the tests themselves. The program itself reads neither variable.

JUMP_TEST_SIGNAL : ``NUMBER@STEP``; the process sends itself this signal at the first step from STEP on.
JUMP_TEST_SLEEP : seconds to sleep at every step.
"""

import os
import time

signal_at, sleep = os.environ.get("JUMP_TEST_SIGNAL"), float(os.environ.get("JUMP_TEST_SLEEP", 0))

if signal_at or sleep:
    from lammps_jump.engines import step_hook

    left = [tuple(int(part) for part in signal_at.split("@"))] if signal_at else []

    def at_step(step):
        time.sleep(sleep)
        if left and step >= left[0][1]:
            os.kill(os.getpid(), left.pop()[0])

    step_hook.at_step = at_step
