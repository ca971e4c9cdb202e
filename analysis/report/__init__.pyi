# SPDX-License-Identifier: GPL-2.0-or-later
from . import page as page
from .page import Block as Block
from .page import Section as Section
from .page import Table as Table
from .page import render as render
from .player import is_running as is_running
from .player import player_widget as player_widget
from .player import widgets_are_there as widgets_are_there
