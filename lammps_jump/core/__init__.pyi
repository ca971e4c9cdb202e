# SPDX-License-Identifier: GPL-2.0-or-later
from .browser import browser_core as browser_core
from .library import CORE as CORE
from .library import core as core
from .library import require_core as require_core
from .library import why_absent as why_absent
