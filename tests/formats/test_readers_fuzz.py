"""Readers against gfortran: a mutated file is read as Fortran reads it, or refused with a place inside it."""

import time
import warnings
from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aomc_sky.errors import InputFileError
from aomc_sky.formats.aomc import amc
from aomc_sky.formats.aomc.amc import fields_of_layout, read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.skydist import SkyTable, read_head, read_rows, read_rows_fast, read_skydist, write_skydist
from aomc_sky.formats.report import Report
from aomc_sky.formats.sky_toml.file import read_sky_toml
from aomc_sky.formats.spectrum_csv import read_spectrum_csv
from aomc_sky.formats.text_file import split_lines
from aomc_sky.formats.weather import read_weather
from tests.support.fortran import as_real, compile_reader, needs_gfortran, readings
from tests.support.limits import MOST_CPU_S, answers_within_limits
from tests.support.shared import DATA

ALPHABET = " 0123456789.,-+eEdDqQ\tx:)Nan*/;#!'\"(_\n\r\f\v\xa0\x85\xb2\xe9"
FAST = settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))

MUTATION = st.tuples(st.integers(0, 7), st.integers(0, 40), st.integers(0, 70), st.sampled_from(ALPHABET))
mutations = st.lists(st.lists(MUTATION, min_size=1, max_size=3), min_size=20, max_size=40)


def mutate(text, changes):
    """Insert, delete, replace or swap characters, shift a line, or delete, double or swap columns of a line."""
    lines = text.split("\n")
    for kind, row, column, character in changes:
        row %= len(lines)
        line, words = lines[row], lines[row].split()
        k, w = column % (len(line) + 1), column % max(len(words), 1)
        if kind == 4:
            lines[row : row + 1] = [line, ""] if column % 2 else []
            lines = lines or [""]
            continue
        lines[row] = {
            0: line[:k] + character + line[k:],
            1: line[:k] + line[k + 1 :],
            2: line[:k] + character + line[k + 1 :],
            3: line[:k] + line[k + 1 : k + 2] + line[k : k + 1] + line[k + 2 :],
            5: " ".join(words[:w] + words[w + 1 :]),
            6: " ".join(words[: w + 1] + words[w:]),
            7: " ".join(words[:w] + words[w + 1 : w + 2] + words[w : w + 1] + words[w + 2 :]),
        }[kind]
    return "\n".join(lines)


def texts_of(kind):
    paths = sorted((DATA / kind / "good").glob("*.inp"))
    return [path.read_bytes().decode("latin-1").removeprefix("\xef\xbb\xbf") for path in paths]


def check_places(error, text):
    """Every problem stands inside the text."""
    lines = text.split("\n")
    for problem in error.problems:
        assert 1 <= problem.line <= max(1, len(lines)), str(error)
        # a short line of amc.inp goes on in blanks up to its field
        assert 1 <= problem.column <= max(49, len(lines[problem.line - 1]) + 1), str(error)
        assert problem.render().startswith(f"{problem.path}:{problem.line}:{problem.column}: error[E")


def read_or_refuse(read, text):
    """What a reader returns; None where it refuses the text with a place inside it."""
    start = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read()
    except InputFileError as error:
        check_places(error, text)
        return None
    finally:
        assert time.process_time() - start < MOST_CPU_S


@pytest.fixture(scope="module")
def amc_program(tmp_path_factory):
    return compile_reader("read_amc", tmp_path_factory.mktemp("amc"))


@pytest.fixture(scope="module")
def list_program(tmp_path_factory):
    return compile_reader("read_list", tmp_path_factory.mktemp("list"))


def read_by_fortran(program, kind, changes, letter, end, which=0):
    """Mutated texts of a kind, the file of each, and the words of the compiled reader; None where it refuses."""
    # texts of lists get an `end`: a slash that ends a file without a line end is more than gfortran's library can read
    sources = texts_of(kind)
    texts = [mutate(sources[(which + k) % len(sources)], change) + end for k, change in enumerate(changes)]
    paths = [program.parent / f"{k}.inp" for k in range(len(texts))]
    for path, text in zip(paths, texts, strict=True):
        path.write_bytes(text.encode("latin-1"))
    return zip(texts, paths, readings(program, list(zip(map(letter, texts), paths, strict=True))), strict=True)


