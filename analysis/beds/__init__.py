# SPDX-License-Identifier: GPL-2.0-or-later
"""Beds that slope, and images of discs in periodic channels.

Its modules are imported by their own names: `contacts` needs images, and slopes need `contacts`.
"""
