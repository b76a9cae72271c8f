"""What every benchmark shares: contenders take turns, and medians and ratios are given with the machine."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from aomc_sky.system import load

PACKAGES = ("numpy", "numba", "scipy", "mitsuba", "drjit")


def versions() -> dict[str, str]:
    """Versions of Python, of this package and of those that take part, where they are installed."""
    found = {"python": platform.python_version()}
    for name in ("aomc-sky", *PACKAGES):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def processor() -> str:
    """Name of the processor, as well as the system knows it."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def machine() -> str:
    """Processor, cores and versions, one line."""
    listed = " ".join(f"{name} {version}" for name, version in versions().items())
    return f"{processor()}, {os.cpu_count()} cores, {platform.system()}, {listed}"


def machine_now() -> str:
    """The same with the load at this moment: how many processes want a processor, 0 on an idle machine."""
    return f"{machine()}, load {load()} before the run"


def seconds(work: Callable[[], object]) -> float:
    """Wall-clock time of one call. [s]"""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def in_turns(
    contenders: Mapping[str, Callable[[], object]], repeats: int, warm_up: bool = True
) -> dict[str, list[float]]:
    """Wall-clock times of each contender, taken turn and turn about so that all see the same machine. [s]

    With `warm_up` one turn more comes first and does not count: it compiles and touches memory.
    """
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
