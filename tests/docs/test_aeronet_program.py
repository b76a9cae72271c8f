"""The program of docs/howto/measured_sky.md for scans of AERONET: right directions, or one sentence and no table."""

import csv
import io
import re
import subprocess
import sys

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.shared import INPUTS

ALMUCANTAR, PLANE = INPUTS / "measured" / "almucantar.alm", INPUTS / "measured" / "principal_plane.ppl"
PROGRAM = INPUTS / "alm_to_csv.py"
HOUR = "21:06:2026,15"
FROM_THE_SUN = "# azimuth: clockwise from the sun\n# radiance unit: uW cm-2 nm-1 sr-1\n"


def converted(path, hour=HOUR):
    return subprocess.run([sys.executable, PROGRAM, path, hour], capture_output=True, text=True, check=False)


def rows(done):
    assert done.returncode == 0, done.stderr
    text = re.sub(r"^#.*\n", "", done.stdout, flags=re.MULTILINE)
    return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(io.StringIO(text))]


def changed(tmp_path, path, *pairs):
    text = path.read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / path.name).write_text(text)
    return tmp_path / path.name


def invented(made, minute):
    """The sky that inputs/make_measured.py had for 440 nm."""
    perez = sky.PerezSky(sun_zenith_deg=55 + minute / 10, sun_azimuth_deg=0, epsilon=3.0, delta=0.15)
    zenith, azimuth = (np.deg2rad([row[name] for row in made]) for name in ("zenith_deg", "azimuth_deg"))
    return perez.radiance(zenith, -azimuth, 440) * 260 / sky.FunctionSky(perez.radiance).irradiance(440)[0] / 10


@pytest.mark.parametrize(
    ("path", "minute", "n", "sun"), [(ALMUCANTAR, 0, 228, 55.15), (PLANE, 4, 120, 55.55)], ids=["alm", "ppl"]
)
def test_every_direction_has_the_radiance_that_the_invented_sky_has_there(path, minute, n, sun):
    done = converted(path)
    assert done.stdout.startswith(f"{FROM_THE_SUN}# sun zenith: {sun}\nzenith_deg,azimuth_deg,wavelength_nm,radiance\n")
    assert done.stderr == f"{n} radiances of 4 rows; 8 cells left out: gaps such as -999, and the sun itself\n"
    made = rows(done)
    assert len(made) == n
    assert {row["wavelength_nm"] for row in made} == {440, 675, 870, 1020}
    blue = [row for row in made if row["wavelength_nm"] == 440]
    np.testing.assert_allclose([row["radiance"] for row in blue], invented(blue, minute), rtol=1e-4)


def test_directions_of_an_almucantar_and_a_plane():
    """Azimuths from the sun at its zenith angle; and angles from the sun that go up, through the zenith and down."""
    alm = rows(converted(ALMUCANTAR))
    assert {row["zenith_deg"] for row in alm} == {55.0, 55.1, 55.2, 55.3}
    assert {row["azimuth_deg"] for row in alm} >= {-180, -3, 3, 90, 180}
    assert 0 not in {row["azimuth_deg"] for row in alm}
    ppl = [row for row in rows(converted(PLANE)) if row["wavelength_nm"] == 440]
    at = [(row["zenith_deg"], row["azimuth_deg"]) for row in ppl]
    assert at[0] == (61.4, 0)
    assert at[-1] == (64.6, 180)
    assert [zenith for zenith, azimuth in at if azimuth == 180] == [4.6, 14.6, 24.6, 34.6, 44.6, 64.6]


def test_the_table_is_read_without_a_question(tmp_path):
    (tmp_path / "sky.csv").write_text(converted(ALMUCANTAR).stdout)
    measured = sky.read_radiance_csv(tmp_path / "sky.csv", sun_azimuth_deg=200.0)
    at_the_left = measured.radiance(np.deg2rad(55.0), np.deg2rad(200 - 30.0), 440)  # clockwise is against our sense
    (row,) = (r for r in rows(converted(ALMUCANTAR)) if r["azimuth_deg"] == 30 and r["wavelength_nm"] == 440)
    assert at_the_left == pytest.approx(row["radiance"] / 100, rel=0.02)


LAST = PLANE.read_text().splitlines()[-1]
LEFT_OUT = {
    "gaps": (ALMUCANTAR, [("4.260628,", "N/A,"), ("4.241009,", ",")], 224, 12),
    "a row that ends early": (PLANE, [(LAST, LAST.rsplit(",", 3)[0])], 117, 11),
    "the sun itself": (PLANE, [("-999.000000", "5000.000000")], 124, 4),
    "a sun that moves": (PLANE, [("55.700000", "56.000000")], 120, 8),
}


@pytest.mark.parametrize("name", LEFT_OUT)
def test_what_is_left_out_is_counted(tmp_path, name):
    """A sun that moves while the plane is seen is not stated."""
    path, pairs, n, left_out = LEFT_OUT[name]
    done = converted(changed(tmp_path, path, *pairs))
    assert done.stderr.startswith(f"{n} radiances of 4 rows; {left_out} cells left out")
    assert len(rows(done)) == n
    assert ("sun zenith" in done.stdout) == ("moves" not in name)


def test_nothing_but_gaps_is_no_table(tmp_path):
    lines = PLANE.read_text().splitlines()
    lines[7:] = [",".join([*line.split(",")[:8], *["-999.000000"] * 32]) for line in lines[7:]]
    (tmp_path / "gaps.ppl").write_text("\n".join(lines))
    done = converted(tmp_path / "gaps.ppl")
    assert (done.returncode, done.stdout) == (1, "")
    assert "has no radiance" in done.stderr


SCATTERING = "Scattering_Angle_for_Nominal_Azimuth_Angle(Degrees)"
RADIANCE = "Radiance_for_Azimuth_Angle_in_Degrees(uW/cm^2/sr/nm)"
REFUSED = {
    "another kind of scan": (PLANE, [("Principal Plane,", "Hybrid,")], "Hybrid"),
    "a file that does not say its kind": (PLANE, [("Sky_Scan_Type", "Kind")], "no row of names"),
    "no scan of this hour": (PLANE, [(",15:", ",16:")], "no radiance"),
    "another block": (ALMUCANTAR, [(SCATTERING, "Degree_of_Polarization")], "unknown block"),
    "a block without a name": (ALMUCANTAR, [(SCATTERING, ""), (RADIANCE, "")], "second block"),
    "two blocks of radiances": (ALMUCANTAR, [(SCATTERING, "Radiance_for_Other")], "second block"),
}


@pytest.mark.parametrize(("path", "pairs", "words"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_converted_is_said_in_one_sentence(tmp_path, path, pairs, words):
    done = converted(changed(tmp_path, path, *pairs))
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert words in done.stderr


def test_a_block_is_named_once_or_above_every_column(tmp_path):
    lines = ALMUCANTAR.read_text().splitlines()
    cells = lines[6].split(",")
    lines[6] = ",".join("" if cell == before else cell for before, cell in zip(["", *cells], cells, strict=False))
    (tmp_path / "once.alm").write_text("\n".join(lines))
    assert converted(tmp_path / "once.alm").stdout == converted(ALMUCANTAR).stdout
