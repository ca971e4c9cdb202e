# SPDX-License-Identifier: GPL-2.0-or-later
from .film import animate as animate
from .film import still as still
from .maps import bed_pressure_figure as bed_pressure_figure
from .maps import field_map as field_map
from .style import depth_profile as depth_profile
from .style import save as save
from .style import xt_map as xt_map
