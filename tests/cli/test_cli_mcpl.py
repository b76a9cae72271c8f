"""Files of ``run --format mcpl``: what the tools of MCPL make of them, and what ``info`` and ``validate`` say."""

import json
import subprocess

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.formats.mcpl.header import runs_of
from tests.support.fault_rows import command
from tests.support.mcpl import oracle
from tests.support.shared import INPUTS


def test_files_of_two_runs_merge(amc, tmp_path):
    """By the real tool: other seeds, photon numbers and methods; the head of the whole says how many runs are in it."""
    library, whole = oracle(), tmp_path / "whole.mcpl"
    options = [(1, 1000, None), (2**64 - 1, 2000, None), (3, 500, "iid")]
    sources = [sky.read_scene(amc, iterations=n).source(seed, method=method) for seed, n, method in options]
    paths = [tmp_path / f"{k}.mcpl" for k in range(len(sources))]
    for source, path in zip(sources, paths, strict=True):
        sky.write_mcpl(source, path)
    library.tool("--merge", whole, *paths)
    file = sky.files.read_mcpl(whole)
    assert len(file) == 3 * 3500
    runs = runs_of(file.header)
    assert (runs.n_runs, runs.n_photons, runs.n_iid, runs.n_stratified) == (3, 10_500, 1500, 9000)
    assert (runs.seed, runs.plan) == (None, "")
    parts = [sky.files.read_mcpl(path).particles().direction for path in paths]
    assert np.array_equal(file.particles().direction, np.concatenate(parts))
    assert command("validate", whole) == 0
    assert [runs_of(sky.files.read_mcpl(path).header).seed for path in paths] == [1, 2**64 - 1, 3]


def test_a_file_is_not_packed(amc, tmp_path):
    with pytest.raises(sky.UsageError, match="gzip can pack"):
        sky.write_mcpl(sky.read_scene(amc, iterations=10).source(), tmp_path / "p.mcpl.gz")
    assert not list(tmp_path.glob("*mcpl*"))


def test_files_of_other_wavebands_do_not_merge(amc, tmp_path):
    """User flags would mean two things."""
    scene = sky.read_scene(amc, iterations=100)
    sky.write_mcpl(scene.source(1), tmp_path / "a.mcpl")
    sky.write_mcpl(sky.read_scene(INPUTS / "clear_day", iterations=100).source(2), tmp_path / "b.mcpl")
    with pytest.raises(subprocess.CalledProcessError):
        oracle().tool("--merge", tmp_path / "c.mcpl", tmp_path / "a.mcpl", tmp_path / "b.mcpl")


def test_info_and_validate_of_a_file(amc, tmp_path, told):
    path = tmp_path / "out" / "photons.mcpl"
    told("run", amc, "--iterations", 1000, "--format", "mcpl", "--out", path.parent, "-q")
    assert f"MCPL-3 file {path}, 3000 particles, {path.stat().st_size} bytes" in told("info", path).out
    facts = json.loads(told("info", "--json", path).out)
    particles = sky.files.read_mcpl(path).particles()
    assert facts["bounds"]["uz"] == [particles.direction[:, 2].min(), particles.direction[:, 2].max()]
    assert facts["bounds"]["user_flags"] == [int(particles.user_flags.min()), int(particles.user_flags.max())]
    assert facts["bounds"]["energy"][1] == particles.energy.max()
    assert told("validate", path, path.parent).out == f"{path}: ok\n" * 2
