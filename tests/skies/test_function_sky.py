"""A function of direction and wavelength as a sky: what it may give, what is refused, and what its patches cost."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.skies import function_sky
from aomc_sky.skies.function_sky import FunctionSky

BANDS = sky.Wavebands(wavelength_nm=np.array([440.0, 550.0]))


def bright_zenith(sky_zenith_rad, sky_azimuth_rad, wavelength_nm):
    return 1 + 2 * np.cos(sky_zenith_rad) ** 2


def source_of(model, n=100_000, **options):
    return sky.Scene(wavebands=BANDS, n_photons=n, components=model.lower(BANDS.wavelength_nm)).source(**options)


def test_the_mean_cosine_of_its_photons():
    """1 + 2 cos^2: 11 / 15, within what the patches cost."""
    model = FunctionSky(bright_zenith)
    exact = source_of(model).exact_moments(0).mean_mu
    assert abs(exact - 11 / 15) < model.variation(440.0)[0]
    assert abs(-source_of(model).photons(0, 0, 100_000).uz.mean(dtype=float) - exact) < 1e-5
    assert abs(source_of(model.refined(1e-4)).exact_moments(0).mean_mu - 11 / 15) < 1e-6
    assert abs(model.irradiance(440.0)[0] / (2 * np.pi) - 1) < 1e-12
    model = FunctionSky(lambda z, a, w: np.cos(z) if w < 500 else 1.0, grid=sky.PatchGrid.regular(4, 6))
    (component,) = model.lower([440.0, 550.0])
    np.testing.assert_allclose(component.strength, [2 * np.pi / 3, np.pi], rtol=0, atol=1e-12)
    both = model.radiance(np.array([[0.2], [0.4]]), 0.0, np.array([440.0, 550.0]))
    np.testing.assert_allclose(both, [[np.cos(0.2), 1], [np.cos(0.4), 1]])


@pytest.mark.parametrize(
    ("function", "expected"),
    [(lambda z, a, w: 2, 2.0), (lambda z, a, w: w / 100, 4.4), (lambda z, a, w: np.float32(0.5), 0.5)],
)
def test_what_ignores_direction_is_a_uniform_sky(function, expected):
    model = FunctionSky(function, grid=sky.PatchGrid.regular(4, 6))
    (component,) = model.lower([440.0])
    np.testing.assert_array_equal(component.mass[0], expected * model.patches.projected_solid_angle_sr)
    assert model.notes([440.0]) == ("sky 'function': a spot of light less than 11 degrees wide may be missed",)
    assert model.radiance(0.3, [0.1, 0.2], 440.0).tolist() == [expected, expected]


def test_a_spot_that_is_missed_on_an_even_sky_is_in_the_notes():
    zenith, azimuth, radius = np.radians([27.377, 313.163, 0.059 / 2])

    def disc(z, a, w):
        cosine = np.cos(z) * np.cos(zenith) + np.sin(z) * np.sin(zenith) * np.cos(a - azimuth)
        return np.where(cosine > np.cos(radius), 1e6, 1.0)

    model = FunctionSky(disc)
    assert model.irradiance(550.0)[0] < 1.0001 * np.pi  # the disc has more than a half of the light
    assert model.notes([550.0]) == ("sky 'function': a spot of light less than 0.19 degrees wide may be missed",)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda z, a, w: np.where(z > 1.5, np.nan, 1.0), "nan at zenith angle 86.5 degrees, azimuth 0.5 degrees, 440"),
        (lambda z, a, w: 0.5 - z, "gives -0.0.* at zenith angle 2.*finite and not negative"),
        (lambda z, a, w: np.ones(z.shape[-1:]), r"shape \(\d+,\) for directions of shape .* or a single number"),
        (lambda z, a, w: np.ma.masked_greater(z, 1.0), "masked values; give them a radiance, 0 where no light comes"),
        (lambda z, a, w: 1j * z, "complex128 instead of real"),
        (lambda z, a, w: math.cos(z), "failed .TypeError: .*np.cos instead of math.cos"),
        (lambda z, a, w: 1.0 if z < 1 else 2.0, "failed .ValueError: .*np.where instead of if"),
        (lambda z, a: z, "three arguments: sky_zenith_rad, sky_azimuth_rad, wavelength_nm"),
    ],
)
def test_refusals_name_the_direction_or_the_cause(function, message):
    with pytest.raises(sky.SceneError, match=message) as caught:
        FunctionSky(function).lower([440.0])
    assert "\n" not in str(caught.value)


def test_errors_of_the_function_itself_are_its_own():
    def broken(z, a, w):
        raise KeyError("cloud")

    with pytest.raises(KeyError, match="cloud"):
        FunctionSky(broken).lower([440.0])

    def out_of_its_range(z, a, w):
        if np.any(z > 1.2):
            raise ValueError("no data beyond 1.2 rad")
        return np.cos(z)

    for function in (out_of_its_range, lambda z, a, w: int("clear")):
        with pytest.raises(sky.SceneError, match=r"function of sky 'function' failed \(ValueError: ") as caught:
            FunctionSky(function).lower([440.0])
        assert isinstance(caught.value.__cause__, ValueError)


@pytest.mark.parametrize("scale", [2.0**1023, 5e-324, 2.0**-1030, 2.0**830])
def test_radiances_of_any_size_are_one_sky(scale):
    """Radiances are relative: sums of the largest and of the smallest floats neither overflow nor vanish."""
    grid = sky.PatchGrid.regular(9, 4)
    plain, scaled = (FunctionSky(lambda z, a, w, s=s: np.where(z < 1.0, s, 0.0), grid=grid) for s in (1.0, scale))
    np.testing.assert_array_equal(source_of(scaled).counts, source_of(plain).counts)
    assert scaled.notes([440.0]) == plain.notes([440.0])
    assert 0 < scaled.irradiance(440.0)[0] == min(scale * plain.irradiance(440.0)[0], np.finfo(float).max)


def test_what_is_no_function_and_what_no_grid_can_meet(monkeypatch):
    with pytest.raises(sky.SceneError, match="needs a function"):
        FunctionSky(3.0)
    with pytest.raises(sky.SceneError, match="points or lines"):
        FunctionSky(bright_zenith, grid=sky.PatchGrid.lattice(3, 3))
    assert function_sky._MAX_PATCHES == 4_000_000
    monkeypatch.setattr(function_sky, "_MAX_PATCHES", 100_000)  # it gives up as soon as it may

    def spot(z, a, w):
        return np.exp((np.sin(z) * np.cos(a) + np.cos(z) - np.sqrt(2)) / 1e-6)

    with pytest.raises(sky.SceneError, match=r"more than 0 million.*DirectBeam"):
        FunctionSky(spot).refined(1e-3, wavelength_nm=550.0)
    for tolerance in (0, 1, -1, math.nan):
        with pytest.raises(sky.SceneError, match="between 0 and 1"):
            FunctionSky(bright_zenith).refined(tolerance)


@pytest.mark.parametrize("tolerance", [0.05, 0.01])
@pytest.mark.parametrize(
    "function",
    [
        bright_zenith,
        lambda z, a, w: np.where(a < 1.0, 1.0, 0.2),
        lambda z, a, w: 2.0 + np.cos(a) * np.sin(z) + (w - 550) / 1000 * np.cos(3 * a) ** 2,
        lambda z, a, w: 7.0,
    ],
    ids=["zenith", "azimuth", "both", "uniform"],
)
def test_refined_grids_meet_the_tolerance_and_are_coarse(function, tolerance):
    model = FunctionSky(function).refined(tolerance)
    assert model.variation([400, 550, 700]).max() <= tolerance
    n_zenith, n_azimuth = model.patches.n_zenith, model.patches.n_azimuth
    is_smooth = not model.radiance(0.5, 0.9, 550) > model.radiance(0.5, 1.1, 550) + 0.5  # a jump may lie on an edge
    if n_zenith * n_azimuth > 8 and is_smooth:  # half as many of either would not do
        fewer = {(max(n_zenith // 2, 1), n_azimuth), (n_zenith, max(n_azimuth // 2, 1))} - {(n_zenith, n_azimuth)}
        coarser = [FunctionSky(function, grid=sky.PatchGrid.regular(*shape)) for shape in fewer]
        assert max(one.variation([400, 550, 700]).max() for one in coarser) > tolerance


def ring(first_rad, width_rad, level=1e5):
    """A uniform sky with a bright ring, and its irradiance."""
    light = math.pi * (1 + (level - 1) * (math.sin(first_rad + width_rad) ** 2 - math.sin(first_rad) ** 2))
    return FunctionSky(lambda z, a, w: np.where((z > first_rad) & (z < first_rad + width_rad), level, 1.0)), light


def wall(first_rad, width_rad, level=1e5):
    """The same with a wall between two meridians."""
    light = math.pi * (1 + (level - 1) * width_rad / (2 * math.pi))
    return FunctionSky(lambda z, a, w: np.where((a > first_rad) & (a < first_rad + width_rad), level, 1.0)), light


def box(first_rad, width_rad, azimuth_rad, length_rad, level=1e5):
    """The same with a bright region between two parallels and two meridians."""

    def radiance(z, a, w):
        is_inside = (z > first_rad) & (z < first_rad + width_rad) & (a > azimuth_rad) & (a < azimuth_rad + length_rad)
        return np.where(is_inside, level, 1.0)

    growth = math.sin(first_rad + width_rad) ** 2 - math.sin(first_rad) ** 2
    return FunctionSky(radiance), math.pi + (level - 1) * length_rad * growth / 2


def errors_of_boxes(n, seed):
    """Relative errors of the light of boxes, 1 to 6 sure spots wide and long."""
    rng, spot = np.random.default_rng(seed), math.radians(FunctionSky(bright_zenith).sure_spot_deg)
    for _ in range(n):
        (width, length), first = spot * rng.uniform(1, 6, 2), rng.uniform(0.05, 1.5)
        length /= math.sin(first + width / 2)
        model, light = box(first, width, rng.uniform(0.0, 2 * math.pi - length), length)
        yield abs(float(model.irradiance(550.0)[0]) / light - 1)


def errors_of_walls(n, seed):
    """Relative errors of the light of walls and rings, 1 to 6 sure spots wide; one begins beside an edge of a patch."""
    rng, spot = np.random.default_rng(seed), math.radians(FunctionSky(bright_zenith).sure_spot_deg)
    cases = [ring(0.96, 2 * spot), wall(0.96, 2 * spot)]
    for _ in range(n):
        width = spot * rng.uniform(1, 6)
        cases += [ring(rng.uniform(0.02, 1.55 - width), width), wall(rng.uniform(0.02, 6.2 - width), width)]
    return [abs(float(model.irradiance(550.0)[0]) / light - 1) for model, light in cases]


@pytest.mark.parametrize("n", [4, pytest.param(150, marks=pytest.mark.slow)])
def test_the_light_of_narrow_walls_and_small_boxes_is_right(n, monkeypatch):
    """Planted: no close look at patches that were cut."""
    assert max(*errors_of_walls(n, 1), *errors_of_boxes(n, 9)) < 1e-11
    monkeypatch.setattr("aomc_sky.skies.patch_integrals._MOST_CLOSE", 0.0)
    assert max(errors_of_walls(0, 1)) > 1e-3
    assert max(errors_of_boxes(4, 9)) > 1e-3


def test_a_refined_grid_is_not_coarser_than_one_that_was_given_and_sees_all_light():
    given = FunctionSky(bright_zenith, grid=sky.PatchGrid.regular(30, 60)).refined(0.01)
    assert (given.patches.n_zenith, given.patches.n_azimuth) == (30, 60)
    model, light = ring(0.9, 0.02, 50.0)
    found = model.refined(0.05, wavelength_nm=550.0)
    assert float(found.irradiance(550.0)[0]) == pytest.approx(light, rel=1e-9)
    assert found.variation(550.0)[0] <= 0.05
    assert FunctionSky(bright_zenith).refined(0.01).patches.n_patches < 100  # of a smooth one without a grid of its own


@given(st.floats(1e-6, 1.0), st.one_of(st.floats(1e-3, 0.999), st.floats(1.0, 1e4)), st.floats(0.0, 1e4))
def test_the_coarsest_grid_keeps_the_tolerance_and_no_coarser_one_of_its_columns_does(tolerance, rings, columns):
    rings, columns = tolerance * rings, tolerance * columns
    n_zenith, n_azimuth = function_sky._coarsest(tolerance, rings, columns)

    def error(n_rings, n_columns):
        return rings / n_rings**2 + columns / n_columns**2

    assert error(n_zenith, n_azimuth) <= tolerance * (1 + 1e-12)
    if n_zenith > 1:
        assert error(n_zenith - 1, n_azimuth) > tolerance * (1 - 1e-12)
    elif n_azimuth > 1:
        assert error(1, n_azimuth - 1) > tolerance * (1 - 1e-12)


def test_an_even_sky_needs_one_patch():
    refined = FunctionSky(lambda zenith, azimuth, nm: 1.0).refined(0.1)
    assert refined.patches.n_patches == 1
