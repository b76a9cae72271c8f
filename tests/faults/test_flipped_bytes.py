"""Run folders with bytes changed at random: every command answers, and changed photons are found."""

import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from tests.support.fault_rows import command, row_id
from tests.support.limits import MOST_CPU_S

SLOW = [pytest.param(150, seed, id=row_id(42, f"bytes-{seed}"), marks=pytest.mark.slow) for seed in (3, 4)]
"""What lets one change in a hundred pass is seen by 300 but for 5 %."""


def photons_of(folder):
    return [path.read_bytes() for path in sorted(folder.glob("photons-000?.npy"))]


@pytest.mark.parametrize(("n", "seed"), [pytest.param(16, 1, id=row_id(42, "bytes")), *SLOW])
def test_changes_of_a_run(n, seed, small_run, tmp_path, capsys):
    generator, whole = np.random.default_rng(seed), {path.name: path.read_bytes() for path in small_run.iterdir()}
    names, work = sorted(whole), tmp_path / "work"
    look = ("export", work, "--to", "csv", "--out", work / "x") if seed % 2 else ("info", work)
    run = ("run", small_run.parent, "--iterations", 1000, "--out", work, "-q", "--force")
    assert command("verify", small_run, "-q") == 0  # what follows would mean nothing if every folder were refused
    for k in range(n):
        name = names[k % len(names)]
        data = bytearray(whole[name])
        for at in generator.integers(len(data), size=generator.integers(1, 4)):
            data[at] ^= int(generator.integers(1, 256))
        shutil.rmtree(work, ignore_errors=True)
        shutil.copytree(small_run, work)
        Path(work, name).write_bytes(data)
        begin, codes = time.process_time(), []
        for words in (("verify", work, "-q"), look, run):
            codes.append(command(*words))
            said = capsys.readouterr()
            assert codes[-1] == 0 or said.out + said.err, words
            assert "Traceback" not in said.out + said.err
        assert time.process_time() - begin < MOST_CPU_S
        assert set(codes) <= set(range(7))
        if name.startswith(("photons-", "counts.")) and data != whole[name]:
            assert codes[0] != 0, f"verify took a change of {name}"
        # the run makes all again, or refuses a folder whose plan it cannot know for its own
        is_same = photons_of(work) == photons_of(small_run)
        assert is_same if codes[-1] == 0 else (codes[-1] == 2 and name == "plan.npz"), name
