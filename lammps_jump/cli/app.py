# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line: groups of commands put together, what becomes of errors, and processes that are started early."""

from __future__ import annotations

import errno
import gc
import importlib
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

import lammps_jump
from lammps_jump import engines, sweeps
from lammps_jump.errors import JumpError, SetupError
from lammps_jump.files import read_file
from lammps_jump.quoting import terminal_text

from . import analyse, run, studies, tools
from .options import Commands

COMMANDS = ("build-and-run", "run", "sweep")
MEMBERS = {"--members", "--until"}
"""Options of a command that runs several members of a case."""
NOTHING = {"--help", "--slurm", "--status", "--table", "--member", "--jobs"}
"""Options of a command that runs nothing in workers, or in as many as it says."""


def start_early(words: list[str]) -> None:
    """Start the engine of a run, or the workers of a study; a wrong guess costs a process that is not used.

    Parameters
    ----------
    words : list of str
        Of the command line, the program's name left out.
    """
    options = {word.partition("=")[0] for word in words}
    if len(words) < 2 or words[0] not in COMMANDS or NOTHING & options:
        return
    if words[0] == "sweep" or MEMBERS & options:
        sweeps.pool.prepare_workers()
        return
    path = Path(words[1]) / "case.yaml" if words[0] == "run" else Path(words[1])
    try:
        named = re.search(rb"(?m)^ *name: *(native|twin)", read_file(path, 1_000_000))
        own = next((name for name in ("native", "twin") if name in words), named and named[1].decode())
    except (OSError, ValueError):
        return  # the command says what is wrong
    engines.prepare_worker(own or "lammps")


class PatientStream:
    """A text stream that ignores what is written after its first error; all else is as of the stream.

    Parameters
    ----------
    stream : file
    shown : callable
        What is written of a text; by default escape sequences are shown, not sent.

    Attributes
    ----------
    trouble : OSError or None
        The first error; None where a reader has closed its end (``| head``).
    """

    def __init__(self, stream: TextIO, shown: Callable[[str], str] = terminal_text):
        self.stream = stream
        self.shown = shown
        self.trouble: OSError | None = None

    def write(self, text: str) -> int:
        """Write; nothing after an error."""
        # bytes are no text: the stream refuses them, by which others tell what kind of stream it is
        self._try(lambda: self.stream.write(self.shown(text) if isinstance(text, str) else text))
        return len(text)

    def flush(self) -> None:
        """Flush; nothing after an error."""
        self._try(self.stream.flush)

    def _try(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError as error:
            if error.errno != errno.EPIPE and self.trouble is None:
                self.trouble = error
            with open(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), self.stream.fileno())  # takes what is still in the buffer

    @property
    def terminal(self) -> PatientStream:
        """The same stream for a program that commands the terminal."""
        return PatientStream(self.stream, str)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def patient_output() -> Iterator[PatientStream]:
    """Make stdout and stderr a `PatientStream`, with ``?`` for what their encoding lacks; yield stdout."""
    before = sys.stdout, sys.stderr
    streams = [stream or open(os.devnull, "w") for stream in before]  # None where the shell has closed it
    for stream in streams:
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    sys.stdout, sys.stderr = map(PatientStream, streams)
    try:
        yield sys.stdout
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        sys.stdout, sys.stderr = before


app = typer.Typer(
    name="lammps-jump",
    cls=Commands,
    context_settings={"max_content_width": 100},
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for group in (run, analyse, tools, studies):
    app.add_typer(group.app)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"lammps-jump {lammps_jump.__version__}")
        raise typer.Exit()


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Free-surface flow with discs: one YAML case in; a LAMMPS script, a run, profiles, figures and a report out."""
    try:
        Path.cwd()
    except FileNotFoundError:
        raise SetupError("the current folder was deleted; change to another folder and try again") from None


def main() -> None:
    """Run the command line; a `JumpError` becomes one paragraph and an exit status, never a traceback."""
    # imports leave a million objects that stay; collecting among them took a tenth of the time of an analysis
    gc.set_threshold(50_000, 20, 50)
    start_early(sys.argv[1:])
    with patient_output() as output:
        drop_unknown_backend()
        status = _status()
        output.flush()
        if output.trouble is not None:
            print(f"error: standard output cannot be written ({output.trouble.strerror})", file=sys.stderr)
            status = status or 1
    gc.freeze()  # collecting at the end takes 0.3 s
    raise SystemExit(status)


def drop_unknown_backend() -> None:
    """Take a value of MPLBACKEND that matplotlib does not know out of the environment: its import would fail."""
    if name := os.environ.pop("MPLBACKEND", None):
        try:
            importlib.import_module("matplotlib").rcParams["backend"] = name
        except ValueError:
            print(f"note: MPLBACKEND={name} is not known to matplotlib and is left aside", file=sys.stderr)
        else:
            os.environ["MPLBACKEND"] = name


def _status() -> int:
    """Run the command; its exit status."""
    try:
        app(standalone_mode=True)
    except SystemExit as stop:
        if stop.code == 130:  # what typer makes of Ctrl-C
            print("\nstopped by Ctrl-C; no further files were written", file=sys.stderr)
        return int(stop.code or 0)
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    except OSError as error:  # a disk that is full, a folder that was taken away
        place = f"{error.filename}: " if error.filename is not None else ""
        print(f"error: {place}{error.strerror or error}; what was written before is kept", file=sys.stderr)
        return 1
    except MemoryError:
        print("error: not enough memory; use fewer discs, frames or bins, or a larger machine", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    main()
