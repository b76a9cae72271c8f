"""Lobes against 60 digits: rotations and masses above the horizon; densities and samplers: test_stated_errors.py."""

import itertools

import mpmath as mp
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.lobes import functions as lobes
from tests.reference import lobes_exact
from tests.reference.phase_exact import ulps
from tests.support.fairness import turned
from tests.support.shared import REFERENCE, csv_rows

LOBES = REFERENCE / "lobes"
UP = (1.0, 0.0, 0.0, 0.0)
KIND = {"1": "hg", "2": "ggx", "3": "beckmann"}
WEIGHTINGS = ("plain", "projected")
MASSES = ("mass_above_horizon", "cosine_weighted_mass_above_horizon")
WIDTHS = {"hg": (np.array([0.0, 0.5, 0.9]), 0.0), "ggx": (np.array([0.1, 0.5, 2.0]), 0.7), "beckmann": (0.3, 0.2)}
TURNS = np.array([[1.0, 0, 0, 0], [0.6, 0.3, -0.2, 0.7], [-7.0, 0, 3.0, 0], [0.0, 1.0, 1e-9, 0]])
HARD_ALPHA = ((1.0, 1.0), (0.25, 1.5), (1e-4, 1e-4), (1e3, 1e3), (1e-2, 1e2), (1e-4, 1.0))


def filled(kind, a, b, draw=lobes.sample):
    """Density times the area that a step of both uniform numbers covers, by differences; 1 for a sampler of it."""
    u, v = np.random.default_rng(1).uniform(0.01, 0.99, (2, 300))
    step = 1e-5
    along = draw(kind, a, b, u + step, v) - draw(kind, a, b, u - step, v)
    across = draw(kind, a, b, u, v + step) - draw(kind, a, b, u, v - step)
    return (
        lobes.pdf(kind, a, b, draw(kind, a, b, u, v))
        * np.linalg.norm(np.cross(along, across), axis=1)
        / (2 * step) ** 2
    )


SAMPLED = [("hg", g, 0.0) for g in (0.0, 1e-6, 0.5, 0.94)]
SAMPLED += [
    (kind, *alpha) for kind in ("ggx", "beckmann") for alpha in ((1.0, 1.0), (0.25, 1.0), (0.001, 0.7), (0.4, 0.2))
]


@pytest.mark.parametrize(("kind", "a", "b"), SAMPLED)
def test_samples_have_the_density(kind, a, b):
    np.testing.assert_allclose(filled(kind, a, b), 1.0, rtol=2e-6)


