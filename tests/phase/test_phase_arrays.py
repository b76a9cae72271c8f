"""What surrounds the formulas: precision, shapes, ranges, and the bits inside numba."""

import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.kernels.phase import jitted

R, H, S = sky.rayleigh, sky.henyey_greenstein, sky.scattering
RNG = np.random.default_rng(11)
XI = np.concatenate([[0.0, 0.5, 1.0, 2.0**-53, 1 - 2.0**-53], RNG.random(2000)])
GAMMA = np.concatenate([[0.0, 1.0, 0.0144, 1 - 1e-10, 0.5], RNG.random(2000)])
G = np.concatenate([[0.0, -0.0, 1e-8, 1 - 1e-14, -1 + 1e-14], 2 * RNG.random(2000) - 1])


def test_precision_and_shape_of_the_results():
    assert isinstance(R.sample_mu(0.3, 0.1), np.float64)
    assert isinstance(R.sample_mu(np.float32(0.3), np.float32(0.1)), np.float32)
    assert R.sample_mu(np.float32([0.3]), 0.1).dtype == np.float32
    assert R.sample_mu(np.float16([0.5]), 0.1).dtype == np.float32
    assert R.sample_mu(np.float32([0.3]), np.float64([0.1])).dtype == np.float64
    assert R.sample_mu(np.array([0, 1]), 1).tolist() == [-1.0, 1.0]
    assert R.sample_mu([[0.1], [0.2], [0.3]], [0.0, 1.0]).shape == (3, 2)
    assert H.sample_mu_sin(np.empty((0, 3)), 0.5)[2].shape == (0, 3)
    assert H.pdf_sr(np.zeros((2, 1)), np.zeros((1, 4))).shape == (2, 4)


def test_blocks_do_not_show():
    xi = RNG.random((3, 10_001))
    gamma = RNG.random((3, 1))
    whole = R.sample_mu(xi, gamma)
    assert np.array_equal(whole[1, ::997], [R.sample_mu(x, gamma[1, 0]) for x in xi[1, ::997]])
    assert np.array_equal(R.sample_mu(xi[:, ::-1], gamma), whole[:, ::-1])


def test_one_rounding_of_float64_is_the_float32_result():
    xi, gamma, g = XI.astype(np.float32), GAMMA.astype(np.float32), (0.999 * G).astype(np.float32)
    assert np.array_equal(R.sample_mu(xi, gamma), R.sample_mu(xi.astype(float), gamma.astype(float)).astype(np.float32))
    wide = [found.astype(np.float32) for found in H.sample_mu_sin(xi.astype(float), g.astype(float))]
    for found, rounded in zip(H.sample_mu_sin(xi, g), wide, strict=True):
        assert np.array_equal(found, rounded)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_the_bits_inside_numba_are_those_of_numpy(kind):
    xi, gamma, g = XI.astype(kind), GAMMA.astype(kind), (0.9999 * G).astype(kind)
    twice = xi + xi
    cases = [
        (jitted.rayleigh_sample_mu, R.sample_mu, xi, gamma),
        (jitted.rayleigh_pdf_mu, R.pdf_mu, 1 - twice, gamma),
        (jitted.rayleigh_cdf_mu, R.cdf_mu, 1 - twice, gamma),
        (jitted.hg_sample_mu, H.sample_mu, xi, g),
        (jitted.hg_pdf_sr, H.pdf_sr, twice, g),
        (jitted.hg_cdf, H.cdf, twice, g),
        (jitted.hg_survival, H.survival, twice, g),
    ]
    for inside, outside, first, second in cases:
        found = [inside(a, b) for a, b in zip(first, second, strict=True)]
        assert np.array_equal(np.array(found, dtype=kind), outside(first, second)), outside
    for inside, outside, second in (
        (jitted.rayleigh_sample_mu_sin, R.sample_mu_sin, gamma),
        (jitted.hg_sample_mu_sin, H.sample_mu_sin, g),
    ):
        found = np.array([inside(a, b) for a, b in zip(xi, second, strict=True)], dtype=kind)
        assert np.array_equal(found.T, outside(xi, second))


@numba.njit
def _walk(xi, share, g, out):
    x, y, z = xi.dtype.type(0), xi.dtype.type(0), xi.dtype.type(-1)
    for k in range(xi.size):
        _, v, s = jitted.hg_sample_mu_sin(xi[k], g)
        x, y, z = jitted.new_direction(x, y, z, v, s, share[k])
        out[k, 0], out[k, 1], out[k, 2] = x, y, z


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_a_walk_of_a_user(kind):
    xi, share = RNG.random((2, 500)).astype(kind)
    out = np.empty((500, 3), dtype=kind)
    g = kind(0.9)
    _walk(xi, share, g, out)
    at = (kind(0), kind(0), kind(-1))
    for k in range(500):
        _, v, s = H.sample_mu_sin(xi[k], g)
        at = S.new_direction(*at, v, s, share[k])
        assert np.array_equal(at, out[k])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: R.sample_mu(1.5, 0.1), r"xi must lie in 0 to 1; found .*1\.5"),
        (lambda: R.sample_mu(0.5, -0.01), r"gamma must lie in 0 to 1; found .*-0\.01"),
        (lambda: R.pdf_mu(1.01, 0.5), "mu must lie in -1 to 1"),
        (lambda: R.king_factor(0.75), "pole at gamma = 3/4"),
        (lambda: R.gamma_from_rho(1.2), "rho must lie in 0 to 1"),
        (lambda: R.gamma_from_king_factor(0.9), "the King factor must lie in 1 to"),
        (lambda: R.air_gamma(150.0), "wavelength_nm must lie in 200 to 1000"),
        (lambda: H.sample_mu(0.5, 1.0), "g must lie between -1 and 1, ends excluded"),
        (lambda: H.sample_mu(np.float32([0.5]), 1 - 1e-14), "after rounding to float32; give float64"),
        (lambda: H.pdf_sr(2.5, 0.5), "one_minus_mu must lie in 0 to 2"),
        (lambda: R.sample_mu(0.5 + 1j, 0.1), "expected real numbers"),
        (lambda: R.sample_mu("a", 0.1), "expected real numbers"),
        (lambda: R.sample_mu([0.1, 0.2], [0.1, 0.2, 0.3]), "broadcast"),
        (lambda: S.new_direction(0.0, 0.0, 0.9, 0.1, 0.1, 0.5), "unit vector"),
    ],
)
def test_outside_the_domain(call, words):
    with pytest.raises(sky.UsageError, match=words):
        call()


def test_nothing_heavy_is_loaded():
    code = (
        "import sys, aomc_sky as sky; sky.rayleigh.sample_mu(0.3, 0.1); sky.henyey_greenstein.sample_mu(0.3, 0.1);"
        "sky.scattering.new_direction(0, 0, 1, 0.1, 0.4, 0.2); print({'numba', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=Path.cwd())
    assert done.stdout.strip() == "set()"
