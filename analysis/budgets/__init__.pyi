# SPDX-License-Identifier: GPL-2.0-or-later
from . import head as head
from . import inflow as inflow
