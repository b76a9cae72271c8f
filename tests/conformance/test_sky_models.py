"""What every sky model of the registry promises; a new one is tested from the moment it is registered."""

import dataclasses
import inspect
from functools import cache, partial

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Component
from aomc_sky.formats.sky_models import SKY_MODELS
from aomc_sky.skies.model import SkyModel, sky_model
from tests.support import atmospheres
from tests.support.lobes import lobe_sky

GRID = sky.PatchGrid.regular(5, 8)


def table(**options):
    values = np.random.default_rng(1).lognormal(0, 1, (2, 40))
    return sky.TabulatedSky(wavelength_nm=[450, 550], values=values, grid=GRID, **options)


def atmosphere(**options):
    return sky.AtmosphereSky(medium=atmospheres.molecules_only([450.0, 550.0]), grid=GRID, **options)


ROUND, TILTED = ("hg", 0.0, 0.0, (1, 0, 0, 0)), ("hg", 0.9, 0.0, (0.7, 0.7, 0, 0))
BROAD = ("ggx", 0.2, 1.0, (1, 0.5, 0, 0)), ("beckmann", 0.3, 0.1, (1, 0, 2, 0))
SUN = {"sun_zenith_rad": 0.7, "sun_azimuth_rad": 0.4}


# instances of the registered models; one that is not named here is made as --sky makes it, from a sun. They are made
# when a test asks for them: a solved atmosphere takes seconds
EXAMPLES = {
    "atmosphere": [
        partial(atmosphere, sun_zenith_deg=40.0, sun_azimuth_deg=70.0),
        partial(atmosphere, sun_zenith_deg=91.0, method="order1"),
    ],
    "cie": [partial(sky.CIESky, type=n, **SUN) for n in (1, 12)],
    "lobes": [partial(lobe_sky, ROUND), partial(lobe_sky, TILTED, *BROAD)],
    "tabulated": [table, partial(table, weighting="projected"), partial(table, weighting="solid-angle")],
    "perez": [
        partial(sky.PerezSky, sun_zenith_rad=0.7, epsilon=8.0, delta=0.1, grid=GRID),
        partial(sky.PerezSky, sun_zenith_rad=0.7, dni=700.0, dhi=120.0, grid=GRID, within="uniform"),
        partial(sky.PerezSky, sun_zenith_rad=0.7, ghi=655.0, dhi=120.0, grid=GRID),
    ],
    "uniform": [sky.UniformSky, partial(sky.UniformSky, per_solid_angle=True)],
}
for name in SKY_MODELS:
    taken = inspect.signature(sky_model(name)).parameters
    EXAMPLES.setdefault(name, [partial(sky_model(name), **{n: v for n, v in SUN.items() if n in taken})])
INSTANCES = [(name, k) for name, models in EXAMPLES.items() for k in range(len(models))]


@cache
def instance(name, k):
    return EXAMPLES[name][k]()


@pytest.fixture
def model(request):
    return instance(*request.param)


every_model = pytest.mark.parametrize("model", INSTANCES, indirect=True, ids=lambda at: f"{at[0]}-{at[1]}")


def test_examples_are_of_the_registered_models():
    assert set(EXAMPLES) == set(SKY_MODELS)
    for name, k in INSTANCES:
        assert isinstance(instance(name, k), sky_model(name))
    with pytest.raises(sky.UsageError, match=", ".join(sorted(SKY_MODELS))):
        sky_model("perez-1993")


@every_model
def test_radiance_is_finite_pure_and_broadcasts(model):
    assert isinstance(model, SkyModel)
    rng = np.random.default_rng(2)
    zenith, azimuth = rng.uniform(0, np.pi / 2, (30, 1)), rng.uniform(0, 2 * np.pi, 20)
    first = model.radiance(zenith, azimuth, 500.0)
    assert first.shape == (30, 20)
    assert np.all(np.isfinite(first) & (first >= 0))
    np.testing.assert_array_equal(first, model.radiance(zenith, azimuth, 500.0))
    hard = np.array([0.0, np.nextafter(0, 1), np.nextafter(np.pi / 2, 0), np.pi / 2])
    assert np.all(np.isfinite(model.radiance(hard[:, None], np.array([0.0, 2 * np.pi]), 450.0)))


