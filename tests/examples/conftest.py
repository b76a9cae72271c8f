"""The examples are scripts in folders of their own; tests import them as they import each other."""

import sys

from tests.support.shared import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "examples" / "slab"))
