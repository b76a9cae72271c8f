"""Light that no sky has."""

import ast
import inspect
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.skies.direct_beam import solar_irradiance


def scene_of(nm, irradiance):
    uniform = sky.UniformSky(irradiance_W_m2_nm=irradiance)
    return sky.Scene(wavebands=[nm], n_photons=10, components=uniform)


SUN = {300.0: 0.52535, 412.0: 1.73114, 550.0: 1.86684, 900.0: 0.91535, 3000.0: 0.025255}
"""Wavelength -> the sun outside the atmosphere of ASTM G173-03, mean over 10 nm. [W m-2 nm-1]"""


@pytest.mark.parametrize("nm", SUN)
def test_twice_the_sun_is_the_limit(nm):
    sun = float(solar_irradiance(np.array(nm)))
    assert sun == pytest.approx(SUN[nm], rel=0.05)
    scene_of(nm, 1.99 * sun)
    with pytest.warns(sky.InputWarning, match=rf"waveband 1 at {nm:g} nm has .* 2 times the sun .*a unit may be wrong"):
        scene_of(nm, 2.01 * sun)


def test_the_sun_is_within_5_percent_of_its_spectrum():
    pvlib = pytest.importorskip("pvlib")
    spectrum = pvlib.spectrum.get_reference_spectra(standard="ASTM G173-03")["extraterrestrial"]
    nm, values = spectrum.index.to_numpy(float), spectrum.to_numpy()
    integral = np.concatenate([[0.0], np.cumsum(np.diff(nm) * (values[1:] + values[:-1]) / 2)])
    middle = np.arange(300.0, 3996.0)
    mean = (np.interp(middle + 5, nm, integral) - np.interp(middle - 5, nm, integral)) / 10
    assert np.abs(solar_irradiance(middle) / mean - 1).max() < 0.0505  # the table has 4 digits


@pytest.mark.parametrize("nm", [121.0, 299.9, 4001.0, 11_000.0])
def test_other_light_than_the_suns_has_no_limit(nm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene_of(nm, 1e6)


def test_what_type_checkers_see_is_what_a_scene_takes():
    """The signature for type checkers is written by hand."""
    tree = ast.parse(inspect.getsource(inspect.getmodule(sky.Scene)))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == "__init__"]
    assert len(functions) == 1
    shown = [argument.arg for argument in functions[0].args.kwonlyargs]
    assert shown == list(inspect.signature(sky.Scene).parameters)


@pytest.mark.slow
def test_documented_scenes_pass_the_type_checker(tmp_path):
    api = pytest.importorskip("mypy.api")
    program = tmp_path / "scenes.py"
    program.write_text(
        "from typing import Any\nimport numpy as np\nimport aomc_sky as sky\n"
        "def radiance(zenith: Any, azimuth: Any, nm: Any) -> Any:\n    return 1.0 + 0.0 * zenith\n"
        "sky.Scene(wavebands=[440, 550], n_photons=10**6, components=radiance)\n"
        "both = [sky.DirectBeam(sun_zenith_deg=30.0, strength=2.0), sky.UniformSky(strength=1.0)]\n"
        "scene = sky.Scene(wavebands=np.array([440.0]), n_photons=[1000], components=both)\n"
        "nm: float = scene.wavebands.wavelength_nm[0]\n"
        'sky.Scene(wavebands=[440.0], n_photons=1000, components="overcast").components[0].name\n'
    )
    said, problems, code = api.run(["--strict", "--cache-dir", str(tmp_path), str(program)])
    assert (code, problems) == (0, ""), said
    program.write_text("import aomc_sky as sky\nsky.Scene(wavebands=[440.0], n_photons=1000, components=5)\n")
    assert "components" in api.run(["--cache-dir", str(tmp_path), str(program)])[0]


def test_a_field_of_xarray_as_component_gets_one_sentence():
    xarray = pytest.importorskip("xarray")
    field = xarray.DataArray(np.ones((90, 360)), dims=("zenith", "azimuth"))
    with pytest.raises(sky.SceneError, match=r"got DataArray; write TabulatedSky[.]from_xarray") as caught:
        sky.Scene(wavebands=[440.0], n_photons=10, components=field)
    assert "\n" not in str(caught.value)
