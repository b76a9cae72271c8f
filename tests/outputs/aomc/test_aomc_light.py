"""`light` of AOMC with our sky: angles that the program's bins hold, whatever directions come."""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.host_programs import EXAMPLES, QUICK, REFERENCE, copied, make, run
from tests.support.shared import INPUTS

FULL_TURN = np.float32(2) * np.float32(3.14159265)
"""2 pi of the program, where its last azimuth bin ends."""


def constant(name):
    """A constant of single precision as the Fortran text has it."""
    text = (EXAMPLES / "fortran" / "aomc_light.f90").read_text()
    found = re.findall(rf"real, parameter :: {name} = ([0-9.]+)", text)
    assert len(found) == 1, f"{name} stands {len(found)} times in aomc_light.f90"
    return np.float32(found[0])


def free_azimuth(ux, uy):
    """Azimuth of the source in single precision before `below_full_turn` is looked at. [0 to 2 pi, both there]"""
    return np.mod(np.arctan2(-uy.astype(np.float64), -ux.astype(np.float64)), 2 * np.pi).astype(np.float32)


def light_azimuth(ux, uy):
    return np.minimum(free_azimuth(ux, uy), constant("below_full_turn"))


def light_zenith(ux, uy, uz):
    x, y, z = (-u.astype(np.float64) for u in (ux, uy, uz))
    return np.minimum(np.arctan2(np.sqrt(x * x + y * y), z).astype(np.float32), constant("below_horizon"))


def azimuth_bin(phi, n_bins):
    """The program's azimuth bin, from 1, in its own single precision; beyond n_bins it writes outside its array."""
    width = FULL_TURN / np.asarray(n_bins, dtype=np.float32)
    return (phi / width).astype(np.int64) + 1


EVERY_NUMBER_OF_BINS = np.arange(1, 361)


def test_the_largest_azimuth_is_in_the_last_bin_of_all():
    """phi -> INT(phi / nphi) + 1 never falls as phi grows (division and truncation do not), so the largest will do."""
    largest = constant("below_full_turn")
    assert largest < FULL_TURN
    np.testing.assert_array_equal(azimuth_bin(largest, EVERY_NUMBER_OF_BINS), EVERY_NUMBER_OF_BINS)
    # a compiler that divides by multiplying (-ffast-math) is a rounding further off: still inside
    width = FULL_TURN / EVERY_NUMBER_OF_BINS.astype(np.float32)
    assert np.all((largest * (np.float32(1) / width)).astype(int) < EVERY_NUMBER_OF_BINS)
    # planted: 2 pi itself, and the number before it, which is below 2 pi and yet beyond the bins
    assert np.sum(azimuth_bin(FULL_TURN, EVERY_NUMBER_OF_BINS) > EVERY_NUMBER_OF_BINS) == 354
    before = np.nextafter(FULL_TURN, np.float32(0))
    assert np.sum(azimuth_bin(before, EVERY_NUMBER_OF_BINS) > EVERY_NUMBER_OF_BINS) == 69


def extreme_floats():
    """Both signs of 0, subnormals and every exponent up to 1, with the first, last and middle mantissas of each."""
    exponents = np.arange(0, 128, dtype=np.uint32) << 23
    mantissas = np.array([0, 1, 2, 0x2AAAAA, 0x400000, 0x7FFFFE, 0x7FFFFF], dtype=np.uint32)
    bits = (exponents[:, None] | mantissas).ravel()
    magnitude = bits.view(np.float32)
    magnitude = magnitude[magnitude <= 1]
    return np.concatenate([magnitude, -magnitude])


