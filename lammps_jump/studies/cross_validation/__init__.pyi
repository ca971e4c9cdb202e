# SPDX-License-Identifier: GPL-2.0-or-later
from .study import cross_validate as cross_validate
from .study import run_command as run_command