DEFECTS = {
    "roughness swapped": ("ggx", lambda kind, a, b, u, v: lobes.sample(kind, b, a, u, v)),
    "azimuth short of a turn by 1 %": ("beckmann", lambda kind, a, b, u, v: lobes.sample(kind, a, b, u, 0.99 * v)),
    "Beckmann wider by 1 %": ("beckmann", lambda kind, a, b, u, v: lobes.sample(kind, 1.01 * a, b, u, v)),
    "g off by 3 %": ("hg", lambda kind, a, b, u, v: lobes.sample(kind, 1.03 * a, b, u, v)),
    "roughness off by 2 %": ("ggx", lambda kind, a, b, u, v: lobes.sample(kind, 1.02 * a, b, u, v)),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_planted_samplers_have_another_density(defect):
    kind, draw = DEFECTS[defect]
    assert np.abs(filled(kind, 0.4, 0.2 if kind != "hg" else 0.0, draw) - 1).max() > 5e-3


def test_ends_and_shapes_of_arguments():
    assert np.array_equal(lobes.sample("beckmann", 0.5, 0.5, 1.0, 0.0), [1.0, 0.0, 0.0])
    assert np.array_equal(lobes.sample("ggx", 0.5, 0.5, 1.0, 0.25), [0.0, 1.0, 0.0])
    assert np.array_equal(lobes.sample("hg", 0.7, 0.0, [0.0, 1.0], 0.3)[:, 2], [-1.0, 1.0])
    for u, v in ((-0.1, 0.5), (1.1, 0.5), (0.5, np.nan)):
        with pytest.raises(SceneError, match="uniform"):
            lobes.sample("ggx", 0.5, 0.5, u, v)
    m = np.ones((4, 1, 3))
    assert lobes.pdf("ggx", np.array([0.1, 0.2]), 0.5, m).shape == (4, 2)
    assert lobes.pdf("ggx", 0.1, 0.5, m.astype(np.float32)).dtype == np.float32
    assert lobes.pdf("ggx", 0.1, 0.5, [0.0, 0.0, 1.0]).dtype == np.float64
    assert lobes.pdf("ggx", 0.5, 0.5, [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).tolist() == [0.0, 0.0]
    assert sky.lobes.pdf is lobes.pdf
    assert lobes.pdf("ggx", 1e-200, 1.0, (1.0, 0.0, 1.0)) == 0.0
    assert lobes.pdf("ggx", 1e-30, 1e-30, (0.0, 0.0, 1.0)) == pytest.approx(1e60 / np.pi)


REFUSED = [
    (lambda: lobes.pdf("hg", 1.0, 0.0, (0, 0, 1)), "asymmetry g"),
    (lambda: lobes.pdf("ggx", 0.0, 1.0, (0, 0, 1)), "roughness"),
    (lambda: lobes.pdf("ggx", 1.0, np.inf, (0, 0, 1)), "roughness"),
    (lambda: lobes.pdf("ggx", 1.0, 1.0, (0, 0, 0)), "not zero"),
    (lambda: lobes.pdf("ggx", 1.0, 1.0, (0, 1)), "three components"),
    (lambda: lobes.pdf("ggx", "a", 1.0, (0, 0, 1)), "real numbers"),
    (lambda: lobes.pdf("ggx", [0.1, 0.2, 0.3], 1.0, [(0, 0, 1)] * 2), "do not broadcast"),
    (lambda: lobes.rotation_matrix((0, 0, 0, 0)), "quaternion"),
    (lambda: lobes.rotation_matrix((1, 0, np.nan, 0)), "quaternion"),
    (lambda: lobes.rotation_matrix((1, 0, 0)), "quaternion"),
    (lambda: lobes.sample("ggx", 0.1, 0.1, "x", 0.1), "real numbers"),
    (lambda: lobes.sample("hg", 0.1, 0.0, [0.1, 0.2], [0.1, 0.2, 0.3]), "do not broadcast"),
    (lambda: lobes.mass_above_horizon("ggx", 0.1, 0.1, "abcd"), "real numbers"),
    (lambda: lobes.patch_mass("ggx", [0.1, 0.2], 0.1, UP, sky.PatchGrid.regular(3, 4)), "one lobe"),
    (lambda: lobes.to_world(UP, (1.0, 2.0)), "three components"),
    (lambda: lobes.to_world(UP, 3.0), r"three components, got the shape \(\)"),
    (lambda: lobes.to_local(UP, (1.0, 2.0, 3.0, 4.0)), "three components"),
    (lambda: lobes.to_local([UP, UP], [(1, 2, 3)] * 3), "do not broadcast"),
]


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_wrong_arguments_are_refused(call, message):
    with pytest.raises((UsageError, SceneError), match=message):
        call()


def exact_rotation(quaternion):
    with mp.workdps(60):
        w, x, y, z = (mp.mpf(float(c)) for c in quaternion)
        n = w * w + x * x + y * y + z * z
        return [
            [1 - 2 * (y * y + z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
            [2 * (x * y + w * z) / n, 1 - 2 * (x * x + z * z) / n, 2 * (y * z - w * x) / n],
            [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, 1 - 2 * (x * x + y * y) / n],
        ]


def test_rotations():
    rng = np.random.default_rng(2)
    for scale in (1.0, 1e-300, 1e300, 3e7):
        for quaternion in [*(rng.normal(size=(20, 4)) * scale), np.array([1, 1 + 1e-9, 0, 0]) * scale]:
            matrix = lobes.rotation_matrix(quaternion)
            for got, true in zip(matrix.ravel(), itertools.chain(*exact_rotation(quaternion)), strict=True):
                assert (true == 0 and got == 0) or ulps(got, true) <= 4
    q, m = rng.normal(size=(5, 4)), rng.normal(size=(5, 3))
    assert lobes.to_local(q, lobes.to_world(q, m)) == pytest.approx(m, rel=1e-13, abs=1e-14)


def tilted(cosine):
    """A quaternion whose axis has about this zenith cosine; the lobe is turned about its axis as well."""
    return np.array(turned(np.rad2deg(np.arccos(cosine)), roll_deg=35.0))


AXES = (1.0, 0.7, 1e-3, 1e-9, 0.0, -1e-9, -1e-3, -0.3, -0.95, -1.0)


@pytest.mark.parametrize("weighting", WEIGHTINGS)
@pytest.mark.parametrize("g", [1e-8, 0.85, *(pytest.param(g, marks=pytest.mark.slow) for g in (0.0, 0.3))])
def test_hg_above_the_horizon(g, weighting):
    for cosine in AXES:
        quaternion = tilted(cosine)
        true = lobes_exact.hg_above(g, exact_rotation(quaternion)[2][2], weighting)
        got = float(lobes.mass_above_horizon("hg", g, 0.0, quaternion, weighting=weighting))
        assert got == pytest.approx(float(true), rel=1e-14)


@pytest.mark.parametrize("g", [1 - 2**-24, 1 - 1e-14])
def test_needles_above_the_horizon(g):
    """Next to a needle the sphere is a plane: the mass is that of Cauchy's law in distance / (1 - g)."""
    for distance in (-1e3, -1.0, 0.0, 0.3, 20.0):
        angle = distance * (1 - g)
        quaternion = (np.cos(np.pi / 4 - angle / 2), np.sin(np.pi / 4 - angle / 2), 0.0, 0.0)
        elevation = float(exact_rotation(quaternion)[2][2])
        true = 0.5 + np.arctan(elevation / (1 - g)) / np.pi
        assert lobes.mass_above_horizon("hg", g, 0.0, quaternion) == pytest.approx(true, abs=3 * (1 - g) + 1e-15)
    up = lobes.mass_above_horizon("hg", g, 0.0, (1, 0, 0, 0), weighting="projected")
    assert up == pytest.approx(1.0, abs=20 * (1 - g))


# 1 - g, x of the quaternion (1, x, 0, 0), mass: 16 digits of a 30-digit integral over rings about the lobe's axis.
NEEDLES = [
    (1e-14, 1 - 2.0**-50, 1.032408183580253e-13),
    (1e-14, 1.0, 1.027841804885079e-13),
    (1e-14, 1 + 2.0**-50, 1.023526399383252e-13),
    (2.0**-24, 1 - 2.0**-20, 1.199215033011215e-6),
]


@pytest.mark.parametrize(("gap", "x", "true"), NEEDLES)
def test_projected_needles_beside_the_horizon(gap, x, true):
    """Tilts by a few units in the last place of pi / 2 count."""
    got = lobes.mass_above_horizon("hg", 1 - gap, 0.0, (1.0, x, 0.0, 0.0), weighting="projected")
    assert float(got) == pytest.approx(true, rel=1e-14)


@pytest.mark.parametrize("alpha", HARD_ALPHA)
@pytest.mark.parametrize("kind", ["ggx", "beckmann"])
def test_vndf_above_the_horizon(kind, alpha):
    for cosine in AXES:
        quaternion = tilted(cosine)
        with mp.workdps(60):
            n = exact_rotation(quaternion)[2]
            k = mp.hypot(mp.mpf(alpha[0]) * n[0], mp.mpf(alpha[1]) * n[1])
            if kind == "ggx":
                true = (1 + n[2] / mp.hypot(n[2], k)) / 2
            else:
                true = mp.erfc(-n[2] / k) / 2 if k else mp.mpf(n[2] > 0)
            condition = 1 + (float(n[2] / k) ** 2 if k and kind == "beckmann" and n[2] < 0 else 0)
        got = float(lobes.mass_above_horizon(kind, *alpha, quaternion))
        assert got == pytest.approx(float(true), rel=1e-14 * condition, abs=1e-300)


def test_projected_masses_with_a_closed_form():
    """A round GGX lobe with alpha 1 is the cosine law: half a moon of it, and the mean cosine 2/3 overhead."""
    up = lobes.mass_above_horizon("ggx", 1.0, 1.0, (1, 0, 0, 0), weighting="projected")
    assert up == pytest.approx(2 / 3, rel=1e-12)
    for cosine in (0.6, 0.0, -0.5):
        quaternion = tilted(cosine)
        axis = float(lobes.rotation_matrix(quaternion)[2, 2])
        true = (np.sqrt(1 - axis**2) + axis * (np.pi - np.arccos(axis))) * 2 / (3 * np.pi)
        got = lobes.mass_above_horizon("ggx", 1.0, 1.0, quaternion, weighting="projected")
        assert got == pytest.approx(true, rel=1e-11)
    far = np.hypot(1e-9, 0) * 20.0  # k of a rough lobe that hangs straight down but for 1e-9
    down = lobes.mass_above_horizon("ggx", 20.0, 20.0, (5e-10, 1.0, 0.0, 0.0), weighting="projected")
    assert down == pytest.approx(2 * far**3 / (9 * np.pi * 20.0), rel=1e-9)


def test_reference_masses_above_the_horizon():
    for row in csv_rows(LOBES / "hg_horizon_mass.csv"):
        cosine = mp.mpf(row["cos_axis_zenith"])
        quaternion = (float(mp.sqrt((1 + cosine) / 2)), float(mp.sqrt((1 - cosine) / 2)), 0.0, 0.0)
        got = [float(lobes.mass_above_horizon("hg", float(row["g"]), 0.0, quaternion, weighting=w)) for w in WEIGHTINGS]
        assert got == pytest.approx([float(row[k]) for k in MASSES], rel=5e-15)
    for row in csv_rows(LOBES / "vndf_horizon_mass.csv"):
        shape = (KIND[row["type"]], float(row["alpha_x"]), float(row["alpha_y"]))
        quaternion = [float(row[k]) for k in ("qw", "qx", "qy", "qz")]
        plain, projected = (float(lobes.mass_above_horizon(*shape, quaternion, weighting=w)) for w in WEIGHTINGS)
        assert plain == pytest.approx(float(row[MASSES[0]]), rel=2e-14, abs=1e-300)
        assert projected == pytest.approx(float(row[MASSES[1]]), rel=1e-9, abs=1e-40)


@pytest.mark.parametrize("weighting", ["plain", "projected"])
@pytest.mark.parametrize("kind", WIDTHS)
def test_masses_over_arrays_are_those_of_single_calls(kind, weighting):
    first, second = (np.broadcast_to(p, 3) for p in WIDTHS[kind])
    table = lobes.mass_above_horizon(kind, first, second, TURNS[:, None], weighting=weighting)
    assert np.all((table >= 0) & (table <= 1))
    shapes = list(zip(first, second, strict=True))
    one_by_one = [
        [lobes.mass_above_horizon(kind, *s, list(turn), weighting=weighting) for s in shapes] for turn in TURNS
    ]
    assert table.tolist() == one_by_one


@pytest.mark.parametrize("tiny", [1e-20, 1e-100, 1e-148, 1e-160, 1e-200])
@pytest.mark.parametrize("weighting", ["plain", "projected"])
@pytest.mark.parametrize(("kind", "shape"), [("hg", (0.8, 0.0)), ("ggx", (0.3, 0.2)), ("beckmann", (0.3, 0.2))])
def test_axes_that_are_level_or_straight_down_but_for_a_tiny_number(kind, shape, weighting, tiny):
    """The cosine of the axis, or what is left of its roughness, is the square of it."""
    for whole in ([1.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0]):
        exact = lobes.mass_above_horizon(kind, *shape, whole, weighting=weighting)
        for place in (k for k, number in enumerate(whole) if number == 0.0):
            near = [tiny if k == place else number for k, number in enumerate(whole)]
            found = lobes.mass_above_horizon(kind, *shape, near, weighting=weighting)
            np.testing.assert_allclose(found, exact, rtol=1e-13, atol=1e-40)
