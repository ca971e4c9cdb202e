# SPDX-License-Identifier: GPL-2.0-or-later
from . import markdown as markdown
from . import rows as rows
