"""Damaged, stale and hostile files, wrong calls, and compilers with other arithmetic: a code each time."""

import re
import shutil
import subprocess

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.component import Law
from aomc_sky.emission import source_file
from aomc_sky.emission.source_file import checksum
from aomc_sky.plan.laws import law_of
from tests.support.builds import APART, SANITIZED, header, sanitized
from tests.support.host_programs import run
from tests.support.shared import REPOSITORY
from tests.support.source_files import (
    FLAGS_OF_HOST,
    SCENES,
    biased,
    built,
    needs_gcc,
    same_bits,
    section_names,
    source_of,
)

pytestmark = needs_gcc
HEADER = include_dir() / "aomc_sky.h"
CODES = {name: int(value) for name, value in re.findall(r"AOMC_SKY_(\w+) = (-\d+)", HEADER.read_text())}
NAMES = {value: name for name, value in CODES.items()} | {0: "ok"}
FUZZED = [("everything", {}), ("lobes and all", {}), ("sloped", {"precision": "float64", "order": "patch"})]
FUZZED += [
    ("disc and table", {"is_biased": True, "replicates": 3}),
    ("perez", {"is_biased": True, "precision": "float64"}),
]


def word(value, width=8):
    return np.float64(value).tobytes() if isinstance(value, float) else int(value).to_bytes(width, "little")


def sealed(data):
    return data[:40] + word(checksum(data)) + data[48:]


def with_bytes(data, at, new):
    return sealed(data[:at] + new + data[at + len(new) :])


def entry(data, name):
    """Where the entry of a section stands in the directory of the first band, its offset and its count."""
    record = np.frombuffer(data, "<u8", 40, 192)
    kind = section_names().index(name) + 1
    for k in range(int(record[6])):
        at = int(record[5]) + 24 * k
        what, offset, count = np.frombuffer(data, "<u8", 3, at).tolist()
        if what & 0xFFFFFFFF == kind:
            return at, offset, count
    raise KeyError(name)


@pytest.fixture(scope="module")
def data():
    return source_of("lobes and all", 5000).to_bytes()


def code_of(data, flags="-O2"):
    return NAMES[built(flags).view(data)]


def code_said(line):
    return NAMES[int(line.split()[0])]


def read_under_sanitizers(files, folder):
    """What a reader built with sanitizers says of files, a line each that begins with the code."""
    program = str(sanitized("source_driver"))
    for number, data in enumerate(files):
        (folder / f"{number}.sky").write_bytes(data)
    return run([program, *(f"{number}.sky" for number in range(len(files)))], folder).splitlines()


HEADS = [
    (0, b"MCPL", "NOT_OURS"), (8, b"\2", "NEWER"), (16, b"aomc-sky/3", "STREAMS"), (16, b"aomc-sky/44", "STREAMS"),
    (12, b"\5", "DIRECTORY"), (12, b"\10", "TABLE"), (32, b"\xff", "SIZE"), (48, b"\xff\xff\xff\xff", "DIRECTORY"),
    (56, word(1 << 40), "DIRECTORY"),
]  # fmt: skip
RECORD = [
    (0, word(1 << 63), "TABLE"),  # photons of the first band
    (8, word(2**31), "TABLE"),  # slots
    (8, word(1), "DIRECTORY"),
    (40, word(1 << 60), "DIRECTORY"),
    (48, word(1 << 60), "DIRECTORY"),
    (56, b"\6", "NEWER"),  # a switch that this header does not know
    (8 * 18, b"\x3f", "TABLE"),  # step of the guide
]


@pytest.mark.parametrize(("at", "new", "code"), [*HEADS, *((192 + at, *more) for at, *more in RECORD)])
def test_heads_and_records(data, at, new, code):
    assert code_of(with_bytes(data, at, new)) == code


WIDTHS = {"cumulative": 4, "guide": 4, "lobe": 4, "bins": 4}