@needs_gfortran
@FAST
@given(changes=mutations, which=st.integers(0, 3))
def test_amc_is_read_as_gfortran_reads_it(changes, which, amc_program):
    letter = lambda text: "P" if amc.has_polar_cap_line(text.split("\n")) else "-"  # noqa: E731
    for text, path, words in read_by_fortran(amc_program, "amc", changes, letter, "", which):
        fields = fields_of_layout(letter(text) == "P")
        for lenient in (False, True):
            config = read_or_refuse(lambda p=path, le=lenient: read_amc(p, lenient=le), text)
            if config is None:
                continue
            assert words is not None, f"Fortran refuses {path}"
            wanted = [w if f.decimals is None else as_real(w) for f, w in zip(fields, words, strict=True)]
            assert [
                getattr(config, field.name) for field in fields_of_layout(config.use_polar_cap is not None)
            ] == wanted


@needs_gfortran
@FAST
@given(changes=mutations, which=st.integers(0, 2))
def test_skydist_is_read_as_gfortran_reads_it(changes, which, list_program):
    for text, path, words in read_by_fortran(list_program, "skydist", changes, lambda _: "S", "\n", which):
        for lenient in (False, True):
            table = read_or_refuse(lambda p=path, le=lenient: read_skydist(p, lenient=le), text)
            if table is None:
                continue
            if words is not None:
                check_table(table, words)
                continue
            # the only file that Fortran refuses and --lenient takes is one that ends early, which is told
            assert lenient, f"Fortran refuses {text!r}"
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                read_skydist(path, lenient=True)
            assert any("E303]: numskyelem: the header says" in str(one.message) for one in told)


def check_table(table, words):
    """The table is what Fortran has in its array: the rows that the header announces, the last of equal places."""
    n, n_zenith, n_azimuth, n_table = words[:4]
    assert table.radiance.shape == (n_table, n_zenith, n_azimuth + 1)
    assert table.wavelength_nm.tolist() == [as_real(w) for w in words[4 : 4 + n_table]]
    wanted = np.zeros_like(table.radiance)
    for k in range(4 + n_table, 4 + n_table + 4 * n, 4):
        wanted[words[k] - 1, words[k + 1] - 1, words[k + 2]] = as_real(words[k + 3])
    assert np.array_equal(table.radiance, wanted)


BOTTOM = ("wavelength_nm", "bottom_reflectance", "bottom_specular_fraction")
BAND_FILES = {
    "2": ("difcol", read_difcol, ("direct_fraction", "intensity")),
    "3": ("lambbot", read_lambbot, BOTTOM),
    "5": ("lambbot", partial(read_lambbot, has_target=True), (*BOTTOM, *(f"target_{name[7:]}" for name in BOTTOM[1:]))),
}
"""Columns of a file of wavebands -> its kind, its reader, and what the columns are."""


@needs_gfortran
@FAST
@given(changes=mutations, n_columns=st.sampled_from(sorted(BAND_FILES)))
def test_band_files_are_read_as_gfortran_reads_them(changes, n_columns, list_program):
    kind, read, names = BAND_FILES[n_columns]
    for text, path, words in read_by_fortran(list_program, kind, changes, lambda _: n_columns, "\n"):
        table = read_or_refuse(lambda p=path: read(p), text)
        if table is None:
            continue
        assert words is not None, f"Fortran refuses {text!r}"
        columns = np.stack([getattr(table, name) for name in names], axis=1)
        assert columns.ravel().tolist() == [as_real(w) for w in words[1:]]


TEXTS = (read_amc, read_difcol, read_lambbot, read_sky_toml, read_skydist, read_spectrum_csv)
TEXTS += tuple(partial(read_weather, kind=kind) for kind in ("epw", "tmy3", "tmy2"))


