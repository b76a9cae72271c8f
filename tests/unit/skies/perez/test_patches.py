"""Patch masses of the Perez sky: two independent routes, every special place of the sun, every kind of patch."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

from aomc_sky.grid import PatchGrid
from aomc_sky.kernels import backend
from aomc_sky.kernels.arithmetic.elementary import exp_level
from aomc_sky.kernels.jit import kernel
from aomc_sky.kernels.perez import mass
from aomc_sky.kernels.perez import sums as sums_compiled
from aomc_sky.kernels.perez.law import arc, first_factor, second_factor
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.patches import first_factor_zero, patch_integrals, second_factor_zeros
from aomc_sky.skies.perez.sky import PerezSky

EPSILONS = (1.0, 1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 8.0)
pytestmark = pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")


@kernel
def _each(which, x, out):
    for k in range(x.size):
        out[k] = arc(x[k]) if which == 0 else exp_level(x[k])


def ulps(found: np.ndarray, exact: list[mp.mpf]) -> float:
    return max(float(abs(mp.mpf(float(f)) - e)) / float(np.spacing(f)) for f, e in zip(found, exact, strict=True))


def test_exponential_and_arc_to_the_last_bits() -> None:
    rng = np.random.default_rng(3)
    x = np.concatenate([rng.uniform(-700, 700, 400), rng.uniform(-1, 1, 400), [0.0, -700.0, 700.0]])
    out = np.empty_like(x)
    _each(1, x, out)
    with mp.workdps(50):
        assert ulps(out, [mp.exp(mp.mpf(float(v))) for v in x]) < 1
    _each(1, np.array([-np.inf, -1e9, np.inf]), out[:3])
    np.testing.assert_allclose(out[:3], np.exp([-700.0, -700.0, 700.0]), rtol=1e-15)
    h = np.concatenate([rng.random(400), 10 ** rng.uniform(-30, 0, 400), [0.0, 0.25, 0.5, 0.75, 1.0]])
    out = np.empty_like(h)
    _each(0, h, out)
    with mp.workdps(50):
        assert ulps(out, [2 * mp.asin(mp.sqrt(mp.mpf(float(v)))) for v in h]) < 2.1


def test_factors_agree_with_the_numpy_form() -> None:
    a, b, c, d, e = -0.9, -0.3, 12.0, -4.0, 0.4
    for xi, phi, sun in ((0.2, 1.0, 0.7), (1.5, 3.0, 0.7), (0.7, 0.0, 0.7)):
        h = np.sin((xi - sun) / 2) ** 2 + np.sin(xi) * np.sin(sun) * np.sin(phi / 2) ** 2
        ours = first_factor(np.cos(xi), a, b) * second_factor(h, c, d, e)
        assert ours == pytest.approx(float(perez.relative_radiance(xi, phi, sun, [a, b, c, d, e])), rel=1e-14)
    assert first_factor(0.0, a, b) == 1
    assert first_factor(0.0, a, 0.0) == 1 + a


def test_zeros_of_the_factors() -> None:
    assert first_factor_zero(-0.5, -0.1) == -1
    assert first_factor_zero(-5.0, 0.0) == -1
    zero = first_factor_zero(-3.0, -0.5)
    assert 1 - 3 * np.exp(-0.5 / np.cos(zero * np.pi / 2)) == pytest.approx(0, abs=1e-14)
    assert second_factor_zeros(1.0, -1.0, 0.1).size == 0
    roots = second_factor_zeros(-3.0, -1.0, 0.0)
    assert 2 * np.arcsin(np.sqrt(roots)) == pytest.approx([np.log(3.0)], rel=1e-12)


@pytest.mark.parametrize("row", range(8))
@pytest.mark.parametrize("sun_deg", [0.0, 1e-7, 0.4, 10.0, 45.3, 89.0, 89.999])
def test_masses_add_up_to_the_integral_of_the_sky(row: int, sun_deg: float) -> None:
    sky = PerezSky(
        sun_zenith_rad=np.deg2rad(sun_deg), sun_azimuth_rad=1.0, epsilon=EPSILONS[row], delta=0.25 if row < 7 else 0.1
    )
    known = float(perez.horizontal_integral(sky.model_coefficients, sky.sun_zenith_rad))
    for grid in (PatchGrid.regular(1, 1), PatchGrid.regular(7, 9), PatchGrid.whole_degrees() if row == 7 else None):
        if grid is not None:
            assert sky._integrals(grid)[1] == pytest.approx(known, rel=1e-10)


@pytest.mark.parametrize(
    ("arguments", "sun_deg"),
    [
        ({"epsilon": 8.0, "delta": 0.03}, 30.0),
        ({"epsilon": 8.0, "delta": 0.09}, 88.7),
        ({"epsilon": 1.0, "delta": 0.5}, 89.9),
        ({"epsilon": 1.6, "delta": 0.6}, 5.0),  # dark around the sun
        ({"epsilon": 8.0, "delta": 0.8, "limits": "paper"}, 5.0),  # light beside the sun alone
        ({"epsilon": 1.1, "delta": 0.05, "limits": "paper"}, 60.0),  # dark overhead
        ({"coefficients": [-1.5, -0.4, 30.0, -90.0, 0.2]}, 33.3),  # an aureole of half a degree
        ({"coefficients": [-0.9, -1e-4, 5.0, -3.0, 0.2]}, 70.0),  # a layer of 0.006 degrees
    ],
)
def test_coarse_patches_are_sums_of_fine_ones(arguments: dict[str, object], sun_deg: float) -> None:
    sky = PerezSky(sun_zenith_rad=np.deg2rad(sun_deg), sun_azimuth_rad=np.deg2rad(123.4), **arguments)
    coarse = sky._integrals(PatchGrid.regular(9, 12))[0]
    fine = sky._integrals(PatchGrid.regular(45, 60))[0].reshape(9, 5, 12, 5).sum(axis=(1, 3)).ravel()
    np.testing.assert_allclose(coarse, fine, rtol=1e-9, atol=1e-12 * fine.sum())


@pytest.mark.parametrize(
    ("arguments", "sun_deg"),
    [
        ({"epsilon": 1.0, "delta": 0.2}, 45.3),
        ({"epsilon": 8.0, "delta": 0.03}, 0.4),
        ({"epsilon": 8.0, "delta": 0.09}, 0.0),
        ({"epsilon": 5.0, "delta": 0.15}, 89.99),
        ({"epsilon": 1.6, "delta": 0.6}, 5.0),
        ({"epsilon": 1.1, "delta": 0.05, "limits": "paper"}, 60.0),
        ({"coefficients": [-1.5, -0.4, 30.0, -90.0, 0.2]}, 33.3),
    ],
)
def test_plain_numpy_gives_the_same_bits(arguments: dict[str, object], sun_deg: float) -> None:
    for azimuth_deg in (17.3, 40.0):
        sky = PerezSky(sun_zenith_rad=np.deg2rad(sun_deg), sun_azimuth_rad=np.deg2rad(azimuth_deg), **arguments)
        grid = PatchGrid.regular(18, 36)
        edges = grid.zenith_bounds_deg / 90, grid.azimuth_bounds_deg / 90
        compiled = patch_integrals(*edges, sky._numbers(), sums_compiled)
        np.testing.assert_array_equal(patch_integrals(*edges, sky._numbers(), mass), compiled)


def test_aureoles_have_the_same_bits() -> None:
    h = np.random.default_rng(5).random(300)
    both = np.empty((2, h.size))
    for sums, out in zip((sums_compiled, mass), both, strict=True):
        sums.each_aureole(h, 12.0, -3.5, out)
    np.testing.assert_array_equal(both[0], both[1])
    # the angle is good to 2 ulp, beyond 120 degrees to 2 ulp of pi, the product to half of one: the exponent has that
    # error times its size, and the exponential adds 2 ulp of its own
    with mp.workdps(30):
        for found, share in zip(both[0], h, strict=True):
            angle = 2 * mp.asin(mp.sqrt(mp.mpf(float(share))))
            size = 3.5 * float(angle if angle < 2 * mp.pi / 3 else mp.pi)
            assert abs(mp.mpf(float(found)) / (12 * mp.exp(-3.5 * angle)) - 1) <= (2.5 * size + 2) * 2.0**-52


def test_kernels_serve_once_they_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backend, "_done", 0)
    assert backend.perez_sums(backend.PLAIN_PHOTONS // 60) is mass
    assert backend.perez_sums(1) is sums_compiled


def test_mirrored_columns_are_equal_and_turning_changes_nothing() -> None:
    grid = PatchGrid.regular(9, 36)
    skies = [
        PerezSky(sun_zenith_rad=0.9, sun_azimuth_rad=np.deg2rad(azimuth), epsilon=5.0, delta=0.15)
        for azimuth in (40.0, 40.0 + 1e-7, -320.0, 0.0)
    ]
    mass = [sky.patch_mass(grid).reshape(9, 36) for sky in skies]
    np.testing.assert_array_equal(mass[0], np.roll(mass[0][:, ::-1], 8, axis=1))
    np.testing.assert_allclose(mass[0], mass[1], rtol=1e-7)  # the same sky by the way without mirror
    np.testing.assert_array_equal(mass[0], mass[2])
    np.testing.assert_allclose(np.roll(mass[3], 4, axis=1), mass[0], rtol=1e-10)


def test_sun_on_edges_and_corners_of_patches() -> None:
    grid = PatchGrid.regular(9, 12)
    for zenith, azimuth in ((30.0, 60.0), (30.0, 45.0), (35.0, 60.0), (30.0, 0.0), (30.0, 360.0), (29.9999999, 60.0)):
        sky = PerezSky(sun_zenith_rad=np.deg2rad(zenith), sun_azimuth_rad=np.deg2rad(azimuth), epsilon=8.0, delta=0.05)
        known = float(perez.horizontal_integral(sky.model_coefficients, sky.sun_zenith_rad))
        assert sky._integrals(grid)[1] == pytest.approx(known, rel=1e-11)


def test_columns_below_zero_and_empty_patches() -> None:
    sky = PerezSky(sun_zenith_rad=0.9, sun_azimuth_rad=0.0, epsilon=8.0, delta=0.1)
    shifted = PatchGrid(
        zenith_bounds_deg=np.array([[0.0, 30.0], [30.0, 30.0], [30.0, 90.0]]),
        azimuth_bounds_deg=np.array([[-45.0, 45.0], [45.0, 45.0], [45.0, 200.0], [200.0, 315.0]]),
    )
    mass = sky.patch_mass(shifted).reshape(3, 4)
    assert mass.sum() == pytest.approx(1, rel=1e-13)
    assert mass[1].max() == 0
    assert mass[:, 1].max() == 0
    first = PatchGrid(zenith_bounds_deg=np.array([[30.0, 90.0]]), azimuth_bounds_deg=np.array([[315.0, 405.0]]))
    assert sky.patch_mass(first)[0] == pytest.approx(mass[2, 0], rel=1e-10)
