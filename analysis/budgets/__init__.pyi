# SPDX-License-Identifier: GPL-2.0-or-later
from . import depths as depths
from . import energy as energy
from . import grade as grade
from . import head as head
from . import inflow as inflow
