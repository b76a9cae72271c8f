"""A year of skies: exact sums, the same bytes however often it was cut short, and nobody else's folder touched."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
import signal
import subprocess
import sys
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from aomc_sky.engine.year import hour_counts, hour_source, run_year
from aomc_sky.errors import AomcSkyError, ForeignOutputError, ModelLimitWarning, OutputError, SceneError
from aomc_sky.outputs import year as year_folder
from aomc_sky.outputs.year import INDEX_COLUMNS, read_index
from aomc_sky.sampling.allocation import allocate, normalise
from aomc_sky.skies.perez.sky import PerezSky
from aomc_sky.source.year import SCHEMA, HourState, YearPlan
from tests.support.scenes import run_bytes
from tests.support.years import YEAR_OPTIONS

N_DAYS = 3
BLOCK = 10
"""Hours of a block in these tests, so that a short year has several."""


def a_plan(**changed) -> YearPlan:
    """Three days of invented hours, 11 of light a day; one without diffuse light, one missing."""
    rows = np.arange(24 * N_DAYS)
    hour = rows % 24
    zenith = np.minimum(np.abs(hour - 12.0) * 15.0 + 3.0 + 0.1 * (rows // 24), 180.0)
    clear = (rows * 7 % 11) / 10.0
    state = np.where(zenith >= 90, HourState.NIGHT, HourState.SKY).astype(np.int8)
    state[9], state[10] = HourState.NO_DIFFUSE, HourState.MISSING
    arrays = {
        "line": rows + 9,
        "start_s": 1_700_000_000 // 3600 * 3600 + 3600 * rows,
        "sun_zenith_deg": zenith,
        "sun_azimuth_deg": np.mod(270.0 - 15.0 * (hour - 12.0), 360.0),
        "extraterrestrial_normal": np.full(rows.size, 1361.1),
        "dni": np.where(state == 0, 900.0 * clear, 0.0),
        "dhi": np.where(state == 0, 10.0 + 3.0 * (90.0 - zenith), 0.0),
        "state": state,
    }
    return YearPlan(arrays=arrays, options={**YEAR_OPTIONS, **changed})


def contents(folder):
    """Bytes of the three files that no clock can change."""
    return {name: (folder / name).read_bytes() for name in ("plan.npz", "counts.npy", "index.csv")}


@pytest.fixture(scope="module", autouse=True)
def _short_blocks():
    assert year_folder.BLOCK_HOURS == 100
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(year_folder, "BLOCK_HOURS", BLOCK)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a year that was made in one go."""
    folder = tmp_path_factory.mktemp("year")
    run_year(a_plan(), folder)
    return folder


class CutShortError(Exception):
    """Ends a run from inside."""


def cut_short(folder, n):
    """Make a year that ends after n hours."""

    def progress(done, total):
        if done == n:
            raise CutShortError

    with pytest.raises(CutShortError):
        run_year(a_plan(), folder, progress=progress)


def test_sums_are_exact_and_every_row_is_listed(whole):
    plan, counts, index = a_plan(), np.load(whole / "counts.npy"), read_index(whole)
    assert counts.shape == (plan.sky_rows.size, 32)
    assert counts.dtype == np.int32
    assert np.all(counts.sum(axis=1) == 1000)
    assert len(index) == plan.n_rows
    assert [int(entry["row"]) for entry in index] == list(range(1, plan.n_rows + 1))
    states = [entry["state"] for entry in index]
    assert (states[9], states[10], states[0]) == ("no-diffuse", "missing", "night")
    lit = [k for k, state in enumerate(states) if state == "sky"]
    assert lit == plan.sky_rows.tolist()
    assert [int(index[k]["counts_row"]) for k in lit] == list(range(len(lit)))
    assert [int(index[k]["photons"]) for k in lit] == [1000] * len(lit)
    assert len(lit) > 3 * BLOCK  # or resuming would not be tested


def test_counts_are_those_of_the_sky_and_of_a_key_of_the_hour(whole):
    plan, counts = a_plan(), np.load(whole / "counts.npy")
    for k in (0, 10, 25):
        row = int(plan.sky_rows[k])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelLimitWarning)
            sky = PerezSky(
                sun_zenith_rad=float(np.deg2rad(plan.arrays["sun_zenith_deg"][row])),
                sun_azimuth_rad=float(np.deg2rad(plan.arrays["sun_azimuth_deg"][row])),
                dni=float(plan.arrays["dni"][row]),
                dhi=float(plan.arrays["dhi"][row]),
            )
        mass = sky.patch_mass(plan.grid)
        assert np.array_equal(counts[k], allocate(mass, 1000, seed=plan.hour_seed(row)))
        assert np.abs(counts[k] - 1000 * normalise(mass)).max() < 1
    assert len({plan.hour_seed(row) for row in range(plan.n_rows)}) == plan.n_rows


