# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies of many runs: benchmarks, cross-validation, stability, budgets of error, calibration."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
