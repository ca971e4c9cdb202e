# SPDX-License-Identifier: GPL-2.0-or-later
from .again import run_again as run_again
from .page import live_page as live_page
from .page import require_place as require_place
from .page import write_page as write_page
from .prepare import LiveFlow as LiveFlow
from .prepare import prepare as prepare
