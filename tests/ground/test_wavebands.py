"""Which wavelength of a sky serves a band."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.wavebands import midpoint_wavelength_index, nearest_wavelength_index


@pytest.mark.parametrize(
    ("bands", "table", "index"),
    [
        ([550], [500, 600], [1]),  # a tie goes to the longer wavelength
        ([550], [600, 500], [0]),  # whatever the order
        ([500], [500, 500, 700], [0]),  # of equal wavelengths the first
    ],
)
def test_nearest(bands, table, index):
    assert nearest_wavelength_index(bands, table).tolist() == index


@given(
    table=st.lists(st.integers(300, 900), min_size=1, max_size=8, unique=True),
    band=st.floats(200, 1000, allow_nan=False),
)
def test_no_other_wavelength_is_nearer(table, band):
    chosen = table[int(nearest_wavelength_index(band, table)[0])]
    distance = [abs(band - w) for w in table]
    assert abs(band - chosen) == min(distance)
    assert chosen == max(w for w, d in zip(table, distance, strict=True) if d == min(distance))


@pytest.mark.parametrize(
    ("bands", "table", "index"),
    [
        ([549, 550, 551], [500, 600], [0, 1, 1]),
        ([510, 690], [700, 500, 600], [0, 2]),  # file order: 510 is below (700 + 500) / 2
        ([500], [500], [0]),
    ],
)
def test_midpoints_in_file_order(bands, table, index):
    assert midpoint_wavelength_index(bands, table).tolist() == index
    assert midpoint_wavelength_index(bands, table).dtype == np.intp
