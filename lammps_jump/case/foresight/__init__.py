# SPDX-License-Identifier: GPL-2.0-or-later
"""What a case will lead to, told before it runs: speeds, overlaps, jumps, heaps, and what would end the run."""
