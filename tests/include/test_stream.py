"""A stream of particles over bands: every column, any part of it, its light, and who may be in it."""

import itertools
import shutil

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from tests.include.test_damage import CODES
from tests.include.test_positions import source_on
from tests.support.builds import fortran_flags
from tests.support.host_programs import needs, run
from tests.support.host_scenes import WAVEBANDS, disc, table
from tests.support.source_files import LOBES, OPTIONS, biased, built, needs_gcc, same_bits, source_of

pytestmark = needs_gcc
CASES = ("table", "disc and table", "everything", *LOBES)
WAYS = [way for way in itertools.product(CASES, *OPTIONS) if way[0] not in LOBES or way[3] != "centre"]
ALL = 2**63 - 1


def photon_light(source, band):
    """Light of a photon of weight 1."""
    irradiance = source.plan.bands[band].irradiance_W_m2_nm
    return 1.0 if irradiance is None else float(np.sum(irradiance)) / source.n_photons(band)


def of_photons(source, band, start, stop):
    """Columns of photons of a band: (6, n) floats, and index, patch, component."""
    batch = source.photons(band, start, stop)
    ones = np.ones(len(batch), source.dtype)
    weight = (ones if batch.weight is None else batch.weight).astype(float) * photon_light(source, band)
    place = [np.zeros(len(batch)) if column is None else column for column in (batch.x, batch.y)]
    floats = np.array([batch.ux, batch.uy, batch.uz, weight, *place], float)
    return floats, [np.arange(start, start + len(batch)), batch.patch, source.component_of(batch.patch)]


