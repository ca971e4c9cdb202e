# SPDX-License-Identifier: GPL-2.0-or-later
"""GrainLearning's Bayesian filter on the runs of `calibration_twins.py`, offline, by a Python that has grainlearning.

Run as ``python benchmarks/calibration_peer.py FOLDER``, with the folder of the twins. Each twin gets the same points
and the means of their starts. One pass of the filter, as it comes: effective sample size 0.3, covariance from the
measured values. The range of a number is its weighted mean ± 1.96 weighted standard deviations. ``peer.json`` holds for
each kind how many truths lie in their ranges, and the mean width over the prior.
"""

from __future__ import annotations

import argparse
import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
from grainlearning.dynamic_systems import DynamicSystem
from grainlearning.iterative_bayesian_filter import IterativeBayesianFilter


def ranges_of(kind: dict, twin: dict) -> np.ndarray:
    """Low and high of each number, shape (varied, 2), in the unit of the number."""
    points = np.array(kind["points"])
    names = list(kind["values"])
    simulated = np.concatenate([np.array(kind["values"][name]) for name in names], axis=1)
    measured = np.concatenate([twin["measured"][name] for name in names])
    known = np.isfinite(simulated).all(axis=0) & (np.abs(measured) > 1e-3)  # it divides by what was measured
    system = DynamicSystem(
        obs_data=measured[known][:, None], num_samples=len(points), param_min=kind["low"], param_max=kind["high"],
        param_names=kind["paths"], param_data=points, sim_data=simulated[:, known][:, :, None],
        sigma_max=10.0,  # its 1e6 leaves the search for the size of the sample without a start
    )  # fmt: skip
    options = {"Bayes_filter": {"ess_target": 0.3}, "sampling": {"max_num_components": 1}}
    found = IterativeBayesianFilter.from_dict(options)
    found.run_inference(system)
    weights = found.posterior
    mean = weights @ points
    half = 1.96 * np.sqrt(weights @ (points - mean) ** 2)
    return np.array([mean - half, mean + half]).T


def main() -> None:
    """Write ``peer.json``."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    rows = {}
    for name, kind in json.loads((folder / "ensembles.json").read_text()).items():
        wide = np.subtract(kind["high"], kind["low"])
        found = [ranges_of(kind, twin) for twin in kind["twins"]]
        truths = np.array([twin["truth"] for twin in kind["twins"]])
        inside = [(r[:, 0] <= t) & (t <= r[:, 1]) for r, t in zip(found, truths, strict=True)]
        widths = np.mean([np.ptp(r, axis=1) / wide for r in found], axis=0)
        rows[name] = {"inside": np.sum(inside, axis=0).tolist(), "width": widths.tolist()}
        print(name, rows[name])
    (folder / "peer.json").write_text(json.dumps({"version": version("grainlearning"), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
