"""A run that tests of faults damage copies of."""

import pytest

from tests.support.fault_rows import command
from tests.support.scenes import copy_scene


@pytest.fixture(scope="session")
def small_run(tmp_path_factory):
    """A finished run, `out` in the folder of its scene."""
    scene = copy_scene("document_example", tmp_path_factory.mktemp("run")).parent
    assert command("run", scene, "--iterations", 1000, "--out", scene / "out", "-q") == 0
    return scene / "out"
