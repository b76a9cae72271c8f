"""A pipe that carries ten thousand million photons while the memory of the program stays what it was at the begin.

`python -m pytest -m soak`; minutes on idle cores. AOMC_SKY_SOAK is the number of photons, if another one is asked for.
"""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from tests.support.scenes import copy_scene

PHOTONS = int(float(os.environ.get("AOMC_SKY_SOAK", "1e10")))
RECORD_BYTES = 12
PIECE = 1 << 20
MOST_GROWTH_MB = 8.0
"""Of the peak, from the first hundredth of the photons to the last: a byte for every 1200 photons would be more."""


def peak_mb(process):
    """Peak of the memory of a process that is alive. [MB]"""
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM"))) / 1024


@pytest.mark.soak
@pytest.mark.skipif(sys.platform != "linux", reason="the peak of the memory is told by Linux")
def test_photons_without_end_in_flat_memory(tmp_path):
    scene = copy_scene("clear_day", tmp_path).parent
    words = ["run", str(scene), "--iterations", str(PHOTONS), "--waveband", "1", "--format", "raw", "--out", "-", "-q"]
    process = subprocess.Popen(
        [sys.executable, "-m", "aomc_sky", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    said: list[bytes] = []
    listener = threading.Thread(target=lambda: said.append(process.stderr.read()))
    listener.start()
    buffer, n_bytes, total = bytearray(PIECE), 0, PHOTONS * RECORD_BYTES
    peaks: dict[int, float] = {}
    while n := process.stdout.readinto(buffer):
        n_bytes += n
        percent = 100 * n_bytes // total
        if percent in (1, 99) and percent not in peaks:
            peaks[percent] = peak_mb(process)
    process.stdout.close()
    assert process.wait(60) == 0, said
    listener.join()
    process.stderr.close()
    assert n_bytes == PHOTONS * RECORD_BYTES
    print(f"{PHOTONS:.3g} photons, peaks of the memory {peaks[1]:.1f} and {peaks[99]:.1f} MB")
    assert peaks[99] - peaks[1] < MOST_GROWTH_MB