@pytest.mark.parametrize(
    ("section", "index", "values"),
    [
        ("cumulative", 0, (1,)),
        ("cumulative", 5, (2**32 - 1,)),
        ("cumulative", -1, (0,)),
        ("guide", 0, (2**31, 3)),  # 3: a slot behind the one of the rank
        ("place", 0, (2**63,)),
        ("place", 1, (2**31,)),
        ("words", 0, (0x7F800000_00000000, 0x42000000_00000000)),  # infinity; a growth of 32
        ("perez_bound", 0, (np.nan, -1.0)),
        ("perez_sky", 3, (np.inf,)),
        ("lobe", 30, (99, 2**32 - 2)),
        ("ranges", 0, (2**40,)),
        ("ranges", 1, (17, 0)),
        ("ranges", 2, (2**40,)),
        ("bins", 0, (2**32 - 1,)),
        ("shapes", 0, (np.inf,)),
        ("envelopes", 3, (0.0,)),  # bins of a cell
        ("envelopes", 7, (-1.0, np.nan)),  # bound
        ("bin_proposals", 1, (2**62,)),
        ("bin_proposals", 4, (3,)),
        ("bins_per_photon", 0, (1e300,)),
        ("bins_per_photon", 1, (-1e300,)),
    ],
)
def test_a_number_of_a_table_out_of_its_bounds(data, section, index, values):
    (_, offset, count), width = entry(data, section), WIDTHS.get(section, 8)
    for value in values:
        assert code_of(with_bytes(data, offset + width * (index % count), word(value, width))) == "TABLE"


def test_no_law_but_those_of_the_table(data):
    """Of a cell that is not a lobe, and of one that is."""
    (_, offset, count), (_, lobes, _) = entry(data, "law"), entry(data, "lobe")
    is_lobe = np.frombuffer(data, "<i4", count, lobes) >= 0
    known = [{law for law in Law if law_of(law).directions}, {law for law in Law if law_of(law).hook == "lobes"}]
    for cell, laws in zip((0, int(np.argmax(is_lobe))), known, strict=True):
        codes = {number: code_of(with_bytes(data, offset + cell, word(number % 256, 1))) for number in range(-128, 128)}
        assert {number for number, code in codes.items() if code != "TABLE"} <= laws  # some have other parameters
        assert codes[data[offset + cell]] == "ok"


