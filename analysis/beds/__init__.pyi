# SPDX-License-Identifier: GPL-2.0-or-later
"""Flows seen along and across a sloping bed."""

from .slope import sloping_stretch as sloping_stretch
from .slope import turned_flow as turned_flow
