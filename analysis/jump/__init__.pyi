# SPDX-License-Identifier: GPL-2.0-or-later
from .found import Jump as Jump
from .result import analyse_jump as analyse_jump
from .summary import inflow_theory as inflow_theory
from .summary import summarise_jump as summarise_jump
from .track import straight_motion as straight_motion
from .track import track_jump as track_jump
