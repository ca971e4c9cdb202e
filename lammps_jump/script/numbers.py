# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers as LAMMPS reads them."""

from __future__ import annotations


def number(value: float) -> str:
    """Shortest text that LAMMPS reads back as the same double."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def numbers(*values: float) -> str:
    """Several numbers, between blanks."""
    return " ".join(number(value) for value in values)
