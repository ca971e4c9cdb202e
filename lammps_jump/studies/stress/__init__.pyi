# SPDX-License-Identifier: GPL-2.0-or-later
from .study import Stress as Stress
from .study import stress as stress
