# SPDX-License-Identifier: GPL-2.0-or-later

from . import crate as crate
from . import folder as folder
from . import known as known
from . import results as results
from . import start as start
from . import steady as steady
from . import stepped as stepped
from . import summary as summary
from . import view as view
from .run import Run as Run
from .run import compare_folders as compare_folders
from .run import open_run as open_run
