"""Degree and angle of polarisation as pictures: of all components of a patch, and of a run."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.pictures.source import source_picture

pytest.importorskip("matplotlib")

GRID = sky.PatchGrid.regular(4, 8)
RNG = np.random.default_rng(2)
VALUES = RNG.uniform(0.5, 1.5, (1, 32))
VALUES[0, 5] = 0.0
DEGREE, ANGLE = RNG.uniform(0.1, 0.9, 32), RNG.uniform(-89.0, 89.0, 32)
DEGREE[9] = 0.0


def table(**more):
    q, u = (VALUES * DEGREE * function(np.deg2rad(2 * ANGLE)) for function in (np.cos, np.sin))
    light = {"wavelength_nm": [550.0], "values": VALUES, "values_q": q, "values_u": u}
    return sky.TabulatedSky(**light, grid=GRID, weighting="projected", **more)


def scene(*components):
    return sky.Scene(wavebands=[550.0], n_photons=1000, components=components)


def values(*components, show):
    return source_picture(scene(*components).source(), show=show).domes[0].values


def test_degree_and_angle_of_each_patch_and_none_without_polarisation():
    degree, angle = values(table(), show="dop"), values(table(), show="aop")
    lit, polarised = np.arange(32) != 5, ~np.isin(np.arange(32), (5, 9))
    np.testing.assert_allclose(degree[lit], DEGREE[lit], atol=1e-14)
    np.testing.assert_allclose(angle[polarised], ANGLE[polarised], atol=1e-10)
    assert np.isnan(degree[5])
    assert np.isnan(angle[~polarised]).all()
    with pytest.raises(sky.UsageError, match="has no polarisation"):
        sky.plot(scene(sky.UniformSky()), show="dop")


def test_light_without_polarisation_lowers_the_degree():
    """A uniform sky of the same irradiance: the degree follows from the radiances of both; a beam does not count."""
    light = VALUES[0] / (VALUES[0] @ GRID.projected_solid_angle_sr)
    both = table(strength=1.0), sky.UniformSky(strength=1.0)
    degree = values(*both, sky.DirectBeam(sun_zenith_deg=30.0, strength=1.0), show="dop")
    fine = source_picture(scene(*both).source(), show="dop").domes[0].grid
    centres = (b.mean(axis=1) for b in (fine.zenith_bounds_deg, fine.azimuth_bounds_deg))
    patch = GRID.patch_of(*np.meshgrid(*centres, indexing="ij")).ravel()
    np.testing.assert_allclose(degree, (DEGREE * light / (light + 1 / np.pi))[patch], rtol=1e-12)


def test_the_colours_do_not_depend_on_the_values(tmp_path):
    """The whole bar, as a neighbour's picture; a dark patch has no colour, one of degree 0 has."""
    for show, span in (("dop", (0.0, 1.0)), ("aop", (-90.0, 90.0))):
        figure = sky.plot(scene(table()), tmp_path / f"{show}.png", show=show)
        mesh = figure.axes[0].collections[0]
        assert mesh.get_clim() == span
        assert int(mesh.get_array().mask.sum()) == (1 if show == "dop" else 2) * 23  # columns of 45 degrees in 2
        with pytest.raises(sky.UsageError, match="norm must be one of linear"):
            sky.plot(scene(table()), show=show, norm="log")
