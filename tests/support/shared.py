"""The reference data beside the repository, where they are; tests that want them skip without."""

from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SHARED = REPOSITORY.parent / "shared" / "reference"
AOMC = SHARED / "aomc"
INPUTS = REPOSITORY / "inputs"
DATA = REPOSITORY / "tests" / "data"

needs_shared = pytest.mark.skipif(not AOMC.is_dir(), reason="the reference data are not beside the repository")
