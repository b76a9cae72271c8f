"""Rows 22 to 26 of the matrix: radiances at the ends of float64, and photon numbers at both ends."""

import json

import pytest

from tests.support.fault_rows import photons_of_band, row_id, run_scene, sky

ONE_WAVELENGTH = "3\n550.0 0.05 0.0\n550.0 0.05 0.0\n550.0 0.05 0.0\n"
"""lambbot.inp of three wavebands at the sky's only wavelength."""
CELLS = ((1, 0), (1, 1), (2, 0), (2, 1))
EXTREMES = {
    # name: (row, radiances of four patches, photons, counts)
    "one-1e300-rest-1": (22, ("1", "1e300", "1", "1"), 10**9, (0, 10**9, 0, 0)),
    "one-1e300-three-quarters": (22, ("1", "3e300", "1e300", "1"), 4000, (0, 3000, 1000, 0)),
    "sum-beyond-float64": (22, ("1.7e308",) * 4, 4000, (1000,) * 4),
    "subnormals-everywhere": (23, ("5e-324",) * 4, 4000, (1000,) * 4),
    "subnormals-that-differ": (23, ("5e-324", "1e-323", "1.5e-323", "2e-323"), 10_000, (1000, 2000, 3000, 4000)),
}
WAYS = ("--allocation systematic", "--allocation largest-remainder")
WAYS += ("--allocation largest-remainder --weighting projected",)
"""All four patches have the projected solid angle pi / 4: no multiple of 5e-324 has such a share of itself."""


def at_one_wavelength(rows, n_zenith, n_azimuth):
    """Files of a scene whose wavebands all take one sky of so many bins."""
    head = f"{len(rows)} {n_zenith} {n_azimuth - 1} 1"
    return {"skydist.inp": sky(rows=rows, head=head, waves="550.0"), "lambbot.inp": ONE_WAVELENGTH}


def one_sky(values):
    """Files of a sky of four patches."""
    return at_one_wavelength([f"1 {z} {a} {value}" for (z, a), value in zip(CELLS, values, strict=True)], 2, 2)


def even_sky(n_zenith, n_azimuth):
    """Files of a sky of equal patches."""
    rows = [f"1 {z} {a} 1.0" for z in range(1, n_zenith + 1) for a in range(n_azimuth)]
    return at_one_wavelength(rows, n_zenith, n_azimuth)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", EXTREMES, ids=[row_id(case[0], name) for name, case in EXTREMES.items()])
def test_radiances_at_the_ends(name, way, tmp_path, capsys):
    _, values, n, counts = EXTREMES[name]
    options = ["--iterations", n, *way.split(), "--format", "none", "-q"]
    answer = run_scene(tmp_path, one_sky(values), options, capsys)
    assert (answer.code, answer.err) == (0, "")
    for band in (1, 2, 3):
        assert photons_of_band(answer.folder, band) == dict(zip(CELLS, counts, strict=True))


@pytest.mark.parametrize("n", [1, 7], ids=["row-24-1-photon-32400-patches", "row-24-7-photons-32400-patches"])
def test_fewer_photons_than_patches(n, tmp_path, capsys):
    """Exactly n photons, one to a patch."""
    answer = run_scene(tmp_path, even_sky(90, 360), ["--iterations", n, "-q", "--weighting", "listed"], capsys)
    assert (answer.code, answer.err) == (0, "")
    counts = photons_of_band(answer.folder, 2)
    assert len(counts) == 32_400
    assert sorted(counts.values(), reverse=True) == [1] * n + [0] * (32_400 - n)


LARGE = {"2-to-the-31": 2**31, "1e12": 10**12, "9e15": 9 * 10**15, "2-to-the-62": 2**62}


@pytest.mark.parametrize("n", LARGE.values(), ids=[row_id(25, f"exact-{name}") for name in LARGE])
def test_many_photons_are_exact(n, tmp_path, capsys):
    """Whole numbers to the last unit: quarters of n, and n in all, where float64 would be off from 2^53."""
    options = ["--iterations", n, "--format", "none", "--json"]
    answer = run_scene(tmp_path, one_sky(("1",) * 4), options, capsys)
    assert answer.code == 0
    assert [band["launched"] for band in json.loads(answer.out)["bands"]] == [n] * 3
    assert photons_of_band(answer.folder, 3) == dict.fromkeys(CELLS, n // 4)
