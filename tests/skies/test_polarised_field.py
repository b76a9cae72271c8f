"""Fields of I, Q and U: a vector code's sky against published rows, its photons, and what a flat sea reflects."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import aomc_sky as sky
from tests.support.fields import FROM_EAST
from tests.support.shared import DATA
from tests.support.stokes import DEFECTS

xarray = pytest.importorskip("xarray")
read = sky.TabulatedSky.from_xarray

MODES = np.genfromtxt(DATA / "polarised/rayleigh.csv", delimiter=",", names=True)
"""Of bench/polarised_field.py: sasktran2, molecules of optical depth 0.5, the cosine of the sun's zenith angle 0.2."""
SUN_AZIMUTH_DEG = 35.0

NATRAJ = np.array(
    [  # cosine of the zenith angle, azimuth from the sun, I, Q, U
        (0.10, 0.0, 0.13485741, -0.01538451, 0.0),
        (0.10, 90.0, 0.08801144, -0.05898050, 0.02077195),
        (0.10, 180.0, 0.13070302, -0.01123012, 0.0),
        (0.20, 0.0, 0.15838610, -0.01767297, 0.0),
        (0.20, 90.0, 0.10033646, -0.07022742, 0.02479837),
        (0.20, 180.0, 0.14846675, -0.00775363, 0.0),
        (0.52, 0.0, 0.12178394, -0.00542392, 0.0),
        (0.52, 90.0, 0.07796226, -0.05573965, 0.01823144),
        (0.52, 180.0, 0.10282324, 0.01353678, 0.0),
        (0.84, 0.0, 0.07348081, 0.01547851, 0.0),
        (0.84, 90.0, 0.05534670, -0.03883915, 0.00889191),
        (0.84, 180.0, 0.05854240, 0.03041692, 0.0),
    ]
)
"""Natraj, Li and Yung (2009), light that comes down; they have Q = I_r - I_l, so q = -Q / I here."""


def at(zenith_deg, turn_rad):
    """I, q, u by our signs at an angle counter-clockwise from the sun, (3, n, m), by splines of the modes."""
    spline = CubicSpline(MODES["zenith_deg"], np.stack([MODES[name] for name in MODES.dtype.names[1:]], axis=1))
    modes = spline(zenith_deg).T
    even, odd = np.cos(np.multiply.outer(range(3), turn_rad)), np.sin(np.multiply.outer((1, 2), turn_rad))
    i, q = (modes[part].T @ even for part in (slice(0, 3), slice(3, 6)))
    return i, q / i, -(modes[6:].T @ odd) / i  # U of sasktran2 is clockwise


NAMES = ("radiance", "radiance_q", "radiance_u")


def dataset(names=NAMES, sense=1.0, step_deg=5.0):
    """The sky with the signs of sasktran2 and azimuths of the map, counterclockwise or (-1) clockwise from the sun."""
    turn = np.arange(0.0, 360.0, step_deg)
    i, q, u = at(MODES["zenith_deg"], np.deg2rad(turn))
    coordinates = {
        "zenith": ("zenith", MODES["zenith_deg"], {"units": "deg"}),
        "azimuth": ("azimuth", sense * turn + SUN_AZIMUTH_DEG, {"units": "deg", **FROM_EAST}),
    }
    both = {name: (("zenith", "azimuth"), part) for name, part in zip(names, (i, q * i, -u * i), strict=True)}
    return xarray.Dataset(both, coordinates)


def model(field=None, **how):
    return read(dataset() if field is None else field, stokes_signs=(1, -1), **how)


def photons(made, n=1_000_000):
    batch = sky.Scene(wavebands=[550.0], n_photons=n, components=made).source(seed=11).photons()
    azimuth = np.arctan2(-batch.uy.astype(float), -batch.ux.astype(float)) - np.deg2rad(SUN_AZIMUTH_DEG)
    return np.arccos(-batch.uz.astype(float)), azimuth, np.stack([batch.q, batch.u]).astype(float)


