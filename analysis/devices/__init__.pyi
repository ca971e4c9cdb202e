# SPDX-License-Identifier: GPL-2.0-or-later
from . import drum as drum
from . import hopper as hopper
from . import waves as waves
