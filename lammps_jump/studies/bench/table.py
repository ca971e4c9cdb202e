# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a benchmark, in Markdown, from what ``bench.json`` holds."""

from __future__ import annotations

from lammps_jump.studies.table import markdown, number, percent


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
