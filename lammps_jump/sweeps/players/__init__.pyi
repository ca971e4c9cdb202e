# SPDX-License-Identifier: GPL-2.0-or-later
from .members import LARGEST as LARGEST
from .members import by_member as by_member
from .points import by_point as by_point
