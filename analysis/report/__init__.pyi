# SPDX-License-Identifier: GPL-2.0-or-later
from . import page as page
from .page import Block as Block
from .page import Section as Section
from .page import Table as Table
from .page import render as render
