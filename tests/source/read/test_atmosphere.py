"""A scene under [atmosphere]: absolute components, what else lies beside it, and what is refused."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from aomc_sky.errors import InputFileError, ModelLimitWarning, UsageError
from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS

SUN_DEG = 41.5


@pytest.fixture
def amc(tmp_path):
    """The scene atmosphere_sky with few orders and patches."""
    path = copy_scene("atmosphere_sky", tmp_path)
    coarse(path)
    return path


def coarse(amc, more="", sun=f"zenith_deg = {SUN_DEG}"):
    keys = "orders = 2\nzenith_bins = 9\nazimuth_bins = 12\n"
    (amc.parent / "sky.toml").write_text(f'[atmosphere]\nfile = "clear.atmo"\n{keys}{more}\n[sun]\n{sun}\n')


def test_strengths_are_the_irradiances_of_the_solution(amc):
    scene = sky.read_scene(amc)
    assert [c.name for c in scene.components] == ["direct", "atmosphere"]
    assert [c.law for c in scene.components] == [Law.DISC, Law.CELL_MU2]
    np.testing.assert_array_equal(scene.sky_wavelength_nm, [412, 510, 590, 670])
    found = sky.solve_atmosphere(
        amc.parent / "clear.atmo", wavelength_nm=scene.sky_wavelength_nm, sun_zenith_deg=SUN_DEG, sky_zenith_deg=0,
        azimuth_from_sun_deg=0, orders=2,
    )  # fmt: skip
    np.testing.assert_allclose(scene.irradiance.of_component[:, 0], found.direct_irradiance, rtol=1e-14)
    np.testing.assert_allclose(scene.irradiance.of_component[:, 1], found.diffuse_irradiance, rtol=3e-5)
    (azimuth,) = np.unique(scene.components[0].cell[:, 5] > 0)
    assert azimuth  # the beam comes from amc.inp's 65 degrees
    json.dumps(dict(scene.options))
    assert scene.options["atmosphere"]["orders"] == 2
    assert any("direct fraction" in note for note in scene.notes)


def test_bands_of_one_wavelength_share_its_row(amc):
    (amc.parent / "lambbot.inp").write_text("4\n500.0 0.05 0.0\n412.0 0.05 0.0\n500.5 0.05 0.0\n499.2 0.05 0.0\n")
    scene = sky.read_scene(amc)
    assert scene.row_of_band.tolist() == [1, 0, 1, 1]
    assert scene.components[0].strength.size == 2  # only what the bands need is solved
    np.testing.assert_array_equal(scene.sky_wavelength_nm, [500, 412, 500, 500])


def test_difcol_gives_intensities_and_no_direct_fraction(amc):
    (amc.parent / "difcol.inp").write_text("4\n0.9 0.5\n0.9 1.0\n0.9 1.0\n0.9 0.25\n")
    scene = sky.read_scene(amc, iterations=1000)
    assert scene.n_photons.tolist() == [500, 1000, 1000, 250]
    assert "difcol.inp: its direct fractions are not used: the light is that of the atmosphere" in scene.notes
    plain = sky.read_scene(amc)
    np.testing.assert_array_equal(plain.components[0].strength, scene.components[0].strength)


def test_the_disc_and_the_sun_of_sky_toml(amc):
    coarse(amc, sun=f"zenith_deg = {SUN_DEG}\ndisc = false")
    assert sky.read_scene(amc).components[0].law is Law.BEAM
    assert sky.read_scene(amc, sun={"disc": True}).components[0].law is Law.DISC
    high = sky.read_scene(amc, sun={"zenith_deg": 10.0})
    assert high.components[0].strength[0] > sky.read_scene(amc).components[0].strength[0]


def test_backgrounds_add_as_they_are(amc):
    pytest.importorskip("h5py")
    lobe = sky.lobes.SkyLobe(kind="hg", width=0.0, spectrum=[0.04, 0.04])
    sky.lobes.write_background(amc.parent / "glow.h5", sky.lobes.background_of_lobes({"glow": lobe}, [400.0, 700.0]))
    alone = sky.read_scene(amc)
    coarse(amc)
    with (amc.parent / "sky.toml").open("a") as file:
        file.write('[[background]]\nfile = "glow.h5"\ntime = 0\n')
    both = sky.read_scene(amc)
    assert [c.name for c in both.components] == ["direct", "atmosphere", "glow"]
    np.testing.assert_allclose(both.irradiance.of_component[:, :2], alone.irradiance.of_component, rtol=1e-14)
    np.testing.assert_allclose(both.irradiance.of_component[:, 2], 0.01, rtol=1e-6)
    source = both.source(seed=1)
    start = source.plan.component_start
    counts = np.add.reduceat(source.counts[0], start[:-1])
    share = both.irradiance.of_component[0] / both.irradiance.of_component[0].sum()
    assert np.all(np.abs(counts - share * source.n_photons(0)) < 1)


def test_another_sky_that_is_asked_for_wins(amc):
    scene = sky.read_scene(amc, sky="perez", perez={"dni": 800.0, "dhi": 90.0, "spectrum": "flat"})
    assert [c.name for c in scene.components] == ["direct", "perez"]
    assert any("[atmosphere] is not used" in note for note in scene.notes)
    with pytest.raises(sky.InputFileError, match="E100") as caught:
        sky.read_scene(amc, sky="overcast")
    assert '--spectrum spectrl2 (spectrum="spectrl2") for a cloudless sky' in str(
        caught.value
    )  # beside [atmosphere]: no [perez]
    pytest.importorskip("pvlib")
    assert sky.read_scene(amc, sky="overcast", perez={"spectrum": "spectrl2"}).irradiance is not None


def test_a_low_sun_under_flat_scattering_is_told(amc):
    coarse(amc, sun="zenith_deg = 85.0", more='method = "sos"')
    with pytest.warns(ModelLimitWarning, match="5 degrees above the horizon"):
        sky.read_scene(amc)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:in .* hardly any path reaches:aomc_sky.errors.ModelLimitWarning")
def test_a_low_sun_is_solved_by_backward_paths(amc):
    bands = "".join(f"{wavelength} 0.05 0.0\n" for wavelength in (412.0, 410.0, 413.0, 414.0))
    (amc.parent / "lambbot.inp").write_text(f"4\n{bands}")
    coarse(amc, sun="zenith_deg = 85.0", more='method = "auto"')
    scene = sky.read_scene(amc)
    assert scene.options["atmosphere"]["method"] == "mc"
    coarse(amc, sun="zenith_deg = 85.0", more='method = "sos"')
    with pytest.warns(ModelLimitWarning):
        flat = sky.read_scene(amc)
    np.testing.assert_array_equal(scene.irradiance.of_component[:, 0], flat.irradiance.of_component[:, 0])
    np.testing.assert_allclose(scene.irradiance.of_component[:, 1], flat.irradiance.of_component[:, 1], rtol=0.02)


def test_a_waveband_beyond_the_description_is_refused(amc):
    (amc.parent / "lambbot.inp").write_text("4\n412.0 0.05 0.0\n510.0 0.05 0.0\n590.0 0.05 0.0\n865.0 0.05 0.0\n")
    with pytest.raises(sky.SceneError, match="865 nm lies beyond its wavelengths, 410 to 680 nm"):
        sky.read_scene(amc)


def test_problems_of_the_description_and_of_amc_come_together(amc):
    (amc.parent / "lambbot.inp").write_text("4\n412.0 1.5 0.0\n510.0 0.05 0.0\n590.0 0.05 0.0\n670.0 0.05 0.0\n")
    atmo = amc.parent / "clear.atmo"
    atmo.write_text(atmo.read_text().replace("return 6.0e8", "return 6.0e8 * nothing"))
    with pytest.raises(InputFileError, match=r"(?s)lambbot\.inp:2.*clear\.atmo:\d+"):
        sky.read_scene(amc)


def test_solve_atmosphere_keeps_the_order_asked():
    def solve(wavelength, zenith, azimuth):
        how = {"sun_zenith_deg": 30.0, "sky_zenith_deg": zenith, "azimuth_from_sun_deg": azimuth, "orders": 2}
        return sky.solve_atmosphere(INPUTS / "atmosphere_sky" / "clear.atmo", wavelength_nm=wavelength, **how)

    found = solve([680, 410, 500, 679], [60, 10], [90, 0, 90])
    assert found.wavelength_nm.tolist() == [680, 410, 500, 680]
    assert found.radiance.shape == found.standard_error.shape == (4, 2, 3)
    assert found.radiance_by_order.shape == (4, 2, 2, 3)
    turned = solve([410, 500, 680], [10, 60], [0, 90])
    np.testing.assert_array_equal(found.radiance[1], turned.radiance[0][::-1][:, [1, 0, 1]])
    np.testing.assert_array_equal(found.direct_irradiance, turned.direct_irradiance[[2, 0, 1, 2]])
    assert found.method == "sos"
    with pytest.raises(UsageError):
        solve([[500.0]], 0, 0)
