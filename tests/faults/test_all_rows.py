"""Every row of README.md has a test of its own in the default suite, and no test is of a row that is not there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.shared import REPOSITORY

N_ROWS = 55
IN_COMMANDS = ("tests/cli/test_cli_validate.py", "tests/cli/test_cli_verify.py")


def test_every_row_has_a_test():
    pytest.importorskip("h5py")  # without it row 40 is not collected
    page = Path(__file__).with_name("README.md").read_text()
    rows = [int(number) for number in re.findall(r"^\| (\d+) \|", page, re.MULTILINE)]
    assert rows == list(range(1, N_ROWS + 1))
    options = ["--collect-only", "-q", "--assert=plain", "-p", "no:cacheprovider"]
    words = [sys.executable, "-m", "pytest", *options, "tests/faults", "tests/skies", *IN_COMMANDS]
    done = subprocess.run(words, cwd=REPOSITORY, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert {int(number) for number in re.findall(r"\[row-(\d\d)-", done.stdout)} == set(rows)
