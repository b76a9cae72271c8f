"""The AOMC program's rounding: equality with what the program launched."""

import subprocess
import warnings

import numpy as np
import pytest

from aomc_sky.errors import AllocationError, InputWarning, UsageError
from aomc_sky.formats.aomc.skydist import SkyTable, read_skydist, write_skydist
from aomc_sky.plan.allocation import allocate
from aomc_sky.skies.tabulated import aomc_weight
from tests.reference import allocation as plain
from tests.support.fortran import compile_reader, needs_gfortran
from tests.support.shared import AOMC, csv_rows

LAUNCH, PATCH = ("iterations", "sky_wavelength_index"), ("zenith_index", "azimuth_index")


def radiances(folder):
    """The table of a case, (n_table, n_zenith, n_azimuth), read as `--compat aomc` reads it."""
    return read_skydist(folder / "skydist.inp", downgrade=frozenset({"E308"})).radiance


def launched_totals(folder):
    """Photons launched by (iterations, sky wavelength from 1)."""
    table = [[int(row[name]) for name in (*LAUNCH, "launched")] for row in csv_rows(folder / "totals.csv")]
    return {(iterations, wavelength): launched for iterations, wavelength, launched in table}


def launches(folder, shape):
    """Iterations, sky wavelength (from 0), launched total and counts (n_zenith, n_azimuth) of each launch."""
    counts = {key: np.zeros(shape, dtype=np.int64) for key in launched_totals(folder)}
    for row in csv_rows(folder / "counts.csv"):
        *key, zenith, azimuth, photons = (int(row[name]) for name in (*LAUNCH, *PATCH, "photons"))
        counts[tuple(key)][zenith - 1, azimuth] = photons
    for (iterations, wavelength), total in launched_totals(folder).items():
        yield iterations, wavelength - 1, total, counts[iterations, wavelength]


ORDERS = [f"wavelength_order_{order}" for order in ("ascending", "descending", "duplicate", "shuffled")]
TABLES = ["repository_sky", "steep_special_rings", "uniform_9x12", "sparse_lognormal", "perez_shapes"]
CASES = ["document_example", *TABLES, *ORDERS, "zero_radiance_band"]


@pytest.mark.parametrize("case", CASES)
def test_counts_of_the_program(case):
    folder = AOMC / case
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # duplicate wavelengths, dark bands
        table = radiances(folder)
        n_launches = 0
        for iterations, wavelength, total, expected in launches(folder, table.shape[1:]):
            counts = allocate(aomc_weight(table[wavelength]), iterations, method="aomc")
            assert counts.sum() == total
            np.testing.assert_array_equal(counts, expected, err_msg=f"{iterations} iterations, sky {wavelength + 1}")
            n_launches += 1
    assert n_launches == len(launched_totals(folder)) > 0


def test_uniform_sky_of_whole_degrees_ring_by_ring():
    weight = aomc_weight(np.ones((89, 360)))
    rings = csv_rows(AOMC / "dense_uniform_1deg" / "counts.csv")
    for (iterations, _), total in launched_totals(AOMC / "dense_uniform_1deg").items():
        counts = allocate(weight, iterations, method="aomc")
        assert counts.sum() == total
        expected = np.zeros((89, 4), dtype=np.int64)
        names = ("launched_in_ring", "min_per_patch", "max_per_patch", "nonzero_patches")
        for row in rings:
            if int(row["iterations"]) == iterations:
                expected[int(row["zenith_deg"]) - 1] = [int(row[name]) for name in names]
        found = np.stack([counts.sum(1), counts.min(1), counts.max(1), (counts > 0).sum(1)], axis=1)
        np.testing.assert_array_equal(found, expected)