@pytest.mark.parametrize("section", ["cumulative", "guide", "place", "words", "law", "bins", "witnesses", "perez_word"])
def test_a_section_outside_of_the_file_or_of_another_length(data, section):
    at, offset, count = entry(data, section)
    offsets = (len(data) // 64 * 64, 2**63, offset + 8)  # the last is not aligned
    counts = (count + 10**9, 2**63)
    if section not in ("words", "bins"):  # their lengths follow from nothing else
        counts += (count - 1,)
    for place, values in ((at + 8, offsets), (at + 16, counts)):
        assert {code_of(with_bytes(data, place, word(value))) for value in values} == {"DIRECTORY"}


ODD = (-1.0, -0.1, 0.0, 0.5, 1.0, 1.5, 2.0, 3.9, -3.9)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("name", ["perez", "table", "everything", "lobes and all", "sloped"])
def test_parameters_of_cells_give_unit_vectors_or_a_code(name, precision):
    """Planted: parameters from -3.9 to 3.9, sealed; roots of negative numbers were directions that are no numbers."""
    source, driver, rng = source_of(name, 3000, precision=precision), built(), np.random.default_rng(4)
    data, kind = source.to_bytes(), "<f4" if precision == "float32" else "<f8"
    _, offset, count = entry(data, "words")
    width, codes = np.dtype(kind).itemsize, []
    for _ in range(60):
        at = offset + width * int(rng.integers(8 * count // width))
        codes.append(driver.view(with_bytes(data, at, np.array(rng.choice(ODD), kind).tobytes())))
        for band in range(source.n_bands if codes[-1] == 0 else 0):
            assert driver.band(band) == 0
            rows = np.empty((3, driver.n), source.dtype)
            if driver.fill(0, rows) > 0:
                assert np.abs((rows.astype(float) ** 2).sum(axis=0) - 1).max() < 1e-3
    assert CODES["TABLE"] in codes


def test_unknown_sections(data):
    at, _, _ = entry(data, "perez_sky")
    kind = word(99 | 8 << 32)
    assert code_of(with_bytes(data, at, word(99 | 8 << 32 | 1 << 48))) == "NEWER"
    assert code_of(with_bytes(data, at, kind)) == "DIRECTORY"  # skipped, and now the numbers of the sky are missing
    spare = source_of("table", 500).to_bytes()
    grown = bytearray(spare + spare[192 + 40 : 192 + 40] + bytes(64))
    record = np.frombuffer(spare, "<u8", 40, 192)
    begin, n = int(record[5]), int(record[6])
    directory = spare[begin : begin + 24 * n] + kind + word(192) + word(1)
    grown[len(spare) :] = directory + bytes(-len(directory) % 64)
    grown[192 + 40 : 192 + 56] = word(len(spare)) + word(n + 1)
    grown[32:40] = word(len(grown))
    assert code_of(sealed(bytes(grown))) == "ok"  # an old header reads a file with a new section


def test_every_flipped_byte_is_found():
    data = source_of("table", 100).to_bytes()
    rng = np.random.default_rng(1)
    for at in [*range(192 + 320), *rng.integers(0, len(data), 300).tolist()]:
        assert built().view(data[:at] + bytes([data[at] ^ (1 << at % 8)]) + data[at + 1 :]) < 0, at
    for size in (0, 7, 8, 191, 192, 200, len(data) - 64, len(data) - 1):
        assert built().view(data[:size]) < 0


@pytest.mark.parametrize(("count", "flags"), [(100, "-O0"), pytest.param(10_000, "-O1", marks=pytest.mark.slow)])
@pytest.mark.parametrize("sealing", [0, 1])
@pytest.mark.parametrize(("name", "options"), FUZZED)
def test_damaged_files_under_sanitizers(name, options, sealing, count, flags, tmp_path):
    path = tmp_path / "one.sky"
    make = biased if options.get("is_biased") else source_of
    options = {key: value for key, value in options.items() if key != "is_biased"}
    sky.write_source(make(name, 5000, **options), path)
    command = [str(sanitized("source_fuzz", flags)), str(path), str(count), "5", str(sealing)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=3000)
    assert done.returncode == 0, done.stderr[-2000:]
    codes = dict(line.split(": ") for line in done.stdout.split("\n") if line)
    if not sealing:  # whatever is not the file itself has a code
        assert codes.get("0", "0") == codes["unchanged"]
    assert len(codes) > (3 if sealing == 0 else 5)


def test_wrong_calls():
    driver, source = built(), source_of("table", 500)
    driver.open(source)
    rows = np.empty((3, 8), np.float32)
    assert driver.fill(-1, rows) == driver.numbers(-1, rows) == CODES["RANGE"]
    assert driver.fill(0, rows, -1) == CODES["RANGE"]
    assert driver.fill(0, np.empty((3, 8))) == driver.numbers(0, np.empty((3, 8))) == CODES["OTHER"]
    assert (driver.fill(495, rows), driver.fill(500, rows), driver.fill(2**62, rows)) == (5, 0, 0)
    assert driver.band(2) == driver.band(-1) == CODES["NO_BAND"]
    single, patch = driver.at(np.array([-1, 500, 2**40]), np.dtype(np.float32))
    assert np.isnan(single).all()
    assert (patch == -1).all()
    assert np.isnan(driver.at(np.array([0]), np.dtype(np.float64))[0]).all()
    assert driver.load(REPOSITORY / "nowhere.sky") == CODES["NO_FILE"]
    assert driver.load(REPOSITORY) == CODES["NO_FILE"]
    assert driver.load(REPOSITORY / "LICENSE") == CODES["NOT_OURS"]


def built_program(folder, text, more="", compiler="gcc"):
    """Strictly compiled, in the folder; what -O2 warns of besides, `built` says of the whole header."""
    (folder / "use.c").write_text(text)
    flags = f"-O0 -Wall -Wextra -Werror -I{include_dir()} {more}".split()
    run([*compiler.split(), *flags, "use.c", "-o", "use", "-lm"], folder)


def test_bytes_begin_at_a_multiple_of_8_as_malloc_of_32_bits_gives_them(tmp_path):
    source = source_of("everything", 3000)
    sky.write_source(source, tmp_path / "one.sky")
    expected = source.photons(0)
    built_program(tmp_path, SHIFTED, f"{SANITIZED} {APART} {header(f'-O0 {SANITIZED}')}")
    for shift, code in (("8", 0), ("4", CODES["NULL"])):
        done = subprocess.run(["./use", "one.sky", shift], cwd=tmp_path, check=False, capture_output=True)
        assert (done.returncode, done.stderr) == (-code, b"")
    done = np.fromfile(tmp_path / "photons", np.float32).reshape(3, -1)
    assert same_bits(done, np.stack([expected.ux, expected.uy, expected.uz]))


SHIFTED = """#include "aomc_sky.h"
int main(int argc, char **argv) {
    static float x[3][3000];
    aomc_sky_file file, moved;
    aomc_sky_source source;
    char *memory;
    FILE *out;
    int shift = argc == 3 ? atoi(argv[2]) : 0, code = aomc_sky_load(argv[1], &file);
    if (code != 0) return 99;
    memory = (char *)malloc(file.size + 16);
    memcpy(memory + shift, file.bytes, file.size);
    code = aomc_sky_view(memory + shift, file.size, &moved);
    if (code == 0 && aomc_sky_band(&moved, 0, &source) == 0 && (out = fopen("photons", "wb"))) {
        if (aomc_sky_fill(&source, 0, 3000, x[0], x[1], x[2]) != 3000) return 98;
        fwrite(x, sizeof x, 1, out);
        fclose(out);
    }
    aomc_sky_unload(&file);
    free(memory);
    return -code;
}
"""


ROUNDED = """#include <fenv.h>
#include "aomc_sky.h"
int main(int argc, char **argv) {
    const int modes[3] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
    aomc_sky_file file, again;
    aomc_sky_source source;
    int k, code = argc == 2 ? aomc_sky_load(argv[1], &file) : -1;
    if (code == 0) code = aomc_sky_band(&file, 0, &source);
    for (k = 0; code == 0 && k < 3; k++) {
        fesetround(modes[k]);
        if (aomc_sky_view(file.bytes, file.size, &again) != AOMC_SKY_ARITHMETIC) code = 1 + k;
        if (aomc_sky_witness(&source) != AOMC_SKY_ARITHMETIC) code = 4 + k;
        fesetround(FE_TONEAREST);
    }
    return code ? code : aomc_sky_witness(&source);
}
"""


def test_another_rounding_mode_is_found_whatever_the_photons_are(tmp_path):
    """A beam is the same in every mode, and numbers of lobes are compared with sums before there are witnesses."""
    beam = sky.Scene(wavebands=[550.0], n_photons=100, components=sky.DirectBeam(sun_zenith_deg=30.0)).source()
    built_program(tmp_path, ROUNDED)
    for source in (beam, source_of("lobes and all", 500), source_of("table", 500)):
        sky.write_source(source, tmp_path / "one.sky")
        assert subprocess.run(["./use", "one.sky"], cwd=tmp_path, check=False).returncode == 0


NO_SOURCE = """#include "aomc_sky.h"
#define IS_NULL(call) ((call) == AOMC_SKY_NULL)
int main(void) {
    float x[3] = {0};
    aomc_sky_numbers_at(NULL, 0, x);
    aomc_sky_numbers_at(NULL, 0, NULL);
    if (aomc_sky_at(NULL, 0).patch != -1 || aomc_sky_at_double(NULL, 0).patch != -1 || x[0] == x[0]) return 1;
    if (!IS_NULL(aomc_sky_fill(NULL, 0, 1, x, x, x)) || !IS_NULL(aomc_sky_witness(NULL))) return 2;
    return IS_NULL(aomc_sky_numbers(NULL, 0, 1, x, NULL, NULL)) ? 0 : 3;
}
"""


@pytest.mark.parametrize("compiler", ["gcc -std=c99", "g++ -std=c++20"])
def test_a_source_that_is_null_has_a_code_and_conversions_do_not_warn(compiler, tmp_path):
    if shutil.which(compiler.split()[0]) is None:
        pytest.skip(f"{compiler} not installed")
    apart = f"{SANITIZED} {APART} {header(f'-O0 {SANITIZED}')}"
    built_program(tmp_path, NO_SOURCE, apart, compiler)
    run(["./use"], tmp_path)
    warnings = ["-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wsign-conversion", "-Wcast-qual"]
    run([*compiler.split(), *warnings, "-fsyntax-only", f"-I{include_dir()}", "use.c"], tmp_path)


def test_every_function_is_declared():
    """`AOMC_SKY_DECLARE_ONLY` has all functions; that declarations are right is the compiler's to say."""
    text = HEADER.read_text()
    declared, defined = text.split("#ifndef AOMC_SKY_DECLARE_ONLY\n")
    first = r"^(?:AOMC_SKY_(?:HOST_)?API|SKY_NEXT) [^;{]*?\b(aomc_sky_\w+)\([^;{]*"
    names = re.findall(first + ";", declared, re.MULTILINE)
    assert sorted(names) == sorted(re.findall(first + r"\{", defined, re.MULTILINE))
    assert len(names) == len(set(names)) > 30


def test_every_code_has_a_sentence_and_checksums_agree(data):
    texts = [built().message(code) for code in CODES.values()]
    assert len(set(texts)) == len(CODES) == 18
    assert "unknown" not in "".join(texts)
    assert (built().message(0), built().message(-99)) == ("no error", "an unknown code")
    assert built().checksum(data) == checksum(data) == int.from_bytes(data[40:48], "little")
    assert code_of(data) == "ok"


@pytest.mark.parametrize("precision", ["float32", pytest.param("float64", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", SCENES)
def test_witnesses_find_a_compiler_that_contracts(name, precision):
    if not _has_fma():
        pytest.skip("this processor has no fused operations")
    data = source_of(name, 5000, precision=precision).to_bytes()
    contracting = "-O2 -mfma -ffp-contract=fast"
    assert code_of(data, f"{contracting} {FLAGS_OF_HOST}") == "ARITHMETIC"
    assert code_of(data, contracting) == "ok"  # the header's own pragma


def test_fast_math_is_found(data):
    assert code_of(data, "-O2 -ffast-math") == "ARITHMETIC"


def test_a_witness_that_differs_is_found(data):
    _, offset, count = entry(data, "witnesses")
    words = np.frombuffer(data, "<u8", count, offset).reshape(-1, 12)
    for column in range(11):
        row = int(np.argmax(words[:, column] != 0x7FF8000000000000)) if column > 7 else 3
        at = offset + 8 * (12 * row + column)
        changed = int.from_bytes(data[at : at + 8], "little") ^ 1
        if column == 0:  # another photon
            changed = int(words[row, 0]) ^ 2
        assert code_of(with_bytes(data, at, word(changed))) == "ARITHMETIC", column


@pytest.mark.parametrize("name", SCENES)
def test_witnesses_take_every_way(name):
    """Every component has witnesses; Perez and lobes have some of trial 0, of trial 1 and of later ones."""
    source = source_of(name, 20_000)
    words = source_file.witnesses(source._emitter, 0).reshape(-1, 12)
    assert len(words) == source_file.witnesses.__globals__["N_WITNESSES"]
    starts = source.plan.component_start
    lit = np.diff(source.plan.cumulative[0][starts]) > 0
    seen = np.unique(np.searchsorted(starts, words[:, 1].astype(np.int64), side="right") - 1)
    assert seen.tolist() == np.flatnonzero(lit).tolist()


def _has_fma():
    try:
        return " fma " in (REPOSITORY.__class__("/proc/cpuinfo").read_text())
    except OSError:
        return False
