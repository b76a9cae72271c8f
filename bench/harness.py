"""What the benchmarks share: contenders take turns, and medians and ratios are printed with the machine."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import statistics
import subprocess
import time
from collections.abc import Callable
from pathlib import Path


def machine() -> str:
    """Processor, cores and versions, one line."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [
            line.split(":", 1)[1].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")
        ]
        model = names[0] if names else model
    versions = " ".join(f"{name} {importlib.metadata.version(name)}" for name in ("numpy", "numba"))
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}"


def seconds(work: Callable[[], object]) -> float:
    """Wall-clock time of one call. [s]"""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def in_turns(contenders: dict[str, Callable[[], object]], repeats: int, warm_up: bool = True) -> dict[str, list[float]]:
    """Times of each contender, taken turn and turn about so that all see the same machine."""
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(-1 if warm_up else 0, repeats):
        for name, work in contenders.items():
            taken = seconds(work)
            if turn >= 0:
                times[name].append(taken)
    return times


def ratio(slow: list[float], fast: list[float]) -> float:
    """Median over the turns of how many times longer the slow one took."""
    return statistics.median(a / b for a, b in zip(slow, fast, strict=True))


def verdict(value: float, bar: float, *, at_least: bool) -> str:
    """A ratio beside its bar."""
    kept = value >= bar if at_least else value <= bar
    return f"{value:8.2f}   bar {'>=' if at_least else '<='} {bar:g}   {'kept' if kept else 'MISSED'}"


def run(command: list[str], **environment: str) -> None:
    """A command in a process of its own; its output is dropped, a failure is not."""
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