def test_sums_of_32_bits_run_down_the_columns_and_stall_beyond_2_to_the_24():
    weight = np.ones((1, 3 * 2**12), dtype=np.float32)
    n = 3 * 2**12 * 4097  # 4097 photons each: odd totals beyond 2^24 are no float32
    counts = allocate(weight, n, method="aomc")
    assert counts.sum() != n
    np.testing.assert_array_equal(counts, plain.aomc(weight, n))
    # 1 + 2^-24 rounds back to 1, two of the small ones first do not
    weight = np.array([[2.0**-24, 1.0], [2.0**-24, 0.0]], dtype=np.float32)
    down, along = allocate(weight, 2**24 + 2, method="aomc"), plain.aomc(weight.T.copy(), 2**24 + 2).T
    np.testing.assert_array_equal(down, plain.aomc(weight, 2**24 + 2))
    assert not np.array_equal(down, along)


def test_one_dimension_is_taken_as_it_stands():
    weight = np.random.default_rng(3).random(50).astype(np.float32)
    flat = allocate(weight, 1234, method="aomc")
    assert flat.shape == (50,)
    np.testing.assert_array_equal(flat, plain.aomc(weight[None, :], 1234)[0])


def test_dark_table_launches_nothing_and_says_so():
    with pytest.warns(InputWarning, match="all weights are zero"):
        counts = allocate(np.zeros((3, 4)), 1000, method="aomc")
    assert counts.shape == (3, 4)
    assert not counts.any()


def test_weights_that_are_refused():
    for bad in (np.nan, np.inf, -1.0):
        with pytest.raises(AllocationError, match="finite and not negative"):
            allocate([[1.0, bad]], 10, method="aomc")
    for weight in ([[1e39]], [[3e38, 3e38]]):
        with pytest.raises(AllocationError, match="overflow the 32-bit sum"):
            allocate(weight, 10, method="aomc")
    with pytest.raises(UsageError, match="3 dimensions"):
        allocate(np.ones((2, 2, 2)), 10, method="aomc")


def test_weight_takes_rings_1_and_89_half_as_often_again():
    weight = aomc_weight(np.ones((89, 2)))
    assert weight.dtype == np.float32
    angle = np.deg2rad(np.arange(1, 90))
    plain_weight = np.sin(angle) * np.cos(angle) * np.deg2rad(1.0) ** 2
    ratio = weight[:, 0] / plain_weight
    np.testing.assert_allclose(ratio[1:-1], 1.0, rtol=5e-6)
    np.testing.assert_allclose(ratio[[0, -1]], 1.5, rtol=1e-5)
    np.testing.assert_array_equal(weight[:, 0], weight[:, 1])


@needs_gfortran
def test_weight_of_whole_degrees_equals_gfortran(tmp_path):
    program = compile_reader("aomc_weight", tmp_path)
    done = subprocess.run([program], capture_output=True, text=True, timeout=60, check=True)
    words = np.array([int(line) for line in done.stdout.split()], dtype=np.int32)
    found = words.view(np.float32).reshape(90, 3)
    for column, radiance in enumerate((1.0, 0.1, 12345.678)):
        weight = aomc_weight(np.full((90, 1), radiance))[:, 0]
        np.testing.assert_array_equal(weight[:89], found[:89, column])
        assert weight[89] == 0 > found[89, column]  # the program's cosine of 90 degrees is -4e-8


@needs_gfortran
def test_ring_90_launches_nothing_as_in_the_program(tmp_path):
    radiance = np.random.default_rng(90).lognormal(sigma=1.5, size=(1, 90, 7))
    write_skydist(SkyTable(wavelength_nm=np.array([500.0]), radiance=radiance), tmp_path / "skydist.inp")
    program = compile_reader("aomc_launch", tmp_path)
    for iterations in (10_000, 999_983, 200_000_000):
        told = f"{tmp_path / 'skydist.inp'}\n{iterations} 1\n500.0\n"
        done = subprocess.run([program], input=told, capture_output=True, text=True, timeout=60, check=True)
        launched = np.zeros((90, 7), dtype=np.int64)
        for _, zenith, azimuth, photons in np.array(done.stdout.split(), dtype=np.int64).reshape(-1, 4):
            launched[zenith - 1, azimuth] = photons
        read = read_skydist(tmp_path / "skydist.inp").radiance[0]
        np.testing.assert_array_equal(allocate(aomc_weight(read), iterations, method="aomc"), launched)
        assert launched.sum() > 0
        assert not launched[89].any()
