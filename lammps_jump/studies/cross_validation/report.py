"""The report of a cross-validation: what ``cross_validation.json`` holds, and one HTML file that needs nothing else."""

from __future__ import annotations

import base64
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import Any

from lammps_jump.files import plain
from lammps_jump.provenance import versions

from .ensembles import JITTER
from .figures import SHOWN
from .outcome import Study
from .quantities import Comparison
from .statistics import CONFIDENCE, FAMILY_ERROR
from .trajectories import CONTACT_STEPS

STYLE = """
body { margin: 0 auto; max-width: 60rem; padding: 1rem; font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; }
h1 { font-size: 1.6rem; margin: .4rem 0; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; border-top: 2px solid #00306f; }
.verdict { background: #f1f4f9; border-left: 5px solid #00306f; padding: .6rem .8rem; margin: 1rem 0; }
.bad { border-left-color: #b3263a; background: #fbeff0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .25rem .5rem; border-bottom: 1px solid #e4e4e4; vertical-align: top; }
.differ { color: #b3263a; font-weight: 600; }
figure { margin: 1.2rem 0; } img { width: 100%; height: auto; } figcaption { font-size: .9rem; color: #444; }
"""


def as_dict(study: Study, seeds: list[int]) -> dict[str, Any]:
    """What goes into ``cross_validation.json``."""
    divergence = study.divergence
    report = {
        "name": study.name,
        "passed": study.passed,
        "seconds": study.seconds,
        "versions": versions(),
        "seeds": seeds,
        "jitter": JITTER,
        "confidence": CONFIDENCE,
        "family_error": FAMILY_ERROR,
        "time_step_fraction": study.scene.coefficients.time_step_fraction,
        "duration": study.scene.time(study.scene.steps),
        "lammps_kernel": study.engine.kernel,
        "notes": study.notes,
        "disc_by_disc": [
            {**asdict(check), "expected_difference": study.expected(check)} for check in study.checks
        ],
        "divergence": divergence and {
            "kernel": divergence.kernel,
            "time_step": study.scene.time_step,
            "steps": int(divergence.engines.steps[-1]) if len(divergence.engines.steps) else 0,
            "growth": asdict(divergence.growth),
            "twin_growth": asdict(divergence.twin_growth),
            "first_step_beyond": divergence.levels,
            "other_discs_from_step": divergence.engines.other_discs,
            "largest_separation": float(divergence.engines.largest.max(initial=0.0)),
        },
        "statistics": study.comparison and _comparison_dict(study.comparison),
        "criteria": study.criteria,
        "laws": {label: {"what": text, **_comparison_dict(found)} for label, (text, found) in study.laws.items()},
        "runs": {
            label: [{"seed": member.seed, **member.result} for member in members]
            for label, members in study.members.items()
        },
    }  # fmt: skip
    return plain(report)


def _comparison_dict(found: Comparison) -> dict[str, Any]:
    return {
        "ensembles": [found.name_1, found.name_2],
        "jump_verdicts": list(found.verdicts_of_jump),
        "agrees": found.agrees,
        "quantities": [
            {
                "name": v.name,
                "unit": v.unit,
                "kind": v.kind,
                "verdict": v.word,
                "text": v.text,
                "place": v.place or None,
                "points": v.points or None,
                "p_adjusted": v.p_adjusted,
                **asdict(v.difference),
            }
            for v in found.verdicts
        ],
    }


def write_report(study: Study, report: dict[str, Any], figures: dict[str, Path], path: Path) -> Path:
    """Write the report; figures are embedded."""
    statistics = report["statistics"]
    parts = [
        "<!doctype html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>Cross-validation of {escape(study.name)}</title>',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<style>{STYLE}</style></head><body>",
        f"<h1>Cross-validation: {escape(study.name)}</h1>",
        f"<p>{escape(study.scene.description)}. Simulated {report['duration']:g} s at f = "
        f"{report['time_step_fraction']:g}; {len(report['seeds'])} members in each ensemble.</p>",
        verdict(report),
        "<h2>Disc by disc</h2>",
        f"<p>Same scene, same law, same integrator: largest distance between the two places of any disc, over the "
        f"first {CONTACT_STEPS} steps from the first contact.</p>",
        _table(
            ["scene", "kernel", "discs", "first contact", "largest distance [d]", "verdict"],
            map(_check, report["disc_by_disc"]),
        ),
        _divergence(report),
        _figure(figures, "How the engines part, disc by disc"),
    ]
    if statistics:
        one, two = (SHOWN.get(name, name) for name in statistics["ensembles"])
        parts += [
            "<h2>Statistics</h2>",
            f"<p>Starts differ by up to {report['jitter']:g} d (row speeds by that share); both engines get the same "
            "ones. Difference: second minus first, with its 95 % interval (Welch); for a curve at its worst point. "
            f"“Differ” means: significant at {100 * report['family_error']:g} % for all quantities together (Holm; "
            "Bonferroni over the points of a curve).</p>",
            _verdicts(statistics, one, two),
            _criteria(report),
        ]
        parts += [
            _figure(figures, title)
            for title in figures
            if title not in ("How the engines part, disc by disc",) and "law" not in title
        ]
    if report["laws"]:
        parts.append(
            "<h2>What each choice changes</h2><p>Native engine, same starts, against hooke with velocity Verlet and "
            "corrected restitution. A difference here is a finding, not a failure.</p>"
        )
        for label, law in report["laws"].items():
            parts += [f"<h3>{escape(label)}: {escape(law['what'])}</h3>", _verdicts(law, "base", label)]
        parts += [_figure(figures, title) for title in figures if "law" in title]
    parts += [
        "<h2>How to repeat it</h2>",
        f"<p>Seeds {', '.join(map(str, report['seeds']))}; versions: "
        + escape(", ".join(f"{name} {value}" for name, value in report["versions"].items()))
        + f"; {report['seconds']:.0f} s of computing in this session.</p>",
        *(f"<p>Note: {escape(note)}</p>" for note in report["notes"]),
        "</body></html>",
    ]
    path.write_text("\n".join(parts), encoding="utf-8")
    return path


