# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a benchmark, in Markdown, and its figures, from what ``bench.json`` holds."""

from __future__ import annotations

from pathlib import Path

from matplotlib.ticker import LogLocator

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.studies.table import markdown, number, percent

MARKS = {
    "stock": ("o", "#33508f"),
    "compiled": ("s", "#7d7c78"),
    "compiled smooth": ("D", "#b5a05a"),
    "native": ("^", "#111111"),
    "native smooth": ("v", "#d9c55b"),
}


def page(data: dict) -> str:
    """Return one benchmark as a page: cheapest settings, then every row.

    Parameters
    ----------
    data : dict
        Content of ``bench.json``.
    """
    names = list(data["quantities"])
    rows = []
    for row in data["rows"]:
        failed = f" ({len(row['failed'])} failed)" if row["failed"] else ""
        rate = row["disc_steps_per_second"]
        cells = [_error(row["errors"].get(name)) for name in names]
        rows.append([row["label"] + failed, number(row["seconds"]), number(rate / 1e6 if rate else None, 1), *cells])
    head = ["setting", "time (s)", "M disc-steps/s", *(f"{name} (floor)" for name in names)]
    about = (
        f"{data['duration']:g} s of flow, {data['members']} starts a setting, reference: {data['reference']}; "
        f"{data['machine']['processor']}, one core. Time: {data['time']}."
    )
    table = markdown(head, "l" + "r" * (len(head) - 1), rows)
    return "\n\n".join([f"### {data['case']}", about, short_table(data), table]) + "\n"


def short_table(data: dict) -> str:
    """Return the cheapest setting for 5 % and 1 % of each quantity, beside stock LAMMPS at f = 0.05."""
    rows = {row["label"]: row for row in data["rows"]}
    base = rows.get("stock f=0.05")
    lines = []
    for name, summary in data["quantities"].items():
        chosen = (rows.get(summary["cheapest"].get(target) or "") for target in ("0.05", "0.01"))
        lines.append([name, _cell(base, name, None), *(_cell(row, name, base) for row in chosen)])
    return markdown(["quantity", "stock f = 0.05", "cheapest within 5 %", "cheapest within 1 %"], "llll", lines)


def _error(entry: dict | None) -> str:
    if not entry or entry["error"] is None:
        return "-"
    return percent(entry["error"]) + (f" ({percent(entry['floor'])})" if entry["floor"] else "")


def _cell(row: dict | None, name: str, base: dict | None) -> str:
    if row is None or row["seconds"] is None:
        return "none shown"
    text = f"{row['label']}: {row['seconds']:.2f} s" if base is not None else f"{row['seconds']:.2f} s"
    if base is not None and base["seconds"] and base is not row:
        text += f", {base['seconds'] / row['seconds']:.1f}x"
    return f"{text} ({_error(row['errors'].get(name))})"


def draw_quantity(data: dict, name: str, folder: Path) -> Path:
    """Draw run time (s, log) against error (%, log): families by mark, Pareto front as a line, floor as a band."""
    summary = data["quantities"][name]
    rows = [row for row in data["rows"] if row["seconds"] and (row["errors"].get(name) or {}).get("error")]
    with drawing(7.2, 4.4) as (figure, axes):
        _draw_families(axes, rows, name)
        front = [row for label in summary["pareto"] for row in rows if row["label"] == label]
        if front:
            axes.step(*_points(front, name), where="post", color="#b03a2e", linewidth=1.0, label="Pareto front")
        axes.set(xscale="log", yscale="log", xlabel="processor time of the run (s)", ylabel="error (%)")
        if summary["floor"]:
            low = min(axes.get_ylim()[0], 50 * summary["floor"])
            axes.set_ylim(bottom=low)
            axes.axhspan(low, 100 * summary["floor"], color="#eeeeee", zorder=0)
            axes.annotate(
                "scatter of the ensembles: nothing can be told apart below", (0.02, 100 * summary["floor"]),
                xycoords=("axes fraction", "data"), fontsize=7, va="top", color="#666666",
            )  # fmt: skip
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter("")
        _name_choices(axes, summary, rows, name)
        axes.set_title(f"{data['case']}: {name}")
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
        return save(figure, folder / f"bench_{name.replace(' ', '_')}.png")


def _points(rows: list[dict], name: str) -> tuple[list[float], list[float]]:
    """Return run times (s) and errors (%)."""
    return [row["seconds"] for row in rows], [100 * row["errors"][name]["error"] for row in rows]


def _draw_families(axes, rows: list[dict], name: str) -> None:
    for family, (mark, colour) in MARKS.items():
        for plain in (True, False):
            some = [row for row in rows if row["family"] == family and row["plain"] is plain]
            if some:
                axes.plot(
                    *_points(some, name), mark, color=colour, markerfacecolor=colour if plain else "white",
                    markersize=6, label=family if plain else f"{family}, other axes",
                )  # fmt: skip


def _name_choices(axes, summary: dict, rows: list[dict], name: str) -> None:
    """Ring and name the cheapest settings; where one serves both targets it is named once."""
    named: dict[str, list[str]] = {}
    for target, label in summary["cheapest"].items():
        if label:
            named.setdefault(label, []).append(f"{100 * float(target):g} %")
    for index, (label, targets) in enumerate(named.items()):
        row = next(row for row in rows if row["label"] == label)
        point = row["seconds"], 100 * row["errors"][name]["error"]
        axes.plot(*point, "o", markersize=12, markerfacecolor="none", color="#b03a2e", linewidth=1.2)
        axes.annotate(
            f"{' and '.join(targets)}: {label}", point, xytext=(1.02, 0.95 - 0.07 * index),
            textcoords="axes fraction", fontsize=8, color="#b03a2e",
            arrowprops={"arrowstyle": "-", "color": "#b03a2e", "linewidth": 0.6},
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
        )  # fmt: skip
