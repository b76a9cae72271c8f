"""Our elementary functions compiled and as numpy runs them: the same bits. Their errors: test_stated_errors.py."""

import numpy as np
import pytest

from aomc_sky.kernels.arithmetic import elementary
from aomc_sky.kernels.jit import shared


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


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_turns_in_cells_of_any_width(dtype):
    """One text for all widths, and those for narrow cells and for cells of at most 90 degrees, give the same bits."""
    rng = np.random.default_rng(5)
    n = 300
    centre = rng.uniform(0, 2 * np.pi, n)
    t0, t1 = np.sin(centre).astype(dtype), np.cos(centre).astype(dtype)
    limit = dtype(elementary.NARROW_HALF_WIDTH)
    half, v = rng.uniform(0, rng.choice([1 / 60, 0.5, 2.0], n)).astype(dtype), rng.random(n).astype(dtype)
    half[:3] = limit, np.nextafter(limit, dtype(1)), 0.0
    s, c = elementary.sincos_turned_any(t0, t1, half, v)
    assert s.dtype == c.dtype == dtype
    for j in range(n):
        assert compiled_turned(t0[j], t1[j], half[j], v[j]) == (s[j], c[j])
    for turned, some in (
        (elementary.sincos_turned_narrow, half <= limit),
        (elementary.sincos_turned, (half > limit) & (half <= 0.5)),
    ):
        assert some.sum() > 50
        np.testing.assert_array_equal(turned(t0[some], t1[some], half[some], v[some]), (s[some], c[some]))


def test_unit_log_and_exp():
    ends = np.array([0, 1, 2**40 - 1, 2**63, 2**64 - 1], dtype=np.uint64)
    for bits in ends:
        for dtype, steps in ((np.float32, 24), (np.float64, 53)):
            u = elementary.unit(bits, dtype(0))
            assert isinstance(u, (float, np.floating))
            assert 0 <= u < 1
            assert float(u) == (int(bits) >> (64 - steps)) / 2**steps
            assert compiled_unit(bits, dtype(0)) == u
    rng = np.random.default_rng(6)
    hard = [1.0, 2.0, 0.5, np.sqrt(0.5), np.nextafter(1, 0), np.nextafter(1, 2), 1e-300, 1e300, 2.0**-1022]
    for x in (*hard, *np.exp(rng.uniform(-600, 600, 100))):
        assert compiled_log(np.float64(x)) == elementary.log_level(np.float64(x))
    for x in (0.0, 700.0, -700.0, 1e-20, *rng.uniform(-700, 700, 100)):
        assert compiled_exp(np.float64(x)) == elementary.exp_level(np.float64(x))
    assert compiled_log(np.float64(1.0)) == 0.0
    assert compiled_exp(np.float64(0.0)) == 1.0
    assert compiled_exp(np.float64(-800.0)) == compiled_exp(np.float64(-700.0))
