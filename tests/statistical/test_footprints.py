"""Entry points: uniform over the circle and the rectangle, and strangers to the directions."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import azimuth_place, even, scene, sky_angles, square_counts

N = 200_000
SHAPES = {"circle": sky.Footprint.circle(3.0), "rectangle": sky.Footprint.rectangle(1.0, 10.0)}


def unit_square(shape, x, y):
    """Coordinates that are uniform on the unit square if points are uniform on the footprint."""
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    footprint = SHAPES[shape]
    if shape == "circle":
        s = (x * x + y * y) / (footprint.size_x_m / 2) ** 2
        s = np.where((s > 1) & (s < 1 + 1e-6), 1.0, s)
        return s, azimuth_place(np.mod(np.rad2deg(np.arctan2(y, x)), 360), (0.0, 360.0))
    return x / footprint.size_x_m + 0.5, y / footprint.size_y_m + 0.5


def p_values(s, t):
    return chi2.ks_p(s), chi2.ks_p(t), chi2.chi2_p(square_counts(s, t).ravel(), even(s.size, 256))


def photons(shape, precision="float32"):
    options = {"placement": "philox", "order": "patch", "precision": precision}
    return scene("uniform", N, footprint=SHAPES[shape]).source(seed=12, **options).photons()


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("shape", SHAPES)
def test_positions(plan, shape, precision):
    batch = photons(shape, precision)
    for p_value in p_values(*unit_square(shape, batch.x, batch.y)):
        plan.check(p_value)


@pytest.mark.parametrize("shape", SHAPES)
def test_positions_do_not_know_directions(plan, shape):
    """In patch order rank = index, so one stream for both would show as equal numbers."""
    batch = photons(shape)
    s, _ = unit_square(shape, batch.x, batch.y)
    _, sin2, _ = sky_angles(batch)
    cells = even(N, 256)
    plan.check(chi2.chi2_p(square_counts(s, sin2).ravel(), cells))
    plan.catches(chi2.chi2_p(square_counts(sin2, sin2).ravel(), cells))


def round_points(radius, v):
    return radius * np.cos(2 * np.pi * v), radius * np.sin(2 * np.pi * v)


DEFECTS = {
    "no square root": ("circle", lambda u, v: round_points(1.5 * u, v)),
    "diameter for radius": ("circle", lambda u, v: round_points(3.0 * np.sqrt(u), v)),
    "square for circle": ("circle", lambda u, v: (2.1 * (u - 0.5), 2.1 * (v - 0.5))),
    "sides exchanged": ("rectangle", lambda u, v: (10 * (u - 0.5), v - 0.5)),
    "corner at the origin": ("rectangle", lambda u, v: (u, 10 * v)),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_planted_defects(plan_only, defect):
    shape, points = DEFECTS[defect]
    plan_only.catches(min(p_values(*unit_square(shape, *points(*np.random.default_rng(3).random((2, N)))))))
