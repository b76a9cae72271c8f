"""The remark about the AOMC program's reading agrees with what the program launched, by its own counts."""

import csv
import re

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.source.read.table import remarks_of
from tests.support.scenes import write_scene
from tests.support.shared import DATA, INPUTS

NUMBERS = re.compile(
    r"AOMC would read this file(?: in waveband (?P<band>\d+))? as a sky of mean cosine "
    r"(?P<mu>[\d.]+), not (?P<our_mu>[\d.]+), and Ed/Eo (?P<ratio>[\d.]+), not (?P<our_ratio>[\d.]+)"
)


def rows_of(path, **wanted):
    with path.open(newline="") as file:
        return [row for row in csv.DictReader(file) if all(row[k] == str(v) for k, v in wanted.items())]


def launched_by_the_program(folder, iterations, sky_wavelength):
    """Mean cosine and Ed/Eo of a launch of the real program (see README.md of the data)."""
    rows = rows_of(folder / "counts.csv", iterations=iterations, sky_wavelength_index=sky_wavelength)
    photons = np.array([int(row["photons"]) for row in rows])
    mu = np.cos(np.deg2rad([float(row["zenith_index"]) for row in rows]))
    return photons @ mu / photons.sum(), photons.sum() / (photons / mu).sum()


def means_of_equal_bins(scene, band):
    """Mean cosine and Ed/Eo of photons by the flux law in each ring of equal zenith bins."""
    source = scene.source(0)
    ring = source.mass(band).reshape(source.grid.n_zenith, -1).sum(axis=1)
    edge = np.cos(np.linspace(0, np.pi / 2, ring.size + 1))
    near, far = edge[:-1], edge[1:]
    mean = 2 / 3 * (near**3 - far**3) / (near**2 - far**2)
    return ring @ mean / ring.sum(), ring.sum() / (ring @ (2 * (near - far) / (near**2 - far**2)))


def two_readings(scene):
    found = NUMBERS.search(remarks_of(scene)[0])
    assert found, remarks_of(scene)[0]
    return found


CASES = [  # the launch of most photons of each folder
    (name, max(int(row["iterations"]) for row in rows_of(DATA / "aomc" / name / "totals.csv")))
    for name in ("document_example", "steep_special_rings", "repository_sky", "wavelength_order_shuffled")
]


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
@pytest.mark.parametrize(("name", "iterations"), CASES)
def test_what_the_program_launched(name, iterations):
    """Mean cosine and ratio of the program's own counts, but for its rounding to whole photons."""
    folder = DATA / "aomc" / name
    scene = sky.read_scene(folder, iterations=iterations, bins="equal")
    found = two_readings(scene)
    band = int(found["band"] or 1)
    total = rows_of(folder / "totals.csv", iterations=iterations, waveband=band)[0]
    mu, ratio = launched_by_the_program(folder, iterations, int(total["sky_wavelength_index"]))
    tolerance = 5.1e-5 + 50 / int(total["launched"])  # half of the last digit, and 100 patches rounded by half a photon
    assert float(found["mu"]) == pytest.approx(mu, abs=tolerance)
    assert float(found["ratio"]) == pytest.approx(ratio, abs=tolerance)
    mu, ratio = means_of_equal_bins(scene, band - 1)
    assert (found["our_mu"], found["our_ratio"]) == (f"{mu:.4f}", f"{ratio:.4f}")


@pytest.mark.parametrize("name", ["document_example", "sparse_sky", "overcast"])
def test_the_two_options_reproduce_it(name):
    """Read with the options that the note names, the run's own numbers are those of the program.

    Photons then start inside cells of a degree, whose mean cosine is within 1e-4 of its middle's.
    """
    there = two_readings(sky.read_scene(INPUTS / name))
    band = int(there["band"] or 1) - 1
    same = sky.read_scene(INPUTS / name, bins="degrees", weighting="aomc").source(0)
    compat = sky.read_scene(INPUTS / name, compat="aomc").source(0)
    for source, tolerance in ((same, 2e-4), (compat, 5.1e-5)):
        mean = -source.photons(band).uz.astype(np.float64).mean()
        assert mean == pytest.approx(float(there["mu"]), abs=tolerance)


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (
            "2 180 0 1\n500.0\n1 20 0 1.0\n1 134 0 1.0\n",
            {"weighting": "listed"},
            "because its zenith indices go to 134",
        ),
        ("1 60 0 1\n500.0\n1 60 0 1.0\n", {"bins": "degrees", "weighting": "aomc"}, "as a sky of the same mean"),
    ],
    ids=["beyond the horizon", "the same reading"],
)
def test_what_is_said_of_the_program(tmp_path, text, options, said):
    scene = sky.read_scene(write_scene(tmp_path, sky_text=text, iterations=10_000), **options)
    assert said in remarks_of(scene)[0]


def test_huge_values(tmp_path):
    """Their sum is beyond float64, their mean cosine is that of the two rings."""
    huge, small = (f"2 90 0 1\n500.0\n1 20 0 1.5e{power}\n1 60 0 1.5e{power}\n" for power in (308, 38))
    assert "AOMC would launch no photon" in remarks_of(sky.read_scene(write_scene(tmp_path, sky_text=huge)))[0]
    scene = sky.read_scene(write_scene(tmp_path, sky_text=small, iterations=10_000))
    mu, _ = means_of_equal_bins(scene, 0)
    assert two_readings(scene)["our_mu"] == f"{mu:.4f}"
