"""The seed of the paths of an atmosphere: solutions of several seeds scatter by the error that each states."""

import json

import numpy as np
import pytest
from scipy.special import chdtr

import aomc_sky as sky
from aomc_sky.skies.atmosphere.backward import seed_of
from tests.support.fault_rows import command
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

pytestmark = pytest.mark.filterwarnings("ignore::aomc_sky.ModelLimitWarning")  # of few paths


def of_seed(seed=None, paths=256, zenith=(20.0, 60.0, 85.0), azimuth=(0.0, 70.0, 180.0)):
    """A low sun in molecules alone, some directions."""
    return sky.solve_atmosphere(
        INPUTS / "atmosphere" / "molecules_only.atmo", wavelength_nm=[450.0], sun_zenith_deg=85.0,
        sky_zenith_deg=zenith,
        azimuth_from_sun_deg=azimuth, method="mc", paths=paths, **({} if seed is None else {"seed": seed}),
    )  # fmt: skip


@pytest.mark.slow
def test_seeds_scatter_by_the_stated_error():
    """chi2 of 40 seeds in 9 directions, and that of an error that is stated a third too small or too large."""
    found = [of_seed(seed) for seed in range(40)]
    radiance = np.array([one.radiance[0] for one in found])
    error = np.array([one.standard_error[0] for one in found])
    variance = np.sum((radiance - radiance.mean(axis=0)) ** 2, axis=0) / np.mean(error**2, axis=0)
    n = (len(found) - 1) * radiance[0].size
    assert 1e-4 < chdtr(n, variance.sum()) < 1 - 1e-4
    for factor in (1.5, 0.67):
        assert not 1e-4 < chdtr(n, variance.sum() * factor**2) < 1 - 1e-4


def test_a_seed_changes_the_paths_alone():
    default, zero, other = (of_seed(**how, paths=16, zenith=(60.0,)) for how in ({}, {"seed": 0}, {"seed": 1}))
    assert default.radiance.tobytes() == zero.radiance.tobytes()
    assert np.array_equal(default.radiance_by_order[:, 0], other.radiance_by_order[:, 0])
    assert not np.any(default.radiance_by_order[:, 1] == other.radiance_by_order[:, 1])
    assert seed_of(5, 0) == 5
    assert len({seed_of(stream, seed) for stream in (0, 1, 2**63) for seed in range(1000)}) == 3000
    for wrong in (-1, 2**64, "x"):
        with pytest.raises(sky.UsageError, match="seed"):
            of_seed(wrong)


def test_the_seed_is_a_key_and_an_option(tmp_path):
    """Diffuse light of a scene and of `atmosphere`, each without a seed, with 0 and with 3."""
    of_scene, of_command = [], []
    for k, seed in enumerate((None, 0, 3)):
        amc = copy_scene("twilight", tmp_path / str(k))
        text = "" if seed is None else f"seed = {seed}\n"
        (amc.parent / "sky.toml").write_text(
            "[sun]\nzenith_deg = 92.0\nazimuth_deg = 0.0\n"
            f'[atmosphere]\nfile = "air.atmo"\nmethod = "mc"\npaths = 16\nzenith_bins = 6\nazimuth_bins = 8\n{text}'
        )
        scene = sky.read_scene(amc, iterations=1000)
        assert scene.options["atmosphere"].get("seed", 0) == (seed or 0)
        of_scene.append(scene.components[-1].strength.tolist())
        words = ["atmosphere", amc.parent / "air.atmo", "--out-dir", tmp_path / f"out{k}", "--sun-zenith", 92, "-q"]
        words += ["--method", "mc", "--paths", 16, "--bins", 6, 8, "--wavelengths", 450, "--no-netcdf"]
        assert command(*words, *([] if seed is None else ["--seed", seed])) == 0
        report = json.loads((tmp_path / f"out{k}" / "report.json").read_text())
        of_command.append(report["suns"][0]["diffuse_irradiance"])
    for found in (of_scene, of_command):
        assert found[0] == found[1]
        assert found[0] != found[2]
