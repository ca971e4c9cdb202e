# SPDX-License-Identifier: GPL-2.0-or-later
from . import drum as drum
from . import front as front
from . import hopper as hopper
from . import runup as runup
from . import waves as waves
