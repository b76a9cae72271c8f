"""What surrounds the formulas: precision, shapes, ranges, the bits inside numba, and the scattering step."""

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


def test_precision_shapes_and_blocks():
    assert isinstance(R.sample_mu(0.3, 0.1), np.float64)
    assert isinstance(R.sample_mu(np.float32(0.3), np.float32(0.1)), np.float32)
    assert R.sample_mu(np.float32([0.3]), 0.1).dtype == np.float32
    assert R.sample_mu(np.float16([0.5]), 0.1).dtype == np.float32
    assert R.sample_mu(np.float32([0.3]), np.float64([0.1])).dtype == np.float64
    assert R.sample_mu(np.array([0, 1]), 1).tolist() == [-1.0, 1.0]
    assert R.sample_mu([[0.1], [0.2], [0.3]], [0.0, 1.0]).shape == (3, 2)
    assert H.sample_mu_sin(np.empty((0, 3)), 0.5)[2].shape == (0, 3)
    assert H.pdf_sr(np.zeros((2, 1)), np.zeros((1, 4))).shape == (2, 4)
    xi = RNG.random((3, 10_001))
    gamma = RNG.random((3, 1))
    whole = R.sample_mu(xi, gamma)
    assert np.array_equal(whole[1, ::997], [R.sample_mu(x, gamma[1, 0]) for x in xi[1, ::997]])
    assert np.array_equal(R.sample_mu(xi[:, ::-1], gamma), whole[:, ::-1])
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
    xi, share = RNG.random((2, 500)).astype(kind)
    out = np.empty((500, 3), dtype=kind)
    g = kind(0.9)
    _walk(xi, share, g, out)
    at = (kind(0), kind(0), kind(-1))
    for k in range(500):
        _, v, s = H.sample_mu_sin(xi[k], g)
        at = S.new_direction(*at, v, s, share[k])
        assert np.array_equal(at, out[k])


@numba.njit
def _walk(xi, share, g, out):
    x, y, z = xi.dtype.type(0), xi.dtype.type(0), xi.dtype.type(-1)
    for k in range(xi.size):
        _, v, s = jitted.hg_sample_mu_sin(xi[k], g)
        x, y, z = jitted.new_direction(x, y, z, v, s, share[k])
        out[k, 0], out[k, 1], out[k, 2] = x, y, z


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


EPS = {np.float64: 2.0**-52, np.float32: 2.0**-23}
STEPS = 1_000_000


def length_error(u):
    """Length less 1, in ulp of 1 of the precision of u; worked out with more digits."""
    wide = [c.astype(np.longdouble) for c in u]
    return np.abs(np.sqrt(wide[0] ** 2 + wide[1] ** 2 + wide[2] ** 2) - 1).astype(float) / EPS[u[0].dtype.type]


def directions(n, seed=1):
    rng = np.random.default_rng(seed)
    z = 2 * rng.random(n) - 1
    a = 2 * np.pi * rng.random(n)
    r = np.sqrt(1 - z * z)
    u = np.stack([r * np.cos(a), r * np.sin(a), z])
    special = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, -0.0], [0, -1, 0], [1e-9, 0, -1]]).T
    return np.concatenate([special, u], axis=1)


@pytest.mark.parametrize("g", [-0.9, 0.0, 0.9, 0.99999, 1 - 1e-12])
def test_angle_and_azimuth(g):
    u = directions(3000)
    rng = np.random.default_rng(2)
    mu, v, s = H.sample_mu_sin(rng.random(u.shape[1]), g)
    share = rng.random(u.shape[1])
    new = np.stack(S.new_direction(*u, v, s, share))
    assert np.abs((u * new).sum(axis=0) - mu).max() < 2e-15
    # the distance of the two ends is 2 sin(theta / 2): it keeps the digits of a small angle
    assert np.abs(np.linalg.norm(new - u, axis=0) - np.sqrt(2 * v)).max() < 1e-15
    # a quarter turn of azimuth further: at right angles around the old direction
    other = np.stack(S.new_direction(*u, v, s, (share + 0.25) % 1.0))
    across = ((new - u * mu) * (other - u * mu)).sum(axis=0)
    assert np.all(np.abs(across) < 2e-15 * s + 1e-30)
    # right-handed: the azimuth grows in the same sense around every direction
    sense = np.einsum("ij,ij->j", np.cross(new, other, axis=0), u)
    big = s > 1e-5
    assert np.all(sense[big] > 0.5 * (s * s)[big])


