"""Every good file is read, every bad one gets the message beside it, word for word, and so do those of inputs/bad."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

import aomc_sky
from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.formats.aomc.amc import read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.skydist import read_skydist
from aomc_sky.formats.mcpl.file import check_mcpl
from aomc_sky.formats.sky_toml.file import read_sky_toml
from aomc_sky.formats.weather import read_weather
from aomc_sky.outputs.photons.npy import read_photons_npy
from aomc_sky.skies.atmosphere.description.medium import read_medium
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.source.read.measured import read_radiance_csv
from tests.support.shared import DATA, INPUTS, REPOSITORY


def read_background(path):
    pytest.importorskip("h5py")
    from aomc_sky.skies.lobes.file.file import read_background_file

    return read_background_file(path)


READERS: dict[str, Callable[[str], object]] = {
    "amc": read_amc,
    "lambbot": lambda path: read_lambbot(path, n_wavebands=2),
    "difcol": lambda path: read_difcol(path, n_wavebands=2),
    "skydist": read_skydist,
    "sky_toml": read_sky_toml,
    "atmo": read_atmo,
    "atmo_blocks": lambda path: read_medium(read_atmo(path)),
    "background": read_background,
    "mcpl": check_mcpl,
    "photons_npy": lambda path: list(read_photons_npy(path).blocks()),
    "radiance_csv": read_radiance_csv,
    "weather": lambda path: read_weather(path, Path(path).name.split("_")[0]),
}
LEAST = {"amc": 20, "lambbot": 10, "difcol": 5, "skydist": 20, "sky_toml": 20, "atmo": 36, "atmo_blocks": 5}
LEAST |= {"background": 9, "mcpl": 5, "photons_npy": 6, "weather": 20, "radiance_csv": 10}
"""Bad files that there are at least."""

ENDINGS = (".inp", ".toml", ".mcpl", ".h5", ".atmo", ".npy", ".csv")
GOOD = [(kind, p) for kind in READERS for p in sorted((DATA / kind / "good").glob("*")) if p.suffix in ENDINGS]
GOOD = [(kind, p) for kind, p in GOOD if kind != "weather" or p.suffix != ".csv"]  # tests/formats/test_weather.py
BAD = [(kind, p) for kind in READERS for p in sorted((DATA / kind / "bad").glob("*")) if p.suffix in ENDINGS]
SHOWN = sorted([*(INPUTS / "bad").glob("*.inp"), *(INPUTS / "bad").glob("*.toml")])


def name_of(value):
    return value.stem if isinstance(value, Path) else str(value)


@pytest.mark.parametrize(("kind", "path"), GOOD, ids=name_of)
def test_a_good_file_is_read_without_a_word(kind, path):
    assert READERS[kind](str(path)) is not None


def refusal(kind, path, monkeypatch):
    monkeypatch.chdir(path.parent)
    with pytest.raises(InputFileError) as caught:
        READERS[kind](path.name)
    assert caught.value.exit_code == 3
    return caught.value


@pytest.mark.parametrize(("kind", "path"), BAD, ids=name_of)
def test_a_bad_file_gets_its_message(kind, path, monkeypatch):
    assert f"{refusal(kind, path, monkeypatch)}\n" == path.with_suffix(".expected").read_text()


@pytest.mark.parametrize("kind", READERS)
def test_every_message_says_what_to_write(kind):
    messages = sorted((DATA / kind / "bad").glob("*.expected"))
    assert messages
    for path in messages:
        carets = [line for line in path.read_text().splitlines() if line.lstrip().startswith("| ") and "^" in line]
        assert all(line.split("^")[-1].strip() for line in carets), path.name


def test_every_expected_message_has_its_file_and_the_page_names_it():
    messages = DATA.glob("*/bad/*.expected")
    assert [path for path in messages if not any(path.with_suffix(e).exists() for e in ENDINGS)] == []
    assert all(sum(of == kind for of, _ in BAD) >= least for kind, least in LEAST.items())
    assert set(shown_messages()) == {path.name for path in SHOWN}
    assert len(SHOWN) >= 10


def shown_messages():
    """What inputs/bad/README.md shows for every broken file."""
    text = (INPUTS / "bad" / "README.md").read_text()
    sections = re.findall(r"^## (\S+)\n.*?^```\n(.*?)^```$", text, re.M | re.S)
    return {name: [line.rstrip() for line in message.strip().splitlines()] for name, message in sections}


@pytest.mark.parametrize("path", SHOWN, ids=lambda path: path.name)
def test_the_page_of_bad_inputs_shows_what_is_printed(path, monkeypatch):
    kind = path.name.split(".")[1]
    error = refusal("sky_toml" if kind == "sky" else kind, path, monkeypatch)
    assert [line.rstrip() for line in str(error).splitlines()] == shown_messages()[path.name]


def test_wavelengths_in_micrometres_can_be_labels():
    """With --lenient they are labels; those of the program's own input, 0 to 30, are no question."""
    for kind, read in (("lambbot", read_lambbot), ("skydist", read_skydist)):
        with pytest.warns(InputWarning, match="wavelengths are in nm, got 0") as caught:
            assert read(DATA / kind / "bad" / "micrometres.inp", lenient=True).wavelength_nm.tolist() == [0.44, 0.55]
        assert len(caught) == 2


ROOMS = [Path(aomc_sky.__file__).parent / room for room in ("formats", "outputs/photons", "skies")]
# the grid knows whether a zenith index is a degree; blocks of code are looked at where they are evaluated; plans,
# manifests and source files are no formats of a person; a whole scene knows which light has no unit, which animations a
# file has, and what of a field is a sky
RUN_CODES = {*(f"E95{k}" for k in range(1, 6)), *(f"E96{k}" for k in range(1, 3)), "E971"}
RAISED_ELSEWHERE = {"E307", "E310", "E311", "E312", "E313", "E708", "E710"} | RUN_CODES


def test_every_code_is_documented_used_and_shown_by_a_bad_file():
    paths = [path for room in ROOMS for path in room.rglob("*.py")]
    used = {code for path in paths for code in re.findall(r'"(E\d{3})"', path.read_text())}
    rows = re.findall(r"^\| (E\d{3}) \|", (REPOSITORY / "docs/errors.md").read_text(), re.MULTILINE)
    assert len(rows) == len(set(rows))
    assert set(rows) - RAISED_ELSEWHERE == used
    shown = {code for path in DATA.glob("*/bad/*.expected") for code in re.findall(r"\[(E\d{3})\]", path.read_text())}
    field_codes = {"E551", "E552", "E553", "E710"}  # tests/faults/test_field_faults.py
    elsewhere = {"E100", "E500", "E708", "E709", "E801", "E901"} | RAISED_ELSEWHERE | RUN_CODES
    assert set(rows) - shown == elsewhere - {"E710"} | field_codes
