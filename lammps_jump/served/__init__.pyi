# SPDX-License-Identifier: GPL-2.0-or-later
from .pages import pages_of as pages_of
from .server import Server as Server
