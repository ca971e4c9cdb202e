# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of a case: their fields, what is made of them, and what is checked before a run."""
