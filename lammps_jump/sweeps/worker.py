# SPDX-License-Identifier: GPL-2.0-or-later
"""A process that works through the calls of its parent: ``python -m lammps_jump.sweeps.worker DESCRIPTOR [MODULE …]``.

The modules are loaded first. The descriptor is one end of a pipe. A call is a function at the top level of a module,
with its arguments. The end of the pipe means that the parent is gone: the call at work gets a request to stop, and the
process ends.
"""

from __future__ import annotations

import gc
import importlib
import os
import select
import signal
import sys
import threading
from functools import partial
from multiprocessing.connection import Connection

from lammps_jump.errors import JumpError

_pipe: Connection | None = None
"""Connection of a worker to its parent; None in a process that is not a worker."""


def tell(news: object) -> None:
    """Tell the parent how far a call has come; nothing where there is no parent."""
    if _pipe is not None:
        _pipe.send(("news", news))


def asked_to_stop() -> bool:
    """Tells whether the parent wants the call at work to save what it has and stop, or is gone."""
    return _pipe is not None and _pipe.poll()


def serve(pipe: Connection) -> None:
    """Work through calls until the pipe ends."""
    global _pipe
    _pipe = pipe
    try:
        while True:
            call = pipe.recv()
            if call is not None:  # a request to stop that came too late
                pipe.send(_answer(call))
    except (EOFError, OSError):
        return


def _answer(call: partial[object]) -> tuple[str, object]:
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            return "done", call()
        finally:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
    except KeyboardInterrupt:
        return "RunInterrupted", "was ended"
    except JumpError as error:
        return type(error).__name__, str(error)
    except OSError as error:
        return "OSError", str(error)
    except Exception as error:  # any error is an outcome of its call, and the next call is served
        return "bug", f"{type(error).__name__}: {error}"


def main() -> None:
    """Serve the parent, which alone hears the terminal and sends SIGINT to end a call."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    gc.set_threshold(50_000, 20, 50)
    os.environ["LAMMPS_JUMP_THREADS"] = "1"  # the workers are as many as the cores
    place = int(sys.argv[1])
    threading.Thread(target=_end_with_parent, args=(place,), daemon=True).start()
    for module in sys.argv[2:]:
        importlib.import_module(module)
    serve(Connection(place))
    gc.freeze()  # collecting at the end takes 0.1 s


def _end_with_parent(place: int) -> None:
    """Interrupt the call at work when the other end of the pipe is closed."""
    end = select.poll()
    end.register(place, 0)  # nothing but the end
    end.poll()
    os.kill(os.getpid(), signal.SIGINT)


if __name__ == "__main__":
    importlib.import_module("lammps_jump.sweeps.worker").main()  # under its own name
