# SPDX-License-Identifier: GPL-2.0-or-later
"""The result of a cross-validation: what ``cross_validation.json`` holds, and one HTML page made from it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from lammps_jump.analysis.report.page import Mark, Picture, Section, Table, Text, picture, render
from lammps_jump.files import plain
from lammps_jump.studies.table import Column, cells
from lammps_jump.sweeps.members import JITTER
from lammps_jump.sweeps.store import Results, all_versions

from .ensembles import Study
from .figures import DIVERGENCE, LAW_FIGURES, SHOWN
from .quantities import Comparison
from .statistics import CONFIDENCE, DECIDES, FAMILY_ERROR
from .trajectories import CONTACT_STEPS, Divergence


def as_dict(study: Study, divergence: Divergence, found: Comparison, criteria: list[Results], seconds: float) -> dict:
    """Return what goes into ``cross_validation.json``.

    Parameters
    ----------
    study : Study
    divergence : Divergence
    found : Comparison
        Of the engines.
    criteria : list of dict
    seconds : float
        Wall time of the study, s.
    """
    passed = found.agrees and all(check.passed for check in study.checks)
    laws = {label: {"what": text, **law.stored()} for label, (text, law) in study.laws.items()}
    runs = {
        label: [{"seed": seed, **member.run} for seed, member in zip(study.seeds, group, strict=True)]
        for label, group in study.members.items()
    }
    return plain({
        "name": study.name,
        "passed": passed and all(item["met"] is not False for item in criteria),
        "seconds": seconds,
        "versions": all_versions(),
        "seeds": study.seeds,
        "jitter": JITTER,
        "confidence": CONFIDENCE,
        "family_error": FAMILY_ERROR,
        "time_step_fraction": study.scene.coefficients.time_step_fraction,
        "duration": study.scene.time(study.scene.steps),
        "lammps_kernel": study.kernel,
        "notes": study.notes,
        "disc_by_disc": study.checks,
        "divergence": divergence.found,
        "statistics": found.stored(),
        "criteria": criteria,
        "laws": laws,
        "runs": runs,
    })  # fmt: skip


def write_report(report: dict, description: str, figures: dict[str, Path], path: Path) -> Path:
    """Write the page with the figures in it.

    Parameters
    ----------
    report : dict
        Of `as_dict`.
    description : str
        Of the scene.
    figures : dict of str to Path
        By title.
    path : Path
    """
    about = (
        f"{description}. Simulated {report['duration']:g} s at f = {report['time_step_fraction']:g}; "
        f"{len(report['seeds'])} members in each ensemble."
    )
    verdict = Text(verdict_text(report), "verdict" if report["passed"] else "bad")
    shown = {title: picture(file, title) for title, file in figures.items()}
    first, laws = ([shown.pop(title) for title in some if title in shown] for some in ((DIVERGENCE,), LAW_FIGURES))
    sections = [Section("", [Text(about), verdict]), _checks(report, first), _statistics(report, [*shown.values()])]
    sections += [*_laws(report["laws"], laws), _how(report)]
    path.write_text(render(f"Cross-validation: {report['name']}", sections), encoding="utf-8")
    return path


def verdict_text(report: dict) -> str:
    """Return the outcome in two sentences."""
    checks, quantities = report["disc_by_disc"], report["statistics"]["quantities"]
    failed = [check for check in checks if not check["agrees"] and not check["expected_difference"]]
    found = {
        "disc by disc": ["{name} ({kernel})".format_map(check) for check in failed],
        "statistics": [q["name"] for q in quantities if q["verdict"] == "differ"],
        "limits": [c["name"] for c in report["criteria"] if c["met"] is False],
    }
    if not any(found.values()):
        words = Counter(q["verdict"] for q in quantities)
        open_ = words["not decided"] + words["not comparable"]
        agreed = f"{len(quantities) - open_} of" if open_ else "all"
        said = (
            f"The engines agree: disc by disc while they can, and in {agreed} {len(quantities)} statistical quantities."
        )
        return f"{said} {open_} are not decided: these members cannot tell." if open_ else said
    return "The engines differ. " + "; ".join(f"{part}: {', '.join(of)}" for part, of in found.items() if of) + "."


def _checks(report: dict, pictures: list[Picture]) -> Section:
    def verdict(check: dict) -> str:
        reason = check["expected_difference"]
        word = f"differs as expected: {reason}" if reason else ("agrees" if check["agrees"] else "DIFFERS")
        return f"{word} {check['note']}"

    columns: dict[str, Column] = {
        "scene": "{name}",
        "kernel": "",
        "discs": "{discs}",
        "first contact": lambda check: f"step {check['first_contact']}",
        "largest distance [d]": "{worst:.1e}",
        "verdict": verdict,
    }
    intro = Text(
        "Same scene, same law, same integrator: largest distance between the two places of any disc, over the "
        f"first {CONTACT_STEPS} steps from the first contact."
    )
    table = Table(*cells(columns, report["disc_by_disc"], "—"))
    return Section("Disc by disc", [intro, table, _growth(report["divergence"]), *pictures])


def _growth(part: dict) -> Text:
    rates = [part[name]["rate"] for name in ("growth", "twin_growth")]
    texts = [f"{r:.3g} /s (e-fold in {1 / r:.3g} s)" if r else "no exponential stretch to fit" for r in rates]
    levels = ", ".join(
        f"{level} d: " + ("never" if step is None else f"step {step} (t = {step * part['time_step']:.3g} s)")
        for level, step in part["first_step_beyond"].items()
    )
    return Text(
        f"Afterwards they part: growth rate {texts[0]}; of the native engine against itself, started a few last "
        f"digits off: {texts[1]}. The same rate means that it is the flow's own chaos, not a difference of the "
        f"engines. First beyond: {levels}; followed over {part['steps']} steps."
    )


def _statistics(report: dict, pictures: list[Picture]) -> Section:
    intro = Text(
        f"Starts differ by up to {report['jitter']:g} d (row speeds by that share); both engines get the same "
        "ones. Difference: second minus first, with its 95 % interval (Welch); for a curve at its worst point. "
        f"“Differ” means: significant at {100 * report['family_error']:g} % for all quantities together (Holm; "
        "Bonferroni over the points of a curve). “Not decided” means: no difference was found, but the interval is "
        f"wider than ± {100 * DECIDES:g} %; the text says how many members of each ensemble would decide."
    )
    words = {True: "met", False: "NOT met", None: "for information"}
    columns: dict[str, Column] = {
        "limit set beforehand": "{name}",
        "found": lambda item: "—" if item["value"] is None else f"{100 * item['value']:.2g} %",
        "limit": lambda item: f"{100 * item['limit']:g} %",
        "": lambda item: words[item["met"]],
    }
    limits = [Table(*cells(columns, report["criteria"]))] if report["criteria"] else []
    names = (SHOWN.get(name, name) for name in report["statistics"]["ensembles"])
    return Section("Statistics", [intro, *_verdicts(report["statistics"], *names), *limits, *pictures])


def _verdicts(part: dict, one: str, two: str) -> list[Text | Table]:
    """Return the verdicts on the jump, and the table of all quantities, of one comparison."""
    columns: dict[str, Column] = {
        "quantity": lambda row: f"{row['name']}{' at ' + row['place'] if row['place'] else ''} [{row['unit']}]",
        f"{one}, mean ± s.d.": "{mean_1:.4g} ± {deviation_1:.4g}",
        f"{two}, mean ± s.d.": "{mean_2:.4g} ± {deviation_2:.4g}",
        "verdict": lambda row: Mark(row["text"], "differ") if row["verdict"] == "differ" else row["text"],
        "p (Holm)": "{p_adjusted:.2g}",
    }
    table = Table(*cells(columns, part["quantities"], "—"))
    if not any(part["jump_verdicts"]):
        return [table]
    texts = [", ".join(f"{word} ({n})" for word, n in side.items()) for side in part["jump_verdicts"]]
    return [Text(f"Jump: {one}: {texts[0]}; {two}: {texts[1]}."), table]


def _laws(laws: dict, pictures: list[Picture]) -> list[Section]:
    intro = Text(
        "Native engine, same starts, against hooke with velocity Verlet and corrected restitution. "
        "A difference here is a finding, not a failure."
    )
    parts = [Section(f"{label}: {law['what']}", _verdicts(law, "base", label)) for label, law in laws.items()]
    return [Section("What each choice changes", [intro]), *parts, Section("", pictures)] if laws else []


def _how(report: dict) -> Section:
    found = ", ".join(f"{name} {value}" for name, value in report["versions"].items())
    text = f"Seeds {', '.join(map(str, report['seeds']))}; versions: {found}; {report['seconds']:.0f} s of computing."
    return Section("How to repeat it", [Text(text), *(Text(f"Note: {note}") for note in report["notes"])])
