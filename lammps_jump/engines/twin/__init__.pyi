# SPDX-License-Identifier: GPL-2.0-or-later
from .loops import SECONDS_PER_DISC_STEP as SECONDS_PER_DISC_STEP
from .loops import Twin as Twin
