"""Fixtures of all tests; functions that several share are in `made_up`."""

import pytest
from made_up import plugin_or_skip


@pytest.fixture(scope="session")
def plugin():
    """Path of the compiled plugin; skips where there is none."""
    return plugin_or_skip()
