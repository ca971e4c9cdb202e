"""Figures of the sensitivity studies: sequent depth, length and speed of the jump against one parameter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

BLUE, GREY, RED = "#33508f", "#7d7c78", "#b03a2e"


def draw_study(study, rows: list[dict[str, Any]], path: Path) -> Path:
    """Three panels with one abscissa; theory for the same (measured) Froude number beside each measurement."""
    from lammps_jump.analysis.draw.style import new_figure, save, style

    with style():
        figure, axes = new_figure(8.6, 2.9, 1, 3)
        _panel(axes[0], rows, "sequent_ratio", "belanger_ratio", "Bélanger")
        axes[0].set_title("sequent depths y2/y1")
        _panel(axes[1], rows, "length_over_y2", "usbr", "USBR curve")
        axes[1].set_title("length over y2")
        _panel(axes[2], rows, "speed", None, "")
        axes[2].set_title("speed of the front (m/s)")
        axes[2].axhline(0, color="#999999", linewidth=0.8)
        for panel in axes:
            panel.set_xlabel(study.label)
            if study.name in ("diameter", "stiffness"):
                panel.set_xscale("log")
                panel.set_xticks([row["value"] for row in rows], [f"{row['value']:g}" for row in rows])
                panel.minorticks_off()
            none = [row["value"] for row in rows if row["sequent_ratio"] is None]
            low = panel.get_ylim()[0]
            if none:
                panel.plot(none, [low] * len(none), "x", color=RED, clip_on=False, label="no jump found")
            panel.legend()
        return save(figure, path)


def _panel(axes, rows, name: str, theory_name: str | None, theory_label: str) -> None:
    found = [row for row in rows if row[name] is not None]
    axes.errorbar(
        [row["value"] for row in found], [row[name] for row in found],
        yerr=[row.get(f"{name}_error") or 0.0 for row in found], fmt="o-", color=BLUE, capsize=2, label="discs",
    )  # fmt: skip
    if theory_name:
        some = [row for row in found if row[theory_name] is not None]
        axes.plot(
            [row["value"] for row in some], [row[theory_name] for row in some], "s--", color=GREY,
            markerfacecolor="white", label=theory_label,
        )  # fmt: skip
