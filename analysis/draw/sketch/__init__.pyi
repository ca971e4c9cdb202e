# SPDX-License-Identifier: GPL-2.0-or-later
from .drawing import WIDEST as WIDEST
from .drawing import Drawing as Drawing
from .picture import figure as figure
from .preview import NamedRegion as NamedRegion
from .preview import scene_drawing as scene_drawing
from .svg import svg_text as svg_text
