# SPDX-License-Identifier: GPL-2.0-or-later
from .command import run_bench as run_bench
from .command import stored_table as stored_table
from .study import read_axes as read_axes
