"""The documented command for a plain processor does what it says, in numpy and in numba."""

import os
import subprocess
import sys

from tests.support.generic_processor import dispatch_targets, settings

SEEN = """
import numpy, sys
core = numpy._core if hasattr(numpy, "_core") else numpy.core
features = core._multiarray_umath.__cpu_features__
print(sum(features[name] for name in sys.argv[1:]))
from numba.core import config
print(config.CPU_NAME)
"""


def seen(words):
    environment = {k: v for k, v in os.environ.items() if k not in settings([])} | (settings(words) if words else {})
    command = [sys.executable, "-c", SEEN, *dispatch_targets()]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()


def test_each_word_does_its_part():
    wide = seen([])[0]
    assert seen(["numpy"])[0] == "0"
    assert seen(["numpy"])[1:] == ["None"]
    assert seen(["numba"]) == [wide, "generic"]
    assert seen(["numba", "numpy"]) == ["0", "generic"]
