"""``run --replicates``: the table, the manifest, resume, pipes, and what is refused."""

import json

import numpy as np
import pytest

from aomc_sky.cli.main import main
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.plan.plan import Plan
from tests.support.scenes import manifest_of


def run(*words):
    return main(["run", *map(str, words)])


def test_table_and_manifest_show_standard_errors(amc, tmp_path, told):
    out = tmp_path / "out"
    shown = told("run", amc, "--iterations", 160_003, "--replicates", 16, "--out", out).out
    for words in ("standard errors from 16 replicates", "about 18 %", "(s.e.)", "no finite variance"):
        assert words in shown
    manifest = manifest_of(out)
    assert manifest["options"]["sampling"]["replicates"] == 16
    source = PhotonSource.from_plan(Plan.load(out / "plan.npz"))
    for band in manifest["bands"]:
        uz = np.load(out / f"photons-{band['waveband']:04d}.npy")[:, 2].astype(np.float64)
        ranges = [source.replicate_range(band["waveband"] - 1, r) for r in range(16)]
        means = np.array([-uz[start:stop].mean() for start, stop in ranges])
        assert np.isclose(band["mean_cosine_standard_error"], means.std(ddof=1) / 4, rtol=1e-3)
        assert f"{band['mean_cosine_standard_error']:.1e}" in shown
        inverse = np.array([np.mean(-1 / uz[start:stop]) for start, stop in ranges])
        assert np.isclose(band["eo_standard_error"], inverse.std(ddof=1) / 4, rtol=1e-3)
        assert np.isclose(band["eo_photons"], 1 / band["ed_over_eo_photons"], rtol=1e-12)
        ratio = band["eo_standard_error"] * band["ed_over_eo_photons"] ** 2
        assert np.isclose(band["ed_over_eo_standard_error"], ratio, rtol=1e-12)
        assert (band["ed_photons"], band["ed_standard_error"], band["eo_variance_is_finite"]) == (1.0, 0.0, False)
    assert "standard errors from 16 replicates" in told("info", out).out


def test_json_and_a_finished_run(amc, tmp_path, told):
    words = ("run", amc, "--iterations", 1000, "--method", "iid", "--out", tmp_path / "out", "--replicates")
    first, again = (json.loads(told(*words, 3, "--json").out) for _ in range(2))
    assert all(band["mean_cosine_standard_error"] > 0 for band in first["bands"])
    assert again["was_finished"]
    assert again["bands"] == first["bands"]
    assert "standard errors from 3 replicates" in told(*words, 3).out
    told(*words, 4, code=5)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--format", "none"), "no standard errors"),
        (("--allocation", "largest-remainder"), "bias is not in these errors"),  # equal counts in all replicates
    ],
)
def test_errors_that_are_not_there_are_told(amc, tmp_path, told, words, said):
    assert said in told("run", amc, "--iterations", 1000, "--replicates", 4, *words, "--out", tmp_path / "out").out
