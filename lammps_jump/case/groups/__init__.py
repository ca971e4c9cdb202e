# SPDX-License-Identifier: GPL-2.0-or-later
"""Groups of fields of a case: models that check them and tell what they are."""