def test_quarter_turns_no_turn_and_full_turn():
    x, y, z = S.new_direction(0.0, 0.0, 1.0, 1.0, 1.0, np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    assert x.tolist() == [1, 0, -1, 0, 1]
    assert y.tolist() == [0, 1, 0, -1, 0]
    assert z.tolist() == [0, 0, 0, 0, 0]
    u = directions(1000)
    same = np.stack(S.new_direction(*u, 0.0, 0.0, 0.3))
    assert np.abs(same - u).max() <= 2.0**-52
    back = np.stack(S.new_direction(*u, 2.0, 0.0, 0.3))
    assert np.abs(back + u).max() <= 2.0**-52


@numba.njit
def _million(draws, g, polar, out):
    """Largest departure of the squared length from 1 on the way, and the last direction."""
    kind = out.dtype.type
    x, y, z = kind(0), kind(0), kind(1)
    worst = 0.0
    for step in range(STEPS):
        _, v, s = jitted.hg_sample_mu_sin(draws[0, step], g)
        if polar and step % 2 == 0:
            # out of the pole and back again, over and over
            v, s = kind(2) * kind(step % 4 == 0), kind(0)
        x, y, z = jitted.new_direction(x, y, z, v, s, draws[1, step])
        n2 = (np.float64(x) * x - 1.0) + np.float64(y) * y + np.float64(z) * z
        worst = max(worst, abs(n2))
    out[0], out[1], out[2] = x, y, z
    return worst


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize(("g", "polar"), [(0.0, False), (0.9, False), (0.99999, False), (0.99999, True)])
def test_length_after_a_million_steps(kind, g, polar):
    out = np.empty(3, dtype=kind)
    draws = np.random.default_rng(5).random((2, STEPS), dtype=kind)
    worst = _million(draws, kind(g), polar, out)
    assert worst <= 2 * 4 * EPS[kind]  # n^2 - 1 is twice n - 1
    assert length_error(out)[()] <= 4


def test_textbook_step_drifts():
    """The step without bringing the length back fails the bound that ours keeps."""
    rng = np.random.default_rng(9)
    x, y, z = np.zeros(100), np.zeros(100), np.ones(100)
    for _ in range(3000):
        mu = (2 * rng.random(100) - 1).astype(np.float32).astype(float)
        a = 2 * np.pi * rng.random(100)
        s, c, n = np.sqrt(1 - mu * mu), np.cos(a), np.sin(a)
        r = np.sqrt(np.maximum(1 - z * z, 1e-300))
        x, y, z = (
            s * (x * z * c - y * n) / r + x * mu,
            s * (y * z * c + x * n) / r + y * mu,
            -s * c * r + z * mu,
        )
    assert length_error([x, y, z]).max() > 4


@pytest.mark.parametrize("long", [-9e-4, 0.0, 9e-4])
def test_a_step_brings_the_length_back_to_second_order(long):
    """By 3/2 - length^2 / 2: an error e of the length becomes 3/2 e^2, and tangents off by e make it a little more."""
    direction = RNG.normal(size=(3, 1000))
    direction *= (1 + long) / np.linalg.norm(direction, axis=0)
    _, one_minus_mu, sin_theta = R.sample_mu_sin(RNG.random(1000), 0.03)
    after = S.new_direction(*direction, one_minus_mu, sin_theta, RNG.random(1000))
    np.testing.assert_allclose(np.linalg.norm(after, axis=0), 1.0, rtol=0, atol=6 * long**2 + 1e-15)
