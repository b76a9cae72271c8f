"""``run --sky NAME --wavelengths NM``: a sky by name, without files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main


def run(*words: object) -> int:
    return main(["run", "--wavelengths", "443", "555", "--iterations", "20000", *map(str, words)])


@pytest.mark.parametrize(
    ("words", "mean_cosine"),
    [
        (("--sky", "uniform"), 2 / 3),
        (("--sky", "overcast"), 5 / 7),
        (("--sky", "cie", "--sky-option", "type=5", "--sun-zenith", "40"), 2 / 3),
    ],
)
def test_the_sky_alone(tmp_path: Path, words: tuple[str, ...], mean_cosine: float) -> None:
    assert run(*words, "--out", tmp_path / "grey", "-q") == 0
    assert main(["verify", str(tmp_path / "grey"), "-q"]) == 0
    manifest = json.loads((tmp_path / "grey" / "manifest.json").read_text())
    assert [band["launched"] for band in manifest["bands"]] == [20000, 20000]
    for band in (1, 2):
        photons = np.load(tmp_path / "grey" / f"photons-{band:04d}.npy")
        assert -photons[:, 2].mean(dtype=np.float64) == pytest.approx(mean_cosine, abs=1e-4)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--sky", "cie", "--sky-option", "type=12"), "--sky cie needs --sun-zenith"),
        (("--sky", "cie", "--sun-zenith", "40"), "--sky-option type="),
        (("--sky", "none"), "--sky none needs a scene of files"),
        (
            ("--sky", "overcast", "--ghi", "300", "--dhi", "200", "--sun-zenith", "40", "--air-mass", "kasten-1966"),
            "--air-mass: of the Perez sky",
        ),
        (
            ("--sky", "overcast", "--coefficients", "-1", "-0.3", "5", "-3", "0.1", "--sun-zenith", "40"),
            "--coefficients: of the Perez sky",
        ),
        (("--sky", "harrison-coombes", "--sun-zenith", "40", "--aod", "0.2"), "--aod: used only for a cloudless sky"),
        (("--sky", "harrison-coombes", "--sun-zenith", "40", "--disc"), "--disc: used only where"),
        (("--sky", "harrison-coombes", "--sun-zenith", "40", "--extraterrestrial", "1367"), "used only with two of"),
        (("--sky", "uniform", "--sky-option", "a=1"), "has no options"),
        (("--sky-option", "a=1", "--ghi", "300", "--dhi", "200", "--sun-zenith", "40"), "is for a sky of another name"),
        (("--sky", "cie", "--sky-option", "type=12", "--sun-zenith", "40", "--within", "uniform"), "--within"),
        (
            ("--sky", "overcast", "--azimuth-convention", "from_sun"),
            "--azimuth-convention is for a measured sky (.csv) or a radiance field (.nc): name it",
        ),
        (("--sky", "overcast", "--bins", "degrees"), "--bins is for a scene of files"),
    ],
)
def test_what_does_not_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], message: str
) -> None:
    assert run(*words, "--out", tmp_path / "grey") == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "grey").exists()


HARRISON = ("--sky", "harrison-coombes", "--sun-zenith", "40")


def test_a_sky_whose_sun_is_lost_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Version 0.3 launched a clear sky without its sun, two thirds of the light, and no word."""
    assert run(*HARRISON, "--out", tmp_path / "one", "-q") == 0
    assert "the direct beam of the sun is missing" in capsys.readouterr().err
    assert run(*HARRISON, "--diffuse-only", "--out", tmp_path / "two", "-q") == 0
    assert capsys.readouterr().err == ""
    one, two = (np.load(tmp_path / name / "photons-0001.npy") for name in ("one", "two"))
    assert np.array_equal(one, two)
    assert run("--sky", "overcast", "--sun-zenith", "40", "--out", tmp_path / "three", "-q") == 0  # no need of a sun
    assert "beam of the sun is missing" in capsys.readouterr().err


def test_python_takes_names_models_and_functions() -> None:
    weather = {"wavebands": [443.0, 555.0], "n_photons": 1000, "sun_zenith_deg": 40.0, "ghi": 780.0, "dhi": 140.0}
    cosines = [
        [sky.weather_scene(**weather, sky=one).source().exact_moments(band).mean_mu for band in (0, 1)]
        for one in ("uniform", sky.UniformSky(), lambda zenith, azimuth, nm: 1 + 0 * zenith)
    ]
    expected = (1 - 140 / 780) * np.cos(np.radians(40)) + 140 / 780 * 2 / 3
    np.testing.assert_allclose(cosines, expected, rtol=1e-9)
    names = [c.name for c in sky.weather_scene(**weather, sky="harrison-coombes").components]
    assert names == ["direct", "harrison-coombes"]
    with pytest.warns(sky.InputWarning, match=r"direct beam of the sun is missing.*write two of dni=, dhi= and ghi="):
        sky.weather_scene(wavebands=[550.0], sun_zenith_deg=40.0, sky="harrison-coombes")
    alone = sky.weather_scene(wavebands=[550.0], sun_zenith_deg=40.0, sky="harrison-coombes", diffuse_only=True)
    assert [c.name for c in alone.components] == ["harrison-coombes"]
    with pytest.raises(sky.UsageError, match="air_mass=: of the Perez sky"):
        sky.weather_scene(**weather, sky="overcast", air_mass="kasten-1966")
    dark = sky.weather_scene(**weather | {"ghi": 140.0}, sky="overcast")
    assert [c.name for c in dark.components] == ["overcast"]


def test_micrometres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        run("--sky", "uniform", "--wavelengths", "0.443", "--out", tmp_path / "grey")
    assert "wavelengths are in nm, got '0.443' (micrometres?); write 443" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "is_noted"),
    [
        (["--iterations", "100"], True),
        (["--iterations", "1e6"], False),
        (["--iterations", "100", "--format", "none"], False),
    ],
)
def test_a_rough_scalar_irradiance_is_noted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], is_noted: bool
) -> None:
    """Ed/Eo of the photons more than 1 % from the exact value."""
    sky = ["run", "--sky", "uniform", "--wavelengths", "500", "--out", str(tmp_path / "out")]
    assert main([*sky, *words]) == 0
    assert ("near the horizon make its scatter" in capsys.readouterr().out) is is_noted


def test_no_sky_is_never_the_nearest(capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["run", "--sky", "nonsense", "--wavelengths", "550"])
    shown = capsys.readouterr().err
    assert "there is no sky model 'nonsense'; write" in shown


def test_the_folder_of_a_sky_alone(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["run", "--sky", "overcast", "--wavelengths", "550", "--iterations", "1000", "-q"]
    assert main([*words, "--dry-run"]) == 0
    assert not list(tmp_path.iterdir())
    assert main(words) == 0
    assert (tmp_path / "aomc-sky-out" / "manifest.json").is_file()