def test_manifest(whole):
    manifest = json.loads((whole / "manifest.json").read_text())
    n_sky = int(a_plan().sky_rows.size)
    assert manifest["schema"] == SCHEMA
    assert manifest["plan_sha256"] == a_plan().sha256
    assert manifest["hours"] == {"missing": 1, "night": 24 * N_DAYS - n_sky - 2, "no-diffuse": 1, "sky": n_sky}
    assert manifest["total"] == 1000 * n_sky
    for name, entry in manifest["files"].items():
        assert entry["bytes"] == (whole / name).stat().st_size
    assert manifest["run"]["hours"] == n_sky


@pytest.mark.parametrize("n", [1, 9, 10, 11, 20, 25, 31])
def test_a_year_that_was_cut_short_goes_on_with_the_same_bytes(n, whole, tmp_path):
    cut_short(tmp_path, n)
    assert not (tmp_path / "manifest.json").exists()
    assert not (tmp_path / "counts.npy").exists()
    seen = []
    result = run_year(a_plan(), tmp_path, progress=lambda done, total: seen.append((done, total)))
    assert contents(tmp_path) == contents(whole)
    n_sky = int(a_plan().sky_rows.size)
    kept = max((n - 1) // BLOCK - 1, 0) * BLOCK  # the last block on the disk is made again
    assert result.hours_done == n_sky - kept
    assert seen[-1] == (n_sky, n_sky)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["counts.npy", "index.csv", "manifest.json", "plan.npz"]


@pytest.mark.parametrize("damage", [1, 128, 1300, 2600, "garbage"])
@pytest.mark.parametrize("name", ["counts.npy.part", "index.csv.part"])
def test_torn_files_are_mended(name, damage, whole, tmp_path):
    """Bytes are missing at the end, or the file holds something else."""
    cut_short(tmp_path, 25)
    torn = tmp_path / name
    if damage == "garbage":
        torn.write_bytes(b"x\n" * 1000)
    else:
        os.truncate(torn, max(torn.stat().st_size - damage, 0))
    run_year(a_plan(), tmp_path)
    assert contents(tmp_path) == contents(whole)


@pytest.mark.parametrize("renamed", [["index.csv"], ["index.csv", "counts.npy"], []])
def test_killed_between_the_last_renames(renamed, whole, tmp_path):
    run_year(a_plan(), tmp_path)
    (tmp_path / "manifest.json").unlink()
    for name in {"index.csv", "counts.npy"} - set(renamed):
        (tmp_path / name).rename(tmp_path / f"{name}.part")
    run_year(a_plan(), tmp_path)
    assert contents(tmp_path) == contents(whole)
    assert (tmp_path / "manifest.json").exists()
    assert not list(tmp_path.glob("*.part"))


PROBE = """
import sys
sys.path.insert(0, {repository!r})
from tests.unit.engine.test_year import a_plan
from aomc_sky.outputs import year as year_folder
from aomc_sky.engine.year import run_year
import time
year_folder.BLOCK_HOURS = 10
def slowly(done, total):
    print(done, flush=True)
    time.sleep(0.02)
run_year(a_plan(), sys.argv[1], progress=slowly)
"""


@pytest.mark.parametrize("n", [12, 24])
def test_a_process_that_is_killed_leaves_a_year_that_goes_on(n, whole, tmp_path):
    from tests.support.shared import REPOSITORY

    command = [sys.executable, "-c", PROBE.format(repository=str(REPOSITORY)), str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if int(line) >= n:
                os.kill(process.pid, signal.SIGKILL)
                break
    assert not (tmp_path / "manifest.json").exists()
    result = run_year(a_plan(), tmp_path)
    assert result.hours_done < a_plan().sky_rows.size or n < 20
    assert contents(tmp_path) == contents(whole)


def test_a_finished_year_is_not_made_again(whole):
    before = {path.name: path.stat().st_mtime_ns for path in whole.iterdir()}
    result = run_year(a_plan(), whole)
    assert result.was_finished
    assert result.hours_done == 0
    assert {path.name: path.stat().st_mtime_ns for path in whole.iterdir()} == before


def test_a_damaged_finish_is_finished_again(whole, tmp_path):
    run_year(a_plan(), tmp_path)
    (tmp_path / "manifest.json").write_text("{")
    assert not run_year(a_plan(), tmp_path).was_finished
    (tmp_path / "counts.npy").unlink()
    assert run_year(a_plan(), tmp_path).hours_done > 0
    assert contents(tmp_path) == contents(whole)


@pytest.mark.parametrize("changed", [{"seed": 6}, {"iterations": 999}, {"bins": [8, 4]}, {"limits": "paper"}])
def test_another_year_is_refused_and_replaced_by_force(changed, whole, tmp_path):
    run_year(a_plan(**changed), tmp_path)
    before = contents(tmp_path)
    with pytest.raises(ForeignOutputError) as caught:
        run_year(a_plan(), tmp_path)
    assert caught.value.exit_code == 5
    assert contents(tmp_path) == before
    run_year(a_plan(), tmp_path, force=True)
    assert contents(tmp_path) == contents(whole)


@pytest.mark.parametrize("name", ["manifest.json", "counts.npy", "index.csv", "plan.npz"])
def test_files_of_somebody_else_are_refused(name, tmp_path):
    (tmp_path / name).write_bytes(b"not ours")
    with pytest.raises(ForeignOutputError):
        run_year(a_plan(), tmp_path)
    assert (tmp_path / name).read_bytes() == b"not ours"


def test_two_at_a_time_are_refused(tmp_path):
    cut_short(tmp_path, 11)
    with (tmp_path / "index.csv.part").open("r+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(OutputError, match="another process"):
            run_year(a_plan(), tmp_path)


def test_a_full_disk_is_an_output_error_and_the_year_goes_on_later(whole, tmp_path, monkeypatch):
    fsync, calls = os.fsync, []

    def full(handle):
        calls.append(handle)
        if len(calls) > 6:  # two for the plan, two for each block
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(handle)

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(OutputError, match="No space"):
            run_year(a_plan(), tmp_path)
    run_year(a_plan(), tmp_path)
    assert contents(tmp_path) == contents(whole)


def test_a_disk_that_is_too_small_is_told_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=4000))
    with pytest.raises(OutputError, match="--bins"):
        run_year(a_plan(), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.npz"]


def test_a_sky_without_light_is_listed_and_the_others_are_made(tmp_path, monkeypatch):
    dark = a_plan().sky_rows[3]
    zenith = float(np.deg2rad(a_plan().arrays["sun_zenith_deg"][dark]))
    patch_mass = PerezSky.patch_mass

    def sometimes(self, grid):
        if self.sun_zenith_rad == zenith:
            raise SceneError("no light, says\nthe test")
        return patch_mass(self, grid)

    monkeypatch.setattr(PerezSky, "patch_mass", sometimes)
    run_year(a_plan(), tmp_path)
    index = read_index(tmp_path)
    assert index[dark]["state"] == "no-light"
    assert index[dark]["note"] == "no light, says the test"
    assert index[dark]["photons"] == "0"
    counts = np.load(tmp_path / "counts.npy")
    assert set(counts.sum(axis=1).tolist()) == {0, 1000}
    with pytest.raises(SceneError, match="no light"):
        hour_source(tmp_path, int(dark) + 1)
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["hours"]["no-light"] == sum(entry["state"] == "no-light" for entry in index)


def test_what_a_model_limits_stands_in_the_index_and_not_on_the_screen(tmp_path, monkeypatch, recwarn):
    patch_mass = PerezSky.patch_mass

    def limiting(self, grid):
        warnings.warn('b was "positive", here', ModelLimitWarning, stacklevel=2)
        return patch_mass(self, grid)

    monkeypatch.setattr(PerezSky, "patch_mass", limiting)
    run_year(a_plan(), tmp_path)
    assert len(recwarn) == 0
    index = read_index(tmp_path)
    assert all('b was "positive", here' in entry["note"] for entry in index if entry["state"] == "sky")
    assert json.loads((tmp_path / "manifest.json").read_text())["hours_limited"] == a_plan().sky_rows.size


def test_photons_of_an_hour_have_the_counts_of_the_folder(whole):
    plan, counts = a_plan(), np.load(whole / "counts.npy")
    for k in (0, 13, counts.shape[0] - 1):
        row = int(plan.sky_rows[k])
        source = hour_source(whole, row + 1)
        assert np.array_equal(source.counts[0], counts[k])
        assert np.array_equal(hour_counts(whole, row + 1), counts[k])
        batch = source.photons()
        assert np.array_equal(np.bincount(batch.patch, minlength=32), counts[k])
        patch = plan.grid.patch_of(
            np.rad2deg(np.arccos(-batch.uz.astype(float))), np.rad2deg(np.arctan2(-batch.uy, -batch.ux))
        )
        assert np.mean(patch == batch.patch) > 0.99  # but for float32 at an edge
    same = hour_source(whole, row + 1, order="patch", precision="float64").photons()
    assert np.all(np.diff(same.patch) >= 0)


def test_stored_counts_win_over_recomputed_ones(tmp_path):
    run_year(a_plan(), tmp_path)
    counts = np.load(tmp_path / "counts.npy", mmap_mode="r+")
    first, second = np.flatnonzero(counts[7])[:2]
    counts[7, first] -= 1
    counts[7, second] += 1
    counts.flush()
    source = hour_source(tmp_path, int(a_plan().sky_rows[7]) + 1)
    assert np.array_equal(source.counts[0], counts[7])
    assert source.photons().ux.size == 1000
    counts[7, first] += 5
    counts.flush()
    with pytest.raises(AomcSkyError, match="damaged"):
        hour_source(tmp_path, int(a_plan().sky_rows[7]) + 1)


def test_the_beam_takes_its_share(tmp_path):
    plan = a_plan(with_beam=True)
    run_year(plan, tmp_path)
    counts = np.load(tmp_path / "counts.npy")
    assert counts.shape[1] == 33
    assert np.all(counts.sum(axis=1) == 1000)
    direct = plan.arrays["dni"] * np.cos(np.deg2rad(plan.arrays["sun_zenith_deg"]))
    fraction = (direct / np.maximum(direct + plan.arrays["dhi"], 1e-9))[plan.sky_rows]
    assert np.abs(counts[:, 0] - 1000 * fraction).max() < 1
    k = int(np.argmax(counts[:, 0]))
    row = int(plan.sky_rows[k])
    source = hour_source(tmp_path, row + 1)
    assert np.array_equal(source.counts[0], counts[k])
    assert [c.name for c in source.components] == ["direct", "perez"]
    batch = source.photons()
    beam = batch.uz[batch.patch == 0]
    assert beam.size == counts[k, 0]
    assert beam == pytest.approx(-np.cos(np.deg2rad(plan.arrays["sun_zenith_deg"][row])), abs=1e-6)


@pytest.mark.parametrize(
    ("row", "error"), [(1, "night"), (10, "no-diffuse"), (11, "missing"), (0, "1 to"), (73, "1 to")]
)
def test_rows_without_a_sky_are_told(row, error, whole):
    for ask in (hour_source, hour_counts):
        with pytest.raises(SceneError, match=error):
            ask(whole, row)


def test_verify_takes_no_year(tmp_path, capsys):
    from aomc_sky.cli.main import main

    (tmp_path / "plan.npz").write_bytes(a_plan().to_bytes())
    assert main(["verify", str(tmp_path)]) == 2
    assert "is a year of skies" in capsys.readouterr().err


def test_a_folder_without_a_finished_year(tmp_path):
    with pytest.raises(AomcSkyError, match="plan"):
        hour_source(tmp_path, 8)
    cut_short(tmp_path, 11)
    with pytest.raises(AomcSkyError, match="cut short"):
        hour_source(tmp_path, 8)


def test_a_year_of_nights(tmp_path):
    plan = a_plan()
    arrays = {**plan.arrays, "state": np.full_like(plan.arrays["state"], HourState.NIGHT)}
    dark = YearPlan(arrays=arrays, options=plan.options)
    result = run_year(dark, tmp_path)
    assert result.manifest["total"] == 0
    assert result.manifest["hours"] == {"night": plan.n_rows}
    assert np.load(tmp_path / "counts.npy").shape == (0, 32)
    assert len((tmp_path / "index.csv").read_text().splitlines()) == plan.n_rows + 1
    with pytest.raises(SceneError, match="night"):
        hour_counts(tmp_path, 12)


def test_many_photons_need_wider_counts(tmp_path):
    plan = a_plan(iterations=2**40 + 1)
    arrays = {name: array[:30] for name, array in plan.arrays.items()}
    run_year(YearPlan(arrays=arrays, options=plan.options), tmp_path)
    counts = np.load(tmp_path / "counts.npy")
    assert counts.dtype == np.int64
    assert np.all(counts.sum(axis=1) == 2**40 + 1)


def test_equal_years_have_equal_plans_and_manifests_apart_from_the_run(whole, tmp_path):
    run_year(a_plan(), tmp_path)
    assert run_bytes(tmp_path) == run_bytes(whole)
    assert YearPlan.load(whole / "plan.npz").sha256 == a_plan().sha256
    assert read_index(whole)[0].keys() == set(INDEX_COLUMNS.split(","))
