"""``run --sky NAME --wavelengths NM``: a sky by name, without files."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main


def run(*words):
    return main(["run", "--wavelengths", "443", "555", "--iterations", "20000", *map(str, words)])


@pytest.mark.parametrize(
    ("words", "mean_cosine"),
    [
        (("--sky", "uniform"), 2 / 3),
        (("--sky", "overcast"), 5 / 7),
        (("--sky", "cie", "--sky-option", "type=5", "--sun-zenith", "40"), 2 / 3),
    ],
)
def test_the_sky_alone(tmp_path, words, mean_cosine):
    assert run(*words, "--out", tmp_path / "grey", "-q") == 0
    assert main(["verify", str(tmp_path / "grey"), "-q"]) == 0
    manifest = json.loads((tmp_path / "grey" / "manifest.json").read_text())
    assert [band["launched"] for band in manifest["bands"]] == [20000, 20000]
    for band in (1, 2):
        photons = np.load(tmp_path / "grey" / f"photons-{band:04d}.npy")
        assert -photons[:, 2].mean(dtype=np.float64) == pytest.approx(mean_cosine, abs=1e-4)


HARRISON = ("--sky", "harrison-coombes", "--sun-zenith", "40")


def test_a_sky_whose_sun_is_lost_says_so(tmp_path, capsys):
    """Version 0.3 launched a clear sky without its sun, two thirds of the light, and no word."""
    assert run(*HARRISON, "--out", tmp_path / "one", "-q") == 0
    assert "the direct beam of the sun is missing" in capsys.readouterr().err
    assert run(*HARRISON, "--diffuse-only", "--out", tmp_path / "two", "-q") == 0
    assert capsys.readouterr().err == ""
    one, two = (np.load(tmp_path / name / "photons-0001.npy") for name in ("one", "two"))
    assert np.array_equal(one, two)
    assert run("--sky", "overcast", "--sun-zenith", "40", "--out", tmp_path / "three", "-q") == 0  # no need of a sun
    assert "beam of the sun is missing" in capsys.readouterr().err


def test_python_says_it_in_its_own_words():
    weather = {"wavebands": [443.0, 555.0], "n_photons": 1000, "sun_zenith_deg": 40.0, "ghi": 780.0, "dhi": 140.0}
    with pytest.warns(sky.InputWarning, match=r"direct beam of the sun is missing.*write two of dni=, dhi= and ghi="):
        sky.weather_scene(wavebands=[550.0], sun_zenith_deg=40.0, sky="harrison-coombes")
    alone = sky.weather_scene(wavebands=[550.0], sun_zenith_deg=40.0, sky="harrison-coombes", diffuse_only=True)
    assert [c.name for c in alone.components] == ["harrison-coombes"]
    with pytest.raises(sky.UsageError, match="air_mass=: of the Perez sky"):
        sky.weather_scene(**weather, sky="overcast", air_mass="kasten-1966")
    dark = sky.weather_scene(**weather | {"ghi": 140.0}, sky="overcast")
    assert [c.name for c in dark.components] == ["overcast"]


@pytest.mark.parametrize(
    ("words", "is_noted"),
    [
        (["--iterations", "100"], True),
        (["--iterations", "1e6"], False),
        (["--iterations", "100", "--format", "none"], False),
    ],
)
def test_a_rough_scalar_irradiance_is_noted(tmp_path, told, words, is_noted):
    """Ed/Eo of the photons more than 1 % from the exact value."""
    sky = ["run", "--sky", "uniform", "--wavelengths", "500", "--out", str(tmp_path / "out")]
    assert ("near the horizon make its scatter" in told(*sky, *words).out) is is_noted


def test_the_folder_of_a_sky_alone(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["run", "--sky", "overcast", "--wavelengths", "550", "--iterations", "1000", "-q"]
    assert main([*words, "--dry-run"]) == 0
    assert not list(tmp_path.iterdir())
    assert main(words) == 0
    assert (tmp_path / "aomc-sky-out" / "manifest.json").is_file()
