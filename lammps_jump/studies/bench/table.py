"""Markdown tables of a benchmark, for the README and the pages."""

from __future__ import annotations

from typing import Any


def percent(value: float | None) -> str:
    """A share as text with two or three digits."""
    if value is None:
        return "-"
    return f"{100 * value:.2f} %" if abs(value) < 0.1 else f"{100 * value:.0f} %"


def markdown(data: dict[str, Any]) -> str:
    """One benchmark as a page: cheapest settings, then every row.

    Parameters
    ----------
    data : dict
        Of `study.bench_case`.
    """
    names = list(data["quantities"])
    lines = [f"### {data['case']}", ""]
    lines += [
        f"{data['duration']:g} s of flow, {data['members']} starts a setting, reference: {data['reference']}; "
        f"{data['machine']['processor']}, one core. Time: {data['time']}.",
        "",
        *short_table(data),
        "",
        "| setting | time (s) | M disc-steps/s | " + " | ".join(f"{name} (floor)" for name in names) + " |",
        "|---|---:|---:|" + "---:|" * len(names),
    ]
    for row in data["rows"]:
        seconds = "-" if row["seconds"] is None else f"{row['seconds']:.2f}"
        rate = "-" if not row["disc_steps_per_second"] else f"{row['disc_steps_per_second'] / 1e6:.1f}"
        cells = [_error(row["errors"].get(name)) for name in names]
        failed = f" ({len(row['failed'])} failed)" if row["failed"] else ""
        lines.append(f"| {row['label']}{failed} | {seconds} | {rate} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _error(entry: dict[str, Any] | None) -> str:
    if not entry or entry["error"] is None:
        return "-"
    floor = f" ({percent(entry['floor'])})" if entry["floor"] else ""
    return percent(entry["error"]) + floor


def short_table(data: dict[str, Any]) -> list[str]:
    """Cheapest setting for 5 % and 1 % of each quantity, beside stock LAMMPS at f = 0.05."""
    rows = {row["label"]: row for row in data["rows"]}
    base = rows.get("stock f=0.05")
    lines = ["| quantity | stock f = 0.05 | cheapest within 5 % | cheapest within 1 % |", "|---|---|---|---|"]
    for name, summary in data["quantities"].items():
        cells = [_cell(base, name, None)]
        cells += [_cell(rows.get(summary["cheapest"].get(target) or ""), name, base) for target in ("0.05", "0.01")]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


def _cell(row: dict[str, Any] | None, name: str, base: dict[str, Any] | None) -> str:
    if row is None or row["seconds"] is None:
        return "none shown"
    text = f"{row['label']}: {row['seconds']:.2f} s" if base is not None else f"{row['seconds']:.2f} s"
    if base is not None and base["seconds"] and base is not row:
        text += f", {base['seconds'] / row['seconds']:.1f}x"
    return f"{text} ({_error(row['errors'].get(name))})"
