"""What CalcMySky does with a description, row by row: the same here, or a difference that the format's page names."""

import warnings

import pytest

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from tests.support.shared import DATA, REFERENCE, REPOSITORY, csv_rows

TABLE = REFERENCE / "atmosphere" / "description_parser_behaviour.csv"
PLAIN = DATA / "atmo" / "good" / "plain.atmo"
ACCEPTED, WARNED, REJECTED = "accepted", "accepted with a warning", "rejected"

MOLECULES = PLAIN.read_text().split("Absorber")[0].split("Scatterer")[1]
ALBEDO = "ground albedo: 0.1, 0.1, 0.2, 0.3\n"

# what the tool was given: changes of the plain file; what it did, and after that what we do where it is another thing
ROWS = {
    "first entry is not version": ([("version: 6\n", ""), ("scattering", "version: 6\nscattering")], REJECTED),
    "version 5": ([("version: 6", "version: 5")], REJECTED),
    '"Version:   6   # text" (case, spaces, comment)': ([("version: 6", "Version:   6   # text")], ACCEPTED),
    "CRLF line ends": ([("\n", "\r\n")], ACCEPTED),
    "leading tab before a key in a section": ([("    angstrom", "\tangstrom")], ACCEPTED),
    "unknown top-level key": ([("version: 6\n", "version: 6\nclouds: 3\n")], WARNED),
    "unknown key in a scatterer section": ([("    angstrom", "    charge: 3\n    angstrom")], ACCEPTED, WARNED),
    "line without a colon / with two colons": ([("height: 120", "height 120")], REJECTED),
    "spectrum entry before wavelengths": (
        [("version: 6\n", f"version: 6\n{ALBEDO}"), (f"1.4\n{ALBEDO}", "1.4\n")],
        REJECTED,
    ),
    "wavelength count 6 (not a multiple of 4)": (
        [("count=4", "count=6"), (" 1.4\n", " 1.4, 1, 1\n"), ("0.3\n", "0.3, 0, 0\n"), ("1e-25\n}", "1e-25, 0, 0\n}")],
        REJECTED,
        ACCEPTED,
    ),
    "blank between a wavelength value and the following comma": ([("400nm,", "400nm ,")], REJECTED),
    "wavelength limits given in um": ([("min=400nm", "min=0.4um")], ACCEPTED),
    "length in scientific notation": ([("120 km", "1.2e2 km")], REJECTED),
    "negative Earth radius": ([("6371 km", "-6371 km")], REJECTED),
    "inline albedo value 1.5": ([("0.1, 0.1", "1.5, 0.1")], REJECTED),
    "scattering orders 2.5": ([("orders: 4", "orders: 2.5")], ACCEPTED),
    "scattering orders 0": ([("orders: 4", "orders: 0")], REJECTED),
    "scattering orders absent": ([("scattering orders: 4\n", "")], ACCEPTED, REJECTED),
    "atmosphere height absent": ([("atmosphere height: 120 km\n", "")], ACCEPTED, REJECTED),
    "ground albedo absent": ([(ALBEDO, "")], WARNED),
    "light pollution absent": ([], WARNED, ACCEPTED),
    "solar irradiance absent": ([("solar irradiance at TOA: 1.5, 1.9, 1.7, 1.4\n", "")], REJECTED),
    "wavelengths absent": ([("wavelengths: min=400nm,max=700nm,count=4\n", "")], REJECTED),
    "same key twice (scattering orders)": ([("orders: 4\n", "orders: 4\nscattering orders: 9\n")], ACCEPTED, WARNED),
    "wavelengths or solar irradiance twice": (
        [(" 1.4\n", " 1.4\nsolar irradiance at TOA: 9, 9, 9, 9\nwavelengths: min=500nm,max=600nm,count=4\n")],
        ACCEPTED,
        WARNED,
    ),
    "opening brace indented": ([("\n{", "\n {")], REJECTED),
    "opening brace on the key line": ([(":\n{", ": {")], REJECTED),
    "closing brace of the last section absent": ([("1e-25\n}\n", "1e-25\n")], ACCEPTED, REJECTED),
    "blank line between a code key and its opening fence": ([("density:\n", "density:\n\n")], REJECTED),
    "last fence absent": ([("1e18;\n    ```\n", "1e18;\n")], REJECTED),
    "scatterer and absorber with the same name": ([("ozone", "molecules")], REJECTED),
    "no scatterer at all": ([(f"Scatterer{MOLECULES}", "")], REJECTED),
    "species names": ([("ozone", "O3")], ACCEPTED),
    "unknown phase function type": ([("    angstrom", "    phase function type: odd\n    angstrom")], REJECTED),
    "closing brace followed by a comment at the end of an absorber section": ([("1e-25\n}", "1e-25\n} # c")], REJECTED),
    "two weighted files for solar irradiance": (
        [("1.5, 1.9, 1.7, 1.4\n", "weighted file 1 one.csv\nsolar irradiance at TOA: weighted file 2 one.csv\n")],
        ACCEPTED,
    ),
    "albedo above 1 read from a file": ([("0.1, 0.1, 0.2, 0.3", "file bright.csv")], ACCEPTED, REJECTED),
    "wavelengths outside the data of a spectrum file": ([("0.1, 0.1, 0.2, 0.3", "file short.csv")], REJECTED),
    "colon inside a file path": ([("0.1, 0.1, 0.2, 0.3", "file a:one.csv")], REJECTED),
    "number with an f suffix in a code block": ([("1e18", "1e18f")], ACCEPTED),
}
ONES = "300,1\n900,1\n"
TABLES = {"one.csv": ONES, "a:one.csv": ONES, "bright.csv": "300,1.02\n900,1.02\n", "short.csv": "450,0.1\n900,0.1\n"}


