"""The command in a process of its own: with limits on time and memory that the system keeps, or to be killed."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from tests.support.forked_commands import ForkedCommand
from tests.support.forked_programs import ForkServer
from tests.support.limits import MOST_CPU_S

# the limit on processor time is the kernel's, which kills the process; the peak is VmHWM and not ru_maxrss, which
# begins with the peak of the process that started this one
_LIMITED = """
import resource, sys
seconds = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
peak_file = sys.argv.pop(1)
from aomc_sky.cli.main import main
code = main(sys.argv[1:])
sys.stdout.flush()
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
with open(peak_file, "w") as file:
    print(int(status["VmHWM"].split()[0]) / 1024, file=file)
    print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024, file=file)
sys.exit(code)
"""
_COMMANDS = ForkServer("aomc_sky.cli.main", "numpy")
_NUMBA = ForkServer("numba", "numba.core.caching", "numba.core.ccallback")


@dataclass(frozen=True, kw_only=True, slots=True)
class Ended:
    """How a process ended: exit code (negative for a signal), both streams, peaks of its memory. [MB]"""

    code: int
    out: str
    err: str
    peak_mb: float
    children_mb: float


def limited(folder: Path, *words: object, cpu_s: float = MOST_CPU_S) -> Ended:
    """Run the command inside a folder under a limit on its processor time; a process that waits is killed, too."""
    peak = folder / ".peak"
    done = _COMMANDS.run(_LIMITED, int(cpu_s), peak, *words, folder=folder)
    own, children = map(float, peak.read_text().split()) if peak.exists() else (math.nan, math.nan)
    return Ended(code=done.code, out=done.out, err=done.err, peak_mb=own, children_mb=children)


def start(*words: object, **how: object) -> subprocess.Popen:
    """A process that hears SIGINT, which a shell lets its background jobs ignore and they their children."""
    command = [sys.executable, "-m", "aomc_sky", *map(str, words)]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how)
    finally:
        signal.signal(signal.SIGINT, before)


def wait_for(folder: Path, pattern: str, process: subprocess.Popen | ForkedCommand) -> None:
    """Return when a file of such a name is there."""
    limit = time.monotonic() + 60
    while not list(folder.glob(pattern)):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < limit
        time.sleep(0.002)


def in_environment(program: str, *arguments: object, **variables: str) -> str:
    """Standard output of a Python program under changed environment variables."""
    done = subprocess.run(
        [sys.executable, "-c", program, *map(str, arguments)],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def with_numba(program: str, *arguments: object, **variables: str) -> str:
    """`in_environment` for programs whose start is not the subject: numba is there, the package is not."""
    done = _NUMBA.run(program, *arguments, **variables)
    assert done.code == 0, done.err
    return done.out


def whole_files_only(folder: Path, whole: dict[str, bytes]) -> bool:
    """Whether every file under a final name is the finished one."""
    names = [path.name for path in folder.iterdir() if not path.name.startswith(".")]
    return all((folder / name).read_bytes() == whole[name] for name in names)
