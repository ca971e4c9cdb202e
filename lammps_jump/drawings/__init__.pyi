# SPDX-License-Identifier: GPL-2.0-or-later
from .entries import Entry as Entry
from .entries import LayerChoice as LayerChoice
from .entries import doubts as doubts
from .entries import entries as entries
from .entries import wall_name as wall_name
from .entries import yaml_text as yaml_text
from .into import DRAWN as DRAWN
from .into import with_drawn as with_drawn
from .into import with_walls as with_walls
from .into import write_into as write_into
from .read import read_drawing as read_drawing
from .strokes import LayeredDrawing as LayeredDrawing
