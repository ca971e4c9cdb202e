# SPDX-License-Identifier: GPL-2.0-or-later
"""Foresight of a case before it runs: speeds, overlaps, jumps, heaps, and what would end the run."""
