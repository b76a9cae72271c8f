"""Our elementary functions against 50-digit arithmetic: the errors that their docstrings state; compiled alike."""

import numba
import numpy as np
import pytest
from mpmath import mp, mpf

from aomc_sky.kernels.arithmetic import elementary
from aomc_sky.kernels.jit import shared

JIT = not numba.config.DISABLE_JIT
N = 1500 if JIT else 300


@shared
def compiled_turned(t0, t1, half, v):
    return elementary.sincos_turned_any(t0, t1, half, v)


@shared
def compiled_log(x):
    return elementary.log_level(x)


@shared
def compiled_exp(x):
    return elementary.exp_level(x)


@shared
def compiled_unit(bits, like):
    return elementary.unit(bits, like)


def ulps(got, true, dtype):
    """Error in units of the last place of the true value."""
    spacing = mpf(float(np.spacing(np.abs(dtype(float(true)))))) or mpf(float(np.finfo(dtype).smallest_subnormal))
    return float(abs(mpf(float(got)) - true) / spacing)


@pytest.mark.parametrize(("dtype", "limit"), [(np.float32, 2.0), (np.float64, 1.5)])
def test_sincos_quarter(dtype, limit):
    rng = np.random.default_rng(3)
    hard = [0.0, 0.5, -0.5, np.nextafter(dtype(0.5), dtype(0)), 1e-30, -1e-8, 0.25]
    points = np.concatenate([np.array(hard, dtype), rng.uniform(-0.5, 0.5, N).astype(dtype)])
    worst = 0.0
    with mp.workdps(50):
        for r in points:
            s, c = elementary.sincos_quarter(r)
            angle = mpf(float(r)) * mp.pi / 2
            if float(r) != 0:
                worst = max(worst, ulps(s, mp.sin(angle), dtype))
            worst = max(worst, ulps(c, mp.cos(angle), dtype))
    assert worst < limit
    s, c = elementary.sincos_quarter(dtype(0))
    assert (float(s), float(c)) == (0.0, 1.0)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_wide_and_narrow_cells_agree_and_whole_turns_are_exact_to_two_ulp(dtype):
    rng = np.random.default_rng(4)
    eps = float(np.finfo(dtype).eps)
    with mp.workdps(40):
        for _ in range(N // 3):
            widest = rng.choice([1 / 60, 0.5, 2.0])
            centre, half, v = rng.uniform(0, 2 * np.pi), dtype(rng.uniform(0, widest)), dtype(rng.random())
            t0, t1 = dtype(np.sin(centre)), dtype(np.cos(centre))
            sine, cosine = elementary.sincos_turned_any(t0, t1, half, v)
            if half <= 0.5:
                is_narrow = half <= dtype(elementary.NARROW_HALF_WIDTH)
                turned = elementary.sincos_turned_narrow if is_narrow else elementary.sincos_turned
                assert turned(t0, t1, half, v) == (sine, cosine)
            offset = mpf(float(half)) * (2 * mpf(float(v)) - 1) * mp.pi / 2
            true_s = mpf(float(t0)) * mp.cos(offset) + mpf(float(t1)) * mp.sin(offset)
            true_c = mpf(float(t1)) * mp.cos(offset) - mpf(float(t0)) * mp.sin(offset)
            assert abs(mpf(float(sine)) - true_s) < 3 * eps
            assert abs(mpf(float(cosine)) - true_c) < 3 * eps


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_compiled_sincos_is_equal(dtype):
    rng = np.random.default_rng(5)
    n = 200
    centre = rng.uniform(0, 2 * np.pi, n)
    t0, t1 = np.sin(centre).astype(dtype), np.cos(centre).astype(dtype)
    limit = dtype(elementary.NARROW_HALF_WIDTH)
    half, v = rng.uniform(0, rng.choice([1 / 60, 2.0], n)).astype(dtype), rng.random(n).astype(dtype)
    half[:3] = limit, np.nextafter(limit, dtype(1)), 0.0
    s, c = elementary.sincos_turned_any(t0, t1, half, v)
    assert s.dtype == c.dtype == dtype
    for j in range(n):
        assert compiled_turned(t0[j], t1[j], half[j], v[j]) == (s[j], c[j])
    narrow = np.flatnonzero(half <= limit)
    found = elementary.sincos_turned_narrow(t0[narrow], t1[narrow], half[narrow], v[narrow])
    np.testing.assert_array_equal(found, (s[narrow], c[narrow]))


@pytest.mark.parametrize(("dtype", "limit"), [(np.float32, 0.7), (np.float64, 0.7)])
def test_the_short_series_is_good_to_an_ulp_of_one_up_to_its_limit(dtype, limit):
    eps = float(np.finfo(dtype).eps)
    points = np.linspace(-elementary.NARROW_HALF_WIDTH, elementary.NARROW_HALF_WIDTH, 401).astype(dtype)
    with mp.workdps(40):
        for r in points:
            s, c = elementary.sincos_narrow(r)
            angle = mpf(float(r)) * mp.pi / 2
            assert abs(mpf(float(c)) - mp.cos(angle)) < limit * eps
            assert abs(mpf(float(s)) - mp.sin(angle)) <= 2 * eps * abs(mp.sin(angle))


def test_unit_never_reaches_one():
    ends = np.array([0, 1, 2**40 - 1, 2**63, 2**64 - 1], dtype=np.uint64)
    for bits in ends:
        for dtype, steps in ((np.float32, 24), (np.float64, 53)):
            u = elementary.unit(bits, dtype(0))
            assert isinstance(u, (float, np.floating))
            assert 0 <= u < 1
            assert float(u) == (int(bits) >> (64 - steps)) / 2**steps
            assert compiled_unit(bits, dtype(0)) == u


def test_log_and_exp():
    rng = np.random.default_rng(6)
    values = [1.0, 2.0, 0.5, np.sqrt(0.5), np.nextafter(1, 0), np.nextafter(1, 2), 1e-300, 1e300, 2.0**-1022]
    logs = np.concatenate([values, np.exp(rng.uniform(-600, 600, N)), 1 + rng.uniform(-0.3, 0.4, N)])
    exps = np.concatenate([[0.0, 1.0, -1.0, 700.0, -700.0, 1e-20], rng.uniform(-700, 700, N), rng.uniform(-1, 1, N)])
    with mp.workdps(40):
        worst = max(ulps(compiled_log(x), mp.log(mpf(float(x))), np.float64) for x in logs if x != 1)
        assert worst < 1.0
        worst = max(ulps(compiled_exp(x), mp.exp(mpf(float(x))), np.float64) for x in exps)
        assert worst < 1.0
    assert compiled_log(np.float64(1.0)) == 0.0
    assert compiled_exp(np.float64(0.0)) == 1.0
    assert compiled_exp(np.float64(-800.0)) == compiled_exp(np.float64(-700.0))
