"""The scattering step: angle, azimuth, unit length after a million steps, and the poles."""

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.kernels.phase import jitted

S, H = sky.scattering, sky.henyey_greenstein
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


def test_quarter_turns_are_exact():
    x, y, z = S.new_direction(0.0, 0.0, 1.0, 1.0, 1.0, np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    assert x.tolist() == [1, 0, -1, 0, 1]
    assert y.tolist() == [0, 1, 0, -1, 0]
    assert z.tolist() == [0, 0, 0, 0, 0]


def test_no_turn_and_full_turn():
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
