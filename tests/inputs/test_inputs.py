"""The scenes of inputs/: what the script writes is what lies there, and each says what it claims."""

import re
import warnings

import numpy as np
import pytest

import aomc_sky
from aomc_sky.formats.aomc.amc import read_amc
from tests.support.shared import INPUTS, script

HDF5_OF_NIGHT = "2.0.0"
"""Version of the HDF5 library that wrote night_sky/night.h5: another one may lay the same content out otherwise."""
SCENES = sorted(path.parent.name for path in INPUTS.glob("*/amc.inp"))
LONG = ("eclipse", "light_polluted", "twilight")
"""Solved by backward paths, which takes most of a minute."""
MARKED = [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in SCENES]


def read(name):
    """Read a scene as inputs/README.md says it is run."""
    if name == "night_sky":
        pytest.importorskip("h5py")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "difcol.inp: the sky's clearness", aomc_sky.InputWarning)
        warnings.filterwarnings("ignore", ".*hardly any path reaches", aomc_sky.ModelLimitWarning)
        return aomc_sky.read_scene(INPUTS / name / "amc.inp")


def test_script_writes_the_same_bytes(tmp_path):
    script(INPUTS / "make_scenes.py").main(tmp_path)
    endings = (".inp", ".toml", ".atmo")
    written = {p.relative_to(tmp_path): p.read_bytes() for p in tmp_path.rglob("*") if p.suffix in endings}
    files = [p for name in SCENES for p in (INPUTS / name).iterdir() if p.suffix in endings]
    kept = {p.relative_to(INPUTS): p.read_bytes() for p in files}
    assert sorted(written) == sorted(kept)
    assert [path for path in kept if written[path] != kept[path]] == []


def test_script_writes_the_same_night(tmp_path):
    h5py = pytest.importorskip("h5py")
    script(INPUTS / "make_night.py").main(tmp_path)
    made, kept = (folder / "night_sky" / "night.h5" for folder in (tmp_path, INPUTS))
    one, other = aomc_sky.lobes.read_background_file(made), aomc_sky.lobes.read_background_file(kept)
    np.testing.assert_array_equal(one.curves, other.curves)
    assert list(one.animations) == list(other.animations)
    if h5py.version.hdf5_version == HDF5_OF_NIGHT:
        assert made.read_bytes() == kept.read_bytes()


@pytest.mark.slow
def test_script_writes_the_same_measurements():
    made, folder = script(INPUTS / "make_measured.py"), INPUTS / "measured"
    written = {"sky.csv": made.measured, "almucantar.alm": made.almucantar, "principal_plane.ppl": made.principal_plane}
    assert sorted(path.name for path in folder.iterdir()) == sorted(written)
    assert [name for name, text in written.items() if (folder / name).read_text() != text()] == []


def test_readme_lists_every_scene_with_its_footprint():
    rows = re.findall(r"^\| `(\w+)` \|.*\| (\w+) \|$", (INPUTS / "README.md").read_text(), re.MULTILINE)
    assert sorted(name for name, _ in rows) == SCENES
    shapes = {name: read_amc(INPUTS / name / "amc.inp").footprint.name.lower() for name, _ in rows}
    assert dict(rows) == shapes
    assert set(shapes.values()) == {"point", "circle", "rectangle"}


@pytest.mark.parametrize("name", MARKED)
def test_scene_is_sampled_exactly(name):
    scene = read(name)
    source = scene.source(seed=3)
    np.testing.assert_array_equal(source.counts.sum(axis=1), scene.n_photons)
    assert scene.n_photons.min() > 0
    batch = source.photons(band=0, start=0, stop=100)
    assert np.all(batch.uz <= 0)
    np.testing.assert_allclose(batch.ux**2 + batch.uy**2 + batch.uz**2, 1.0, rtol=0, atol=3e-7)


def test_skies_are_what_they_claim():
    # int (1 + 2 mu) mu^2 dmu over int (1 + 2 mu) mu dmu, from 0 to 1; the five-degree rings are within 1e-3 of it
    moments = read("overcast").source().exact_moments(0)
    assert moments.mean_mu == pytest.approx((1 / 3 + 2 / 4) / (1 / 2 + 2 / 3), abs=1e-3)
    scene = read("clear_day")
    (component,) = scene.components
    for row in range(3):
        radiance = component.mass_of(row) / component.grid.projected_solid_angle_sr
        ring, column = np.divmod(int(radiance.argmax()), component.grid.n_azimuth)
        assert abs(component.grid.zenith_bounds_deg[ring].mean() - 35.0) <= 0.5
        assert column in (0, component.grid.n_azimuth - 1)
