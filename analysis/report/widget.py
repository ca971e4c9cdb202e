# SPDX-License-Identifier: GPL-2.0-or-later
"""The player as a widget of Jupyter, by anywidget: the page of the player in a frame, which tells its time."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

from lammps_jump.analysis.report.page import Player, Section, render
from lammps_jump.errors import SetupError
from lammps_jump.files import text_of

SCRIPT = Path(__file__).parent / "widget.js"


def widgets_are_there() -> bool:
    """Tells whether anywidget is installed."""
    return importlib.util.find_spec("anywidget") is not None


def is_running() -> bool:
    """Tells whether this program runs in a notebook: an IPython that has a kernel."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return hasattr(shell, "kernel")


def player_widget(player: Player, title: str) -> Any:
    """A widget that plays a run.

    Returns
    -------
    anywidget.AnyWidget
        ``time`` is the time that is shown, s; ``seek(time)`` goes to another one.

    Raises
    ------
    SetupError
        anywidget is not installed.
    """
    page = render("", [Section("", [player])], tab=title, embedded=True)
    return _widget_class()(title=title, page=page, time=float(player.header["times"][0]))


@lru_cache(maxsize=1)
def _widget_class() -> Any:
    """The class of the widget; anywidget defines its base."""
    try:
        anywidget, traitlets = (importlib.import_module(name) for name in ("anywidget", "traitlets"))
    except ImportError:
        raise SetupError(
            "the player in a notebook needs anywidget, which is not installed: pip install 'lammps-jump[notebook]'"
        ) from None

    class RunWidget(anywidget.AnyWidget):  # type: ignore[misc, name-defined]
        """A run that plays in a notebook."""

        _esm = text_of(SCRIPT)
        title = traitlets.Unicode().tag(sync=True)
        page = traitlets.Unicode().tag(sync=True)
        time = traitlets.Float().tag(sync=True)

        def seek(self, time: float) -> None:
            """Show another time, s."""
            self.send({"seek": float(time)})

    return RunWidget
