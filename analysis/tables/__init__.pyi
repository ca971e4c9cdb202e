# SPDX-License-Identifier: GPL-2.0-or-later
from . import rows as rows
