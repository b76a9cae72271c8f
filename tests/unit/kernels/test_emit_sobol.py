"""The compiled Sobol emission equals its plain form to the bit, and any range or start gives the same photons."""

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import Law
from tests.support.sobol_scenes import grid_component, scenes, source_of

JIT = not numba.config.DISABLE_JIT
N = 9001 if JIT else 150


def photons(source, start, stop, way):
    """Photons [start, stop) of the first band, compiled or plain."""
    kinds = {"ux": source.dtype, "uy": source.dtype, "uz": source.dtype, "patch": np.int32}
    arrays = {name: np.empty(stop - start, kind) for name, kind in kinds.items()}
    with np.errstate(over="ignore"):
        getattr(source._emitter, f"fill_{way}")(0, start, arrays)
    return arrays


def assert_same(one, other, part=slice(None)):
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name][part], err_msg=name)


DOUBLE = ("table", "tiny masses", "beam and perez", "four components")
SLOW = {("perez in narrow cells", "float32"), ("beam and perez", "float64")}
"""Forms of the kernel that take the compiler longest; the same laws are in other cases."""

CASES = [
    pytest.param(*case, marks=[pytest.mark.slow] if case in SLOW else [])
    for case in [(name, "float32") for name in scenes()] + [(name, "float64") for name in DOUBLE]
]


@pytest.mark.parametrize(("name", "precision"), CASES)
def test_compiled_equals_plain(name, precision):
    source = source_of(name, N, precision=precision)
    whole = photons(source, 0, N, "compiled")
    assert_same(whole, photons(source, 0, N, "plain"))
    np.testing.assert_array_equal(np.bincount(whole["patch"], minlength=source.plan.n_cells), source.counts[0])
    norm = sum(whole[axis].astype(float) ** 2 for axis in ("ux", "uy", "uz"))
    np.testing.assert_allclose(norm, 1.0, atol=6e-7 if precision == "float32" else 1.2e-15)
    for start, stop in ((0, 1), (1, 2), (2047, 2050), (N // 3, N // 2), (N - 1, N)):
        if stop <= N:
            assert_same(photons(source, start, stop, "compiled"), whole, slice(start, stop))
            assert_same(photons(source, start, stop, "plain"), whole, slice(start, stop))


@pytest.mark.skipif(not JIT, reason="two million photons")
def test_deep_levels_equal_plain():
    """More photons than 2^20: the sixth group of levels, and ranges far inside."""
    source = source_of("beam and table", 2_500_000)
    for start in (0, 2**20 - 5, 2**21 - 5, 2_500_000 - 3000):
        assert_same(photons(source, start, start + 3000, "compiled"), photons(source, start, start + 3000, "plain"))


@pytest.mark.parametrize("n", [1, 2, 3, 16, 17, 4096, 4097])
def test_any_number_of_photons(n):
    if not JIT and n > 100:
        pytest.skip("slow without the JIT")
    source = source_of("beam and table", n)
    whole = photons(source, 0, n, "compiled")
    assert_same(whole, photons(source, 0, n, "plain"))
    np.testing.assert_array_equal(np.bincount(whole["patch"], minlength=source.plan.n_cells), source.counts[0])
    assert source.counts.sum() == n


def test_counts_compiled_and_plain_agree(monkeypatch):
    """The counts of a plan are the same whichever form settles them."""
    from aomc_sky.source import sobol_plan

    found = []
    for compiled in (False, True):
        monkeypatch.setattr(sobol_plan, "use_kernels", lambda n, c=compiled: c)
        with np.errstate(over="ignore"):
            found.append([source_of(name, N).counts for name in ("table", "beam and table", "four components")])
    for plain, kernel in zip(*found, strict=True):
        np.testing.assert_array_equal(plain, kernel)


def test_all_cells_of_two_laws():
    """Cells uniform in mu, with a beam beside them, take the other formula."""
    parts = (*sky.DirectBeam(sun_zenith_deg=35, sun_azimuth_deg=200).lower(500), grid_component(Law.CELL_MU))
    scene = sky.Scene(wavebands=sky.Wavebands(wavelength_nm=np.array([500.0])), n_photons=N, components=parts)
    source = scene.source(seed=2, method="sobol")
    assert_same(photons(source, 0, N, "compiled"), photons(source, 0, N, "plain"))
