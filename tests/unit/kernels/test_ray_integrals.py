"""Path weights of the successive orders of scattering against a plain quadrature, with and without the compiler."""

from __future__ import annotations

import numpy as np

from aomc_sky.skies.atmosphere.kernels.ray_integrals import fill_down, fill_up

SHARE = np.array([[0.2, 0.5, 0.9], [0.1, 0.4, 0.8]])
ELEMENT = np.repeat([0, 1], 3)
POWERS = np.arange(3)
INVERSE = np.linalg.inv(SHARE[:, :, None] ** POWERS)
TURNED = np.linalg.inv((1.0 - SHARE)[:, :, None] ** POWERS)
NODE, WEIGHT = np.polynomial.legendre.leggauss(40)


def stretch(depth: float, begin: float, end: float, inverse: np.ndarray) -> np.ndarray:
    """Weights of one stretch by Gauss nodes."""
    s = begin + (end - begin) * 0.5 * (NODE + 1.0)
    left = np.exp(-depth * 0.5 * (1.0 - NODE))
    return (0.5 * WEIGHT * left * depth) @ (s[:, None] ** POWERS) @ inverse


def test_down_through_two_elements() -> None:
    crossed = np.tile([[0.3, 1.7], [0.01, 4.0]], (6, 1, 1))
    own = np.take_along_axis(crossed, ELEMENT[:, None, None], axis=2)[:, :, 0] * SHARE.ravel()[:, None]
    found = np.empty((2, 6, 6))
    fill_down(crossed, own, SHARE.ravel(), ELEMENT, INVERSE, found)
    for i in range(2):
        for k, element in enumerate(ELEMENT):
            expected = np.zeros((2, 3))
            expected[element] = stretch(own[k, i], 0.0, SHARE.ravel()[k], INVERSE[element])
            if element == 1:
                expected[0] = np.exp(-own[k, i]) * stretch(crossed[k, i, 0], 0.0, 1.0, INVERSE[0])
            np.testing.assert_allclose(found[i, k], expected.ravel(), atol=1e-12)


def test_up_from_the_ground_and_past_a_lowest_point() -> None:
    """The second line of each point turns back at share 0.6 of the lower element."""
    crossed = np.tile([[0.3, 1.7], [0.5, 2.5]], (6, 1, 1))
    tangent = np.tile([[1.0, 1.0], [1.0, 0.6]], (6, 1, 1))
    share = np.array([0.2, 0.5, 0.9, 0.1, 0.3, 0.5])
    lowest = np.tile([-1.0, 5.0], (6, 1))
    own = np.take_along_axis(crossed, ELEMENT[:, None, None], axis=2)[:, :, 0]
    turn = np.take_along_axis(tangent, ELEMENT[:, None, None], axis=2)[:, :, 0]
    below = own * (1.0 - share[:, None] / turn)
    up, over, from_ground = np.empty((2, 6, 6)), np.empty((2, 6, 6)), np.empty((2, 6))
    fill_up(crossed, below, tangent, lowest, share, ELEMENT, INVERSE, TURNED, up, over, from_ground)
    for i in range(2):
        for k, element in enumerate(ELEMENT):
            near, far = np.zeros((2, 3)), np.zeros((2, 3))
            near[element] = stretch(below[k, i], 1.0 - turn[k, i], 1.0 - share[k], TURNED[element])
            left = np.exp(-below[k, i])
            if element == 0:
                near[1] = left * stretch(crossed[k, i, 1], 1.0 - tangent[k, i, 1], 1.0, TURNED[1])
                left *= np.exp(-crossed[k, i, 1])
            np.testing.assert_allclose(up[i, k], near.ravel(), atol=1e-12)
            if i == 0:
                np.testing.assert_allclose(from_ground[i, k], left, rtol=1e-14)
                np.testing.assert_array_equal(over[i, k], 0.0)
                continue
            assert from_ground[i, k] == 0.0
            far[1] = left * stretch(crossed[k, i, 1], 0.0, 0.6, INVERSE[1])
            far[0] = left * np.exp(-crossed[k, i, 1]) * stretch(crossed[k, i, 0], 0.0, 1.0, INVERSE[0])
            np.testing.assert_allclose(over[i, k], far.ravel(), atol=1e-12)
