"""Footprints in the source file: bits of every position, codes for damage, and files without them."""

import itertools

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.emission.source_file import FOOTPRINTS
from aomc_sky.plan.options import FootprintShape
from tests.include.test_damage import CODES, code_of, code_said, entry, read_under_sanitizers, with_bytes, word
from tests.support.builds import fortran_flags
from tests.support.host_programs import needs, run
from tests.support.host_scenes import WAVEBANDS, disc, table
from tests.support.source_files import OPTIONS, RECORDS, built, needs_gcc, same_bits

pytestmark = needs_gcc
SHAPES = {
    "point": sky.Footprint(),
    "circle": sky.Footprint.circle(3.7),
    "no circle": sky.Footprint.circle(0.0),
    "rectangle": sky.Footprint.rectangle(2.3, 0.7),
    "line": sky.Footprint.rectangle(2.3, 0.0),
}
BUILDS = [("-O2", "gcc")]
BUILDS += [
    pytest.param(*how, marks=pytest.mark.slow) for how in (("-O3 -march=native", "g++"), ("-O1 -mno-avx", "gcc"))
]
SHAPE, SIZES = RECORDS + 8 * 32, RECORDS + 8 * 33


def source_on(name, n=3011, **options):
    """Photons of a beam and a table that enter through a footprint."""
    parts = *disc(40), table(sky.component.Law.CELL_MU2, 6, 9)
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=n, components=parts, footprint=SHAPES[name])
    return scene.source(seed=9, **options)


def expected(batch):
    """Columns x and y; zeros of a point, which has none."""
    return [np.zeros_like(batch.ux) if column is None else column for column in (batch.x, batch.y)]


def compare_positions(driver, source):
    assert driver.view(source.to_bytes()) == 0
    for band in range(source.n_bands):
        assert driver.band(band) == 0
        total = source.n_photons(band)
        start = total // 3
        x, y = expected(source.photons(band, start))
        made = np.full((2, total - start), np.nan, source.dtype)
        assert driver.positions(start, *made) == total - start
        assert same_bits(made, np.stack([x, y]))
        for one in (0, 1):  # NULL for the other
            alone = np.full_like(x, np.nan)
            columns = (alone, None) if one == 0 else (None, alone)
            assert driver.positions(start, *columns) == total - start
            assert same_bits(alone, (x, y)[one])
        single = driver.position(np.arange(start, total), source.dtype)
        assert same_bits(single.T, np.stack([x, y]))


@pytest.mark.parametrize(("flags", "compiler"), BUILDS)
@pytest.mark.parametrize(("name", "precision", "order", "placement"), [*itertools.product(SHAPES, *OPTIONS)])
def test_positions_are_those_of_python(name, precision, order, placement, flags, compiler):
    source = source_on(name, precision=precision, order=order, placement=placement)
    compare_positions(built(flags, compiler), source)


@pytest.mark.parametrize("n", [1, 63, 65, 2**32 + 5])
@pytest.mark.parametrize("precision", OPTIONS[0])
def test_few_and_many_photons(n, precision):
    source, driver = source_on("circle", n, precision=precision), built()
    driver.open(source, 1)
    start = max(n - 700, 0)
    made = np.empty((2, n - start), source.dtype)
    assert driver.positions(start, *made) == n - start
    assert same_bits(made, np.stack(expected(source.photons(1, start))))


def test_wrong_calls():
    source, driver = source_on("circle", 500), built()
    driver.open(source)
    x, y = np.full((2, 9), 7.0, np.float32)
    assert driver.positions(-1, x, y) == driver.positions(0, x, y, count=-1) == CODES["RANGE"]
    assert driver.positions(0, x.astype(float), y.astype(float)) == CODES["OTHER"]
    assert driver.positions(500, x, y) == 0
    assert (x == 7.0).all()
    assert driver.positions(497, x, y) == 3
    assert (x[3:] == 7.0).all()
    assert np.isnan(driver.position(np.array([-1, 500]), np.float32)).all()
    assert np.isnan(driver.position(np.array([0]), np.float64)).all()


def test_positions_fill_the_footprint():
    """Planted: a half-turn, sides that are exchanged, and a radius of the diameter would be seen."""
    for name, mean in (("circle", 3.7**2 / 16), ("rectangle", 2.3**2 / 12)):
        driver = built()
        driver.open(source_on(name, 20_000))
        x, y = np.empty((2, 20_000), np.float32)
        driver.positions(0, x, y)
        assert np.mean(x.astype(float) ** 2) == pytest.approx(mean, rel=0.03)
        assert np.mean(y.astype(float) ** 2) == pytest.approx(mean if name == "circle" else 0.7**2 / 12, rel=0.03)
        assert abs(np.mean(x)) < 0.03
        assert abs(np.mean(y)) < 0.03


