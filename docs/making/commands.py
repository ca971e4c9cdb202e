# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all commands: what ``--help`` prints."""

from __future__ import annotations

import os
import subprocess
import sys

HEAD = """\
# All commands

This page is what each command prints with `--help`.
"""
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
    from lammps_jump.cli.app import app

    return [
        name.name or name.callback.__name__.replace("_", "-")
        for group in app.registered_groups
        for name in group.typer_instance.registered_commands
    ] + list(GROUPS)


def _block(words: tuple[str, ...]) -> str:
    command = [sys.executable, "-m", "lammps_jump", *words, "--help"]
    done = subprocess.run(
        command, env={**os.environ, "COLUMNS": "90", "TERM": "dumb"}, capture_output=True, text=True, check=True
    )
    text = done.stdout.replace("python -m lammps_jump", "lammps-jump").strip()
    return f"```text\n{text}\n```\n"
