# SPDX-License-Identifier: GPL-2.0-or-later
from .page import live_page as live_page
from .page import live_part as live_part
from .page import recorded_run as recorded_run
from .page import require_place as require_place
from .page import run_again as run_again
from .page import write_page as write_page
from .prepare import LiveFlow as LiveFlow
from .prepare import LiveStart as LiveStart
from .prepare import from_times as from_times
from .prepare import prepare as prepare
from .prepare import with_fewer as with_fewer
