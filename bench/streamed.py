"""Peak memory of a process that streams photons: `python bench/streamed.py N` prints bytes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from aomc_sky.errors import OutputError

_STATUS = Path("/proc/self/status")


def peak_memory() -> int:
    """Largest resident memory of this process so far. [bytes]

    Linux keeps it per program; `getrusage` would count the parent of a forked process too.
    """
    if _STATUS.exists():
        for line in _STATUS.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def streamed_peak(n_photons: int) -> int:
    """Peak memory of a process of its own that emits photons of the clear sky's table into reused buffers. [bytes]"""
    command = [sys.executable, __file__, str(n_photons)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise OutputError(f"a streamed run of {n_photons} photons ended with {done.returncode}: {last}")
    return int(done.stdout)


def _main() -> None:
    from aomc_sky.benchmark.samplers import buffer_of, drain
    from aomc_sky.benchmark.skies import bench_sky
    from aomc_sky.kernels.backend import announce_photons

    announce_photons(10**12)  # the same code for few photons and for many
    source = bench_sky("clear-uniform").scene(int(sys.argv[1])).source(seed=1)
    drain(source, buffer_of(source))
    print(peak_memory())


if __name__ == "__main__":
    _main()
