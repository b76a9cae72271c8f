"""2500 spoilt descriptions: an answer for each, at a place of the file; and the answers stay when a reader changes.

Good files and bad ones of tests/data and those of inputs are spoilt by seeds. spoilt_files.json has a short digest of
each answer: numbers with nine digits, or code, line, column and width of every problem; wordings are free. A file of
another answer is named with both. After a change on purpose, or of the files in `SOURCES`,
`python -m tests.skies.atmosphere.description.test_spoilt_files` writes it anew.
"""

import collections
import hashlib
import json
import random
import re
import shutil
import tempfile
import warnings
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning, SourceText
from aomc_sky.skies.atmosphere.description.data import AtmosphereDescription
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from tests.support.shared import DATA, INPUTS, REPOSITORY

GOLDEN = Path(__file__).with_name("spoilt_files.json")
SOURCES = sorted([*DATA.glob("atmo*/*/*.atmo"), *INPUTS.glob("*/*.atmo")])
N_OF_GOOD, N_OF_BAD = 100, 20

TOKENS = (
    *' \t#:{}"`,.-+e0127\n\r\0\ufeff\u00a0\u2028x\u00e9',
    *("```", "km", "nm", "AU", "^2", "1e9", "inf", "nan", "min=", "count=4,", "\n```\n", "\n{\n", "\n}\n", "\n\n"),
    *("file ", "weighted file 1 ", "weighted file 0.5 ", "file x.csv", "file spectra/sun.csv", "../", "-0", "1e-40"),
)
LINES = (
    *("```", "{", "}", "version: 6", "version: 5", 'Scatterer "a":', 'Absorber "molecules":', 'Scatterer "Molecules":'),
    *("needs interpolation guides", "all textures are radiances", "no eclipsed double scattering textures"),
    *("wavelengths: min=400nm,max=700nm,count=4", "wavelengths: min=400nm,max=700nm,count=0", "wavelengths:"),
    *("solar irradiance at TOA: 1, 1, 1, 1", "solar irradiance at TOA: weighted file 1 spectra/sun.csv"),
    *("ground albedo: weighted file -0.5 spectra/snow.csv", "ground albedo: 0.5, 0.5, 0.5, 0.5", "ground albedo:"),
    "light pollution relative radiance: file spectra/lamps.csv",
    "light pollution relative radiance: weighted file 2 spectra/lamps.csv",
    "light pollution relative radiance: 1e-5, 1e-5, 1e-5, 1e-5",
    *("single scattering albedo: 1, 0.5, 1, 2", "cross section: 1, 2, 3, 4", "cross section: file spectra/sun.csv"),
    *("phase function: file spectra/sun.csv", "phase function type: smooth", "phase function type: smoth"),
)
BLOCK = ["```", "    return 1.0;", "```"]


