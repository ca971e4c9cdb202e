# SPDX-License-Identifier: GPL-2.0-or-later
"""Front and height of a column that collapses, in the numbers of Martin & Moyce."""

from __future__ import annotations

from lammps_jump import Run


def column(run: Run) -> dict:
    """Mean deviation of the front from Martin & Moyce's curve (n² = 2 alone), and its slope."""
    found = run.summary["front"]["martin_moyce"]
    if found["slope_of_table"] is None or found["slope"] is None:
        raise ValueError(f"the column has n² = {found['aspect']:.2f}; curves are known of 1 and 2")
    return {key: found[key] for key in ("mean_bulk", "rms_bulk", "rms_height", "aspect", "slope", "slope_of_table")}