def verdict(report: dict[str, Any]) -> str:
    """The one thing to know."""
    return f'<div class="verdict{"" if report["passed"] else " bad"}">{escape(verdict_text(report))}</div>'


def verdict_text(report: dict[str, Any]) -> str:
    """The outcome in two sentences."""
    failed = [
        f"{c['name']} ({c['kernel']})"
        for c in report["disc_by_disc"]
        if not c["agrees"] and not c["expected_difference"]
    ]
    differ = [q["name"] for q in (report["statistics"] or {"quantities": []})["quantities"] if q["verdict"] == "differ"]
    missed = [c["name"] for c in report["criteria"] if c["met"] is False]
    if not failed and not differ and not missed:
        total = len((report["statistics"] or {"quantities": []})["quantities"])
        return f"The engines agree: disc by disc while they can, and in all {total} statistical quantities."
    words = [f"disc by disc: {', '.join(failed)}"] if failed else []
    words += [f"statistics: {', '.join(differ)}"] if differ else []
    words += [f"limits: {', '.join(missed)}"] if missed else []
    return "The engines differ. " + "; ".join(words) + "."


def _check(check: dict) -> list[str]:
    word = "agrees" if check["agrees"] else "DIFFERS"
    if check["expected_difference"]:
        word = f"differs as expected: {check['expected_difference']}"
    worst = "—" if check["worst"] is None else f"{check['worst']:.1e}"
    return [
        check["name"],
        check["kernel"],
        str(check["discs"]),
        f"step {check['first_contact']}",
        worst,
        f"{word} {check['note']}",
    ]


def _divergence(report: dict) -> str:
    part = report["divergence"]
    if not part:
        return ""
    rates = [part[name]["rate"] for name in ("growth", "twin_growth")]
    texts = [
        "no exponential stretch to fit" if not rate else f"{rate:.3g} /s (e-fold in {1 / rate:.3g} s)" for rate in rates
    ]
    levels = ", ".join(
        f"{level} d: " + ("never" if step is None else f"step {step} (t = {step * part['time_step']:.3g} s)")
        for level, step in part["first_step_beyond"].items()
    )
    return (
        f"<p>Afterwards they part: growth rate {texts[0]}; of the native engine against itself, started a few last "
        f"digits off: {texts[1]}. The same rate means that it is the flow's own chaos, not a difference of the "
        f"engines. First beyond: {levels}; followed over {part['steps']} steps.</p>"
    )


def _verdicts(part: dict, one: str, two: str) -> str:
    rows = []
    for q in part["quantities"]:
        place = f" at {q['place']}" if q["place"] else ""
        means = [f"{_number(q[f'mean_{k}'])} ± {_number(q[f'deviation_{k}'])}" for k in (1, 2)]
        word = f'<span class="{"differ" if q["verdict"] == "differ" else ""}">{escape(q["text"])}</span>'
        p = "—" if q["p_adjusted"] is None else f"{q['p_adjusted']:.2g}"
        rows.append([f"{q['name']}{place} [{q['unit']}]", *means, word, p])
    jump = part["jump_verdicts"]
    said = ""
    if any(jump):
        texts = [", ".join(f"{word} ({n})" for word, n in side.items()) for side in jump]
        said = f"<p>Jump: {escape(one)}: {escape(texts[0])}; {escape(two)}: {escape(texts[1])}.</p>"
    return said + _table(
        ["quantity", f"{one}, mean ± s.d.", f"{two}, mean ± s.d.", "verdict", "p (Holm)"], rows, raw=(3,)
    )


def _criteria(report: dict) -> str:
    rows = []
    for item in report["criteria"]:
        word = {True: "met", False: "NOT met", None: "for information"}[item["met"]]
        value = "—" if item["value"] is None else f"{100 * item['value']:.2g} %"
        rows.append([item["name"], value, f"{100 * item['limit']:g} %", word])
    return _table(["limit set beforehand", "found", "limit", ""], rows) if rows else ""


def _number(value: float | None) -> str:
    return "—" if value is None else f"{value:.4g}"


def _table(head: list[str], rows, raw: tuple[int, ...] = ()) -> str:
    body = "".join(
        "<tr>" + "".join(f"<td>{cell if k in raw else escape(str(cell))}</td>" for k, cell in enumerate(row)) + "</tr>"
        for row in rows
    )
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _figure(figures: dict[str, Path], title: str) -> str:
    if title not in figures:
        return ""
    source = f"data:image/png;base64,{base64.b64encode(figures[title].read_bytes()).decode()}"
    name = escape(title)
    return f'<figure><figcaption>{name}</figcaption><img alt="{name}" src="{source}"></figure>'
