"""Tiles that the edge of an unlit region crosses: the kernel, its plain form, and sums over many cells."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.kernels.perez import mass
from aomc_sky.kernels.perez import tiles as compiled
from aomc_sky.kernels.perez.law import first_factor, half_sine2, second_factor, sin_cos
from aomc_sky.skies.perez.patches import second_factor_zeros
from aomc_sky.skies.perez.sky import PerezSky

SKIES = [
    ({"epsilon": 1.6, "delta": 0.6}, 5.0),  # dark around the sun
    ({"epsilon": 8.0, "delta": 0.8, "limits": "paper"}, 5.0),  # light beside the sun alone
    ({"coefficients": [-1.0, -0.3, -3.0, -1.0, 0.0]}, 60.0),  # a dark circle of 63 degrees
    ({"coefficients": [-1.0, -0.3, -3.0, -1.0, 0.0]}, 0.0),  # the same about the zenith
    ({"coefficients": [-1.0, -0.3, -3.0, -1.0, -0.9]}, 89.0),  # two circles
]
pytestmark = pytest.mark.filterwarnings("ignore::aomc_sky.errors.ModelLimitWarning")


def _numbers(arguments: dict[str, object], sun_deg: float) -> tuple[np.ndarray, np.ndarray]:
    sky = PerezSky(sun_zenith_rad=np.deg2rad(sun_deg), sun_azimuth_rad=1.0, **arguments)
    numbers = sky._numbers()
    return numbers, second_factor_zeros(*numbers[2:5])


def _tiles(numbers: np.ndarray, roots: np.ndarray, n: int) -> np.ndarray:
    """Tiles of about 2 degrees, centred on the circles; shape (n, 4)."""
    rng = np.random.default_rng(8)
    gamma, along = 2 * np.arcsin(np.sqrt(rng.choice(roots, 40 * n))), rng.uniform(0, 2 * np.pi, 40 * n)
    sun = numbers[5] * np.pi / 2
    x = np.arccos(np.cos(gamma) * np.cos(sun) + np.sin(gamma) * np.sin(sun) * np.cos(along))
    y = np.arctan2(np.sin(gamma) * np.sin(along) * np.sin(sun), np.cos(gamma) - np.cos(x) * np.cos(sun))
    middle = np.stack([x, np.mod(y + numbers[6] * np.pi / 2, 2 * np.pi)], axis=1) / (np.pi / 2)
    middle = middle[(middle[:, 0] > 0.02) & (middle[:, 0] < 0.98)][:n]
    half = rng.uniform(0.002, 0.02, (len(middle), 2))
    return np.stack([middle - half, middle + half], axis=2).reshape(-1, 4)


def _sum_of_cells(tile: np.ndarray, numbers: np.ndarray, n: int) -> float:
    """Middle-point sum over n x n cells of a tile: its error falls with 1/n^2 alone at an edge."""
    centres = (np.arange(n) + 0.5) / n
    x, y = (low + (high - low) * centres for low, high in (tile[:2], tile[2:]))
    s, c = sin_cos(x)
    h = half_sine2(x - numbers[5])[:, None] + (s * numbers[7])[:, None] * half_sine2(y - numbers[6])
    value = np.maximum(second_factor(h, *numbers[2:5]), 0.0) * (s * c * first_factor(c, *numbers[:2]))[:, None]
    return float(np.maximum(value, 0.0).mean() * np.prod(tile[1::2] - tile[::2]) * (np.pi / 2) ** 2)


@pytest.mark.parametrize(("arguments", "sun_deg"), SKIES)
def test_plain_numpy_gives_the_same_bits(arguments: dict[str, object], sun_deg: float) -> None:
    numbers, roots = _numbers(arguments, sun_deg)
    rng = np.random.default_rng(3)
    ends = np.sort(rng.random((20, 2)), axis=1)
    tiles = np.concatenate([_tiles(numbers, roots, 60), np.hstack([ends, 4 * rng.random((20, 1)) + ends])])
    tolerance = rng.choice([1e-16, 1e-12, 1e-8], len(tiles))
    both = np.empty((2, len(tiles)))
    for module, out in zip((compiled, mass), both, strict=True):
        module.edge_integrals(tiles, tolerance, numbers, roots, out)
    assert both[0].max() > 0
    np.testing.assert_array_equal(both[0], both[1])


@pytest.mark.parametrize(("arguments", "sun_deg"), SKIES)
def test_integral_is_the_limit_of_sums_over_cells(arguments: dict[str, object], sun_deg: float) -> None:
    numbers, roots = _numbers(arguments, sun_deg)
    tiles = _tiles(numbers, roots, 12)
    assert len(tiles) == 12
    found = np.empty(len(tiles))
    compiled.edge_integrals(tiles, np.full(len(tiles), 1e-16), numbers, roots, found)
    errors = []
    for n in (40, 320):
        sums = np.array([_sum_of_cells(tile, numbers, n) for tile in tiles])
        errors.append(np.max(np.abs(sums - found) / np.max(sums)))
    assert errors[1] < 1e-5
    assert errors[1] < errors[0] / 10


def test_parts_of_a_tile_add_up() -> None:
    numbers, roots = _numbers(*SKIES[-1])
    tiles = _tiles(numbers, roots, 50)
    x0, x1, y0, y1 = tiles.T
    x, y = 0.3 * x0 + 0.7 * x1, 0.6 * y0 + 0.4 * y1
    parts = [(x0, x, y0, y), (x0, x, y, y1), (x, x1, y0, y), (x, x1, y, y1)]
    found = np.empty((5, len(tiles)))
    for k, part in enumerate([(x0, x1, y0, y1), *parts]):
        compiled.edge_integrals(np.stack(part, axis=1), np.full(len(tiles), 1e-17), numbers, roots, found[k])
    np.testing.assert_allclose(found[1:].sum(axis=0), found[0], rtol=1e-10, atol=1e-11 * found[0].max())
