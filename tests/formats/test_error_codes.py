"""The codes in the readers are those of docs/errors.md."""

import re
from pathlib import Path

import aomc_sky
from tests.support.shared import DATA, REPOSITORY

ROOMS = [Path(aomc_sky.__file__).parent / room for room in ("formats", "outputs/photons", "skies")]
# the grid knows whether a zenith index is a degree; blocks of code are looked at where they are evaluated; plans,
# manifests and source files are no formats of a person; a whole scene knows which light has no unit, which animations a
# file has, and what of a field is a sky
RUN_CODES = {*(f"E95{k}" for k in range(1, 6)), *(f"E96{k}" for k in range(1, 3)), "E971"}
RAISED_ELSEWHERE = {"E307", "E310", "E708", "E710"} | RUN_CODES


def test_every_code_is_documented_and_every_documented_code_is_used():
    paths = [path for room in ROOMS for path in room.rglob("*.py")]
    used = {code for path in paths for code in re.findall(r'"(E\d{3})"', path.read_text())}
    rows = re.findall(r"^\| (E\d{3}) \|", (REPOSITORY / "docs/errors.md").read_text(), re.MULTILINE)
    assert len(rows) == len(set(rows))
    assert set(rows) - RAISED_ELSEWHERE == used


def test_a_documented_code_has_an_example_among_the_bad_files():
    rows = set(re.findall(r"^\| (E\d{3}) \|", (REPOSITORY / "docs/errors.md").read_text(), re.MULTILINE))
    shown = {code for path in DATA.glob("*/bad/*.expected") for code in re.findall(r"\[(E\d{3})\]", path.read_text())}
    field_codes = {"E551", "E552", "E553", "E710"}  # tests/faults/test_field_faults.py
    assert rows - shown == {"E100", "E307", "E310", "E500", "E708", "E709", "E801", "E901"} | field_codes | RUN_CODES
