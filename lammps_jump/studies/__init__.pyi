# SPDX-License-Identifier: GPL-2.0-or-later
from . import bench as bench
from . import budget as budget
from . import cross_validation as cross_validation
from . import fluid as fluid
from . import own_data as own_data
from . import points as points
from . import sensitivity as sensitivity
from . import validation as validation
from .own_data import compare_with_data as compare_with_data
