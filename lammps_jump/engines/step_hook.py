# SPDX-License-Identifier: GPL-2.0-or-later
"""A function that the engines call after every step: none, unless a test of faults sets one."""

from __future__ import annotations

from collections.abc import Callable

at_step: Callable[[int], None] | None = None
"""Called with the number of the step. LAMMPS on more than one rank calls it at the steps of its log only."""
