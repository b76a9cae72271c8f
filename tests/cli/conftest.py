"""The scene that most commands are tested on."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.scenes import copy_scene


@pytest.fixture
def amc(tmp_path: Path) -> Path:
    return copy_scene("document_example", tmp_path)
