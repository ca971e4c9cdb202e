# SPDX-License-Identifier: GPL-2.0-or-later
from . import inflow as inflow
from . import stations as stations
