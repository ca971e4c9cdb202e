# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a case: what all its models share, and the inflow."""
