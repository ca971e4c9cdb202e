# SPDX-License-Identifier: GPL-2.0-or-later
from .say import VERDICTS as VERDICTS
from .say import doubts as doubts
from .say import headline as headline
from .say import verdict as verdict
