# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that engines write beside the dump: contacts, and places of walls."""
