"""inputs/bad/README.md shows for every broken file what its reader prints."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.formats.amc import read_amc, read_difcol, read_lambbot
from aomc_sky.formats.sky_toml.file import read_sky_toml
from aomc_sky.formats.skydist import read_skydist

BAD = Path(__file__).resolve().parents[3] / "inputs/bad"
READERS = {
    "amc": read_amc,
    "lambbot": read_lambbot,
    "difcol": read_difcol,
    "skydist": read_skydist,
    "sky": read_sky_toml,
}
FILES = sorted([*BAD.glob("*.inp"), *BAD.glob("*.toml")])


def messages() -> dict[str, str]:
    sections = re.findall(r"^## (\S+)\n.*?^```\n(.*?)^```$", (BAD / "README.md").read_text(), re.M | re.S)
    return {name: message.strip() for name, message in sections}


def test_the_page_names_every_file() -> None:
    assert set(messages()) == {path.name for path in FILES}
    assert len(FILES) >= 10


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_page_shows_what_is_printed(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BAD)
    with pytest.raises(InputFileError) as caught:
        READERS[path.name.split(".")[1]](path.name)
    assert [line.rstrip() for line in str(caught.value).splitlines()] == [
        line.rstrip() for line in messages()[path.name].splitlines()
    ]