def test_published_rows():
    """The table is within 2e-4 of them; means of patches whose middle is up to 0.4 degrees away within 1 % and 7e-3."""
    made, grid = model(), model().grid
    zenith, azimuth = np.rad2deg(np.arccos(NATRAJ[:, 0])), NATRAJ[:, 1] + SUN_AZIMUTH_DEG
    patch = grid.patch_of(zenith, azimuth)
    light = NATRAJ[:, 2]
    np.testing.assert_allclose(made.values[0, patch], light, rtol=0.01)
    found = np.stack([made.values_q[0, patch], made.values_u[0, patch]]) / made.values[0, patch]
    expected = np.stack([-NATRAJ[:, 3], NATRAJ[:, 4]]) / light
    np.testing.assert_allclose(found, expected, atol=7e-3)
    own = [at(z, np.deg2rad(a - SUN_AZIMUTH_DEG)) for z, a in zip(zenith, azimuth, strict=True)]
    np.testing.assert_allclose(np.array([one[0] for one in own]), light, rtol=2e-4)
    np.testing.assert_allclose(np.array([one[1:] for one in own]).T, expected, atol=1e-4)
    mirrored = grid.patch_of(zenith, 2 * SUN_AZIMUTH_DEG - azimuth)
    found_mirrored = made.values_u[0, mirrored] / made.values[0, mirrored]
    assert np.abs(found_mirrored - expected[1]).max() > 0.2
    for defect in DEFECTS.values():
        assert np.abs(np.stack(defect(*found)) - expected).max() > 0.2


def pulls(zenith, azimuth, stokes):
    """Means of q and u times modes of the azimuth over photons, less those of the field, in standard errors."""
    mu, weights = np.polynomial.legendre.leggauss(64)
    mu, weights = (mu + 1) / 2, weights / 2
    turn = np.deg2rad(np.arange(0.0, 360.0, 1.0))
    reach = np.rad2deg(np.arccos(mu)) <= 89.0  # the table ends at 88 degrees; the last degree has 1 % of the light
    i, *expected = at(np.rad2deg(np.arccos(mu[reach])), turn)
    flux = i * (mu * weights)[reach][:, None]
    inside = zenith < np.deg2rad(89.0)
    modes = [lambda a, k=k: np.cos(k * a) for k in range(3)] + [lambda a, k=k: np.sin(k * a) for k in (1, 2)]
    found = []
    for k, mode in ((k, mode) for k in (0, 1) for mode in modes):
        sample = (stokes[k] * mode(azimuth))[inside]
        truth = np.sum(flux * expected[k] * mode(turn)) / np.sum(flux)
        found.append(abs(sample.mean() - truth) / (sample.std() / np.sqrt(sample.size)))
    return np.array(found)


def test_a_million_photons_have_the_stokes_vectors_of_the_field():
    """Within 5 standard errors of independent photons; each planted defect is beyond 100."""
    zenith, azimuth, stokes = photons(model())
    assert pulls(zenith, azimuth, stokes).max() < 5
    for defect in DEFECTS.values():
        assert pulls(zenith, azimuth, np.stack(defect(*stokes))).max() > 100
    assert pulls(zenith, -azimuth, stokes).max() > 100


def test_a_clockwise_azimuth_turns_the_sign_of_u():
    """A field whose azimuths run the other way is the mirror image: q is the same, u changes its sign."""
    one, other = model(), read(dataset(sense=-1.0))
    zenith_deg, turn_deg = np.array([20.0, 60.0, 80.0]), np.array([30.0, 100.0, 250.0])
    patch = one.grid.patch_of(zenith_deg, turn_deg + SUN_AZIMUTH_DEG)
    mirrored = other.grid.patch_of(zenith_deg, SUN_AZIMUTH_DEG - turn_deg)
    np.testing.assert_allclose(one.values_q[0, patch], other.values_q[0, mirrored], atol=1e-6)
    np.testing.assert_allclose(one.values_u[0, patch], -other.values_u[0, mirrored], atol=1e-6)


SUN = {"sun_zenith_deg": np.rad2deg(np.arccos(0.2)), "sun_azimuth_deg": SUN_AZIMUTH_DEG}


def test_signs_that_are_not_those_of_the_sky_get_a_warning():
    model(**SUN)
    with pytest.warns(sky.InputWarning, match=r"^U: another sign .*\(--stokes-signs 1 -1\)"):
        read(dataset(), **SUN)
    both = dataset().assign(radiance_q=-dataset().radiance_q)
    with pytest.warns(sky.InputWarning, match=r"^Q and U: another sign .*\(--stokes-signs -1 -1\)"):
        read(both, **SUN)


