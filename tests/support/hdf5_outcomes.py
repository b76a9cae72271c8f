"""What becomes of background-sky files, one line for each, and the memory it took: a program of its own."""

import sys
import time
import warnings

import aomc_sky.skies.lobes.file.file as background
from aomc_sky.errors import InputFileError

CODES = {f"E50{k}" for k in range(1, 10)}


def print_outcomes(paths):
    """Outcome and processor time of every file; then the peak of this process. [MB]"""
    warnings.simplefilter("ignore")
    for path in paths:
        start = time.process_time()
        print(outcome(path), time.process_time() - start, flush=True)
    with open("/proc/self/status") as file:  # not ru_maxrss, which begins with the parent's peak
        own = next(int(line.split()[1]) for line in file if line.startswith("VmHWM:"))
    print(own / 1e3)


def outcome(path):
    """One word: read, or refused by our codes; or what else there was."""
    try:
        background.read_background_file(path)
    except InputFileError as error:
        codes = {problem.code for problem in error.problems}
        return "refused" if codes <= CODES else f"odd {codes}"
    return "read"


if __name__ == "__main__":
    print_outcomes(sys.argv[1:])
