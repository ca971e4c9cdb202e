# SPDX-License-Identifier: GPL-2.0-or-later
"""Markdown tables of records."""

from lammps_jump.analysis.tables import markdown, percent, with_error


def test_cells_come_from_templates_functions_and_the_title():
    rows = [{"engine": "stock", "share": -0.0312, "n": None}, {"engine": "native", "share": 0.5, "n": 3.0}]
    columns = {"engine": "", "change:": "{share:+.1%}", "n:": "{n:.2f}", "": lambda row: "", "other": ""}
    assert markdown(columns, rows) == (
        "| engine | change | n | | other |\n|---|---:|---:|---|---|\n"
        "| stock | -3.1 % | - | | - |\n| native | +50.0 % | 3.00 | | - |"
    )


def test_numbers_are_shown_with_their_error_where_there_is_one():
    cell = with_error("y2")
    found = [cell({"y2": value, "y2_error": error}) for value, error in ((1.0, 0.25), (1.0, None), (None, None))]
    assert found == ["1.00 ± 0.25", "1.00", "-"]
    assert [percent(share) for share in (0.0123, 0.123, None)] == ["1.23 %", "12 %", "-"]
