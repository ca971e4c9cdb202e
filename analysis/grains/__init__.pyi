# SPDX-License-Identifier: GPL-2.0-or-later
from . import heap as heap
from . import layers as layers
from . import rest as rest
from . import state as state
