"""One self-contained page about a run: no network, no script, readable on a phone, below 5 MB."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

import base64
import html
import json
from pathlib import Path
from typing import Any

from lammps_jump.errors import DumpError

from .tables import COEFFICIENTS, energy_section, force_section, front_section, jump_section, key_numbers, table, text

LARGEST = 5_000_000
"""Bytes of a report; figures come first, the animation only where it still fits."""

TITLES = {
    "depth_profile.png": "Depth and velocity along the channel, mean of the window",
    "depth_map.png": "Depth of the free surface over distance and time",
    "jump_track.png": "The jump in time",
    "jump_frame.png": "The jump in its own frame",
    "jump_balance.png": "Where the momentum goes",
    "energy_head.png": "Energy head along the channel",
    "front.png": "Front and column",
    "martin_moyce.png": "Against Martin & Moyce (1952)",
    "forces.png": "Force on the structures",
    "impulse.png": "Impulse",
    "reflected_wave.png": "The reflected wave",
    "energy.png": "Energy of the discs",
    "snapshots.png": "Ten equal times, discs coloured by speed",
    "field_density.png": "Density of the flow",
    "field_pressure.png": "Pressure",
    "bed_pressure.png": "Pressure at the bed against the weight above",
}

STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 1rem 1rem 4rem; font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a;
  background: #fff; overflow-wrap: break-word; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .4rem 0; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .6rem; padding-top: .5rem; border-top: 2px solid #00306f; }
p { margin: .4rem 0; max-width: 46rem; }
.lead { font-size: 1.05rem; }
.verdict { background: #f1f4f9; border-left: 5px solid #00306f; padding: .6rem .8rem; margin: 1rem 0; }
.warn { border-left-color: #b08a00; background: #faf6ea; }
.bad { border-left-color: #b3263a; background: #fbeff0; }
.numbers { display: grid; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr)); gap: .6rem; margin: 1rem 0; }
.number { border: 1px solid #d5d9e0; border-radius: 6px; padding: .5rem .7rem; }
.number b { display: block; font-size: 1.25rem; font-weight: 600; }
.number span { font-size: .82rem; color: #555; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .28rem .5rem; border-bottom: 1px solid #e4e4e4; vertical-align: top; }
td.n, th.n { text-align: right; white-space: nowrap; }
.scroll, figure { overflow-x: auto; }
figure { margin: 1.2rem 0; }
figure img, video { width: 100%; height: auto; display: block; }
figcaption { font-size: .88rem; color: #555; margin-bottom: .3rem; }
pre { background: #f6f6f6; padding: .7rem; overflow-x: auto; font-size: .82rem; line-height: 1.4;
  overflow-wrap: normal; }
details { margin: .5rem 0; }
summary { cursor: pointer; font-weight: 600; }
@media (max-width: 40rem) { figure img { width: auto; min-width: 100%; max-width: none; max-height: 34rem; } }
@media (max-width: 30rem) { body { font-size: 15px; padding: .7rem .7rem 3rem; } th, td { padding: .25rem .3rem; } }
@media print { details > * { display: block; } h2 { break-after: avoid; } figure { break-inside: avoid; } }
"""


def write_report(folder: Path, summary: dict[str, Any], case_yaml: str = "", *, name: str = "report.html") -> Path:
    """Write the report of a run folder from its summary, its figures and its animation.

    Parameters
    ----------
    folder : Path
        Holds ``figures/*.png`` and, if asked for, ``animation.mp4``.
    summary : dict
        As in ``summary.json``; what it lacks is left out.
    case_yaml : str
        The case as run.
    name : str
        File name.

    Returns
    -------
    Path

    Raises
    ------
    DumpError
        The file cannot be written.
    """
    folder = Path(folder)
    parts = [_head(summary), key_numbers(summary), _notes(summary)]
    sections = (jump_section, front_section, force_section, energy_section)
    parts += [section(summary) for section in sections]
    parts += ["{figures}", _coefficients(summary), _skipped(summary), _case(case_yaml), _how(summary)]
    frame = (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<link rel='icon' href='data:,'><title>{text(summary.get('name', 'run'))}: report</title>"
        f"<style>{STYLE}</style></head><body>\n"
    )
    page = frame + "\n".join(part for part in parts if part) + "\n</body></html>\n"
    page = page.replace("{figures}", _figures(folder, LARGEST - len(page.encode())))
    path = folder / name
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise DumpError(f"{path}: the report cannot be written ({error.strerror}).") from error
    return path


