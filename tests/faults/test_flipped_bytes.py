"""Run folders with bytes changed at random: every command answers, and changed photons are found."""

import hashlib
import subprocess
import sys

import pytest

from tests.support.fault_rows import command, row_id
from tests.support.limits import MOST_CPU_S

PHOTONS = 1000
MOST_MB = 300
"""numpy and scipy alone take 100 MB; the run itself is 36 kB for each waveband."""

# one process for all changes: exceptions leave it, the kernel ends it where it has no end, and its peak is its own
PROBE = """
import contextlib, hashlib, io, os, resource, sys, traceback
from pathlib import Path
os.fsync = os.fstat  # nothing here outlives a power cut
most_s, n, seed = map(int, sys.argv[1:4])
good, work = map(Path, sys.argv[4:6])
commands = [line.split() for line in sys.argv[6:]]
import shutil
import numpy as np
from aomc_sky.cli.main import main

generator = np.random.default_rng(seed)
whole = {path.name: path.read_bytes() for path in sorted(good.iterdir())}
names = list(whole)

def said(*words):
    out, err = io.StringIO(), io.StringIO()
    before = resource.getrusage(resource.RUSAGE_SELF)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    after = resource.getrusage(resource.RUSAGE_SELF)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert seconds < most_s, (words, seconds)
    text = out.getvalue() + err.getvalue()
    assert "Traceback" not in text, text
    assert code == 0 or text, words
    return code

for k in range(n):
    name = names[k % len(names)]
    data = bytearray(whole[name])
    places = []
    for _ in range(int(generator.integers(1, 4))):
        places.append(int(generator.integers(len(data))))
        data[places[-1]] ^= int(generator.integers(1, 256))
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(good, work)
    (work / name).write_bytes(data)
    is_changed = bytes(data) != whole[name]
    try:
        codes = [said(*words) for words in commands]
    except Exception:
        print("exception", name, places, traceback.format_exc())
        continue
    assert set(codes) <= {0, 1, 2, 3, 4, 5, 6}, codes
    photons = b"".join(path.read_bytes() for path in sorted(work.glob("photons-000?.npy")))
    print("done", name, int(is_changed), *codes, hashlib.sha256(photons).hexdigest())
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
print("peak", int(status["VmHWM"].split()[0]) / 1024)
"""


def photon_hash(folder):
    return hashlib.sha256(b"".join(p.read_bytes() for p in sorted(folder.glob("photons-000?.npy")))).hexdigest()


def outcomes(good, work, n, seed, commands):
    """For every change: the file, whether it is another one now, exit codes, and the hash of the photons then."""
    words = [sys.executable, "-c", PROBE, int(MOST_CPU_S), n, seed, good, work, *commands]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=3000, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    assert "exception" not in done.stdout, done.stdout[done.stdout.index("exception") :][:3000]
    *lines, peak = done.stdout.splitlines()
    assert float(peak.split()[1]) < MOST_MB
    assert len(lines) == n
    for line in lines:
        _, name, is_changed, *codes, photons = line.split()
        yield name, bool(int(is_changed)), [int(code) for code in codes], photons


SLOW = [pytest.param(150, seed, id=row_id(42, f"bytes-{seed}"), marks=pytest.mark.slow) for seed in (3, 4)]
"""What lets one change in a hundred pass is seen by 300 but for 5 %."""


@pytest.mark.parametrize(("n", "seed"), [pytest.param(16, 1, id=row_id(42, "bytes")), *SLOW])
def test_changes_of_a_run(n, seed, small_run, tmp_path):
    whole, scene, work = small_run, small_run.parent, tmp_path / "work"
    assert command("verify", whole, "-q") == 0  # what follows would mean nothing if every folder were refused
    run = f"run {scene} --iterations {PHOTONS} --out {work} -q --force"
    look = f"export {work} --to csv --out {work}/x" if seed % 2 else f"info {work}"
    for name, is_changed, codes, photons in outcomes(whole, work, n, seed, [f"verify {work} -q", look, run]):
        if is_changed and name.startswith(("photons-", "counts.")):
            assert codes[0] != 0, f"verify took a change of {name}"
        # the run makes all again, or refuses a folder whose plan it cannot know for its own
        assert (codes[-1], photons) == (0, photon_hash(whole)) or (codes[-1] == 2 and name == "plan.npz"), name
