# SPDX-License-Identifier: GPL-2.0-or-later
from . import live as live
from . import progress as progress