@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
def test_every_reader_of_every_mutated_file_is_bounded(tmp_path):
    """Good files of all text formats, mutated, each through all readers: files under a wrong name are faults, too."""
    generator = np.random.default_rng(11)
    good = [p for kind in ("amc", "lambbot", "difcol", "skydist", "sky_toml") for p in (DATA / kind / "good").iterdir()]
    good += sorted((DATA / "weather" / "good").iterdir()) + sorted((DATA / "atmo" / "good" / "spectra").iterdir())
    path, codes, problems = tmp_path / "file.txt", [], []
    for source in 8 * sorted(path for path in good if path.is_file()):
        draws = generator.integers(0, [8, 41, 71, len(ALPHABET)], size=(3, 4)).tolist()
        changes = [(kind, row, column, ALPHABET[letter]) for kind, row, column, letter in draws]
        path.write_bytes(mutate(source.read_bytes().decode("latin-1"), changes).encode("latin-1"))
        for read in TEXTS:
            begin = time.process_time()
            try:
                read(path)
                codes.append("read")
            except InputFileError as error:
                codes.append(error.problems[0].code)
                problems += error.problems
            assert time.process_time() - begin < MOST_CPU_S
    assert 20 < codes.count("read") < 0.4 * len(codes)
    assert all(problem.message for problem in problems)


def rows_both_ways(path):
    """Rows of a sky file by the fast path and by the slow one; None where the header or the fast path refuses."""
    data = path.read_bytes()
    report = Report(path=str(path))
    head = read_head(split_lines(data), len(data), report)
    fast = None if head is None or report.problems else read_rows_fast(data, head)
    if head is None or fast is None:
        return None
    slow = read_rows(split_lines(data), head, report)
    assert report.problems == []
    return fast, slow


SHAPES = st.tuples(st.integers(1, 3), st.integers(1, 4), st.integers(1, 5))
RADIANCES = arrays(np.float64, SHAPES, elements=st.floats(0, 1.7e308, allow_subnormal=True))


@settings(max_examples=60, deadline=None)
@given(radiance=RADIANCES.filter(lambda a: bool(a.any())))
def test_fast_and_slow_rows_are_the_same(radiance, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "sky.inp"
    waves = np.arange(1.0, radiance.shape[0] + 1) * 400.1
    write_skydist(SkyTable(wavelength_nm=waves, radiance=radiance), path)
    fast, slow = rows_both_ways(path)
    for one, other in ((fast[0], slow[0]), (fast[1], slow[1]), (fast[0], radiance)):
        assert np.array_equal(one, other)


@FAST
@given(changes=mutations)
def test_what_the_fast_path_takes_the_slow_path_takes(changes, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "sky.inp"
    for change in changes:
        path.write_bytes(mutate(texts_of("skydist")[-1], change).encode("latin-1"))
        rows = rows_both_ways(path)
        if rows is not None:
            assert np.array_equal(rows[0][0], rows[1][0])
            assert np.array_equal(rows[0][1], rows[1][1])


READERS = """
from aomc_sky.formats.aomc.amc import read_amc, read_difcol, read_lambbot
from aomc_sky.formats.aomc.skydist import read_skydist
readers = (read_amc, read_lambbot, read_difcol, read_skydist)
"""


HOSTILE = {
    # a gigabyte in one line and headers of 10^9 bins: tests/faults
    "many bad rows": b"400000 89 359 1\n500\n" + b"1 x 0 1.0\n" * 400_000,
    "largest header": b"2 8192 8191 2\n500 600\n1 1 0 x\n",
    "many wavelengths": b"2 1 0 300000\n" + (b"2 " * 30_000 + b"\n") * 10,
    "exponent of thousands of digits": b"1\n400 1e" + b"9" * 5000 + b" 0\n",
    "quarter of a million digits": b"9" * 60_000 + b"\n" + b"1e" + b"9" * 60_000 + b"\n",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_cost_little(name, tmp_path):
    """Refused within 200 MB and without numba or scipy, and soon."""
    path = tmp_path / "file.inp"
    path.write_bytes(HOSTILE[name])
    assert all(answer.startswith("E") for answer in answers_within_limits(READERS, path))
