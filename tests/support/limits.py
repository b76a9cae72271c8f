"""How much a bad file may cost in a test: processor time, memory, and neither numba nor scipy."""

from tests.support.forked_programs import ForkServer

MOST_CPU_S = 30.0
"""Processor time of one file. The promise is 2 s on a calm machine; here only a reader whose time grows with the
square of a file's size fails, never a busy machine."""
MOST_MB = 200.0

# one process per file, so that its peak memory and its CPU time are its own, whatever else the machine does
_PROBE = """
import sys, time
from aomc_sky.errors import InputFileError
for read in readers:
    begin = time.process_time()
    try:
        read(sys.argv[1])
    except InputFileError as error:
        print(error.problems[0].code, time.process_time() - begin)
    else:
        print("read", time.process_time() - begin)
assert not {"numba", "scipy"} & set(sys.modules)
# not ru_maxrss, which begins with the peak of the process that started this one
status = dict(line.split(':', 1) for line in open('/proc/self/status'))
print(int(status['VmHWM'].split()[0]) / 1024)
"""
_READERS = ForkServer(
    "numpy", "aomc_sky.formats.aomc.amc", "aomc_sky.formats.aomc.skydist", "aomc_sky.formats.mcpl.file"
)


def answers_within_limits(readers, path):
    """What each of the readers says of a file, "read" or the code of its first problem, at little cost."""
    done = _READERS.run(f"{readers}\n{_PROBE}", path)
    assert done.code == 0, done.err
    *lines, peak_mb = done.out.splitlines()
    answers = [line.split() for line in lines]
    assert all(float(seconds) < MOST_CPU_S for _, seconds in answers), answers
    assert float(peak_mb) < MOST_MB
    return [answer for answer, _ in answers]
