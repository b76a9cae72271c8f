"""Stokes vectors of patches in plans, batches and tables; a scene without them has the bytes that it had."""

import dataclasses
import pickle

import numpy as np
import pytest

import aomc_sky as sky

GRID = sky.PatchGrid.regular(6, 9)
NM = [450.0, 550.0]


def table(**more):
    """Two wavelengths of 54 patches, one of them dark, with any polarisation."""
    rng = np.random.default_rng(3)
    values = rng.lognormal(0, 1, (2, 54))
    values[:, 7] = 0.0
    degree, angle = rng.uniform(0, 1, (2, 54)), rng.uniform(0, 2 * np.pi, (2, 54))
    q, u = values * degree * np.cos(angle), values * degree * np.sin(angle)
    more = {"weighting": "projected", "values_q": q, "values_u": u, **more}
    return sky.TabulatedSky(wavelength_nm=NM, values=values, grid=GRID, **more)


def source_of(*components, n=20_000, seed=7, wavebands=NM, **more):
    scene = sky.Scene(wavebands=wavebands, n_photons=n, components=components)
    return scene.source(seed=seed, **more)


@pytest.mark.parametrize("weighting", ["projected", "listed", "solid-angle"])
def test_photons_have_the_stokes_vector_of_their_patch(weighting):
    model = table(weighting=weighting)
    source = source_of(model)
    for band in (0, 1):
        batch = source.photons(band)
        expected = np.stack([model.values_q[band], model.values_u[band]]) / np.maximum(model.values[band], 1e-300)
        np.testing.assert_allclose(source.stokes(band).T, expected, rtol=1e-15)
        np.testing.assert_array_equal(np.stack([batch.q, batch.u]), expected.astype(np.float32)[:, batch.patch])
        assert not source.stokes(band)[7].any()


def test_parts_and_batches():
    sun = {"sun_zenith_deg": 30.0, "sun_azimuth_deg": 10.0}
    beam, disc = sky.DirectBeam(**sun, strength=2.0), sky.UniformSky(strength=1.0)
    pattern = sky.PerezSky(epsilon=4.0, delta=0.1, **sun, strength=1.0, polarisation=sky.RayleighPattern())
    source = source_of(beam, disc, pattern)
    start, batch = source.plan.component_start, source.photons(1)
    is_polarised = batch.patch >= start[2]
    assert 0.2 < is_polarised.mean() < 0.3
    assert not batch.q[~is_polarised].any()
    assert not batch.u[~is_polarised].any()
    assert np.hypot(batch.q, batch.u)[is_polarised].min() > 0
    assert source.stokes(1).shape == (source.plan.n_cells, 2)
    source = source_of(table())
    whole = source.photons(1)
    assert pickle.loads(pickle.dumps(source)).photons(1) == whole
    assert {"q", "u"} <= set(whole.to_dict())
    assert "q, u" in repr(whole)
    with pytest.raises(ValueError, match=r"out\.q"):
        source.photons(1, out=source_of(table(values_q=None, values_u=None)).photons(1))
    values = np.ones((1, 54))
    model = sky.TabulatedSky(
        wavelength_nm=[550.0], values=values, grid=GRID, values_q=0.6 * values * (1 + 4e-7), values_u=0.8 * values
    )
    stokes = source_of(model, wavebands=[550.0]).stokes()
    assert np.hypot(*stokes.T).max() <= 1 + 1e-15
    np.testing.assert_allclose(stokes[0], [0.6, 0.8], rtol=1e-6)


def test_photons_and_plan_are_those_of_the_light_without_polarisation():
    """One more member of the plan, hashed; directions, patches and all other members are the same."""
    with_it, without = source_of(table()), source_of(table(values_q=None, values_u=None))
    members, plain = with_it.plan.members(), without.plan.members()
    assert set(members) == {*plain, "stokes_0"}
    for name, array in plain.items():
        np.testing.assert_array_equal(array, members[name])
    assert with_it.plan.sha256 != without.plan.sha256
    other = table()
    other = dataclasses.replace(other, values_u=-other.values_u)
    assert source_of(other).plan.sha256 != with_it.plan.sha256
    a, b = with_it.photons(1), without.photons(1)
    for name in ("ux", "uy", "uz", "patch"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert b.q is None
    assert b.u is None
    assert set(b.to_dict()) == {"ux", "uy", "uz", "patch"}
    assert not without.stokes(1).any()
    assert without.stokes(1).shape == (54, 2)


@pytest.mark.parametrize(
    ("more", "error", "text"),
    [
        ({"values_u": None}, sky.UsageError, "belong together"),
        ({"values_q": np.full((2, 54), 1e9)}, sky.SceneError, "more polarised light"),
        ({"values_q": np.full((2, 54), np.nan)}, sky.SceneError, "more polarised light"),
        ({"values_q": np.zeros((2, 9))}, ValueError, "wants the shape"),
    ],
)
def test_tables_that_are_no_light_are_refused(more, error, text):
    with pytest.raises(error, match=text):
        table(**more)


@pytest.mark.parametrize(
    "stokes",
    [np.zeros((2, 54)), np.zeros((3, 54, 2)), *(np.full((2, 54, 2), value) for value in (np.nan, 0.8, -1e300))],
)
def test_components_want_rows_of_all_cells_and_degrees_up_to_one(stokes):
    (component,) = table().lower(NM)
    with pytest.raises(ValueError, match=r"stokes|degree from 0 to 1"):
        dataclasses.replace(component, stokes=stokes)
