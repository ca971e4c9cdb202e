# SPDX-License-Identifier: GPL-2.0-or-later
from .loops import Twin as Twin
