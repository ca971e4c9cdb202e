# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages of the documentation site that are made from the program; ``docs/conf.py`` calls them."""

NONE = "\N{EN DASH}"
"""What stands in a table where there is nothing to say."""
