# SPDX-License-Identifier: GPL-2.0-or-later
"""Hydraulics of a case before it is run, and where along the channel it holds."""
