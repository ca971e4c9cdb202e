# SPDX-License-Identifier: GPL-2.0-or-later
from .study import read_axes as read_axes
from .study import run_bench as run_bench
from .study import stored_table as stored_table
