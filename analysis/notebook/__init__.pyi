# SPDX-License-Identifier: GPL-2.0-or-later
from .widget import is_running as is_running
from .widget import player_widget as player_widget
from .widget import widgets_are_there as widgets_are_there
