# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies: walls that move as their mass, their weight and what touches them let them."""