def written(folder, changes):
    text = PLAIN.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new) if old == "\n" else text.replace(old, new, 1)
    for name, table in TABLES.items():
        (folder / name).write_text(table)
    path = folder / "changed.atmo"
    path.write_bytes(text.encode())
    return path


def read(path):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        try:
            description = read_atmo(path)
        except InputFileError:
            return REJECTED, None
    return (WARNED if caught else ACCEPTED), description


@pytest.mark.parametrize("name", ROWS)
def test_a_row(name, tmp_path):
    changes, *outcomes = ROWS[name]
    assert len(set(outcomes)) == len(outcomes)
    assert read(written(tmp_path, changes))[0] == outcomes[-1]


def test_the_rows_are_those_of_the_table():
    table = {row["input"]: row["what the reference tool did"] for row in csv_rows(TABLE)}

    def kind(text):
        if text.startswith(REJECTED):
            return REJECTED
        if text.startswith(WARNED):
            return WARNED
        assert text.startswith(ACCEPTED) or text == "folded to lower case"
        return ACCEPTED

    assert {name: kind(text) for name, text in table.items()} == {name: row[1] for name, row in ROWS.items()}


def values(tmp_path, name):
    description = read(written(tmp_path, ROWS[name][0]))[1]
    assert description is not None
    return description


def test_what_is_accepted_has_the_same_values(tmp_path):
    assert values(tmp_path, "scattering orders 2.5").scattering_orders == 2
    twice = values(tmp_path, "wavelengths or solar irradiance twice")
    assert twice.wavelength_nm.tolist() == [400.0, 500.0, 600.0, 700.0]
    assert twice.solar_irradiance.tolist() == [1.5, 1.9, 1.7, 1.4]
    assert values(tmp_path, "wavelength limits given in um").wavelength_nm[0] == 400.0
    assert [part.name for part in values(tmp_path, "species names").species] == ["molecules", "o3"]
    # unlike in the tool, weighted files of the sun are all added
    assert values(tmp_path, "two weighted files for solar irradiance").solar_irradiance.tolist() == [3.0] * 4


def test_the_page_names_every_difference():
    page = (REPOSITORY / "docs/formats/atmo.md").read_text().split("## Differences")[1].lower()
    words = {
        "unknown key in a scatterer section": "unknown key in a section",
        "wavelength count 6 (not a multiple of 4)": "multiple of 4",
        "scattering orders absent": "`scattering orders` absent",
        "atmosphere height absent": "`atmosphere height`",
        "light pollution absent": "`light pollution relative radiance` absent",
        "same key twice (scattering orders)": "a key twice",
        "wavelengths or solar irradiance twice": "a key twice",
        "closing brace of the last section absent": "closing brace of the last section absent",
        "albedo above 1 read from a file": "albedo above 1",
    }
    assert {name for name, row in ROWS.items() if len(row) == 3} == set(words)
    assert {name for name, word in words.items() if word not in page} == set()
