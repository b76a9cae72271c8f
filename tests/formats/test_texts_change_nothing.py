"""Sentences of scientists in eight languages beside a table and a field: the light is the same, and they are quoted."""

import numpy as np
import pytest

import aomc_sky as sky

xarray = pytest.importorskip("xarray")

ZENITH, AZIMUTH = np.array([10.0, 40.0, 70.0]), np.arange(0.0, 360.0, 45.0)
VALUES = 100.0 + ZENITH[:, None] + AZIMUTH / 10
SENTENCES = [
    # factors and scales, angles, azimuths, and what a key or a unit could be taken from
    "Radiances were stored as thousand-fold integers.", "1 count = 0.001 W m-2 nm-1 sr-1", "scale factor: 0.001",
    "Radiances x 1000", "log10 of the radiances", "Saturated pixels have the value 150.", "mu = cos(theta)",
    "Zenith is counted up from the horizontal plane.", "directions of propagation", "angles in gradians",
    "Azimuth from magnetic north, declination 3 E", "x = north, y = east", "phi = 180 towards the sun", "frame NED",
    "Die Azimute zählen im Uhrzeigersinn von Norden.", "Les luminances sont multipliées par 100.",
    "Los ángulos de acimut se cuentan desde el norte.", "Os azimutes contam do sul para o oeste.",
    "Gli azimut sono contati da est in senso antiorario.", "Яркости умножены на 1000.", "方位角: 北から時計回り",
    "辐亮度单位为毫瓦",
]  # fmt: skip
STATED = ["# azimuth: clockwise from north", "# radiance unit: W m-2 nm-1 sr-1"]


def table(path, *lines):
    angles = [(z, a) for z in ZENITH for a in AZIMUTH]
    rows = [f"{z:g},{a:g},{v:.17g}" for (z, a), v in zip(angles, VALUES.ravel(), strict=True)]
    path.write_text("\n".join([*lines, "zenith_deg,azimuth_deg,radiance", *rows, ""]), encoding="utf-8")
    return sky.read_radiance_csv(path)


def field(*, file="", light="", zenith="", azimuth="", convention="clockwise from north"):
    stated = {"azimuth_convention": convention} if convention else {}
    coords = {
        "zenith": ("zenith", ZENITH, {"units": "degree", "long_name": zenith}),
        "azimuth": ("azimuth", AZIMUTH, {"units": "degree", "comment": azimuth, **stated}),
    }
    light = (("zenith", "azimuth"), VALUES, {"units": "W m-2 nm-1 sr-1", "comment": light})
    return sky.TabulatedSky.from_xarray(xarray.Dataset({"radiance": light}, coords, {"title": file}))


SILENT = field()


def is_quoted(sentence, remarks):
    return any(one.startswith("the file says") and f'"{sentence}"' in one for one in remarks)


@pytest.mark.parametrize("sentence", SENTENCES)
def test_beside_a_table(sentence, tmp_path):
    """A line of a stated table changes no bit and is quoted; a table that states nothing is asked, and it is quoted."""
    silent, spoken = table(tmp_path / "a.csv", *STATED), table(tmp_path / "b.csv", *STATED, f"# {sentence}")
    np.testing.assert_array_equal(spoken.values[0], silent.values[0])
    np.testing.assert_array_equal(spoken.direction[0], silent.direction[0])
    assert spoken.is_absolute
    assert spoken.sun is None
    assert is_quoted(sentence, spoken.remarks)
    assert not any(one.startswith("the file says") for one in silent.remarks)
    with pytest.raises(sky.InputFileError, match="nothing says from where") as error:
        table(tmp_path / "c.csv", f"# {sentence}")
    assert f'its text says "{sentence}"' in str(error.value)


@pytest.mark.parametrize("sentence", SENTENCES)
def test_beside_a_field(sentence):
    """As title of the file, text of the radiance or of an angle."""
    assert not any(one.startswith("the file says") for one in SILENT.remarks)
    for place in ("file", "light", "zenith", "azimuth"):
        spoken = field(**{place: sentence})
        np.testing.assert_array_equal(spoken.values, SILENT.values)
        np.testing.assert_array_equal(spoken.slope, SILENT.slope)
        assert spoken.grid == SILENT.grid
        assert (spoken.radiance_unit, spoken.has_wavelength) == (1.0, False)
        assert is_quoted(sentence, spoken.remarks)
    with pytest.raises(sky.SceneError, match="nothing says from where azimuth 'azimuth' counts") as error:
        field(azimuth=sentence, convention="")
    assert f'its text says "{sentence}"' in str(error.value)


def test_many_and_long_texts_are_cut(tmp_path):
    lines = [f"# text {k} {'x' * 300}\x1b[31m" for k in range(8)]
    (note,) = [one for one in table(tmp_path / "a.csv", *STATED, *lines).remarks if one.startswith("the file says")]
    assert note.count('"text') == 5
    assert "; and 3 more (texts change nothing)" in note
    assert note.isprintable()
    assert len(note) < 1200


def test_plain_texts_are_not_quoted():
    angles = {
        "zenith": ("zenith", ZENITH, {"units": "deg", "long_name": "Viewing zenith angle"}),
        "azimuth": ("azimuth", AZIMUTH, {"units": "degree_true", "standard_name": "sensor_azimuth_angle"}),
    }
    light = (("zenith", "azimuth"), VALUES, {"units": "W m-2 nm-1 sr-1", "long_name": "Radiance"})
    of_file = {"Conventions": "CF-1.11", "history": "made", "institution": "a place", "source": "a radiometer"}
    remarks = sky.TabulatedSky.from_xarray(xarray.Dataset({"radiance": light}, angles, of_file)).remarks
    assert not any(one.startswith(("the file says", "not used")) for one in remarks)