def test_all_signs_and_magnitudes_of_both_components():
    """Every pair of extreme values: 2 pi, -0.0 and NaN never come, and the seam was touched."""
    values = extreme_floats()
    at_the_seam = 0
    for ux in values:
        free = free_azimuth(np.full_like(values, ux), values)
        phi = light_azimuth(np.full_like(values, ux), values)
        at_the_seam += np.count_nonzero(free >= FULL_TURN)
        assert np.all(phi >= 0)
        assert np.all(phi <= constant("below_full_turn"))
        assert np.all(np.abs(phi - free) <= 3 * np.spacing(FULL_TURN))  # turned by 1.5e-6 rad at most
    assert at_the_seam > 10_000  # planted: the law without its bound


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """An AOMC-like program around our `light`, its arrays checked."""
    for command in ("gcc", "gfortran", "make"):
        if shutil.which(command) is None:
            pytest.skip(f"{command} not installed")
    folder = copied("fortran", tmp_path_factory.mktemp("light"))
    run(["gfortran", "-c", "-O1", "-fcheck=bounds", str(REFERENCE / "aomc_stub.f90")], folder)
    make(folder, "light", flags=QUICK)
    objects = [f"{name}.o" for name in ("aomc_stub", "aomc_light", "aomc_difcol", "aomc_sky_module", "aomc_sky")]
    run(["gfortran", "-o", "stub", *objects, "-lm"], folder)
    return folder / "stub"


def set_up(folder, name, iterations=30_000, **files):
    """The source of a copy of a scene with these iterations, other files (None: without) and its day.sky."""
    shutil.copytree(INPUTS / name, folder)
    for file, text in files.items():
        path = folder / file.replace("_", ".")
        path.write_text(text) if text is not None else path.unlink()
    amc = folder / "amc.inp"
    first, rest = amc.read_text().split("\n", 1)
    amc.write_text(f"{first[:48]}{iterations}\n{rest}")
    source = sky.read_scene(folder).source(8)
    sky.write_source(source, folder / "day.sky")
    return source


def launch(program, scene_folder, lsource, n_bands, n):
    """theta and phi, each (n_band, n), and the program's logs: one (layer, azimuth bin) for each number."""
    run([str(program), str(lsource), str(n_bands), str(n), "angles.bin"], scene_folder)
    words = np.fromfile(scene_folder / "angles.bin", np.float32)
    angles, rest = words[: 2 * n * n_bands].reshape(n_bands, n, 2), words[2 * n * n_bands :].view(np.int32)
    logs = []
    for n_bins in EVERY_NUMBER_OF_BINS:
        logs.append(rest[: 2 * n_bins].reshape(2, n_bins))
        rest = rest[2 * n_bins :]
    assert rest.size == 0
    return angles[..., 0], angles[..., 1], logs


def check_angles(batch, theta, phi):
    """Angles to 3e-7 relative: a float32 rounding (6e-8) and atan2 of two libraries, doubled."""
    np.testing.assert_allclose(theta, light_zenith(batch.ux, batch.uy, batch.uz), rtol=3e-7, atol=0)
    np.testing.assert_allclose(phi, light_azimuth(batch.ux, batch.uy), rtol=3e-7, atol=1e-30)
    # phi is the azimuth of the source: the program adds pi, and the photon travels along (ux, uy)
    turned = phi.astype(np.float64) + np.pi
    assert np.abs(np.sin(theta.astype(np.float64)) * np.cos(turned) - batch.ux).max() < 1e-6 + 1.4e-6


@pytest.mark.parametrize(
    ("name", "lsource", "n_bands", "launched"), [("clear_day", 1, 3, 150_001), ("perez_sky", 0, 4, 30_000)]
)
def test_the_program_launches_our_photons(program, tmp_path, name, lsource, n_bands, launched):
    folder = tmp_path / name
    source = set_up(folder, name, launched)
    n = min(source.n_photons(band) for band in range(n_bands))
    theta, phi, logs = launch(program, folder, lsource, n_bands, n)
    for band in range(n_bands):
        check_angles(source.photons(band, 0, n), theta[band], phi[band])
    for n_bins, log in zip(EVERY_NUMBER_OF_BINS, logs, strict=True):
        wanted = np.bincount(azimuth_bin(phi.ravel(), n_bins) - 1, minlength=n_bins)
        np.testing.assert_array_equal(log[0], wanted)
        assert log[1].sum() == n * n_bands


TWO_BANDS = "2\n1.0 1.0\n1.0 1.0\n"


