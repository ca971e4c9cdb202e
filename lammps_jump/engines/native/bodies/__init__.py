# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies on the native engine: their corners, the faces near these, their contacts, and what is wrong with them."""
