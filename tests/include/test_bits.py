"""Photons of aomc_sky.h are those of the package, bit for bit: every law, order, placement, precision, and flags."""

import itertools
import re
import shutil

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.emission import band
from aomc_sky.emission.emitter import Emitter
from aomc_sky.emission.source_file import source_bytes
from tests.support.host_programs import run
from tests.support.shared import REPOSITORY
from tests.support.source_files import SCENES, STRICT, WAYS, built, compare, needs_gcc, same_bits, source_of

pytestmark = needs_gcc
FLAGS = ("-O0", "-O2", "-O3 -march=native", "-O3 -march=native -fno-math-errno", "-Os", "-O3 -mno-avx")


BUILDS = [("-O2", "gcc", 2011)]
BUILDS += [pytest.param(*way, 50_021, marks=pytest.mark.slow) for way in itertools.product(FLAGS, ("gcc", "g++"))]


@pytest.mark.parametrize(("flags", "compiler", "n"), BUILDS)
@pytest.mark.parametrize(("name", "precision", "order", "placement"), WAYS)
def test_every_law_order_placement_and_precision(name, precision, order, placement, flags, compiler, n):
    source = source_of(name, n, precision=precision, order=order, placement=placement)
    compare(built(flags, compiler), source, n)


@pytest.mark.parametrize("name", ["everything", "lobes and all"])
def test_method_iid_and_cplusplus(name):
    compare(built("-O2 -std=c++11", "g++"), source_of(name, method="iid"))
    compare(built("-O2 -std=c++11", "g++"), source_of(name, method="iid", precision="float64"))


LONG = ("eclipse", "twilight", "light_polluted", "night_sky")  # their light is computed for about ten seconds
INPUTS = sorted(path.parent.name for path in (REPOSITORY / "inputs").glob("*/amc.inp"))


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in INPUTS])
@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning", "ignore::aomc_sky.ModelLimitWarning")
def test_scenes_of_inputs(name):
    try:
        scene = sky.read_scene(REPOSITORY / "inputs" / name, iterations=20_000)
    except sky.errors.MissingExtraError as error:
        pytest.skip(str(error))
    for options in ({}, {"precision": "float64", "order": "patch"}):
        compare(built("-O3 -march=native"), scene.source(seed=3, **options))


def test_a_file_of_the_version_before_keeps_its_numbers(monkeypatch):
    """Version 0.4 had the lattice for every sky. Its files lack the switch that its header refuses."""
    of_net = np.frombuffer(source_of("table").to_bytes(), "<u8")
    monkeypatch.setattr(band, "_is_one_lattice", lambda plan, number: True)
    before = source_of("table")
    compare(built("-O2"), before)
    of_lattice = np.frombuffer(before.to_bytes(), "<u8")
    switches = int(of_lattice[7]) // 8 + 7
    assert (of_lattice[switches], of_net[switches]) == (1, 5)


@pytest.mark.parametrize("order", ["shuffled", "patch"])
@pytest.mark.parametrize("name", ["table", "sparse", "everything", "lobes and all"])
@pytest.mark.parametrize("n", [1, 2, 3, 513, (65535 << 16) + 1, 2**32 - 1, 2**32 + 5, 10**13])
def test_few_and_many_photons(name, n, order):
    compare(built("-O2"), source_of(name, n, order=order), 2000)


def test_a_million_patches():
    grid = sky.PatchGrid.regular(1000, 1000)
    mass = np.random.default_rng(1).random((1, grid.n_patches))
    cell = sky.component.cells_of_grid(grid)
    one = sky.component.Component(
        name="t", law=sky.component.Law.CELL_MU2, strength=np.ones(1), mass=mass, cell=cell, grid=grid
    )
    scene = sky.Scene(wavebands=[550.0], n_photons=10**7, components=(one,))
    for order in ("shuffled", "patch"):
        compare(built("-O2"), scene.source(seed=1, order=order))


