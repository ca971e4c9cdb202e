# SPDX-License-Identifier: GPL-2.0-or-later
"""The bytes of dump files, as the readers of their formats take them."""
