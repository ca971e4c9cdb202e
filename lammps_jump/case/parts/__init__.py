# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a case: what all its models share, the inflow, and the places of discs, inlets and gauges."""
