"""What the scripts share: timing in turns from the package's own benchmark, and commands in processes of their own."""

from __future__ import annotations

import functools
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping

from aomc_sky.benchmark.timing import in_turns as in_turns
from aomc_sky.benchmark.timing import machine as machine
from aomc_sky.benchmark.timing import ratio as ratio
from aomc_sky.benchmark.timing import seconds as seconds
from aomc_sky.cli.terminal import error_text
from aomc_sky.errors import AomcSkyError


def verdict(value: float, bar: float, *, at_least: bool) -> str:
    """A value beside its bar."""
    kept = value >= bar if at_least else value <= bar
    return f"{value:8.2f}   bar {'>=' if at_least else '<='} {bar:g}   {'kept' if kept else 'MISSED'}"


def run(command: list[str], **environment: str) -> None:
    """A command in a process of its own; its output is dropped, a failure is not."""
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")


def best_cpu_time(
    contenders: Mapping[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = time.thread_time
) -> dict[str, float]:
    """Least CPU time, turn about, for work of one thread on a machine that others use. [s]

    By default that of the calling thread; `time.process_time` also counts work handed to another one.
    """
    best = dict.fromkeys(contenders, math.inf)
    for turn in range(-1, repeats):
        for name, work in contenders.items():
            start = clock()
            work()
            if turn >= 0:
                best[name] = min(best[name], clock() - start)
    return best


def guarded(main: Callable[..., int]) -> Callable[..., int]:
    """The main function of a script, with an error of the package as one message and its exit code."""

    @functools.wraps(main)
    def run_main(argv: list[str] | None = None) -> int:
        try:
            return main(argv)
        except AomcSkyError as error:
            print(error_text(error), file=sys.stderr)
            return error.exit_code

    return run_main
