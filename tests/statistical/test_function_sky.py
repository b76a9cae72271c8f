"""Independent photons of functions against laws of their own, in closed form or by another quadrature."""

import numpy as np
import pytest
from scipy import integrate
from scipy.special import erf

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import grid_of_edges, sky_angles

N = 300_000
SPOT_RAD, SPOT_ZENITH, SPOT_AZIMUTH = np.deg2rad(1.0), 0.7, 2.0


def bright_zenith(z, a, nm):
    return 1 + 2 * np.cos(z) ** 2


def tangent_spot(z, a, nm):
    """A Gaussian of one degree in the plane that touches the sphere in its middle, per projected area."""
    x, y, w = _in_frame_of_the_spot(z, a)
    inside = w > 0.5
    safe = np.where(inside, w, 1.0)
    return np.where(
        inside, np.exp(-(x * x + y * y) / safe**2 / 2 / SPOT_RAD**2) / safe**3 / np.maximum(np.cos(z), 1e-9), 0.0
    )


def _in_frame_of_the_spot(z, a):
    px, py, pz = np.sin(z) * np.cos(a - SPOT_AZIMUTH), np.sin(z) * np.sin(a - SPOT_AZIMUTH), np.cos(z)
    sine, cosine = np.sin(SPOT_ZENITH), np.cos(SPOT_ZENITH)
    return px * cosine - pz * sine, py, px * sine + pz * cosine


def split_sky(z, a, nm):
    return np.where(a < 1.0, 1.0, 0.25)


def reddening(z, a, nm):
    return 1 + nm / 500 * np.sin(z) ** 2


def emitted(function, *, grid=None, nm=500.0):
    model = sky.FunctionSky(function, grid=grid)
    scene = sky.Scene(wavebands=[nm], n_photons=N, components=model)
    mu, sin2, azimuth_deg = sky_angles(scene.source(seed=11, method="iid", precision="float64").photons())
    return np.arctan2(np.sqrt(sin2), mu), np.deg2rad(azimuth_deg)


def ring_p(zenith, share_below):
    """Photons in 18 rings of 5 degrees, whose edges are those of patches, against a distribution function."""
    edges = np.deg2rad(np.arange(0, 91, 5.0))
    share = np.diff(share_below(edges))
    return chi2.chi2_p(np.histogram(zenith, edges)[0], share * N)


def test_a_bright_zenith(plan):
    zenith, _ = emitted(bright_zenith)
    plan.check(ring_p(zenith, lambda z: (2 - np.cos(z) ** 2 - np.cos(z) ** 4) / 2))
    plan.catches(ring_p(zenith, lambda z: np.sin(z) ** 2))


def spot_p(zenith, azimuth, width_rad):
    """A Gaussian in the plane that touches the sphere: both coordinates by their shares, 8 x 8 cells."""
    x, y, w = _in_frame_of_the_spot(zenith, azimuth)
    edges = np.linspace(-3, 3, 9) * SPOT_RAD
    cells = np.histogram2d(x / w, y / w, bins=(edges, edges))[0]
    share = np.diff(erf(edges / width_rad / np.sqrt(2))) / 2
    expected = np.append(np.outer(share, share).ravel(), 0.0) * N
    expected[-1] = N - expected.sum()
    return chi2.chi2_p(np.append(cells.ravel(), N - cells.sum()), expected)


def test_a_spot_of_one_degree(plan):
    """The edges of the cells are not those of patches: these are fine enough that they cannot be seen."""
    rings = np.rad2deg(SPOT_ZENITH) + np.linspace(-6, 6, 241)
    columns = np.rad2deg(SPOT_AZIMUTH) + np.linspace(-10, 10, 401)
    zenith, azimuth = emitted(tangent_spot, grid=grid_of_edges(rings, columns))
    plan.check(spot_p(zenith, azimuth, SPOT_RAD))
    plan.catches(spot_p(zenith, azimuth, 1.02 * SPOT_RAD))


def test_a_jump_at_an_azimuth(plan):
    """The jump lies inside a column of patches, so its cell takes the column whole."""
    _, azimuth = emitted(split_sky)
    edges = np.deg2rad(np.arange(0, 361, 20.0))

    def share(jump):
        total = 0.25 * 2 * np.pi + 0.75 * jump
        return np.diff(0.25 * edges + 0.75 * np.minimum(edges, jump)) / total

    counts = np.histogram(azimuth, edges)[0]
    plan.check(chi2.chi2_p(counts, share(1.0) * N))
    plan.catches(chi2.chi2_p(counts, share(1.02) * N))


@pytest.mark.parametrize("nm", [400.0, 700.0])
def test_a_function_of_wavelength(plan, nm):
    zenith, _ = emitted(reddening, nm=nm)

    def share_below(edges, at=nm):
        of = [integrate.quad(lambda z: reddening(z, 0, at) * np.cos(z) * np.sin(z), 0, edge)[0] for edge in edges]
        return np.array(of) / of[-1]

    plan.check(ring_p(zenith, share_below))
    plan.catches(ring_p(zenith, lambda edges: share_below(edges, at=1100 - nm)))


def leaning(z, a, nm):
    return np.exp(2 * np.sin(z) * np.cos(a - 0.3))


def test_photons_follow_the_function_inside_coarse_patches(plan):
    """Halves of patches of 10 x 15 degrees against the function; patches of constant radiance are found out."""
    grid = sky.PatchGrid.regular(9, 24)
    zenith, azimuth = emitted(leaning, grid=grid)
    fine = sky.PatchGrid.regular(18, 48)
    counts = np.bincount(fine.patch_of(np.rad2deg(zenith), np.rad2deg(azimuth)), minlength=fine.n_patches)
    own = sky.FunctionSky(leaning, grid=fine).lower([500.0])[0].mass[0]
    plan.check(chi2.chi2_p(counts, own / own.sum() * N))
    constant = np.kron(sky.FunctionSky(leaning, grid=grid).lower([500.0])[0].mass[0].reshape(9, 24), np.ones((2, 2)))
    area = fine.projected_solid_angle_sr.reshape(18, 48)
    share = area / np.kron(area.reshape(9, 2, 24, 2).sum(axis=(1, 3)), np.ones((2, 2)))
    expected = (constant * share).ravel()
    plan.catches(chi2.chi2_p(counts, expected / expected.sum() * N))
