# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts: for each question the sentence that answers it, its numbers, and what makes it doubtful."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