def _head(summary: dict) -> str:
    status = summary.get("status")
    title = f"<h1>{text(summary.get('name', 'run').replace('_', ' '))}</h1>"
    lead = f"<p class='lead'>{text(summary['description'])}</p>" if summary.get("description") else ""
    if status in (None, "complete"):
        return title + lead
    return (
        f"{title}{lead}<div class='verdict bad'>The run is {text(status)}. {text(summary.get('message') or '')}</div>"
    )


def _notes(summary: dict) -> str:
    notes = summary.get("warnings") or []
    items = "".join(f"<li>{text(note)}</li>" for note in notes)
    return f"<div class='verdict warn'><b>Notes</b><ul>{items}</ul></div>" if notes else ""


def _figures(folder: Path, room: int) -> str:
    """Figures in a fixed order as data URIs, then the animation, as long as there is room."""
    found = {path.name: path for path in sorted((folder / "figures").glob("*.png"))}
    order = [name for name in TITLES if name in found] + [name for name in found if name not in TITLES]
    parts, left_out = [], []
    for name in order:
        title = TITLES.get(name, name.removesuffix(".png").replace("_", " "))
        data = base64.b64encode(_smaller(found[name])).decode()
        kind = "jpeg" if data.startswith("/9j/") else "png"
        image = f"<img alt='{text(title)}' src='data:image/{kind};base64,{data}'>"
        part = f"<figure><figcaption>{text(title)}</figcaption>{image}</figure>"
        if len(part) + 500 > room:
            left_out.append(f"figures/{name}")
            continue
        room -= len(part)
        parts.append(part)
    movie = folder / "animation.mp4"
    if movie.is_file():
        if movie.stat().st_size * 4 / 3 + 1000 < room:
            data = base64.b64encode(movie.read_bytes()).decode()
            source = f"data:video/mp4;base64,{data}"
            parts.insert(0, f"<figure><figcaption>The flow</figcaption><video controls playsinline loop src='{source}'>"
                            "</video></figure>")  # fmt: skip
        else:
            left_out.append(movie.name)
    if left_out:
        parts.append(f"<p>Too large for this page, beside it in the run folder: {text(', '.join(left_out))}.</p>")
    return "<h2>Figures</h2>" + "".join(parts) if parts else ""


def _smaller(path: Path) -> bytes:
    """The image file; pictures of discs, which PNG stores badly, as JPEG where that is much smaller."""
    data = path.read_bytes()
    if len(data) < 400_000:
        return data
    import io

    from PIL import Image

    buffer = io.BytesIO()
    Image.open(io.BytesIO(data)).convert("RGB").save(buffer, "JPEG", quality=85, optimize=True)
    return buffer.getvalue() if len(buffer.getvalue()) < 0.7 * len(data) else data


def _coefficients(summary: dict) -> str:
    values = summary.get("coefficients")
    if not values:
        return ""
    rows = [(COEFFICIENTS.get(key, (key.replace("_", " "), ""))[0], value, COEFFICIENTS.get(key, ("", ""))[1])
            for key, value in values.items()]  # fmt: skip
    return "<h2>Coefficients</h2>" + table(rows, ("", "value", "unit"))


def _skipped(summary: dict) -> str:
    skipped = summary.get("skipped") or []
    items = "".join(f"<li>{text(item)}</li>" for item in skipped)
    return f"<h2>What this case did not need</h2><ul>{items}</ul>" if skipped else ""


def _case(case_yaml: str) -> str:
    if not case_yaml:
        return ""
    inside = f"<summary>case.yaml, every default filled in</summary><pre>{html.escape(case_yaml)}</pre>"
    return f"<h2>The case</h2><details>{inside}</details>"


def _how(summary: dict) -> str:
    seconds = summary.get("wall_seconds") or {}
    versions = summary.get("versions") or {}
    speed = summary.get("disc_steps_per_second")
    rows: list[tuple] = [("Engine", f"{summary.get('engine') or '–'}, kernel {summary.get('kernel') or '–'}")]
    rows += [(f"Wall time, {name}", f"{value:.2f} s") for name, value in seconds.items() if value is not None]
    rows += [("Steps", summary.get("steps"))] if summary.get("steps") is not None else []
    rows += [("Disc-steps per second", f"{speed / 1e6:.1f} million")] if speed else []
    discs = summary.get("discs") or {}
    if discs:
        rows.append(("Discs", ", ".join(f"{value} {name}" for name, value in discs.items())))
    rows += [(f"Version of {name}", value) for name, value in versions.items()]
    command = "lammps-jump build-and-run case.yaml"
    return (
        "<h2>How to repeat it</h2>"
        f"<p>In this run folder, with the versions below:</p><pre>{command}</pre>{table(rows)}"
        f"<details><summary>summary.json</summary><pre>{html.escape(json.dumps(summary, indent=1))}</pre></details>"
    )
