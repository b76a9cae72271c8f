"""Entry points: uniform over the circle and the rectangle, and strangers to the directions."""

import numpy as np
import pytest

import aomc_sky as sky
from tests.support import chi2
from tests.support.sampled import azimuth_place, even, scene, sky_angles, square_counts

N = 200_000
SHAPES = {
    "circle": sky.Footprint(shape="circle", size_x_m=3.0, size_y_m=3.0),
    "rectangle": sky.Footprint(shape="rectangle", size_x_m=1.0, size_y_m=10.0),
}


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
    components = sky.UniformSky().lower([500])
    source = scene(components, N, footprint=SHAPES[shape]).source(
        seed=12, placement="philox", order="patch", precision=precision
    )
    return source.photons()


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


@pytest.mark.parametrize(
    "defect", ["no square root", "diameter for radius", "sides exchanged", "corner at the origin", "square for circle"]
)
def test_planted_defects(plan_only, defect):
    u, v = np.random.default_rng(3).random((2, N))
    circle = 1.5 * np.sqrt(u), 2 * np.pi * v
    if defect == "no square root":
        circle = 1.5 * u, 2 * np.pi * v
    if defect == "diameter for radius":
        circle = 3.0 * np.sqrt(u), 2 * np.pi * v
    if defect in ("no square root", "diameter for radius"):
        points = "circle", circle[0] * np.cos(circle[1]), circle[0] * np.sin(circle[1])
    elif defect == "square for circle":
        points = "circle", 2.1 * (u - 0.5), 2.1 * (v - 0.5)
    elif defect == "sides exchanged":
        points = "rectangle", 10 * (u - 0.5), 1 * (v - 0.5)
    else:
        points = "rectangle", 1 * u, 10 * v
    plan_only.catches(min(p_values(*unit_square(*points))))