def test_signs_that_are_offered_are_those_of_the_file():
    with pytest.warns(sky.InputWarning, match=r"^Q: another sign .*\(--stokes-signs 1 -1\)"):
        read(dataset(), stokes_signs=(-1, -1), **SUN)


def test_names_of_the_three_and_the_dimension_of_sasktran2():
    """I, Q and U of other names want their arguments, and the question says so; texts say nothing."""
    expected, plain = model(dataset(step_deg=30.0)), dataset(step_deg=30.0)
    odd = dataset(("I", "Q", "U"), step_deg=30.0)
    with pytest.raises(sky.SceneError, match=r"none of 3 variables has the name radiance: 'I', 'Q', 'U'; .*--variable"):
        model(odd)
    assert model(odd, variable="I", variable_q="Q", variable_u="U") == expected
    np.testing.assert_array_equal(model(plain.rename(radiance="L")).values_q, expected.values_q)
    stacked = xarray.concat([odd[name] for name in "UIQ"], dim="stokes").assign_coords(stokes=["U", "I", "Q"])
    assert model(stacked.rename("radiance")) == expected
    assert model(stacked.to_dataset(name="radiance")) == expected
    with pytest.raises(sky.SceneError, match="dimension 'stokes' of 3"):
        read(stacked.drop_vars("stokes").rename("radiance"))


def test_texts_of_q_and_u_are_quoted():
    made = dataset(step_deg=30.0)
    made.radiance_u.attrs["comment"] = "positive clockwise, seen along the ray"
    assert "positive clockwise" in " ".join(model(made).remarks)


def test_a_field_of_radiances_is_the_sky_that_it_was():
    """By its name alone, I is scalar: the same values, slopes and hash as a field without Q and U."""
    scalar = read(dataset()[["radiance"]])
    named = read(dataset(), variable="radiance")
    assert "not used: variables radiance_q, radiance_u" in named.remarks
    assert dataclasses.replace(named, remarks=scalar.remarks) == scalar
    assert named.values_q is None
    with pytest.raises(sky.UsageError, match="stokes_signs are for a field of Q and U"):
        model(variable="radiance")
    polarised = model()
    np.testing.assert_array_equal(polarised.values, scalar.values)
    np.testing.assert_array_equal(polarised.slope, scalar.slope)


def test_gaps_and_what_is_no_light_are_refused():
    field = dataset(step_deg=30.0)
    lines = field.stack(point=("zenith", "azimuth")).reset_index("point")
    assert model(lines) == model(field)
    holed, ranged = field.copy(deep=True), field.copy(deep=True)
    holed["radiance_q"][3, 4] = np.nan
    ranged["radiance_u"].attrs["valid_range"] = [-1e-3, 1e-3]
    missing, twice = lines.isel(point=slice(0, -1)), lines.isel(point=[0, *range(lines.sizes["point"])])
    for one in (holed, ranged, missing, twice):
        with pytest.raises(sky.SceneError, match="without gaps"):
            model(one)
    with pytest.raises(sky.SceneError, match="more polarised light"):
        model(field.assign(radiance_q=5 * field["radiance"]))
    absolute = field.assign(radiance=field["radiance"].assign_attrs(units="mW m-2 nm-1 sr-1"))
    for attributes in ({"units": "1"}, {"units": "%"}, {"units": "W m-2 nm-1 sr-1"}):
        with pytest.raises(sky.SceneError, match="give Q and U in the unit of I"):
            model(absolute.assign(radiance_q=field["radiance_q"].assign_attrs(attributes)))
    same = absolute.assign(radiance_q=field["radiance_q"].assign_attrs(units="mW/m2/nm/sr"))
    assert "of a degree up to 0.76" in model(same).remarks[-1]
    with pytest.raises(sky.UsageError, match="stokes_signs"):
        read(field, stokes_signs=(1, 2))
    with pytest.raises(sky.UsageError, match="belong together"):
        model(field, variable_q="radiance_q")
    with pytest.raises(sky.SceneError, match="no variable 'X'"):
        model(field, variable="radiance", variable_q="X", variable_u="radiance_u")
    with pytest.raises(sky.SceneError, match="want the dimensions"):
        model(field.assign(radiance_q=field["radiance_q"].isel(azimuth=0, drop=True)))


