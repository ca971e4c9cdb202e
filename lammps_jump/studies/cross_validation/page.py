# SPDX-License-Identifier: GPL-2.0-or-later
"""The result of a cross-validation: what ``cross_validation.json`` holds, figures, and one HTML page made from both."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.chart import PLACE, TIME, Chart, Panel, Trace
from lammps_jump.analysis.draw.style import BLUE, GOLD, GREY, RED, drawing, drawn, save
from lammps_jump.analysis.report.page import Mark, Picture, Section, Table, Text, picture, render
from lammps_jump.analysis.tables import Column, cells
from lammps_jump.files import write_text
from lammps_jump.scene import Scene

from .quantities import DECIDES, Comparison, Difference, MemberCurve, relative_size
from .trajectories import AGREEMENT, CONTACT_STEPS, DeterministicCheck, Divergence, Growth

SHOWN = {
    "lammps_stock": "LAMMPS (stock)",
    "lammps_compiled": "LAMMPS (compiled kernel)",
    "native": "native engine",
    "twin": "twin",
}
DIVERGENCE = "How the engines part, disc by disc"
LAW_FIGURES = ("What the choice of law, integrator and correction changes", "Depth profiles of the laws")
DEPTH = "mass_depth profile"


Laws = dict[str, tuple[str, Comparison]]
"""Changes by each choice of law, in words and in numbers, by its label."""


def draw_all(chart: Chart, compared: Comparison, choices: Laws, folder: Path) -> dict[str, Path]:
    """Draw the chart of the `divergence` and what was compared; returns file by title, in the order of the report."""
    folder.mkdir(parents=True, exist_ok=True)
    profiles = [name for name in compared.bands if name.endswith("profile")]
    times = [name for name in compared.bands if compared.bands[name][0].axis == "t"]
    leading = [name for name in times if "front" in name or "toe" in name]
    figures = {"divergence": chart}
    curves = {
        "profiles": ("Profiles along the channel, mean over the window", profiles),
        "front": ("Toe of the jump" if "jump toe history" in leading else "Front", leading),
        "histories": ("Histories", [name for name in times if name not in leading]),
    }
    for file, (title, names) in curves.items():
        figures |= (
            {file: means(title, compared, names), f"{file}_differences": gaps(title, compared, names)} if names else {}
        )
    laws = {label: comparison for label, (_, comparison) in choices.items()}
    if any(DEPTH in law.bands for law in laws.values()):
        figures["law_profiles"] = law_profiles(laws)
    files = {one.title: save(drawn(one), folder / f"{name}.png") for name, one in figures.items()}
    files["Differences of all numbers"] = save(forest({"": compared}), folder / "differences.png")
    return files | ({LAW_FIGURES[0]: save(forest(laws), folder / "laws.png")} if laws else {})


def divergence(scene: Scene, checks: Sequence[DeterministicCheck], part: Divergence) -> Chart:
    """Describe separation against time, with the perturbed run, and the stretch in which the engines must agree."""
    numbers = part.found
    rows = (
        (part.engines, numbers["growth"], "first", f"LAMMPS ({numbers['kernel']}) from native"),
        (part.perturbed, numbers["twin_growth"], "second", "native from native, start off by the last digits"),
    )
    lines = [
        Trace(f"{label}{_rate(growth)}", scene.time(0) + run.steps * scene.time_step,
             np.log10(np.where(run.largest > 0, run.largest, nan)), look)
        for run, growth, look, label in rows
    ]  # fmt: skip
    begin = next((check.first_contact for check in checks if check.name == scene.name), None)
    steps = {} if begin is None else {"first contact": begin, f"{CONTACT_STEPS} steps later": begin + CONTACT_STEPS}
    y, marks = "log10 of the largest distance\nof a disc's two places [d]", {t: scene.time(s) for t, s in steps.items()}
    limits = -17.0, 1.0 + max(0.0, *(np.nanmax(line.y, initial=0.0) for line in lines))
    agreed = {f"must agree to {AGREEMENT:zg} d": np.log10(AGREEMENT)}
    panel = Panel(y, lines, levels=agreed, marks=marks, ylim=limits)
    return Chart(DIVERGENCE, TIME, [panel])


def _rate(growth: Growth) -> str:
    return f" (e-fold in {1.0 / growth.rate:z.3g} s)" if growth.rate > 0 else ""


def _label(name: str, curve: MemberCurve) -> str:
    words = name.removesuffix(" profile").removesuffix(" history").replace("_", " ")
    return f"{words}{' energy' if curve.unit == 'J/m' else ''} [{curve.unit}]".replace(" [1]", "").replace("m2/", "m²/")


def band_chart(
    title: str,
    comparison: Comparison,
    names: list[str],
    lines: Callable[[MemberCurve, Difference[np.ndarray]], list[Trace]],
) -> Chart:
    """Describe curves with `lines` of each and its difference."""
    panels = [Panel(_label(name, comparison.bands[name][0]), lines(*comparison.bands[name])) for name in names]
    return Chart(title, TIME if comparison.bands[names[0]][0].axis == "t" else PLACE, panels)


def means(title: str, comparison: Comparison, names: list[str]) -> Chart:
    """Describe the mean of each ensemble with a band of one standard deviation: two of a half."""
    one, two = (SHOWN.get(label, label) for label in comparison.ensembles)

    def lines(curve: MemberCurve, band: Difference[np.ndarray]) -> list[Trace]:
        first = Trace(one, curve.at, band.mean_1, "first", 0.5 * band.deviation_1)
        return [first, Trace(two, curve.at, band.mean_2, "second", 0.5 * band.deviation_2)]

    return band_chart(f"{title}; band: ± 1 s.d. of the members", comparison, names, lines)


def gaps(title: str, comparison: Comparison, names: list[str]) -> Chart:
    """Describe the difference of each curve with its interval, 95 % for all points at once."""

    def lines(curve: MemberCurve, band: Difference[np.ndarray]) -> list[Trace]:
        return [Trace("", curve.at, band.difference, "sum", 0.5 * band.half_width)]

    return band_chart(f"{title}: native minus LAMMPS, 95 % for all at once", comparison, names, lines)


def forest(comparisons: dict[str, Comparison]) -> Figure:
    """Draw the relative difference of every number with its confidence interval."""
    rows = [
        (label, row["name"], row["difference"] / size, row["half_width"] / size, row["verdict"] == "differ")
        for label, comparison in comparisons.items()
        for row in comparison.quantities
        if row["kind"] == "scalar" and isfinite(row["half_width"]) and (size := 0.01 * (relative_size(row) or 0.0))
    ]
    table = pd.DataFrame(rows, columns=["label", "name", "share", "half", "differs"])
    names, shift = list(dict.fromkeys(table.name)), 0.8 / len(comparisons)
    looks = ((BLUE, "o"), (GOLD, "s"), (GREY, "^"), (RED, "D"))
    with drawing(7.6, 0.26 * len(names) * max(1, 0.6 * len(comparisons)) + 1.2) as (figure, axes):
        for index, (label, part) in enumerate(table.groupby("label", sort=False)):
            colour, mark = looks[index % len(looks)]
            y = -part.name.map(names.index) - index * shift
            bars = {"xerr": part.half, "fmt": mark, "color": colour, "ms": 4, "lw": 1.1, "capsize": 2}
            axes.errorbar(part.share, y, label=label or None, **bars)
            axes.plot(part.share[part.differs], y[part.differs], mark, ms=9, mfc="none", mec=RED)
        widest = max(1.0, (table.share.abs() + np.minimum(table.half, 3 * table.share.abs() + 5)).max())
        axes.axvline(0.0, color=GREY, lw=0.8)
        axes.set_yticks([-k - 0.4 + 0.5 * shift for k in range(len(names))], names)
        xlabel = "difference, % of the quantity, with its 95 % interval (red ring: differs)"
        axes.set(xlim=(-1.1 * widest, 1.1 * widest), xlabel=xlabel)
        if any(comparisons):
            axes.legend(loc="best")
    return figure


def law_profiles(laws: dict[str, Comparison]) -> Chart:
    """Describes depth profiles of the laws, with those of the law they are compared with."""
    bands = {label: law.bands[DEPTH] for label, law in laws.items() if DEPTH in law.bands}
    curve, base = next(iter(bands.values()))
    lines = [Trace("viscous, velocity Verlet, corrected", curve.at, base.mean_1, "first", 0.5 * base.deviation_1)]
    looks = ("second", "third", "sum", "theory")
    lines += [Trace(n, c.at, band.mean_2, look) for look, (n, (c, band)) in zip(looks, bands.items(), strict=False)]
    return Chart(LAW_FIGURES[1], PLACE, [Panel("depth by mass [m]", lines)])


def write_report(report: dict[str, Any], description: str, figures: dict[str, Path], path: Path) -> Path:
    """Write the page with the figures in it.

    Parameters
    ----------
    report : dict
        Content of ``cross_validation.json``.
    description : str
        Of the scene.
    figures : dict of str to Path
        By title.
    path : Path
    """
    about = (
        f"{description}. Simulated {report['duration']:zg} s at f = {report['time_step_fraction']:zg}; "
        f"{len(report['seeds'])} members in each ensemble."
    )
    verdict = Text(verdict_text(report), "verdict" if report["passed"] else "bad")
    shown = {title: picture(file, title) for title, file in figures.items()}
    first, laws = ([shown.pop(title) for title in some if title in shown] for some in ((DIVERGENCE,), LAW_FIGURES))
    sections = [Section("", [Text(about), verdict]), _checks(report, first), _statistics(report, [*shown.values()])]
    sections += [*_laws(report["laws"], laws), _how(report)]
    return write_text(path, render(f"Cross-validation: {report['name']}", sections))


def verdict_text(report: dict[str, Any]) -> str:
    """Return the outcome in two sentences."""
    checks, quantities = report["disc_by_disc"], report["statistics"]["quantities"]
    failed = [check for check in checks if not check["agrees"] and not check["expected_difference"]]
    by_engine = {
        "disc by disc": ["{name} ({kernel})".format_map(check) for check in failed],
        "statistics": [q["name"] for q in quantities if q["verdict"] == "differ"],
        "limits": [c["name"] for c in report["criteria"] if c["met"] is False],
    }
    if not any(by_engine.values()):
        words = Counter(q["verdict"] for q in quantities)
        open_ = words["not decided"] + words["not comparable"]
        agreed = f"{len(quantities) - open_} of" if open_ else "all"
        said = (
            f"The engines agree: disc by disc while they can, and in {agreed} {len(quantities)} statistical quantities."
        )
        return f"{said} {open_} are not decided: these members cannot tell." if open_ else said
    return "The engines differ. " + "; ".join(f"{part}: {', '.join(of)}" for part, of in by_engine.items() if of) + "."


def _checks(report: dict[str, Any], pictures: list[Picture]) -> Section:
    def verdict(check: dict[str, Any]) -> str:
        reason = check["expected_difference"]
        word = f"differs as expected: {reason}" if reason else ("agrees" if check["agrees"] else "DIFFERS")
        return f"{word} {check['note']}"

    columns: dict[str, Column] = {
        "scene": "{name}",
        "kernel": "",
        "discs": "{discs}",
        "first contact": lambda check: f"step {check['first_contact']}",
        "largest distance [d]": "{worst:z.1e}",
        "verdict": verdict,
    }
    intro = Text(
        "Same scene, same law, same integrator: largest distance between the two places of any disc, over the "
        f"first {CONTACT_STEPS} steps from the first contact."
    )
    table = Table(*cells(columns, report["disc_by_disc"], "—"))
    return Section("Disc by disc", [intro, table, _growth(report["divergence"]), *pictures])


def _growth(part: dict[str, Any]) -> Text:
    rates = [part[name]["rate"] for name in ("growth", "twin_growth")]
    texts = [f"{r:z.3g} /s (e-fold in {1 / r:z.3g} s)" if r else "no exponential stretch to fit" for r in rates]
    levels = ", ".join(
        f"{level} d: " + ("never" if step is None else f"step {step} (t = {step * part['time_step']:z.3g} s)")
        for level, step in part["first_step_beyond"].items()
    )
    return Text(
        f"Afterwards they part: growth rate {texts[0]}; of the native engine against itself, started a few last "
        f"digits off: {texts[1]}. The same rate means that it is the flow's own chaos, not a difference of the "
        f"engines. First beyond: {levels}; followed over {part['steps']} steps."
    )


def _statistics(report: dict[str, Any], pictures: list[Picture]) -> Section:
    intro = Text(
        f"Starts differ by up to {report['jitter']:zg} d (row speeds by that share); both engines get the same "
        "ones. Difference: second minus first, with its 95 % interval (Welch); for a curve at its worst point. "
        f"“Differ” means: significant at {100 * report['family_error']:zg} % for all quantities together (Holm; "
        "Bonferroni over the points of a curve). “Not decided” means: no difference was found, but the interval is "
        f"wider than ± {100 * DECIDES:zg} %; the text says how many members of each ensemble would decide."
    )
    words = {True: "met", False: "NOT met", None: "for information"}
    columns: dict[str, Column] = {
        "limit set beforehand": "{name}",
        "found": lambda item: "—" if item["value"] is None else f"{100 * item['value']:z.2g} %",
        "limit": lambda item: f"{100 * item['limit']:zg} %",
        "": lambda item: words[item["met"]],
    }
    limits = [Table(*cells(columns, report["criteria"]))] if report["criteria"] else []
    names = (SHOWN.get(name, name) for name in report["statistics"]["ensembles"])
    return Section("Statistics", [intro, *_verdicts(report["statistics"], *names), *limits, *pictures])


def _verdicts(part: dict[str, Any], one: str, two: str) -> list[Text | Table]:
    """Return the verdicts on the jump, and the table of all quantities, of one comparison."""
    columns: dict[str, Column] = {
        "quantity": lambda row: f"{row['name']}{' at ' + row['place'] if row['place'] else ''} [{row['unit']}]",
        f"{one}, mean ± s.d.": "{mean_1:z.4g} ± {deviation_1:z.4g}",
        f"{two}, mean ± s.d.": "{mean_2:z.4g} ± {deviation_2:z.4g}",
        "verdict": lambda row: Mark(row["text"], "differ") if row["verdict"] == "differ" else row["text"],
        "p (Holm)": "{p_adjusted:z.2g}",
    }
    table = Table(*cells(columns, part["quantities"], "—"))
    if not any(part["jump_verdicts"]):
        return [table]
    texts = [", ".join(f"{word} ({n})" for word, n in side.items()) for side in part["jump_verdicts"]]
    return [Text(f"Jump: {one}: {texts[0]}; {two}: {texts[1]}."), table]


def _laws(laws: dict[str, Any], pictures: list[Picture]) -> list[Section]:
    intro = Text(
        "Native engine, same starts, against viscous friction with velocity Verlet and corrected restitution. "
        "A difference here is a finding, not a failure."
    )
    parts = [Section(f"{label}: {law['what']}", _verdicts(law, "base", label)) for label, law in laws.items()]
    return [Section("What each choice changes", [intro]), *parts, Section("", pictures)] if laws else []


def _how(report: dict[str, Any]) -> Section:
    used = ", ".join(f"{name} {value}" for name, value in report["versions"].items())
    text = f"Seeds {', '.join(map(str, report['seeds']))}; versions: {used}; {report['seconds']:z.0f} s of computing."
    return Section("How to repeat it", [Text(text), *(Text(f"Note: {note}") for note in report["notes"])])
