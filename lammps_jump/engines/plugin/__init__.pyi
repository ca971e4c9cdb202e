# SPDX-License-Identifier: GPL-2.0-or-later
from .build import KernelStatus as KernelStatus
from .build import availability as availability
from .build import plugin_path as plugin_path
