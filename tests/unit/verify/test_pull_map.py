"""Pulls of cells: their sign, their scale, and where there is nothing to say."""

import numpy as np

from aomc_sky.verify.sky.directions import pull_map


def test_pulls_are_in_standard_deviations():
    pulls = pull_map([[110, 400]], [[100.0, 400.0]])
    assert pulls.shape == (1, 2)
    assert pulls.tolist() == [[1.0, 0.0]]
    assert pull_map([110], [100.0], variance=[25.0]).tolist() == [2.0]


def test_cells_that_say_nothing():
    pulls = pull_map([3, 0, 2, 1], [2.0, 0.0, 0.0, 30.0])
    assert np.isnan(pulls[0])  # expects too few
    assert np.isnan(pulls[1])  # dark, and is dark
    assert pulls[2] == np.inf  # photons from the dark
    assert pulls[3] < -5