def test_every_shape_has_a_number():
    assert set(FOOTPRINTS) == set(FootprintShape)
    header = (include_dir() / "aomc_sky.h").read_text()
    names = ", ".join(f"AOMC_SKY_{shape.name}" for shape in FOOTPRINTS)
    assert f"enum {{ {names} }}; /* footprints */" in header


def test_a_file_of_the_version_before_is_a_point():
    """Its words 32 to 34 are 0, and so is the last of each witness."""
    driver = built()
    data = with_bytes(source_on("circle", 500).to_bytes(), SHAPE, word(0) * 3)
    _, offset, count = entry(data, "witnesses")
    for at in range(offset + 88, offset + 8 * count, 96):
        data = with_bytes(data, at, word(0))
    driver.open(data)
    made = np.full((2, 500), np.nan, np.float32)
    assert driver.positions(0, *made) == 500
    assert same_bits(made, np.zeros_like(made))


DAMAGES = [(SHAPE, value, "NEWER") for value in (3, 259, 512, 513, 2**32, 2**63)]
DAMAGES += [(SHAPE, value, "DIRECTORY") for value in (256, 257)]  # weights times mu, without weights
DAMAGES += [(SIZES + 8 * k, float(x), "TABLE") for k in (0, 1) for x in (-1.0, np.nan, np.inf, -np.inf, -5e-324)]
DAMAGES += [(SIZES, 2.0, "TABLE"), (SIZES + 8, 0.0, "TABLE"), (SHAPE, 2, "ARITHMETIC"), (SHAPE, 0, "ARITHMETIC")]


@pytest.fixture(scope="module")
def damaged():
    data = source_on("circle", 500).to_bytes()
    return [(with_bytes(data, at, word(value)), code) for at, value, code in DAMAGES]


def test_damages_have_codes(damaged):
    for (changed, code), what in zip(damaged, DAMAGES, strict=True):
        assert code_of(changed) == code, what


def test_damages_under_sanitizers(damaged, tmp_path):
    """Ellipses do not exist: a circle of two sizes is refused. Witnesses know the shape."""
    said = read_under_sanitizers([changed for changed, _ in damaged], tmp_path)
    assert [code_said(line) for line in said] == [code for _, code in damaged]


PROGRAM = """program places
    use, intrinsic :: iso_fortran_env, only: int64, {real}
    use aomc_sky
    implicit none
    type(aomc_sky_file) :: file
    type(aomc_sky_source) :: source
    real({real}) :: x(1000), y(1000), again(1000), xy(2)
    integer(int64) :: n, k
    integer :: code
    code = aomc_sky_load("day.sky" // achar(0), file)
    if (code == 0) code = aomc_sky_band(file, 0, source)
    if (code /= 0) error stop aomc_sky_text(int(code, int64))
    x = 7
    y = 7
    n = aomc_sky_positions{suffix}(source, 10_int64, 900_int64, x, y)
    if (n /= 900 .or. any(x(901:) /= 7) .or. any(y(901:) /= 7)) error stop "another number of positions"
    if (aomc_sky_positions{suffix}(source, 10_int64, n, y=again) /= n) error stop "no positions"
    if (any(again(:n) /= y(:n))) error stop "another column"
    do k = 1, n
        call aomc_sky_position{suffix}(source, 9 + k, xy)
        if (xy(1) /= x(k) .or. xy(2) /= y(k)) error stop "another position"
        print "(2es26.17)", xy
    end do
end program
"""


@needs("gfortran")
@pytest.mark.parametrize(("precision", "real", "suffix"), [("float32", "real32", ""), ("float64", "real64", "_double")])
def test_fortran(precision, real, suffix, tmp_path):
    source = source_on("circle", 2500, precision=precision)
    sky.write_source(source, tmp_path / "day.sky")
    (tmp_path / "places.f90").write_text(PROGRAM.format(real=real, suffix=suffix))
    run(["gfortran", "-o", "places", "places.f90", *fortran_flags()], tmp_path)
    numbers = np.array(run(["./places"], tmp_path).split(), float).reshape(900, 2).astype(source.dtype)
    assert same_bits(numbers.T, np.stack(expected(source.photons(0, 10, 910))))


@needs("clang")
def test_a_compiler_that_contracts_positions_is_found():
    """A beam in the middle of its disc has nothing else to contract; not every clang listens to the header."""
    beam = sky.DirectBeam(sun_zenith_deg=40.0).lower(WAVEBANDS)
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=2000, components=beam, footprint=sky.Footprint.circle(3.0))
    data = scene.source(1, placement="centre").to_bytes()
    assert code_of(data) == "ok"
    contracted = built("-O1 -march=native -ffp-contract=fast", "clang")
    if contracted.view(data) == 0:  # it does listen, or this processor has no such operation
        assert contracted.band(0) == 0
        made = np.empty((2, 2000), np.float32)
        assert contracted.positions(0, *made) == 2000
        batch = scene.source(1, placement="centre").photons(0)
        assert same_bits(made, np.stack([batch.x, batch.y]))
    else:
        assert contracted.view(data) == CODES["ARITHMETIC"]