def test_a_band_without_photons_stands_among_others():
    source, driver = source_of("table", [0, 500]), built("-O2")
    driver.open(source, 0)
    rows = np.empty((3, 4), source.dtype)
    assert (driver.n, driver.fill(0, rows), driver.numbers(0, rows), driver.witness) == (0, 0, 0, 0)
    assert np.isnan(driver.at(np.array([0]), source.dtype)[0]).all()
    compare(driver, source_of("table", [1000, 500]))
    assert driver.band(1) == 0


@pytest.mark.parametrize("precision", ["float32", pytest.param("float64", marks=pytest.mark.slow)])
def test_a_disc_that_no_try_hits_ends(precision):
    """Planted: a squared radius of -1. The plan would be refused; the last of 10 000 tries is kept in all twins."""
    plan = source_of("disc at the horizon", [2, 0], precision=precision).plan
    emitter = Emitter(plan)
    cell = emitter._cell.copy()
    cell[:, 2] = -1.0
    vars(emitter)["_cell"] = cell
    made = []
    for fill in (emitter.fill_plain, emitter.fill_compiled):
        arrays = {name: np.empty(2, emitter.dtype) for name in ("ux", "uy", "uz")}
        fill(0, 0, {**arrays, "patch": np.empty(2, np.int32), "numbers": None})
        made.append(np.stack(list(arrays.values())))
    assert same_bits(*made)
    driver, rows = built("-O2"), np.empty((3, 2), emitter.dtype)
    driver.open(source_bytes(emitter))
    assert driver.fill(0, rows) == 2
    assert same_bits(rows, made[0])
    assert same_bits(driver.at(np.arange(2), emitter.dtype)[0][:3], made[0])


def test_the_constants_of_the_header_are_those_of_the_package():
    package = REPOSITORY / "src" / "aomc_sky"
    texts = "".join(path.read_text() for path in [package / "directions.py", *package.glob("**/arithmetic/*.py")])
    known = {float(number) for number in re.findall(r"\d+\.\d{6,}(?:e[+-]?\d+)?", texts)}
    known |= {2.0**-k for k in (11, 24, 30, 52, 53)} | {1 - 2.0**-24, 1 - 2.0**-53}
    header = (include_dir() / "aomc_sky.h").read_text()
    of_header = re.findall(r"\d+\.\d{6,}(?:e[+-]?\d+)?", header)
    assert len(of_header) > 40
    assert [x for x in of_header if float(x) not in known] == []


@pytest.mark.parametrize(
    "command", ["gcc -std=c99", "gcc -std=c11", "gcc -std=gnu17", "g++ -std=c++11", "g++ -std=c++17"]
)
def test_no_standard_warns(command, tmp_path):
    """What the optimiser finds besides is an error where `built` compiles the driver, by gcc and by g++."""
    compiler, standard = command.split()
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} not installed")
    language = ["-x", "c++"] if compiler == "g++" else []
    (tmp_path / "use.c").write_text('#include "aomc_sky.h"\nint main(void) { return aomc_sky_message(0) == 0; }\n')
    for how, text in (("-O2", "use.c"), ("-fsyntax-only", str(include_dir() / "aomc_sky.c"))):
        run([compiler, standard, how, *STRICT.split(), f"-I{include_dir()}", "-c", *language, text], tmp_path)


@pytest.mark.parametrize("name", SCENES)
def test_other_flags(name):
    compare(built("-O3 -march=native"), source_of(name))
    compare(built("-O3 -march=native"), source_of(name, precision="float64", order="patch"))


@pytest.mark.parametrize("name", ["table", "lobes and all"])
def test_single_photons_of_more_than_32_bits(name):
    source, driver = source_of(name, 2**32 + 5), built("-O2")
    driver.open(source)
    index = np.random.default_rng(3).integers(0, 2**32 + 5, 300)
    rows, patch = driver.at(index, source.dtype)
    batches = [source.photons(0, i, i + 1, numbers=3) for i in index.tolist()]
    expected = [[b.ux[0], b.uy[0], b.uz[0], *b.numbers[0]] for b in batches]
    assert same_bits(rows, np.array(expected, source.dtype).T)
    assert patch.tolist() == [b.patch[0] for b in batches]