def test_fully_polarised_and_dark_patches():
    """Nothing is NaN where I is Q, or where no light comes from; the degree is at most 1."""
    field = dataset(step_deg=30.0)
    light = field["radiance"] * (field["azimuth"] < 200.0).drop_attrs()
    light.attrs.clear()
    stokes = model(field.assign(radiance=light, radiance_q=light, radiance_u=0.0 * light)).lower([550.0])[0].stokes
    assert np.isfinite(stokes).all()
    assert np.hypot(*np.moveaxis(stokes, -1, 0)).max() <= 1 + 1e-15
    assert set(np.round(stokes[..., 0].ravel(), 9)) == {0.0, 1.0}


INDEX = 1.34


def reflected(zenith, q):
    """Reflectance of a flat sea for unpolarised light, and that of light with q in the plane of incidence over it.

    The first row of the Mueller matrix of Fresnel: the plane of incidence is the meridian plane of the ray.
    """
    inner = np.arcsin(np.sin(zenith) / INDEX)
    across = (np.sin(zenith - inner) / np.sin(zenith + inner)) ** 2
    along = (np.tan(zenith - inner) / np.tan(zenith + inner)) ** 2
    return (along + across) / 2, 1 + q * (along - across) / (along + across)


def glint(made):
    """Least and largest ratio of polarised to unpolarised reflected light at 40 degrees, by azimuths of 10 degrees."""
    zenith, azimuth, (q, _) = photons(made, 300_000)
    seen = np.abs(np.rad2deg(zenith) - 40.0) < 2.0
    column = np.floor(np.mod(np.rad2deg(azimuth[seen]), 360.0) / 10.0).astype(int)
    share, ratio = reflected(zenith[seen], q[seen])
    ratios = np.bincount(column, share * ratio) / np.bincount(column, share)
    return ratios.min(), ratios.max()


def test_glint_of_a_flat_sea():
    """A sky of largest degree 0.65 and a sun at 61 degrees: 0.71 to 1.46 (Mobley 2015), 1 without polarisation."""
    sun = {"sun_zenith_deg": 61.0, "sun_azimuth_deg": SUN_AZIMUTH_DEG}
    made = {m: sky.PerezSky(epsilon=6.0, delta=0.1, polarisation=m and sky.RayleighPattern(max_degree=m), **sun)
            for m in (0.65, 0.3)}  # fmt: skip
    np.testing.assert_allclose(glint(made[0.65]), (0.71, 1.46), atol=0.01)
    assert np.abs(np.subtract(glint(made[0.3]), (0.71, 1.46))).min() > 0.1
    np.testing.assert_allclose(glint(model()), (0.464, 1.307), atol=0.01)  # the sun at 78 degrees, air alone


def test_how_far_rayleighs_pattern_is_from_a_vector_field():
    """As docs/howto/polarised.md says: what a flat sea reflects, and q, weighted by the light."""
    x, weight = np.polynomial.legendre.leggauss(40)
    zenith, turn = (x + 1) / 2 * np.deg2rad(87.9), np.linspace(0.0, 2 * np.pi, 144, endpoint=False)
    i, q, _ = at(np.rad2deg(zenith), turn)
    sun = {"sun_zenith_rad": float(np.arccos(0.2))}
    pattern, _ = sky.RayleighPattern(max_degree=0.75).stokes(zenith[:, None], turn[None], **sun)
    refracted = np.arcsin(np.sin(zenith) / 1.34)
    parallel = (np.tan(zenith - refracted) / np.tan(zenith + refracted)) ** 2
    across = (np.sin(zenith - refracted) / np.sin(zenith + refracted)) ** 2
    light = (weight * np.sin(zenith) * np.cos(zenith))[:, None] * i
    scalar = ((parallel + across) / 2) @ light
    factors = [1 + (((parallel - across) / 2) @ (one * light)).sum() / scalar.sum() for one in (q, pattern)]
    assert factors == pytest.approx([0.849, 0.892], abs=5e-4)
    assert np.sqrt(np.average((pattern - q) ** 2, weights=light)) == pytest.approx(0.073, abs=5e-4)
