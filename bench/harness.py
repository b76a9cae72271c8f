"""What the scripts share: contenders take turns, medians and ratios, the machine, and errors as one message."""

from __future__ import annotations

import functools
import importlib.metadata
import math
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from aomc_sky.errors import AomcSkyError

PACKAGES = ("aomc-sky", "numpy", "numba", "scipy", "mitsuba", "drjit")


def machine() -> str:
    """Processor, cores, versions and the load at this moment, one line."""
    processor = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        processor = names[0].split(":", 1)[1].strip() if names else processor
    found = [f"python {platform.python_version()}"]
    for name in PACKAGES:
        try:
            found.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return f"{processor}, {os.cpu_count()} cores, {platform.system()}, {' '.join(found)}, load {load} before the run"


def in_turns(contenders: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, list[float]]:
    """Wall-clock times of each contender, taken turn and turn about so that all see the same machine. [s]

    One turn more comes first and does not count: it compiles and touches memory.
    """
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(-1, repeats):
        for name, work in contenders.items():
            start = time.perf_counter()
            work()
            if turn >= 0:
                times[name].append(time.perf_counter() - start)
    return times


def ratio(slow: list[float], fast: list[float]) -> float:
    """Median over the turns of how many times longer the slow one took."""
    return statistics.median(a / b for a, b in zip(slow, fast, strict=True))


def best_cpu_time(contenders: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Least CPU time of the calling thread, turn about, for work of one thread on a machine that others use. [s]"""
    best = dict.fromkeys(contenders, math.inf)
    for turn in range(-1, repeats):
        for name, work in contenders.items():
            start = time.thread_time()
            work()
            if turn >= 0:
                best[name] = min(best[name], time.thread_time() - start)
    return best


def guarded(main: Callable[..., int]) -> Callable[..., int]:
    """The main function of a script, with an error of the package as one message and its exit code."""

    @functools.wraps(main)
    def run_main(argv: list[str] | None = None) -> int:
        try:
            return main(argv)
        except AomcSkyError as error:
            print(f"error: {error}", file=sys.stderr)
            return error.exit_code

    return run_main


def count(text: str) -> int:
    """A whole number of at least 1, also as 1e6: the type of an option."""
    value = float(text)
    if value < 1 or value != int(value):
        raise ValueError(text)
    return int(value)


def markdown_table(rows: list[tuple[str, ...]], head: tuple[str, ...]) -> str:
    """A table in Markdown: the first column to the left, the others to the right."""
    ruler = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in (head, ruler, *rows))
