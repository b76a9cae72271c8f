"""Light that no sky has."""

import inspect
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.skies.direct_beam import solar_irradiance
from tests.support.type_checker import complaints


def scene_of(nm, irradiance):
    uniform = sky.UniformSky(irradiance_W_m2_nm=irradiance)
    return sky.Scene(wavebands=[nm], n_photons=10, components=uniform)


@pytest.mark.parametrize("nm", [300.0, 412.0, 550.0, 900.0, 3000.0])
def test_twice_the_sun_is_the_limit(nm):
    sun = float(solar_irradiance(np.array(nm)))
    scene_of(nm, 1.99 * sun)
    with pytest.warns(sky.InputWarning, match=rf"waveband 1 at {nm:g} nm has .* 2 times the sun .*a unit may be wrong"):
        scene_of(nm, 2.01 * sun)


@pytest.mark.parametrize("nm", [121.0, 299.9, 4001.0, 11_000.0])
def test_other_light_than_the_suns_has_no_limit(nm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene_of(nm, 1e6)


@pytest.mark.slow
def test_documented_scenes_pass_the_type_checker(tmp_path):
    (tmp_path / "programs").mkdir()
    program = tmp_path / "programs" / "scenes.py"
    good = (
        "from typing import Any\nimport numpy as np\nimport aomc_sky as sky\n"
        "def radiance(zenith: Any, azimuth: Any, nm: Any) -> Any:\n    return 1.0 + 0.0 * zenith\n"
        "sky.Scene(wavebands=[440, 550], n_photons=10**6, components=radiance)\n"
        "both = [sky.DirectBeam(sun_zenith_deg=30.0, strength=2.0), sky.UniformSky(strength=1.0)]\n"
        "scene = sky.Scene(wavebands=np.array([440.0]), n_photons=[1000], components=both)\n"
        "nm: float = scene.wavebands.wavelength_nm[0]\n"
        'sky.Scene(wavebands=[440.0], n_photons=1000, components="overcast").components[0].name\n'
        "sun = sky.sun_position('2026-06-21T12:00Z', 54.0, 8.0)\n"
        "model = sky.PerezSky(sun_zenith_deg=sun.zenith_deg, epsilon=5.0, delta=0.1)\n"
        "source = scene.source()\ncounts, mass = source.counts[0], source.mass(0)\n"
    )
    program.write_text(good)
    assert complaints(program.parent) == []
    wrong = {
        "sky.Scene(wavebands=[440.0], n_photons=1000, components=5)": '"components"',
        "source.counts(0)": "not callable",
        "source.mass[0]": "not indexable",
    }
    program.write_text(good + "\n".join(wrong))
    said = complaints(program.parent)
    assert [word in line for word, line in zip(wrong.values(), said, strict=True)] == [True] * len(wrong)


def test_what_covers_all_wavebands_is_an_attribute_and_what_takes_one_is_a_method():
    """The rule of docs/api.md; other methods do something."""
    doing = {"from_plan", "one_by_one", "to_bytes", "plot", "source", "refuse_dark_bands", "component_of"}
    methods = {
        name: bool({"band", "bands"} & inspect.signature(getattr(kind, name)).parameters.keys())
        for kind in (sky.PhotonSource, sky.Scene)
        for name in dir(kind)
        if name[0] != "_" and callable(getattr(kind, name))
    }
    assert {name for name, takes_band in methods.items() if not takes_band} == doing


def test_a_field_of_xarray_as_component_gets_one_sentence():
    xarray = pytest.importorskip("xarray")
    field = xarray.DataArray(np.ones((90, 360)), dims=("zenith", "azimuth"))
    with pytest.raises(sky.SceneError, match=r"got DataArray; write TabulatedSky[.]from_xarray") as caught:
        sky.Scene(wavebands=[440.0], n_photons=10, components=field)
    assert "\n" not in str(caught.value)
