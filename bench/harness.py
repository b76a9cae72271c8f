"""What the scripts share: timing in turns from the package's own benchmark, and commands in processes of their own."""

from __future__ import annotations

import os
import subprocess

from aomc_sky.benchmark.timing import in_turns as in_turns
from aomc_sky.benchmark.timing import machine as machine
from aomc_sky.benchmark.timing import ratio as ratio
from aomc_sky.benchmark.timing import seconds as seconds
from aomc_sky.benchmark.timing import verdict as verdict


def run(command: list[str], **environment: str) -> None:
    """A command in a process of its own; its output is dropped, a failure is not."""
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
