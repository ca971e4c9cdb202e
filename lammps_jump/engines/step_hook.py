# SPDX-License-Identifier: GPL-2.0-or-later
"""A function that the engines call after every step: none, unless a test of faults sets one."""

from __future__ import annotations

from collections.abc import Callable

at_step: Callable[[int], None] | None = None
"""Called in the engine's process with the number of the step; of several MPI ranks, the first calls it."""
