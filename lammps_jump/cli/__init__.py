# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line."""

import os

import lazy_loader

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads would spin for 0.1 s when numpy is loaded
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
