# SPDX-License-Identifier: GPL-2.0-or-later
"""Report of a run: its summary, figures and film in one page below 5 MB."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from shlex import quote

from lammps_jump.analysis.budgets import stations
from lammps_jump.analysis.budgets.inflow import Delivery
from lammps_jump.analysis.jump.summary import Jump
from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.errors import DumpError
from lammps_jump.files import CURVES, FIGURES, read_json, write_text
from lammps_jump.physics.contact import Coefficients
from lammps_jump.units import ABSENT, numbers_of

from .definitions import DEFINITIONS
from .headline import belongs, headline
from .page import (
    Box,
    Boxes,
    Code,
    Curve,
    Items,
    Picture,
    Section,
    Table,
    Text,
    heading,
    percent,
    picture,
    render,
    with_error,
)

LARGEST = 5_000_000
"""Bytes of a report; figures come first, the film only where it still fits."""
BOXES = ("sequent_ratio", "belanger_ratio", "froude", "speed", "length", "head_lost")
"""Numbers of a jump that stand in boxes at the top."""
INFLOW = ("delivered", "froude", "belanger_y2")
"""Numbers of the inflow there."""
REMARKS = {"length": "; discs make a short one"}
UNSURE = "no error from one run"


def write_report(folder: Path, summary: Mapping, case_yaml: str = "", *, name: str = "report.html") -> Path:
    """Write the report of a run folder from its summary, its figures and its film.

    Parameters
    ----------
    folder : Path
        Holds ``figures/*.png`` and, if asked for, ``animation.mp4`` or ``animation.gif``.
    summary : mapping
        As in ``summary.json``; what it lacks is left out.
    case_yaml : str
        The case as run.
    name : str
        File name.

    Raises
    ------
    DumpError
        The file cannot be written.
    """
    name_of_run = str(summary.get("name", "run"))
    title = name_of_run if "given" in summary else name_of_run.replace("_", " ")
    tab = f"{name_of_run}: report"
    lead = [
        *_lead(summary),
        Boxes([Box(*number) for number in _key_numbers(summary)]),
        Items(summary.get("warnings") or (), "Notes"),
    ]
    before = [Section("", lead)]
    before += [
        _defined(key, quantity.section(summary[key])) for key, quantity in QUANTITIES.items() if summary.get(key)
    ]
    before.append(_defined("stations", stations.section(summary)))
    numbers = numbers_of(Coefficients)
    values = [(numbers[key], value) for key, value in (summary.get("coefficients") or {}).items() if key in numbers]
    coefficients = [(heading(number.meaning, ""), value, number.unit) for number, value in values]
    after = [
        Section("Coefficients", [Table(coefficients, ("", "value", "unit"))]),
        Section("What this case did not need", [Items(summary.get("skipped") or ())]),
        Section("The case", [Code(case_yaml, "case.yaml, every default filled in")]),
        _how(summary),
    ]
    room = LARGEST - len(render(title, [*before, *after], tab=tab).encode(errors="replace"))
    path = Path(folder) / name
    page = render(title, [*before, _figures(Path(folder), room), *after], tab=tab)
    try:
        write_text(path, page)
    except OSError as error:
        raise DumpError(f"{path}: the report cannot be written ({error.strerror}).") from error
    return path


def _defined(key: str, section: Section | None) -> Section | None:
    """The section of a quantity, with what its numbers mean folded away at its end."""
    if section is None or not section.blocks:
        return section
    return section._replace(blocks=[*section.blocks, Code(DEFINITIONS[key], "What these numbers mean")])


def _lead(summary: Mapping) -> list[Text]:
    status = summary.get("status", "complete")
    said = "" if status == "complete" else f"The run is {status}. {summary.get('message') or ''}"
    return [Text(summary.get("description", ""), "lead"), Text(said, "bad"), Text(headline(summary), "verdict")]


def _key_numbers(summary: Mapping) -> list[tuple[str, float | str, str]]:
    """The few numbers that readers look for first."""
    parts = ("inflow", "jump", "front", "energy", "force")
    inflow, jump, front, energy, force = (summary.get(key) or {} for key in parts)
    boxes: list[tuple[str, float | str, str]] = [("verdict", jump["verdict"], "")] if jump else []
    given = numbers_of(Delivery)
    for key in INFLOW:
        if inflow.get(key) is not None:
            sure = "" if key == "delivered" else ", ± within this run"
            boxes.append((given[key].meaning + sure, with_error(inflow, key), given[key].unit))
    if jump.get("share_found") is not None:
        boxes.append(("of the window's frames have a jump", percent(jump["share_found"], 0), ""))
    numbers = numbers_of(Jump)
    for key in BOXES:
        if jump.get(key) is not None and belongs(key, jump):
            error = jump.get(f"{key}_error")
            sure = (
                numbers[key].meaning
                + REMARKS.get(key, "")
                + (", ± within this run" if error is not None else f" ({UNSURE})")
            )
            starts = (jump.get("members") or {}).get(key)
            sure += f"; for 3 % at least {starts} run(s)" if starts else ""
            boxes.append((sure, with_error(jump, key), numbers[key].unit))
    if front.get("position") is not None:
        when = "at the last frame" if front.get("time") is None else f"at t = {front['time']:.3g} s"
        boxes.append((f"front {when} ({UNSURE})", front["position"], "m"))
        boxes += [(f"speed of the front ({UNSURE})", front["speed"], "m/s")] if front.get("speed") is not None else []
    for name, values in force.items():
        if isinstance(values, dict) and values.get("peak") is not None:
            sure = ", ± within this run" if values.get("peak_error") is not None else f" ({UNSURE})"
            boxes.append((f"peak force on {name}{sure}", with_error(values, "peak", 1e3), "kN/m"))
    if energy.get("conservative") and energy.get("max_deviation") is not None:
        boxes.append(("largest energy deviation, exact", 100 * energy["max_deviation"], "%"))
    discs = summary.get("discs") or {}
    boxes += [("discs in all", discs["inserted"], "")] if discs.get("inserted") is not None else []
    return boxes


def curves(folder: Path) -> dict[str, Curve]:
    """What the page draws of a run folder, by the name of the figure's file, in the order of `FIGURES`."""
    try:
        found = read_json(folder / CURVES)
        return {name: Curve(text, found[Path(name).stem]) for name, text in FIGURES.items() if Path(name).stem in found}
    except (OSError, ValueError, TypeError):
        return {}  # of a version before, or damaged: the page is whole without


def _figures(folder: Path, room: int) -> Section:
    """The film, curves and pictures in a fixed order, as long as there is room; the film gives way to the pictures."""
    drawn = curves(folder)
    found = {path.name: path for path in sorted((folder / "figures").glob("*.png")) if path.name not in drawn}
    order = [name for name in FIGURES if name in found] + [name for name in found if name not in FIGURES]
    files = [(found[name], FIGURES.get(name, name.removesuffix(".png").replace("_", " "))) for name in order]
    films = [folder / f"animation.{kind}" for kind in ("mp4", "gif")]
    shown: list[Picture] = []
    left_out = []
    for path, caption in [*files, *((film, "The flow") for film in films if film.is_file())]:
        block = picture(path, caption) if path.stat().st_size < LARGEST else None
        if block is None or len(block.source) + 500 > room:
            left_out.append(path.name if path in films else f"figures/{path.name}")
            continue
        room -= len(block.source) + 200
        shown.insert(0 if path in films else len(shown), block)
    tail = f"Too large for this page, beside it in the run folder: {', '.join(left_out)}." if left_out else ""
    return Section("Figures", [*drawn.values(), *shown, Text(tail)])


def _command(summary: Mapping) -> list[Text | Code]:
    """The command that makes the results again."""
    if "given" not in summary:
        return [Text("In this run folder, with the versions below:"), Code("lammps-jump build-and-run case.yaml")]
    options = [
        f"--{key.replace('_', '-')} "
        + (",".join(f"{k}={v:g}" for k, v in value.items()) if isinstance(value, Mapping) else f"{value:g}")
        for key, value in summary["given"].items()
    ]
    return [Code(" ".join(["lammps-jump analyze", quote(summary["name"]), *options]))]


def _how(summary: Mapping) -> Section:
    seconds, discs = summary.get("wall_seconds") or {}, summary.get("discs") or {}
    speed, versions = summary.get("disc_steps_per_second"), summary.get("versions") or {}
    rows = [
        ("Engine", f"{summary['engine']}, kernel {summary.get('kernel') or ABSENT}" if summary.get("engine") else None),
        *((f"Wall time, {name}", f"{value:.2f} s") for name, value in seconds.items() if value is not None),
        ("Steps", summary.get("steps")),
        ("Disc-steps per second", f"{speed / 1e6:.1f} million" if speed else None),
        ("Discs", ", ".join(f"{value} {name}" for name, value in discs.items()) or None),
        *((f"Version of {name}", value) for name, value in versions.items()),
    ]
    return Section(
        "How to repeat it",
        [
            *_command(summary),
            Table([row for row in rows if row[1] is not None]),
            Code(json.dumps(summary, indent=1), "summary.json"),
        ],
    )
