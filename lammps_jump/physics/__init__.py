# SPDX-License-Identifier: GPL-2.0-or-later
"""Closed forms of contacts, jumps and waves."""
