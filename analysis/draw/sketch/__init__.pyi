# SPDX-License-Identifier: GPL-2.0-or-later
from .drawing import WIDEST as WIDEST
from .drawing import Drawing as Drawing
from .picture import figure as figure
from .preview import Region as Region
from .preview import preview as preview
from .svg import svg as svg
