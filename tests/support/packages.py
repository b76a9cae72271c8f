"""Packages of the repository and of its pages, installed as a user would, into a folder of their own."""

import subprocess
import sys


def pip_install(package, site):
    """Install a package into a folder for the module path, without the network: its build needs hatchling here."""
    options = ["--quiet", "--disable-pip-version-check", "--no-index", "--no-deps", "--no-build-isolation"]
    words = [sys.executable, "-m", "pip", "install", *options, "--target", str(site), str(package)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
