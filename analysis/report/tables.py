"""Sections of the report: main numbers, each analysis as a table with theory and error beside the measurement."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

import html
from typing import Any

COEFFICIENTS = {
    "mass": ("Disc mass m = ρd²", "kg/m"),
    "restitution": ("Restitution coefficient e", ""),
    "friction": ("Friction coefficient ks", ""),
    "stiffness": ("Stiffness k, disc-disc", "N/m"),
    "stiffness_wall": ("Stiffness k, disc-wall", "N/m"),
    "damping_ratio": ("Damping ratio ξ", ""),
    "damping": ("Dashpot c, disc-disc", "N s/m"),
    "damping_wall": ("Dashpot c, disc-wall", "N s/m"),
    "correction": ("Dashpot correction, disc-disc", ""),
    "correction_wall": ("Dashpot correction, disc-wall", ""),
    "gamma_normal": ("γn, disc-disc", "1/s"),
    "gamma_normal_wall": ("γn, disc-wall", "1/s"),
    "gamma_tangential": ("γt, disc-disc", "1/s"),
    "gamma_tangential_wall": ("γt, disc-wall", "1/s"),
    "omega": ("Contact frequency ω, disc-disc", "rad/s"),
    "omega_wall": ("Contact frequency ω, disc-wall", "rad/s"),
    "time_step": ("Time step", "s"),
    "critical_time_step": ("Critical time step 2/ω", "s"),
    "time_step_fraction": ("Time step over 2/ω", ""),
    "stable_fraction": ("Largest stable fraction, densest packing", ""),
    "contact_duration": ("Contact duration", "s"),
    "contact_steps": ("Steps per contact", ""),
    "slip_speed": ("Slip speed where Coulomb friction takes over", "m/s"),
    "largest_overlap": ("Largest overlap at the reference speed", "m"),
}


def _number(label: str, value: Any, unit: str = "") -> str:
    return f"<div class='number'><b>{text(value)}{f' {unit}' if unit else ''}</b><span>{text(label)}</span></div>"


def _deviation(measured: float | None, expected: float | None) -> str:
    if measured is None or not expected:
        return "–"
    return f"{100 * (measured / expected - 1):+.1f} %".replace("-", "−")


def _with_error(value: float | None, error: float | None, digits: int = 3) -> str:
    if value is None:
        return "–"
    tail = f" ± {error:.2g}" if error is not None else ""
    return f"{value:.{digits}f}{tail}".replace("-", "−")


def key_numbers(summary: dict) -> str:
    """The few numbers a person looks for first."""
    jump, front, energy, force = (summary.get(key) for key in ("jump", "front", "energy", "force"))
    boxes = []
    if jump:
        boxes.append(_number("verdict", jump["verdict"]))
        for label, key, unit in (
            ("sequent-depth ratio s₂/s₁", "sequent_ratio", ""),
            ("Bélanger, front's frame", "belanger_ratio", ""),
            ("Froude number, front's frame", "froude", ""),
            ("velocity of the front", "speed", "m/s"),
            ("length", "length", "m"),
            ("head lost", "energy_loss", "m"),
        ):
            if jump.get(key) is not None:
                boxes.append(_number(label, jump[key], unit))
    if front and front.get("position") is not None:
        boxes.append(_number(f"front at t = {front['time']:.3g} s", front["position"], "m"))
        if front.get("speed") is not None:
            boxes.append(_number("speed of the front", front["speed"], "m/s"))
    for name, values in (force or {}).items():
        if isinstance(values, dict) and values.get("peak") is not None:
            boxes.append(_number(f"peak force on {name}", values["peak"] / 1e3, "kN/m"))
    if energy and energy.get("conservative") and energy.get("max_deviation") is not None:
        boxes.append(_number("largest energy deviation", 100 * energy["max_deviation"], "%"))
    discs = summary.get("discs") or {}
    if discs.get("inserted") is not None:
        boxes.append(_number("discs in all", discs["inserted"]))
    return f"<div class='numbers'>{''.join(boxes)}</div>" if boxes else ""


def jump_section(summary: dict) -> str:
    """The jump: verdict, states, ratios, balance, lengths."""
    jump = summary.get("jump")
    if not jump:
        return ""
    kind = "" if jump["verdict"] == "jump" else " warn"
    parts = [
        "<h2>Hydraulic jump</h2>",
        f"<div class='verdict{kind}'><b>{text(jump['verdict'])}</b>: {text(jump['reason'])}</div>",
    ]
    inflow = jump.get("inflow")
    if inflow:
        parts.append(
            f"<p>Theory for the inflow (y₁ = {text(inflow['depth'])} m, {text(inflow['velocity'])} m/s): Froude number "
            f"{inflow['froude']:.2f} ({text(inflow['class'])}), Bélanger depth {inflow['belanger_y2']:.2f} m, length "
            f"by thesis (4.27) {text(inflow['length'])} m.</p>"
        )
    if jump.get("y1") is None:
        return "".join(parts)
    error = jump.get("speed_error")
    parts.append(
        table(
            [
                (
                    "Mass depth s [m]",
                    _with_error(jump["y1"], jump["y1_error"]),
                    _with_error(jump["y2"], jump["y2_error"]),
                ),
                ("Surface depth h [m]", jump["h1"], jump["h2"]),
                ("Mean velocity u [m/s]", jump["u1"], jump["u2"]),
                ("Packing", jump["packing_1"], jump["packing_2"]),
                ("Momentum coefficient β", jump["beta_1"], jump["beta_2"]),
                ("Froude number, front's frame", jump["froude"], jump["froude_downstream"]),
                ("Momentum function [kN/m]", jump["momentum_upstream"] / 1e3, jump["momentum_downstream"] / 1e3),
                ("Head, front's frame [m]", jump["head_upstream"], jump["head_downstream"]),
            ],
            ("State, measured beside the jump", "upstream 1", "downstream 2"),
        )
    )
    ratio = jump["sequent_ratio"]
    rows = [
        ("s₂/s₁", ratio, "Bélanger, front's frame", jump["belanger_ratio"], _deviation(ratio, jump["belanger_ratio"])),
        ("s₂/s₁", ratio, f"with density ratio {jump['density_ratio']:.3f}", jump["density_relation_ratio"],
         _deviation(ratio, jump["density_relation_ratio"])),
        ("s₂/s₁", ratio, "and measured bed force and β", jump["full_relation_ratio"],
         _deviation(ratio, jump["full_relation_ratio"])),
    ]  # fmt: skip
    if jump.get("pressure_relation_ratio") is not None:
        rows.append(("s₂/s₁", ratio, "and measured contact pressure", jump["pressure_relation_ratio"],
                     _deviation(ratio, jump["pressure_relation_ratio"])))  # fmt: skip
    rows += [
        ("Velocity of the front [m/s]", _with_error(jump["speed"], error), "from mass, (s₂u₂ − s₁u₁)/(s₂ − s₁)",
         jump["mass"]["speed_from_mass"], _deviation(jump["speed"], jump["mass"]["speed_from_mass"])),
        ("Length [m]", jump["length"], "thesis (4.27)", jump["length_theory"],
         _deviation(jump["length"], jump["length_theory"])),
        ("Length [m]", jump["length"], "USBR curve", jump["length_usbr"],
         _deviation(jump["length"], jump["length_usbr"])),
        ("Head lost [m]", jump["energy_loss"], "Bélanger", jump["energy_loss_theory"],
         _deviation(jump["energy_loss"], jump["energy_loss_theory"])),
    ]  # fmt: skip
    parts.append(table(rows, ("Measured", "", "against", "", "difference")))
    terms = jump["momentum_terms"]
    names = {
        "profile": "uneven velocities and their fluctuations",
        "packing": "surface depth in place of mass depth",
        "pressure": "contact pressure beyond hydrostatic",
        "bed": "force of the bed",
        "slope": "gravity along the bed",
        "unsteady": "momentum stored between the stations",
        "unexplained": "left unexplained",
    }
    explained = "; ".join(
        f"{label} {100 * terms[key]:+.1f} %" for key, label in names.items() if terms[key] is not None
    )
    parts.append(
        f"<p>Mass flux through the moving front: downstream minus upstream {100 * jump['mass']['closure']:+.2f} %, "
        f"{100 * jump['mass']['closure_with_storage']:+.2f} % with what is stored in between. Momentum function "
        f"upstream minus downstream: {100 * jump['momentum_residual']:+.1f} % of the downstream one; measured parts: "
        f"{text(explained)}.</p>"
    )
    roller = jump["roller"]
    found = roller["length"] is not None
    words = (
        f"over {roller['length']:.1f} m, from {roller['start']:.1f} m behind the toe"
        if found
        else "nowhere in the mean"
    )
    parts.append(f"<p>Roller: the mean surface velocity is reversed {words}.</p>")
    return "".join(parts)


def front_section(summary: dict) -> str:
    """The front of a collapsing column against Ritter and Martin & Moyce."""
    front = summary.get("front")
    if not front:
        return ""
    if front.get("position") is None:
        return f"<h2>Front</h2><div class='verdict warn'>{text(front.get('reason'))}</div>"
    rows = [
        ("Column at the start, base × height [m]", f"{front['column_base']:.3g} × {front['column_depth']:.3g}"),
        ("Bulk front at the end [m]", front["position"]),
        ("99 % of the discs within [m]", front["position_99"]),
        ("Column at the back wall at the end [m]", front["column_height"]),
        ("Mean speed of the front [m/s]", front["speed"]),
        ("Arrival at the first obstacle [s]", front["arrival_time"]),
    ]
    ritter, moyce = front.get("ritter"), front.get("martin_moyce")
    if ritter:
        rows.append(
            (f"Ritter's front, holds until t = {ritter['valid_until']:.2g} s: RMS difference", _percent(ritter["rms"]))
        )
    if moyce:
        rows += [
            ("Aspect n² = H/a (Martin & Moyce: 2)", moyce["aspect"]),
            ("Martin & Moyce, bulk front, T > 0.8: RMS difference", _percent(moyce["rms_bulk"])),
            ("Martin & Moyce, 99 % front: RMS difference", _percent(moyce["rms_99"])),
            ("Martin & Moyce, column height: RMS difference", _percent(moyce["rms_height"])),
            ("Slope dZ/dT (Martin & Moyce: 1.32)", moyce["slope"]),
        ]
    return "<h2>Front</h2>" + table(rows)


def _percent(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.1f} %"


def force_section(summary: dict) -> str:
    """Forces on the probed structures, the impulse identity, the reflected wave."""
    force = summary.get("force")
    if not force:
        return ""
    rows = []
    for name, values in force.items():
        if isinstance(values, dict) and "peak" in values:
            kilo = [_kilo(values.get(key)) for key in ("impulse", "peak_moment", "hydrostatic", "stagnation")]
            rows.append((name, _kilo(values["peak"]), values.get("peak_time"), *kilo))
    first = ("Structure", "peak [kN/m]", "at [s]", "impulse [kN s/m]", "peak moment [kN m/m]")
    parts = ["<h2>Forces</h2>", table(rows, (*first, "ρgh²/2 [kN/m]", "with ρhu² [kN/m]"))]
    parts += [f"<p>{text(note)}</p>" for note in force.get("notes") or []]
    return "".join(parts)


def _kilo(value: float | None) -> float | None:
    return None if value is None else value / 1e3


def energy_section(summary: dict) -> str:
    """Energy at the start and the end; deviation and drift of a closed box."""
    energy = summary.get("energy")
    if not energy or energy.get("initial") is None:
        return ""
    rows = [("Energy at the start [J/m]", energy["initial"]), ("at the end [J/m]", energy.get("final"))]
    if energy.get("conservative"):
        rows += [
            ("Largest deviation", _percent_fine(energy["max_deviation"])),
            ("Drift over the record", _percent_fine(energy["drift"])),
        ]
    rows += [(f"{name} at the end [J/m]", energy.get(name)) for name in ("kinetic", "potential", "elastic")]
    return "<h2>Energy</h2>" + table(rows)


def _percent_fine(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:+.4f} %"


def text(value: Any) -> str:
    """A value as safe HTML text; numbers with four digits, nothing as a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        shown = f"{value:.4g}"
        if "e" in shown:
            mantissa, exponent = shown.split("e")
            return f"{mantissa}&thinsp;×&thinsp;10<sup>{int(exponent)}</sup>"
        return shown.replace("-", "−")
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f").replace("-", "−")
    return html.escape(str(value))


def table(rows: list[tuple], header: tuple[str, ...] = ()) -> str:
    """An HTML table; cells are made safe, numbers right-aligned."""

    def number(value: Any) -> bool:
        return isinstance(value, int | float) and not isinstance(value, bool)

    columns = max((len(row) for row in rows), default=0)
    right = [any(len(row) > i and number(row[i]) for row in rows) for i in range(columns)]

    def line(tag: str, row: tuple) -> str:
        cells = (f"<{tag}{' class=n' if right[i] else ''}>{text(value)}</{tag}>" for i, value in enumerate(row))
        return f"<tr>{''.join(cells)}</tr>"

    head = line("th", header) if header and rows else ""
    body = "".join(line("td", row) for row in rows)
    return f"<div class='scroll'><table>{head}{body}</table></div>"