@every_model
def test_components_fit_the_sampler(model):
    components = model.lower(np.array([450.0, 550.0, 550.0]))
    for component in components:
        assert isinstance(component, Component)
        assert component.strength.shape == (3,)
        assert not component.mass.flags.writeable
    source = sky.Scene(wavebands=[450.0, 550.0, 551.0], n_photons=1000, components=components).source()
    assert source.total == 3000
    for batch in source.batches(2, 300):
        assert np.all(batch.uz <= 0)


@every_model
def test_scenes_take_models_as_they_are(model):
    given = sky.Scene(wavebands=[450, 550], n_photons=500, components=model)
    bands = {"wavebands": [450.0, 550.0], "n_photons": [500, 500], "sky_wavelength_nm": given.sky_wavelength_nm}
    by_hand = sky.Scene(**bands, components=model.lower([450.0, 550.0]))
    assert given.source(seed=2).plan.sha256 == by_hand.source(seed=2).plan.sha256


def by_quadrature(name, k):
    """One of each quick model: where there are kinks, quadrature to 1e-10 takes seconds, or half a minute."""
    marks = pytest.mark.slow if k > 0 or name in ("atmosphere", "cie", "harrison-coombes") else ()
    return pytest.param((name, k), marks=marks, id=f"{name}-{k}")


@pytest.mark.parametrize("model", [by_quadrature(*at) for at in INSTANCES], indirect=True)
def test_a_model_with_radiance_alone_is_lowered_by_its_radiance(model):
    """Its strength is what quadrature finds in the radiance."""
    generic = sky.FunctionSky(model.radiance, grid=GRID).irradiance([450.0])[0]
    assert generic > 0
    (component,) = sky.Scene(wavebands=[450.0], n_photons=10, components=Radiance(model)).components
    assert component.name == "function"
    assert component.grid is GRID
    assert component.strength[0] == generic


class Radiance:
    """A model of somebody else's that has a radiance and patches, and nothing more."""

    grid = GRID

    def __init__(self, model):
        self.radiance = model.radiance


@every_model
def test_every_model_takes_its_share(model):
    if isinstance(model, sky.AtmosphereSky):
        pytest.skip("solved once more for each share: its own test has them")
    relative = dataclasses.replace(model, strength=0.25)
    for unit, expected in (("strength", [0.25, 0.25]), ("irradiance_W_m2_nm", [2.0, 3.0])):
        shared = dataclasses.replace(model, **{unit: expected})
        beam = sky.DirectBeam(sun_zenith_deg=30.0, **{unit: 0.5})
        given = sky.Scene(wavebands=[450.0, 550.0], n_photons=1000, components=[shared, beam])
        assert sum(c.strength for c in given.components[:-1]) == pytest.approx(expected)
        assert given.components[-1].strength.tolist() == [0.5, 0.5]
        assert (given.irradiance is None) == (unit == "strength")
    with pytest.raises(sky.UsageError, match="not both"):
        dataclasses.replace(relative, irradiance_W_m2_nm=1.0)
    for bad in (-1.0, np.nan, [[1.0]], "much"):
        with pytest.raises(sky.SceneError, match="strength must be"):
            dataclasses.replace(model, strength=bad)
    with pytest.raises(sky.SceneError, match="3 values for 2 wavelengths"):
        dataclasses.replace(model, strength=[1.0, 2.0, 3.0]).lower([450.0, 550.0])


def test_what_is_no_table_and_no_beam():
    shapes = [([500], np.ones((1, 39)), ValueError), ([500, 600], np.ones((1, 40)), ValueError)]
    numbers = [([500], np.full((1, 40), bad), sky.SceneError) for bad in (-1.0, np.nan, np.inf)]
    for nm, values, error in shapes + numbers:
        with pytest.raises(error):
            sky.TabulatedSky(wavelength_nm=nm, values=values, grid=GRID)
    beams = [(90, 0, 0), (-1, 0, 0), (np.nan, 0, 0), (91, 0, 0.3), (10, np.inf, 0)]
    for zenith, azimuth, radius in (*beams, *((10, 0, r) for r in (11, 10.001, -1e-3, np.nan))):
        with pytest.raises(sky.SceneError):
            sky.DirectBeam(sun_zenith_deg=zenith, sun_azimuth_deg=azimuth, radius_deg=radius)


