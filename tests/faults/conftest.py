"""The small run of the rows on shards: its three shards, and the whole of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.shards import make_shards, whole_run


@pytest.fixture(scope="module")
def shards(tmp_path_factory) -> Path:
    """Three good shards."""
    return make_shards(tmp_path_factory.mktemp("shards"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """The run in one go."""
    return whole_run(tmp_path_factory.mktemp("whole"))
