"""The program of docs/howto/from_libradtran.md: the light of uvspec's output, in its directions."""

import subprocess
import sys

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.pages import programs
from tests.support.shared import REPOSITORY

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")
PAGE = (REPOSITORY / "docs" / "howto" / "from_libradtran.md").read_text()
PROGRAMS = programs("docs/howto/from_libradtran.md")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder and field of two wavelengths: what the second program writes of the output that the first one invents."""
    found = []
    for nm in ("550.0", "650.0"):
        folder = tmp_path_factory.mktemp("uvspec")
        for name in ("uvspec_out.py", "uvspec_sky.py"):
            (folder / name).write_text(PROGRAMS[name].replace("550.0", nm))
            subprocess.run([sys.executable, name], cwd=folder, check=True)
        found.append((folder, xarray.load_dataarray(folder / "uvspec.nc", engine="h5netcdf")))
    return found


def test_light_and_directions(made):
    """Bins of equal angles around the directions, as a skydist.inp has them, hold the same light within 1 %."""
    folder, field = made[0]
    rings = np.diff(np.sin(np.deg2rad([0, 30, 60, 90])) ** 2) * np.pi
    binned = field.values[0].mean(axis=1) @ rings / 1000
    assert binned == pytest.approx(0.26298, abs=1e-5)
    diffuse = sky.TabulatedSky.from_xarray(field, azimuth_convention="clockwise from south")
    scene = sky.Scene(wavebands=[550.0], n_photons=100_000, components=[diffuse])
    (light,) = scene.irradiance.of_component[0]
    assert light == pytest.approx(binned, rel=0.01)
    first_line = (folder / "uvspec.out").read_text().splitlines()[0].split()
    assert light == pytest.approx(float(first_line[2]) / 1000, rel=0.01)
    for phi, azimuth in ((0, 270), (90, 180), (180, 90), (270, 0)):  # south, west, north, east
        near = [k for k, other in enumerate(field.azimuth.values) if abs((other - phi + 180) % 360 - 180) <= 30]
        seen = diffuse.radiance(np.deg2rad(75.0), np.deg2rad(azimuth), 550.0)  # in mW, as the field has it
        assert seen == pytest.approx(field.values[0, 2, near].mean(), rel=0.08)
    photons = scene.source(seed=1).photons(0)
    assert photons.uy.mean(dtype=float) > 0.12  # the south is brighter: photons travel north
    assert abs(photons.ux.mean(dtype=float)) < 0.005


def test_wavelengths_are_joined_as_the_page_says(made):
    assert 'xarray.concat(fields, "wavelength")' in PAGE
    joined = xarray.concat([field for _, field in made], "wavelength")
    table = sky.TabulatedSky.from_xarray(joined, azimuth_convention="clockwise from south")
    assert table.wavelength_nm.tolist() == [550.0, 650.0]
