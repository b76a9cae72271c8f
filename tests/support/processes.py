"""The command in a process of its own: with limits on time and memory that the system keeps, or to be killed."""

import math
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

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
sys.exit(code)
"""
_COMMANDS = ForkServer("aomc_sky.cli.main", "numpy")

_IN_ITS_MIDST = """
import os, signal, sys
from aomc_sky.cli.main import main
from aomc_sky.emission.photon_source import PhotonSource
block, photons = int(sys.argv.pop(1)), PhotonSource.photons

def photons_or_rest(*arguments, **options):
    global block
    block -= 1
    if block == 0:
        {rest}
    return photons(*arguments, **options)

PhotonSource.photons = photons_or_rest
sys.exit(main())
"""
UNFINISHED = re.compile(r"\.aomc-sky-.+\.[0-9a-f]{8}", re.DOTALL)
"""Names of files that a process is writing, or that one left when it was killed."""

_NUMBA = ForkServer("numba", "numba.core.caching", "numba.core.ccallback")


@dataclass(frozen=True, kw_only=True, slots=True)
class Ended:
    """How a process ended: exit code (negative for a signal), both streams, the peak of its memory. [MB]"""

    code: int
    out: str
    err: str
    peak_mb: float


def limited(folder, *words):
    """Run the command inside a folder under a limit on its processor time; a process that waits is killed, too."""
    peak = folder / ".peak"
    done = _COMMANDS.run(_LIMITED, int(MOST_CPU_S), peak, *words, folder=folder)
    peak_mb = float(peak.read_text()) if peak.exists() else math.nan
    return Ended(code=done.code, out=done.out, err=done.err, peak_mb=peak_mb)


def start(*words, **how):
    """A process that hears SIGINT, which a shell lets its background jobs ignore and they their children."""
    return _listening([sys.executable, "-m", "aomc_sky", *map(str, words)], **how)


def resting(*words, block, rest="signal.pause()"):
    """Command line that rests, for ever or until a signal comes, before it makes its block of photons of this number.

    However fast the machine is, it is in its midst then: it works on one thread.
    """
    program = _IN_ITS_MIDST.format(rest=rest)
    return [sys.executable, "-c", program, str(block), *map(str, words), "--threads", "1"]


def stopped(*words, block):
    """A process that has stopped itself, as by SIGSTOP, before its block of photons of this number."""
    process = _listening(resting(*words, block=block, rest="os.kill(os.getpid(), signal.SIGSTOP)"))
    now = os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
    assert now.si_code == os.CLD_STOPPED, process.communicate()
    return process


def end_by(process, how):
    """Send a signal to a stopped process, and return its standard error when it has ended."""
    process.send_signal(how)
    process.send_signal(signal.SIGCONT)
    return process.communicate(timeout=60)[1]


def _listening(command, **how):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how)
    finally:
        signal.signal(signal.SIGINT, before)


def wait_for(folder, pattern, process):
    """Return when a file of such a name is there."""
    limit = time.monotonic() + 60
    while not list(folder.glob(pattern)):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < limit
        time.sleep(0.002)


def in_environment(program, *arguments, **variables):
    """Standard output of a Python program under changed environment variables."""
    command, environment = [sys.executable, "-c", program, *map(str, arguments)], {**os.environ, **variables}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def with_numba(program, *arguments, **variables):
    """`in_environment` for programs whose start is not the subject: numba is there, the package is not."""
    done = _NUMBA.run(program, *arguments, **variables)
    assert done.code == 0, done.err
    return done.out


def whole_files_only(folder, whole):
    """Whether every file under a final name is the finished one."""
    names = [path.name for path in folder.iterdir() if not path.name.startswith(".")]
    return all((folder / name).read_bytes() == whole[name] for name in names)
