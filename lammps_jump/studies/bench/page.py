# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a benchmark, in Markdown, and its figures, from what ``bench.json`` holds."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator

from lammps_jump.analysis.draw.style import RED, drawing, save
from lammps_jump.analysis.tables.markdown import Column, markdown, percent

MARKS = {
    "stock": ("o", "#33508f"),
    "compiled": ("s", "#7d7c78"),
    "compiled smooth": ("D", "#b5a05a"),
    "native": ("^", "#111111"),
    "native smooth": ("v", "#d9c55b"),
}
COLUMNS = ("label", "family", "plain", "seconds", "error")


def page(data: Mapping[str, Any]) -> list[str]:
    """Return the paragraphs of a benchmark's page: cheapest settings, then every row.

    Parameters
    ----------
    data : dict
        Content of ``bench.json``.
    """
    columns: dict[str, Column] = {
        "setting": lambda row: row["label"] + (f" ({len(row['failed'])} failed)" if row["failed"] else ""),
        "time (s):": "{seconds:z.2f}",
        "M disc-steps/s:": lambda row: f"{rate / 1e6:z.1f}" if (rate := row["disc_steps_per_second"]) else "-",
    }
    columns |= {f"{name} (floor):": partial(_error, name=name) for name in data["quantities"]}
    about = (
        f"{data['duration']:zg} s of flow, {data['members']} starts a setting, reference: {data['reference']}; "
        f"{data['machine']['processor']}, one core. Time: {data['time']}."
    )
    return [f"### {data['case']}", about, short_table(data), markdown(columns, data["rows"])]


def short_table(data: Mapping[str, Any]) -> str:
    """Return the cheapest setting for 5 % and 1 % of each quantity, beside stock LAMMPS at f = 0.05."""
    rows = {row["label"]: row for row in data["rows"]}
    base, targets = rows.get("stock f=0.05"), {"0.05": "5 %", "0.01": "1 %"}
    lines = []
    for name, summary in data["quantities"].items():
        chosen = {f"cheapest within {word}": rows.get(summary["cheapest"].get(t)) for t, word in targets.items()}
        cells = {title: _cell(row, name, base) for title, row in chosen.items()}
        lines.append({"quantity": name, "stock f = 0.05": _cell(base, name, None), **cells})
    return markdown(dict.fromkeys(lines[0] if lines else (), ""), lines)


def _error(row: Mapping[str, Any], name: str) -> str:
    entry = row["errors"].get(name)
    if not entry or entry["error"] is None:
        return "-"
    return percent(entry["error"]) + (f" ({percent(entry['floor'])})" if entry["floor"] else "")


def _cell(row: Mapping[str, Any] | None, name: str, base: Mapping[str, Any] | None) -> str:
    if row is None or row["seconds"] is None:
        return "none shown"
    text = f"{row['label']}: {row['seconds']:z.2f} s" if base is not None else f"{row['seconds']:z.2f} s"
    if base is not None and base["seconds"] and base is not row:
        text += f", {base['seconds'] / row['seconds']:z.1f}x"
    return f"{text} ({_error(row, name)})"


def draw_settings(data: Mapping[str, Any], folder: Path) -> None:
    """Draw the figure of each quantity."""
    for name in data["quantities"]:
        draw_quantity(data, name, folder)


def draw_quantity(data: Mapping[str, Any], name: str, folder: Path) -> Path:
    """Draw run time (s, log) against error (%, log): families by mark, Pareto front as a line, floor as a band.

    A setting without any error has no place on a logarithmic axis.
    """
    summary = data["quantities"][name]
    rows = [{**row, "error": 100 * (row["errors"].get(name, {}).get("error") or 0.0)} for row in data["rows"]]
    table = pd.DataFrame([row for row in rows if row["seconds"] and row["error"]], columns=COLUMNS).set_index("label")
    with drawing(7.2, 4.4) as (figure, axes):
        for family, plain in product(MARKS, (True, False)):
            some, (mark, colour) = table[(table.family == family) & (table.plain == plain)], MARKS[family]
            if len(some):
                axes.plot(some.seconds, some.error, mark, color=colour, markerfacecolor=colour if plain else "white",
                          markersize=6, label=family if plain else f"{family}, other axes")  # fmt: skip
        front = table.reindex(summary["pareto"]).dropna()
        if len(front):
            axes.step(front.seconds, front.error, where="post", color=RED, linewidth=1.0, label="Pareto front")
        axes.set(xscale="log", yscale="log", xlabel="processor time of the run (s)", ylabel="error (%)")
        if summary["floor"]:
            floor, low = 100 * summary["floor"], min(axes.get_ylim()[0], 50 * summary["floor"])
            axes.set_ylim(bottom=low)
            axes.axhspan(low, floor, color="#eeeeee", zorder=0)
            axes.annotate("scatter of the ensembles: nothing can be told apart below", (0.02, floor),
                          xycoords=("axes fraction", "data"), fontsize=7, va="top", color="#666666")  # fmt: skip
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:zg}")
            axis.set_minor_formatter("")
        _name_choices(axes, summary["cheapest"], table)
        axes.set_title(f"{data['case']}: {name}")
        if len(table):
            axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
        return save(figure, folder / f"bench_{name.replace(' ', '_')}.png")


def _name_choices(axes: Axes, cheapest: dict[str, str | None], table: pd.DataFrame) -> None:
    """Ring and name the cheapest settings; where one serves both targets it is named once."""
    for index, label in enumerate(dict.fromkeys(label for label in cheapest.values() if label in table.index)):
        targets = " and ".join(f"{100 * float(target):zg} %" for target, one in cheapest.items() if one == label)
        point = tuple(table.loc[label, ["seconds", "error"]])
        axes.plot(*point, "o", markersize=12, markerfacecolor="none", color=RED, linewidth=1.2)
        axes.annotate(
            f"{targets}: {label}", point, xytext=(1.02, 0.95 - 0.07 * index), textcoords="axes fraction", fontsize=8,
            color=RED, arrowprops={"arrowstyle": "-", "color": RED, "linewidth": 0.6},
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
        )  # fmt: skip
