"""``run --format mcpl``, ``info`` and ``validate``: one file per run, resumed, the same on any number of threads."""

import json
import shutil
import subprocess

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.formats.mcpl.header import runs_of
from tests.support.fault_rows import command
from tests.support.mcpl import oracle
from tests.support.shared import INPUTS


def run(amc, out, *words):
    assert command("run", amc, "-q", "--format", "mcpl", "--out", out, "--iterations", *words) == 0


def test_a_name_that_asks_for_gzip_is_refused_with_what_to_do(amc, tmp_path, told):
    with pytest.raises(sky.errors.UsageError, match="gzip can pack"):
        sky.write_mcpl(sky.read_scene(amc, iterations=1000).source(), tmp_path / "p.mcpl.gz")
    run(amc, tmp_path / "out", 1000)
    said = told("export", tmp_path / "out", "--to", "mcpl", "--out", tmp_path / "r.mcpl.gz", code=2).err
    assert "write r.mcpl and run gzip on it" in said
    assert list(tmp_path.glob("*mcpl*")) == []


def test_files_of_two_runs_merge(amc, tmp_path):
    """By the real tool: other seeds, photon numbers and methods; the head of the whole says how many runs are in it."""
    library, whole = oracle(), tmp_path / "whole.mcpl"
    options = [(1, 1000, None), (2**64 - 1, 2000, None), (3, 500, "iid")]
    sources = [sky.read_scene(amc, iterations=n).source(seed, method=method) for seed, n, method in options]
    paths = [tmp_path / f"{k}.mcpl" for k in range(len(sources))]
    for source, path in zip(sources, paths, strict=True):
        sky.write_mcpl(source, path)
    library.tool("--merge", whole, *paths)
    file = sky.read_mcpl(whole)
    assert len(file) == 3 * 3500
    runs = runs_of(file.header)
    assert (runs.n_runs, runs.n_photons, runs.n_iid, runs.n_stratified) == (3, 10_500, 1500, 9000)
    assert (runs.seed, runs.plan) == (None, "")
    parts = [sky.read_mcpl(path).particles().direction for path in paths]
    assert np.array_equal(file.particles().direction, np.concatenate(parts))
    assert command("validate", whole) == 0
    assert [runs_of(sky.read_mcpl(path).header).seed for path in paths] == [1, 2**64 - 1, 3]


def test_files_of_other_wavebands_do_not_merge(amc, tmp_path):
    """User flags would mean two things."""
    scene = sky.read_scene(amc, iterations=100)
    sky.write_mcpl(scene.source(1), tmp_path / "a.mcpl")
    sky.write_mcpl(sky.read_scene(INPUTS / "clear_day", iterations=100).source(2), tmp_path / "b.mcpl")
    with pytest.raises(subprocess.CalledProcessError):
        oracle().tool("--merge", tmp_path / "c.mcpl", tmp_path / "a.mcpl", tmp_path / "b.mcpl")


def test_info_shows_head_and_bounds(amc, tmp_path, told):
    run(amc, tmp_path / "out", 1000)
    path = tmp_path / "out/photons.mcpl"
    text = told("info", path).out
    assert f"MCPL-3 file {path}, 3000 particles, {path.stat().st_size} bytes" in text
    assert "comment: positions: cm" in text
    facts = json.loads(told("info", "--json", path).out)
    particles = sky.read_mcpl(path).particles()
    assert facts["particles"] == 3000
    assert facts["bounds"]["uz"] == [particles.direction[:, 2].min(), particles.direction[:, 2].max()]
    assert facts["bounds"]["user_flags"] == [int(particles.user_flags.min()), int(particles.user_flags.max())]
    assert facts["bounds"]["energy"][1] == particles.energy.max()


def test_validate_takes_good_files_and_folders(amc, tmp_path, told):
    out = tmp_path / "out"
    run(amc, out, 100)
    assert told("validate", out / "photons.mcpl", out).out == f"{out / 'photons.mcpl'}: ok\n" * 2
    shutil.copy(out / "photons.mcpl", tmp_path / "a.mcpl.gz")
    assert json.loads(told("validate", "--json", tmp_path / "a.mcpl.gz").out)["ok"] is True
    assert "E801" in told("validate", tmp_path / "absent.mcpl", code=3).err
