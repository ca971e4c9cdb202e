# SPDX-License-Identifier: GPL-2.0-or-later
"""The program: ``lammps-jump``, and ``python -m lammps_jump``."""

import atexit
import os
import sys
import threading
from contextlib import suppress

from lammps_jump.cli.app import main


def run() -> None:
    """Run the command line and end the process; to free, one by one, what it has loaded would take 0.2 s."""
    try:
        main()
    except SystemExit as end:
        if threading.active_count() > 1 or not isinstance(end.code, int):
            raise
        atexit._run_exitfuncs()
        for stream in filter(None, (sys.stdout, sys.stderr)):  # None where the program began with a closed one
            with suppress(OSError, ValueError):  # closed by who reads it
                stream.flush()
        os._exit(end.code)


if __name__ == "__main__":
    run()