class Spoiler:
    """Spoils the lines of one file; `Random.random` alone is the same in every version of Python."""

    def __init__(self, lines, seed):
        self.lines = lines
        self._random = random.Random(seed).random
        self.ways = [self.cut, self.double, self.swap, self.shorten, self.move, self.fence, self.put, self.insert]
        self.ways += [self.erase, self.change_value, self.repeat, self.change_case, self.copy_section]

    def below(self, n):
        return int(self._random() * n)

    def one_of(self, things):
        return things[self.below(len(things))]

    def line(self):
        return self.below(len(self.lines))

    def spoil(self, n):
        for _ in range(n):
            self.one_of(self.ways)()
            self.lines = self.lines or [""]

    def cut(self):
        first = self.line()
        del self.lines[first : first + 1 + self.below(3)]

    def double(self):
        at = self.line()
        self.lines[at:at] = self.lines[at : at + 1 + self.below(3)]

    def swap(self):
        one, other = self.line(), self.line()
        self.lines[one], self.lines[other] = self.lines[other], self.lines[one]

    def shorten(self):
        if self.below(3):  # seldom, because little is left
            return
        last = self.line()
        self.lines[last:] = [self.lines[last][: self.below(len(self.lines[last]) + 1)]]

    def move(self):
        first = self.line()
        block = self.lines[first : first + 1 + self.below(12)]
        del self.lines[first : first + len(block)]
        at = self.below(len(self.lines) + 1)
        self.lines[at:at] = block

    def fence(self):
        """A code block below a line, open now and then."""
        at = self.line() + 1
        self.lines[at:at] = BLOCK[: 3 - self.below(8) // 7]

    def put(self):
        """A token in a line, before a character or for it."""
        row = self.line()
        text = self.lines[row]
        at = self.below(len(text) + 1)
        self.lines[row] = text[:at] + self.one_of(TOKENS) + text[at + self.below(2) :]

    def insert(self):
        at = self.line()
        self.lines[at:at] = [self.one_of(LINES)]

    def erase(self):
        row = self.line()
        text = self.lines[row]
        at = self.below(len(text) + 1)
        self.lines[row] = text[:at] + text[at + 1 + self.below(3) :]

    def entries(self):
        return [row for row, text in enumerate(self.lines) if ":" in text] or [0]

    def change_value(self):
        """The value of another line, or none."""
        row, other = self.one_of(self.entries()), self.one_of(self.entries())
        value = self.lines[other].partition(":")[2] if self.below(4) else ""
        self.lines[row] = f"{self.lines[row].partition(':')[0]}:{value}"

    def repeat(self):
        """An entry once more with another digit, mostly below itself."""
        row = self.one_of(self.entries())
        text = re.sub("[0-9]", str(self.below(10)), self.lines[row], count=1 + self.below(2))
        at = row + 1 if self.below(3) else self.line()
        self.lines[at:at] = [text]

    def change_case(self):
        row = self.line()
        text = self.lines[row]
        self.lines[row] = self.one_of([text.upper(), text.lower(), text.strip(), f"  {text}", f"{text} "])

    def sections(self):
        """Where sections stand."""
        heads = [row for row, text in enumerate(self.lines) if text.startswith(("Scatterer", "Absorber"))]
        ends = (
            next((row for row, text in enumerate(self.lines) if row > one and text.startswith("}")), one)
            for one in heads
        )
        return [slice(first, last + 1) for first, last in zip(heads, ends, strict=True)]

    def copy_section(self):
        self.lines += self.lines[self.one_of(self.sections() or [slice(0)])]


def spoilt(source, k):
    """The text of a file, spoilt in the k-th way: first by a code block below its wavelengths, then by what is random.

    In the second one the first section stands above them, where a scatterer may stand.
    """
    name = source.relative_to(REPOSITORY).as_posix()
    spoiler = Spoiler(source.read_bytes().decode().split("\n"), f"{name} {k}")
    at = next((row for row, text in enumerate(spoiler.lines) if text.startswith("wavelengths")), 0)
    if k > 1:
        spoiler.spoil((1, 1, 2, 4)[k % 4])
    elif k:
        section = (spoiler.sections() or [slice(0)])[0]
        block = spoiler.lines[section]
        del spoiler.lines[section]
        spoiler.lines[at:at] = block
    else:
        spoiler.lines[at + 1 : at + 1] = BLOCK
    return "\n".join(spoiler.lines)


_FREE = {"path", "texts"}


def shown(value):
    """Content in words, floats with nine digits; without paths and wordings."""
    if is_dataclass(value):
        return [[field.name, shown(getattr(value, field.name))] for field in fields(value) if field.name not in _FREE]
    if isinstance(value, (tuple, list)):
        return [shown(one) for one in value]
    if isinstance(value, np.ndarray):
        return shown(value.tolist())
    if isinstance(value, float):
        return f"{value:.9g}"
    return dict(value) if hasattr(value, "keys") else str(value)


def read(path, text):
    """The description or the error, the warnings, and all of it in short; anything else than the two is raised."""
    path.write_bytes(text.encode())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = read_atmo(path)
        except InputFileError as error:
            found = error
    if isinstance(found, InputFileError):
        said = [[Path(p.path).name, p.code, p.line, p.column, p.width, p.is_error] for p in found.problems]
    else:
        places = [re.match(r"(:\d+:\d+)?: warning\[E...\]", str(one.message).removeprefix(str(path))) for one in caught]
        said = [[place and place[0] for place in places], shown(found)]
    return found, caught, json.dumps(said)


def short(answer):
    return hashlib.sha256(answer.encode()).hexdigest()[:4]


def check_error(error, path, text):
    """Every problem names a file and a place inside it."""
    assert error.problems
    assert str(error)
    for problem in error.problems:
        assert problem.code[:2] in ("E4", "E1")
        assert problem.is_error
        assert problem.message
        assert problem.advice or problem.code == "E101"
        named = text if problem.path == str(path) else Path(problem.path).read_text()
        lines = named.split("\n")
        assert 0 <= problem.line <= len(lines)
        if not problem.line:
            assert (problem.column, problem.text) == (0, "")
            continue
        line = lines[problem.line - 1].removeprefix("\ufeff" if problem.line == 1 else "")
        assert problem.width >= 1
        assert 1 <= problem.column <= len(line) + 1
        if problem.text and problem.code != "E101":
            assert problem.text == line.removesuffix("\r")
            assert problem.column + problem.width <= max(len(line), problem.column) + 1


def check_description(found, caught, text):
    """Spectra lie on the wavelengths and inside their ranges, and code stands in the file where it says."""
    assert isinstance(found, AtmosphereDescription)
    assert {one.category for one in caught} <= {InputWarning}
    n = len(found.wavelength_nm)
    shares = [found.ground_albedo, *(one.single_scattering_albedo for one in found.scatterers)]
    rows = [found.solar_irradiance, *shares, *(one.cross_section_m2 for one in found.absorbers)]
    rows += [] if found.ground_glow is None else [found.ground_glow]
    assert all(row.shape == (n,) and np.all(row >= 0.0) and np.all(np.isfinite(row)) for row in rows)
    assert all(np.all(row <= 1.0) for row in shares)
    assert not any(row.flags.writeable for row in [found.wavelength_nm, *rows])
    assert np.all(np.diff(found.wavelength_nm) > 0)
    assert found.scatterers
    lines, rest = text.split("\n"), re.sub(r"(?m)^\s*```\s*$[^`]*^\s*```\s*$", "", text)
    assert len(re.findall(r"(?mi)^\s*(?:scatterer|absorber)\b", rest)) == len(found.species)
    assert len({one.name for one in found.species}) == len(found.species)
    for one in found.species:
        for code in (one.number_density, getattr(one, "phase_function", None)):
            if isinstance(code, SourceText):
                there = lines[code.line - 1 : code.line + code.text.count("\n")]
                # an empty block has no line of its own
                assert [line.removesuffix("\r") for line in there] == code.text.split("\n") or not code.text


def answers(folder, every=1):
    """Each spoilt file with its name, way, path, text and answer; of its ways one of `every`."""
    for owner in {source.parent for source in SOURCES}:
        there = folder / owner.relative_to(REPOSITORY)
        there.mkdir(parents=True)
        for tables in ("spectra", "phase"):
            if (owner / tables).is_dir():
                shutil.copytree(owner / tables, there / tables)
    for source in SOURCES:
        name = source.relative_to(REPOSITORY)
        path = folder / name.with_name("spoilt.atmo")
        for k in range(0, N_OF_BAD if source.parent.name == "bad" else N_OF_GOOD, every):
            text = spoilt(source, k)
            yield name.as_posix(), k, path, text, *read(path, text)


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_spoilt_files_get_the_answers_that_they_had(every, tmp_path):
    golden = json.loads(GOLDEN.read_text())
    assert sorted(golden) == [source.relative_to(REPOSITORY).as_posix() for source in SOURCES]
    codes = collections.Counter()
    for name, k, path, text, found, caught, answer in answers(tmp_path, every):
        if isinstance(found, InputFileError):
            check_error(found, path, text)
            codes.update({problem.code for problem in found.problems})
        else:
            check_description(found, caught, text)
            codes["read"] += 1
        if short(answer) != golden[name].split()[k]:
            pytest.fail(f"another answer for way {k} of {name}:\n{answer}\n\nThe file:\n{text}")
    # not a test of nothing: every code of a description comes, and a good part is read
    n_golden = sum(len(ways.split()) for ways in golden.values())
    assert n_golden >= 2500
    assert 0.1 < every * codes["read"] / n_golden < 0.5
    assert min(codes[f"E{code}"] for code in (101, 401, 402, 404, 405, 406, 407, 408, 409)) >= 2, codes


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        found = collections.defaultdict(list)
        for name, _, _, _, _, _, answer in answers(Path(folder)):
            found[name].append(short(answer))
    GOLDEN.write_text(json.dumps({name: " ".join(ways) for name, ways in found.items()}, indent=1) + "\n")