def by_python(*sources):
    """The whole stream, built up from its definition."""
    bands = [(source, band) for source in sources for band in range(source.n_bands)]
    sizes = [source.n_photons(band) for source, band in bands]
    n_segment = -(-sum(sizes) // (2048 * sum(n > 0 for n in sizes)))
    floats, whole = [], []
    for s in range(n_segment):
        for number, ((source, band), n) in enumerate(zip(bands, sizes, strict=True)):
            start, stop = n * s // n_segment, n * (s + 1) // n_segment
            if start < stop:
                columns, (index, patch, component) = of_photons(source, band, start, stop)
                floats.append(columns)
                whole.append(np.array([index, np.full(index.size, number), patch, component], np.int64))
    return np.concatenate(floats, axis=1), np.concatenate(whole, axis=1)


def compare_stream(driver, *sources):
    """Assert that the whole stream is that of Python; returns it."""
    driver.take_bands(*(source.to_bytes() for source in sources))
    expected = by_python(*sources)
    n = expected[0].shape[1]
    made, total = driver.stream(0, ALL, n + 10)
    assert total == n
    assert same_bits(made[0], expected[0])
    assert same_bits(made[1], expected[1])
    return expected


@pytest.mark.parametrize(("name", "precision", "order", "placement"), WAYS)
def test_columns_are_those_of_python(name, precision, order, placement):
    options = {"precision": precision, "order": order, "placement": placement}
    compare_stream(built(), source_of(name, [5011, 2500], **options))
    compare_stream(built("-O3 -march=native"), biased(name, [700, 4097], **options))


@pytest.mark.parametrize(("precision", "shape"), [*itertools.product(OPTIONS[0], ("circle", "rectangle"))])
def test_positions(precision, shape):
    floats, _ = compare_stream(built(), source_on(shape, 5000, precision=precision))
    assert np.ptp(floats[4]) > 2.0


def test_several_files_and_bands_without_photons():
    sources = source_on("circle", [3000, 0]), source_of("table", [0, 9000]), biased("disc and table", 4100)
    floats, whole = compare_stream(built("-O2", "g++"), *sources)
    assert np.unique(whole[1]).tolist() == [0, 3, 4, 5]
    assert np.unique(floats[4][whole[1] != 0]).tolist() == [0.0]
    compare_stream(built(), *sources[::-1])


def test_parts_are_the_whole():
    """Ranks and threads take ranges: at ends of segments, of bands and of buffers, empty ones, and single particles."""
    sources = biased("disc and table", [9001, 300]), source_of("table", [0, 4000])
    floats, whole = compare_stream(built(), *sources)
    driver, n, rng = built(), floats.shape[1], np.random.default_rng(8)
    ends = np.flatnonzero(np.diff(whole[1])) + 1
    cuts = [[], ends, ends + 1, ends - 1, np.arange(0, n, 256), np.arange(0, n, 1000)]
    cuts += [np.sort(rng.integers(0, n + 1, k)) for k in (1, 2, 5, 30, 200)]
    for cut in cuts:
        places = [0, *map(int, cut), n]
        parts = [driver.stream(a, b, max(b - a, 1) + 3)[0] for a, b in itertools.pairwise(places)]
        assert same_bits(np.concatenate([part[0] for part in parts], axis=1), floats)
        assert same_bits(np.concatenate([part[1] for part in parts], axis=1), whole)
    for place in rng.integers(0, n, 400).tolist():
        made, _ = driver.stream(place, place + 1, 2)
        assert same_bits(made[0], floats[:, place : place + 1])


def test_a_prefix_has_the_bands_in_their_shares():
    driver = built()
    sizes = np.array([90_000, 30_000])
    driver.take_bands(source_of("table", sizes.tolist()).to_bytes())
    for stop in (10_000, 33_333, 77_777):
        (_, whole), _ = driver.stream(0, stop, stop)
        counts = np.bincount(whole[1], minlength=2)
        assert np.abs(counts - stop * sizes / sizes.sum()).max() < 2 * 2048


@pytest.mark.parametrize("n", [2**32 + 5, 10**13, 2**61])
def test_any_place_of_a_long_stream(n):
    """There segments are longer than 2048 photons; no product of the bisection overflows."""
    driver = built(
        "-O1 -fsanitize=signed-integer-overflow -fno-sanitize-recover=all -fsanitize-undefined-trap-on-error"
    )
    source = source_of("disc and table", n)
    driver.take_bands(source.to_bytes())
    total = 2 * n
    for start in (0, n // 3, n - 5, n + 12_345, total - 700):
        made, there = driver.stream(start, start + 700, 700)
        assert there == total
        floats, (index, band, patch, component) = made
        assert floats.shape[1] == 700
        place = 0
        while place < 700:  # photons that follow each other in their band
            stop = place + 1
            while stop < 700 and band[stop] == band[place]:
                stop += 1
            first = int(index[place])
            columns, others = of_photons(source, int(band[place]), first, first + stop - place)
            assert same_bits(floats[:, place:stop], columns)
            for one, other in zip((index, patch, component), others, strict=True):
                assert one[place:stop].tolist() == other.tolist()
            place = stop
    assert index[-1] == n - 1
    assert driver.stream(total - 1, ALL, 9)[0][0].shape[1] == 1


def test_codes_and_ends():
    driver = built()
    driver.take_bands(source_of("table", 300).to_bytes())
    for start, stop, n in ((0, 0, 0), (600, 700, 0), (9999, ALL, 0), (599, ALL, 1), (0, ALL, 600)):
        made, total = driver.stream(start, stop, 1000)
        assert (made[0].shape[1], total) == (n, 600)
    assert driver.stream(-1, 5, 10)[0] == CODES["RANGE"]
    assert driver.stream(5, 4, 10)[0] == CODES["RANGE"]
    absolute = sky.Scene(wavebands=[500.0], n_photons=700, components=sky.UniformSky(irradiance_W_m2_nm=1.4))
    driver.take_bands(source_of("table", 300).to_bytes(), absolute.source(seed=1).to_bytes())
    assert driver.stream(0, 5, 10)[0] == CODES["UNITS"]
    assert "no common light" in driver.message(CODES["UNITS"])
    driver.take_bands(source_of("table", 300).to_bytes(), source_of("table", 300, precision="float64").to_bytes())
    assert driver.stream(0, 5, 10)[0] == CODES["OTHER"]
    driver.take_bands(source_of("table", [0, 0]).to_bytes())
    made, total = driver.stream(0, ALL, 10)
    assert (made[0].shape[1], total) == (0, 0)


def test_the_weights_sum_to_the_light_of_all_bands():
    """A band has as many photons as the caller likes: the light of a photon undoes it."""
    beam = sky.DirectBeam(sun_zenith_deg=40.0, irradiance_W_m2_nm=[0.9, 0.4])
    parts = beam, sky.UniformSky(irradiance_W_m2_nm=[0.2, 0.5])
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=[20_000, 7000], components=parts)
    for options, rel in (({}, 1e-12), ({"bias": {"direct": 0.2}}, 1e-3)):
        source = scene.source(seed=1, **options)
        light = [sum(source.irradiance(band).values()) for band in (0, 1)]
        (floats, whole), _ = _whole_stream(source)
        assert floats[3].sum() == pytest.approx(sum(light), rel=rel)
        for band in (0, 1):
            assert floats[3][whole[1] == band].sum() == pytest.approx(light[band], rel=rel)
            direct = floats[3][(whole[1] == band) & (whole[3] == 0)].sum()
            assert direct == pytest.approx(source.irradiance(band)["direct"], rel=2e-3)


def _whole_stream(source):
    driver = built()
    driver.take_bands(source.to_bytes())
    return driver.stream(0, ALL, 40_000)


NULL = """#include "aomc_sky.h"
int main(void) {
    static aomc_sky_stream stream;
    aomc_sky_particle p;
    aomc_sky_source none[2];
    memset(none, 0, sizeof none);
    printf("%d %d ", aomc_sky_particles(NULL, none, 1, 0, 1), aomc_sky_particles(&stream, NULL, 1, 0, 1));
    printf("%d %d ", aomc_sky_next(NULL, &p), aomc_sky_next(&stream, NULL));
    printf("%d %d ", aomc_sky_particles(&stream, none, 0, 0, 1), aomc_sky_particles(&stream, none, 2, 0, 1));
    printf("%d", aomc_sky_next(&stream, &p)); /* a stream that was refused is at its end */
    return 0;
}
"""


@pytest.mark.parametrize("compiler", ["gcc -std=c99", "g++ -std=c++11"])
def test_null_and_empty(compiler, tmp_path):
    if shutil.which(compiler.split()[0]) is None:
        pytest.skip(f"{compiler} not installed")
    (tmp_path / "use.c").write_text(NULL)
    language = ["-x", "c++"] if "++" in compiler else []
    run([*compiler.split(), f"-I{include_dir()}", "-o", "use", *language, "use.c", "-lm"], tmp_path)
    names = "NULL", "NULL", "NULL", "NULL", "NO_BAND", "OTHER"
    assert run(["./use"], tmp_path).split() == [*(str(CODES[name]) for name in names), "0"]


THREADS = """#include "aomc_sky.h"
int main(void)
{
    aomc_sky_file file;
    aomc_sky_source sources[2];
    double sum = 0;
    int k, part;
    if (aomc_sky_load("day.sky", &file)) return 1;
    for (k = 0; k < 2; k++)
        if (aomc_sky_weighted_band(&file, k, sources + k)) return 1;
#pragma omp parallel for reduction(+ : sum)
    for (part = 0; part < 7; part++) {
        aomc_sky_stream stream;
        aomc_sky_particle p;
        int64_t n = sources[0].n + sources[1].n;
        if (aomc_sky_particles(&stream, sources, 2, n * part / 7, n * (part + 1) / 7)) sum = NAN;
        while (aomc_sky_next(&stream, &p) > 0) sum += ldexp(floor(ldexp(p.ux, 24)), 0) + (double)p.index;
    }
    printf("%.17g", sum);
    return 0;
}
"""


def test_threads_take_ranges(tmp_path):
    source = source_of("disc and table", [9001, 3000])
    sky.write_source(source, tmp_path / "day.sky")
    (tmp_path / "use.c").write_text(THREADS)
    run(["gcc", "-O0", "-fopenmp", f"-I{include_dir()}", "-o", "use", "use.c", "-lm"], tmp_path)
    floats, whole = by_python(source)
    exact = float(np.floor(np.ldexp(floats[0], 24)).sum() + whole[0].sum())  # whole numbers: in any order
    assert float(run(["./use"], tmp_path)) == exact


PROGRAM = """program particles
    use, intrinsic :: iso_fortran_env, only: int32, int64, real64
    use aomc_sky
    implicit none
    type(aomc_sky_file) :: file
    type(aomc_sky_source), target :: sources(2)
    type(aomc_sky_stream) :: stream
    type(aomc_sky_particle) :: p
    integer(int64) :: n = 0
    integer :: code, k
    code = aomc_sky_load("day.sky" // achar(0), file)
    do k = 1, 2
        if (code == 0) code = aomc_sky_weighted_band(file, int(k - 1, int32), sources(k))
    end do
    if (code == 0) code = aomc_sky_particles(stream, sources, 2_int32, 100_int64, huge(1_int64))
    if (code /= 0) error stop aomc_sky_text(int(code, int64))
    if (stream%n /= 5600 .or. stream%at /= 100 .or. stream%to /= 5600) error stop "another stream"
    do
        code = aomc_sky_next(stream, p)
        if (code <= 0) exit
        n = n + 1
        print "(6es26.17, 4i8)", p%ux, p%uy, p%uz, p%weight, p%x, p%y, p%index, p%band, p%patch, p%component
    end do
    if (code /= 0 .or. n /= 5500 .or. stream%at /= 5600) error stop "another end"
end program
"""


@needs("gfortran")
@pytest.mark.parametrize("precision", OPTIONS[0])
def test_fortran(precision, tmp_path):
    parts = *disc(40), table(sky.component.Law.CELL_MU2, 6, 9)
    circle = sky.Footprint.circle(2.0)
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=[3500, 2100], components=parts, footprint=circle)
    source = scene.source(seed=9, bias={"direct": 0.2}, precision=precision)
    sky.write_source(source, tmp_path / "day.sky")
    (tmp_path / "particles.f90").write_text(PROGRAM)
    run(["gfortran", "-o", "particles", "particles.f90", *fortran_flags()], tmp_path)
    numbers = np.array(run(["./particles"], tmp_path).split(), float).reshape(5500, 10).T
    floats, whole = by_python(source)
    assert same_bits(numbers[:6], floats[:, 100:])
    assert same_bits(numbers[6:], whole[:, 100:].astype(float))


@needs("nvcc")
def test_the_compiler_of_a_gpu_takes_positions_there_and_streams_on_its_host(tmp_path):
    (tmp_path / "use.cu").write_text(
        '#include "aomc_sky.h"\n'
        "__global__ void one(aomc_sky_source s, float *xy) { aomc_sky_position(&s, threadIdx.x, xy); }\n"
        "int main() { aomc_sky_source s = {}; static aomc_sky_stream t; aomc_sky_particle p;\n"
        "return aomc_sky_particles(&t, &s, 1, 0, 1) == 0 && aomc_sky_next(&t, &p); }\n"
    )
    folder = f"-I{include_dir()}"
    run(["nvcc", "-fmad=false", "-Werror", "all-warnings", folder, "-ptx", "-o", "use.ptx", "use.cu"], tmp_path)
    text = (tmp_path / "use.ptx").read_text()
    assert ".entry" in text
    assert "fma." not in text
    run(["nvcc", "-fmad=false", folder, "-o", "use", "use.cu"], tmp_path)
    run(["./use"], tmp_path)
