# SPDX-License-Identifier: GPL-2.0-or-later
"""The table of runs that went on is of today's features and engines; ``make faults`` writes it."""

import pytest
from fault_table import NONE, cells_of_page
from features import ENGINES, FEATURES
from made_up import scene_of_feature

pytestmark = pytest.mark.prose


def test_the_table_has_a_cell_for_each_feature_and_engine():
    cells = cells_of_page()
    assert list(cells) == [(feature, engine) for feature in FEATURES for engine in ENGINES]
    for (feature, engine), text in cells.items():
        if text == NONE:
            assert scene_of_feature(feature, engine) is None, (feature, engine)
        elif engine == "native":
            assert text == "0"
        else:
            assert float(text.partition(",")[0]) < 1e-9