@pytest.mark.parametrize("below_north_deg", [1e-9, 2.5e-5])
def test_no_photon_beyond_the_bins(program, tmp_path, below_north_deg):
    """A beam from a hair before azimuth 360, whose azimuth rounds to 2 pi or to the number before it."""
    n, n_bands, folder = 1000, 2, tmp_path / "seam"
    sun = f"[sun]\nzenith_deg = 50.0\nazimuth_deg = {360 - below_north_deg!r}\n"
    batch = set_up(folder, "beam_only", n, sky_toml=sun, difcol_inp=TWO_BANDS).photons(0)
    theta, phi, logs = launch(program, folder, 0, n_bands, n)
    free = free_azimuth(batch.ux, batch.uy)
    assert np.all(azimuth_bin(free, 360) == 361)  # each would stop the program
    assert np.all(phi == constant("below_full_turn"))
    np.testing.assert_allclose(theta, np.deg2rad(50.0), rtol=3e-7)
    for n_bins, log in zip(EVERY_NUMBER_OF_BINS, logs, strict=True):
        assert log[0][n_bins - 1] == log[0].sum() == n * n_bands


def test_no_difcol_where_sky_toml_says_all(program, tmp_path):
    """The program looks for difcol.inp before any photon; afterwards the scene is as it was."""
    folder = tmp_path / "scene"
    toml = (INPUTS / "perez_sky" / "sky.toml").read_text().replace("[perez]", '[perez]\nspectrum = "flat"')
    source = set_up(folder, "perez_sky", difcol_inp=None, sky_toml=toml)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    theta, phi, _ = launch(program, folder, 0, source.n_bands, 30_000)
    for band in range(source.n_bands):
        check_angles(source.photons(band), theta[band], phi[band])
    (folder / "angles.bin").unlink()
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_difcol_that_is_needed_is_missed(program, tmp_path):
    """Without sky.toml the program says what it always said, and nothing is written."""
    folder = tmp_path / "scene"
    shutil.copytree(INPUTS / "sun_and_sky", folder)
    (folder / "difcol.inp").unlink()
    assert not (folder / "sky.toml").exists()
    command = [str(program), "0", "1", "100", "angles.bin"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert "Failed to open 'difcol.inp'" in done.stdout + done.stderr
    assert not (folder / "difcol.inp").exists()


STALE = {
    "iterations": ("amc.inp", b": 30000", b": 30011", "has other iterations"),
    "intensity": ("difcol.inp", b"0.86 1.00", b"0.86 0.99", "has other iterations"),
    "wavelength": ("lambbot.inp", b"550.0 ", b"551.0 ", "wavelengths of lambbot.inp"),
    "damage": ("day.sky", b"AOMC-SKY", b"AOMC-SKI", "not a source file"),
}


def said_by(program, folder, n_bands, **environment):
    """What the program says of 20 000 photons of each waveband when it stops; empty where it does not."""
    command = [str(program), "0", str(n_bands), "20000", "angles.bin"]
    words = {**os.environ, **environment}
    done = subprocess.run(command, cwd=folder, env=words, capture_output=True, text=True, check=False)
    assert (done.returncode != 0) == bool(done.stderr)
    return done.stderr


def test_a_stale_file_gives_no_light(program, tmp_path):
    """Another iteration, intensity or wavelength than when day.sky was written."""
    folder = tmp_path / "scene"
    set_up(folder, "perez_sky")
    assert said_by(program, folder, 4) == ""
    for file, old, new, says in STALE.values():
        content = (folder / file).read_bytes()
        assert content.count(old) == 1
        (folder / file).write_bytes(content.replace(old, new))
        assert says in said_by(program, folder, 4)
        (folder / file).write_bytes(content)


def test_another_file_by_its_name_and_another_number_of_wavebands(program, tmp_path):
    folder = tmp_path / "scene"
    set_up(folder, "perez_sky")
    (folder / "day.sky").rename(tmp_path / "noon.sky")
    assert "day.sky: the file cannot be read" in said_by(program, folder, 4)
    assert said_by(program, folder, 4, AOMC_SKY_FILE="../noon.sky") == ""
    folder = tmp_path / "two"
    set_up(folder, "beam_only", difcol_inp=TWO_BANDS)
    assert said_by(program, folder, 2) == ""
    (folder / "difcol.inp").write_text("3\n" + 3 * "1.0 1.0\n")
    assert "amc.inp has another number of wavebands than day.sky" in said_by(program, folder, 3)
