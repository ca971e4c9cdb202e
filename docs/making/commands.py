# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all commands: what ``--help`` prints."""

from __future__ import annotations

from contextlib import redirect_stdout
from io import StringIO

from lammps_jump.cli.app import app

HEAD = """\
# All commands

This page is what each command prints with `--help`.
"""
WIDTH = 90
"""Columns of a page."""
GROUPS = {"kernels": ("build", "status")}
"""Commands that hold commands."""


def page() -> str:
    """The page, Markdown."""
    blocks = [HEAD, _block(())]
    for name in _names():
        blocks += [f"## {name}\n", _block((name,))]
        for inner in GROUPS.get(name, ()):
            blocks += [f"### {name} {inner}\n", _block((name, inner))]
    return "\n".join(blocks)


def _names() -> list[str]:
    return [
        name.name or name.callback.__name__.replace("_", "-")
        for group in app.registered_groups
        for name in group.typer_instance.registered_commands
    ] + list(GROUPS)


def _block(words: tuple[str, ...]) -> str:
    told = StringIO()
    with redirect_stdout(told):
        app(args=[*words, "--help"], prog_name="lammps-jump", standalone_mode=False, terminal_width=WIDTH)
    return f"```text\n{told.getvalue().strip()}\n```\n"
