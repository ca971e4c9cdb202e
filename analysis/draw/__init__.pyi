# SPDX-License-Identifier: GPL-2.0-or-later
from . import arrows as arrows
from . import film as film
from . import maps as maps
from . import style as style
from .drawing import WIDEST as WIDEST
from .drawing import Drawing as Drawing
from .film import animate as animate
from .film import still as still
from .maps import depth_profile as depth_profile
from .maps import field_map as field_map
from .maps import xt_map as xt_map
from .preview import NamedRegion as NamedRegion
from .preview import scene_drawing as scene_drawing
from .style import drawn as drawn
from .style import figure as figure
from .style import save as save
from .svg import svg_text as svg_text
