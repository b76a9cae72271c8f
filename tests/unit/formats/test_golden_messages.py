"""Every good file is read, every bad one gets the message that stands beside it, word for word."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.formats.amc import read_amc, read_difcol, read_lambbot
from aomc_sky.formats.atmo.reader import read_atmo
from aomc_sky.formats.sky_toml.file import read_sky_toml
from aomc_sky.formats.skydist import read_skydist
from aomc_sky.source.atmospheres.medium import read_medium

DATA = Path(__file__).resolve().parents[2] / "data"
READERS: dict[str, Callable[[str], object]] = {
    "amc": read_amc,
    "lambbot": lambda path: read_lambbot(path, n_wavebands=2),
    "difcol": lambda path: read_difcol(path, n_wavebands=2),
    "skydist": read_skydist,
    "sky_toml": read_sky_toml,
    "atmo_blocks": lambda path: read_medium(read_atmo(path)),
}
GOOD = [(kind, path) for kind in READERS for path in sorted((DATA / kind / "good").iterdir())]
BAD = [(kind, p) for kind in READERS for p in sorted((DATA / kind / "bad").iterdir()) if p.suffix != ".expected"]


def name_of(value: object) -> str:
    return value.stem if isinstance(value, Path) else str(value)


@pytest.mark.parametrize(("kind", "path"), GOOD, ids=name_of)
def test_a_good_file_is_read_without_a_word(kind: str, path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert READERS[kind](str(path)) is not None


@pytest.mark.parametrize(("kind", "path"), BAD, ids=name_of)
def test_a_bad_file_gets_its_message(kind: str, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(path.parent)
    with pytest.raises(InputFileError) as caught:
        READERS[kind](path.name)
    assert f"{caught.value}\n" == path.with_suffix(".expected").read_text()
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("kind", ["amc", "lambbot", "difcol", "skydist", "sky_toml", "atmo", "atmo_blocks"])
def test_every_message_says_what_to_write(kind: str) -> None:
    for path in sorted((DATA / kind / "bad").glob("*.expected")):
        carets = [line for line in path.read_text().splitlines() if line.lstrip().startswith("| ") and "^" in line]
        assert all(line.split("^")[-1].strip() for line in carets), path.name


def test_every_expected_message_has_its_file() -> None:
    endings = (".inp", ".toml", ".mcpl", ".h5", ".atmo", ".npy")
    messages = DATA.glob("*/bad/*.expected")
    without = [path for path in messages if not any(path.with_suffix(e).exists() for e in endings)]
    assert without == []
    assert len(BAD) > 60
