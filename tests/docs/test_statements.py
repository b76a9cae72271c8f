"""Statements of the pages that the code answers: numbers, lists, files, names of tests, options of scripts."""

import ast
import re

import pytest

from aomc_sky import errors, system
from aomc_sky.directions import AzimuthConvention
from aomc_sky.formats.aomc.amc import FIRST_COLUMN, fields_of_layout
from aomc_sky.formats.mcpl.file import MAX_HEAD_BYTES, MAX_TEXTS
from aomc_sky.formats.sky_toml.file import MAX_BYTES
from aomc_sky.grid import MAX_PATCHES
from aomc_sky.kernels.backend import PLAIN_PHOTONS
from aomc_sky.outputs.aomc.degree_counts import MOST_PHOTONS
from aomc_sky.outputs.photons.files import BLOCK
from aomc_sky.outputs.photons.mcpl import MAX_CELLS, MAX_WAVEBANDS
from aomc_sky.outputs.picture import SUFFIXES
from aomc_sky.pictures.picture import MOST_PANELS
from aomc_sky.plan.options import MAX_REPLICATES
from aomc_sky.skies.atmosphere.description import keys, reader, spectra
from aomc_sky.skies.atmosphere.language import expressions, lexer
from aomc_sky.skies.atmosphere.model import DEFAULT_BINS
from aomc_sky.skies.direct_beam import SOLAR_RADIUS_DEG
from aomc_sky.skies.perez import coefficients, irradiances
from aomc_sky.source.light.skies import MEDIAN_DELTA
from aomc_sky.source.light.spectral_split import LARGEST_TURBIDITY
from aomc_sky.source.read.kind import TABLES
from aomc_sky.verify import repeats, zone_tests, zones
from tests.docs.test_docs import PAGES
from tests.support.shared import REPOSITORY


def spaced(number):
    return f"{number:,}".replace(",", " ")


OF_TABLES = f"({', '.join(TABLES)})"
BLOCKS = f"blocks of {spaced(BLOCK)} photons"
BINS = f"2^{MAX_PATCHES.bit_length() - 1} bins"
STATEMENTS = {
    "verify.md": [
        BLOCKS,
        f"up to {zones.N_ZONES} zones of mu², up to {zones.N_ZONES} of azimuth",
        f"At most 1 in {1 / repeats.MOST_EQUAL:g} of the pairs",
        f"below {zone_tests.MAX_PER_DEGREE:g} in zones that expect {zone_tests.MIN_EVEN:g} photons",
    ],
    "scale.md": [BLOCKS],
    "formats/run_folder.md": [BLOCKS],
    "error_bars.md": [f"R goes from 1 to {MAX_REPLICATES}"],
    "export.md": [f"Up to {spaced(MOST_PHOTONS)} photons"],
    "plots.md": [
        f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}",
        f"At most {MOST_PANELS} wavebands",
        f"a measured sky {OF_TABLES}",
    ],
    "errors.md": [
        f"at most {errors.MAX_PROBLEMS_SHOWN}, are reported",
        f"Measured skies {OF_TABLES}",
        BINS,
        f"more than {reader.MAX_SPECIES} species",
    ],
    "formats/index.md": [f"radiances in directions {OF_TABLES}"],
    "formats/amc.md": [
        f"{len(fields_of_layout(False))} lines in a fixed order",
        f"The value starts in column {FIRST_COLUMN}",
        BINS,
    ],
    "formats/mcpl.md": [
        f"0 beyond 2^{MAX_CELLS.bit_length() - 1} cells or {MAX_WAVEBANDS} wavebands",
        f"at most {MAX_HEAD_BYTES >> 20} MiB and {spaced(MAX_TEXTS)} comments and blobs",
    ],
    "formats/sky_toml.md": [
        f"has at most {MAX_BYTES >> 10} kB",
        f"The radius of the solar disc is {SOLAR_RADIUS_DEG} degrees",
        f"There are {DEFAULT_BINS[0]} and {DEFAULT_BINS[1]} patches by default",
        f"({', '.join(f'{delta:.2f}' for delta in MEDIAN_DELTA)})",
        f"(../howto/measured_sky.md) {OF_TABLES}",
    ],
    "formats/atmo.md": [
        f"CalcMySky, version {keys.FORMAT_VERSION}.",
        f"count 1 to {keys.MAX_WAVELENGTHS}",
        f"at most {spaced(spectra.MAX_ANGLES)} angles, {spectra.MAX_COLUMNS} columns",
        f"More than {spectra.MAX_FILES} tables or {spectra.MAX_TOTAL_BYTES >> 20} MiB",
        f"| size of a block | {lexer.MAX_BLOCK_BYTES >> 10} KiB |",
        f"| numbers, names and operators | {spaced(lexer.MAX_NODES)} |",
        f"in each other | {expressions.MAX_NESTING};",
        f"| variables | {expressions.MAX_VARIABLES},",
    ],
    "accuracy.md": [f"Up to {PLAIN_PHOTONS // 10**6} million photons come from plain numpy"],
    "models/perez.md": [
        f"is {irradiances.EXTRATERRESTRIAL_NORMAL} W m⁻²",
        f"than turbidity {LARGEST_TURBIDITY} has",
        f"to [1, {coefficients.EPSILON_LIMITS[1]}]",
    ],
    "howto/from_0.4.md": [f"a table has a name in {', '.join(TABLES[:-1])} or {TABLES[-1]}"],
}
"""Page below docs -> what it says where a number or a list of the code stands in it."""