def test_components_are_checked():
    good = {"name": "x", "law": sky.component.Law.BEAM, "strength": [1.0], "mass": [[1.0]], "cell": np.zeros((1, 6))}
    sky.component.Component(**good)
    shapes = {"mass": [[1.0, 2.0]], "cell": np.zeros((1, 5)), "strength": [[1.0]]}
    numbers = {"mass": [[-1.0]], "strength": [np.nan]}
    with pytest.raises(sky.UsageError, match="is not a valid Law"):
        sky.component.Component(**{**good, "law": max(sky.component.Law) + 1})
    for changes, error, words in ((shapes, ValueError, "do not fit"), (numbers, sky.SceneError, "finite")):
        for name, value in changes.items():
            with pytest.raises(error, match=words):
                sky.component.Component(**{**good, name: value})
    with pytest.raises(sky.SceneError, match="at a wavelength where it is dark"):
        sky.FunctionSky(lambda z, a, w: max(w - 500.0, 0.0), strength=1.0).lower([450.0, 550.0])
    assert sky.Scene(wavebands=[500.0], n_photons=10, components=lobe_sky(TILTED)).irradiance is not None


UNIFORM, BEAM = sky.UniformSky(), sky.DirectBeam(sun_zenith_deg=30.0)
MIXED = [sky.UniformSky(strength=1), sky.DirectBeam(sun_zenith_deg=30.0, irradiance_W_m2_nm=1.0)]


def test_models_without_shares_are_refused_not_halved():
    for components, named in (
        ([UNIFORM, BEAM], "'uniform'"),
        ([sky.UniformSky(strength=1), BEAM], "'direct'"),
        ([UNIFORM.lower([500.0])[0], lambda z, a, w: 1.0], "'function'"),
        (MIXED, "'direct'.*'uniform'"),
        (3, "int: 3"),
    ):
        with pytest.raises(sky.SceneError, match=named):
            sky.Scene(wavebands=[500.0], n_photons=10, components=components)


def test_scenes_are_checked():
    bands = [500.0, 600.0]
    beam = sky.DirectBeam(sun_zenith_deg=10).lower([500.0, 600.0])
    parts = [("components", parts) for parts in ((), (*beam, *beam), (*beam, *UNIFORM.lower([500.0])))]
    numbers = [("n_photons", n) for n in ([1, 2, 3], -1, 1.5)]
    for key, value in (*parts, *numbers, ("row_of_band", [0, 5])):
        with pytest.raises(sky.SceneError):
            sky.Scene(**{"wavebands": bands, "n_photons": 10, "components": beam, key: value})
    dark = sky.component.Component(
        name="dark", law=sky.component.Law.BEAM, strength=[1.0, 0.0], mass=[[1.0]], cell=beam[0].cell
    )
    with pytest.raises(sky.SceneError, match="waveband 2 at 600 nm"):
        sky.Scene(wavebands=bands, n_photons=10, components=(dark,)).source()
    assert sky.Scene(wavebands=bands, n_photons=[10, 0], components=(dark,)).source().total == 10


@pytest.mark.parametrize("zenith_deg", [0.0, 50.0, 89.0, 89.9999, 89.99995, 90.0])
@pytest.mark.parametrize("radius_deg", [1e-4, 1.23e-4, 0.0077])
def test_small_discs_have_photons(zenith_deg, radius_deg):
    beam = sky.DirectBeam(sun_zenith_deg=zenith_deg, radius_deg=radius_deg)
    batch = sky.Scene(wavebands=[550.0], n_photons=1000, components=beam).source(precision="float64").photons(0)
    assert np.all(batch.uz < 0)
    found = np.rad2deg(np.arctan2(-batch.ux, -batch.uz))
    assert abs(found - zenith_deg).max() < 1.001 * radius_deg + 1e-12


@pytest.mark.parametrize(("zenith_deg", "radius_deg"), [(90, 1e-6), (89.9999999, 1e-6), (90, 9.9e-5)])
def test_a_disc_that_is_too_small_for_the_horizon_to_cut(zenith_deg, radius_deg):
    with pytest.raises(sky.SceneError, match=f"0.0001 degrees or more, got radius_deg {radius_deg:g} at the zenith"):
        sky.DirectBeam(sun_zenith_deg=zenith_deg, radius_deg=radius_deg)