@pytest.mark.parametrize("page", STATEMENTS)
def test_numbers_of_a_page_are_those_of_the_code(page):
    text = " ".join((REPOSITORY / "docs" / page).read_text().split())
    assert [said for said in STATEMENTS[page] if said not in text] == []


def test_files_and_tests_that_pages_name_are_there():
    written = "".join(path.read_text() for path in (REPOSITORY / "tests").rglob("*.py"))
    tests = set(re.findall(r"^ *def (test_\w+)", written, re.MULTILINE))
    named = [
        re.findall(r"`(tests/[\w/.]+|test_\w+)`", page.read_text()) for page in PAGES if page.name != "CHANGELOG.md"
    ]
    names = {name for names in named for name in names}
    assert len(names) >= 20
    assert [name for name in names if name not in tests and not (REPOSITORY / name).exists()] == []


def test_words_of_the_field_say_where_they_are_defined():
    rows = re.findall(r"^\| .* \| ([^|]*) \|$", (REPOSITORY / "docs/words.md").read_text(), re.MULTILINE)
    files = [name for row in rows for name in re.findall(r"`([\w/]+(?:\.py|/)?)`", row)]
    assert len(files) >= 25
    assert [name for name in files if not (REPOSITORY / "src/aomc_sky" / name).exists()] == []


def test_every_scene_of_inputs_has_its_line():
    shown = re.findall(r"^\| `(\w+)` \|", (REPOSITORY / "inputs/README.md").read_text(), re.MULTILINE)
    assert sorted(shown) == sorted(path.parent.name for path in (REPOSITORY / "inputs").glob("*/amc.inp"))


def test_conventions_of_azimuths_and_codes_of_errors_are_all_named():
    conventions, commands = ((REPOSITORY / "docs" / page).read_text() for page in ("conventions.md", "cli.md"))
    assert [name for name in AzimuthConvention.__members__ if f"`{name}`" not in conventions] == []
    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, errors.AomcSkyError)]
    words = {kind.code for kind in kinds if kind not in (errors.AomcSkyError, errors.InputFileError)}
    assert len(words) >= 8
    assert [word for word in words if f"`{word}`" not in commands] == []


def test_calls_that_systems_lack_are_in_one_module():
    shown = re.findall(r"^\| `(\w+)` \|", (REPOSITORY / "CONTRIBUTING.md").read_text(), re.MULTILINE)
    assert len(shown) >= 8
    assert [name for name in shown if not callable(getattr(system, name, None))] == []


def options_of_script(text):
    """Options of a script and the defaults that are numbers."""
    for call in ast.walk(ast.parse(text)):
        if isinstance(call, ast.Call) and ast.unparse(call.func).endswith("add_argument"):
            defaults = [word.value for word in call.keywords if word.arg == "default"]
            number = defaults[0].value if defaults and isinstance(defaults[0], ast.Constant) else None
            for word in call.args:
                yield ast.literal_eval(word), number


def test_the_page_of_benchmarks_names_every_script_its_options_and_their_defaults():
    rows = re.findall(r"^\| `(.*?)` \|", (REPOSITORY / "bench/README.md").read_text().replace("`, ", ""), re.MULTILINE)
    shown = {re.search(r"python bench/(\w+\.py)", row)[1]: row for row in rows}
    texts = {path.name: path.read_text() for path in (REPOSITORY / "bench").glob("*.py")}
    assert set(shown) == {name for name, text in texts.items() if "__main__" in text}
    for name, row in shown.items():
        known = dict(options_of_script(texts[name]))
        assert set(re.findall(r"--[\w-]+", row)) <= set(known), name
        for option, default in re.findall(r"\[(--[\w-]+) ([\d.e]+)\]", row):
            assert known[option] in (None, float(default)), f"{name} {option}"
