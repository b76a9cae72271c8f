"""The Fortran module under strict flags: the bits of Python in every form of every routine, and nothing beside them."""

import re
import shutil
import subprocess

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from tests.include.test_damage import CODES, HEADER
from tests.include.test_stream import by_python, of_photons
from tests.support.builds import SANITIZED, header
from tests.support.host_programs import FLAGS, needs, run
from tests.support.host_scenes import WAVEBANDS, disc, table
from tests.support.pages import SavedFile, steps
from tests.support.shared import INPUTS, REPOSITORY
from tests.support.source_files import built, same_bits, source_of

pytestmark = needs("gcc", "gfortran")
MODULE = include_dir() / "aomc_sky.f90"
TEXT = MODULE.read_text()
STRICT = {
    "plain": FLAGS,
    "wide": "-fcheck=all -fdefault-integer-8 -fdefault-real-8 -Wall -Wextra -Werror",
    "sanitized": f"{SANITIZED} -fcheck=all -Wall -Wextra -Werror",
}


class Fortran:
    """Folders with the module and the header, compiled once for each set of flags, and the sources of a test."""

    def __init__(self, folder):
        self.folder = folder

    def module(self, name):
        """The folder of a compiled module."""
        into = self.folder / name
        if not into.exists():
            into.mkdir()
            run(["gfortran", *STRICT[name].split(), "-c", str(MODULE)], into)
            shutil.copy(header(f"-O0 {SANITIZED}" if name == "sanitized" else "-O1"), into)
        return into

    def build(self, name, text, folder, *more):
        """Compile a program in `folder`; returns its path."""
        module = self.module(name)
        (folder / "host.f90").write_text(text)
        flags = [*STRICT[name].split(), *more, f"-I{module}"]
        run(["gfortran", *flags, "-o", "host", "host.f90", f"{module}/aomc_sky.o", f"{module}/header.o", "-lm"], folder)
        return folder / "host"

    def said(self, name, text, folder, *more):
        """What a program prints, warnings of its library included."""
        self.build(name, text, folder, *more)
        return run(["sh", "-c", "./host 2>&1"], folder)


@pytest.fixture(scope="module")
def fortran(tmp_path_factory):
    return Fortran(tmp_path_factory.mktemp("fortran"))


def program(body, declarations=""):
    uses = "use, intrinsic :: iso_c_binding\nuse aomc_sky"
    return f"program host\n{uses}\nimplicit none\n{declarations}\n{body}\nend program\n"


@pytest.fixture(scope="module")
def day(tmp_path_factory):
    """The folder of the file of docs/hosts.md."""
    folder = tmp_path_factory.mktemp("day")
    (folder / "day").mkdir()
    sky.write_source(sky.read_scene(INPUTS / "clear_day", iterations=100_000).source(1), folder / "day" / "source.sky")
    return folder


@pytest.mark.parametrize("name", STRICT)
def test_the_program_of_the_page(name, fortran, day):
    """It compiles under all flags, prints what the page shows, and no library warns."""
    page = [*steps((REPOSITORY / "docs" / "hosts.md").read_text())]
    (host,) = [step for step in page if isinstance(step, SavedFile) and step.name.endswith(".f90")]
    (shown,) = [step.shown for step in page if not isinstance(step, SavedFile) and step.line == "./host90"]
    assert fortran.said(name, host.text, day) == shown


OLD_LOAD = """interface
integer(c_int) function load(path, file) bind(C, name="aomc_sky_load")
import
character(kind=c_char), intent(in) :: path(*)
type(aomc_sky_file), intent(out) :: file
end function
end interface
"""


def test_a_name_needs_no_end(fortran, day):
    """Blanks behind it do not count; achar(0) may stand there. Planted: the interface before, which read on."""
    names = '"day/source.sky"', '"day/source.sky  "', '"day/source.sky" // achar(0)', "path", "full", '""', '"no.sky"'
    variables = 'type(aomc_sky_file) :: file\ncharacter(40) :: path = "day/source.sky"\n'
    variables += 'character(14) :: full = "day/source.sky"'
    loads = "\n".join(f'print "(i0)", aomc_sky_load({name}, file); call aomc_sky_unload(file)' for name in names)
    codes = [0, 0, 0, 0, 0, CODES["NO_FILE"], CODES["NO_FILE"]]
    assert fortran.said("sanitized", program(loads, variables), day).split() == [str(code) for code in codes]
    old = program('print "(i0)", load(full, file)', f"{OLD_LOAD}{variables}")
    host = fortran.build("sanitized", old, day, "-Wno-error")
    done = subprocess.run([host], cwd=day, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "overflow" in done.stderr


OLD_FILL = """interface
integer(c_int64_t) function fill(source, start, n, ux, uy, uz) bind(C, name="aomc_sky_fill")
import
type(aomc_sky_source), intent(in) :: source
integer(c_int64_t), value :: start, n
real(c_float), intent(out) :: ux(*), uy(*), uz(*)
end function
end interface
type(aomc_sky_file) :: file
type(aomc_sky_source) :: source
real(c_float) :: u(3, 9) = 7
integer(c_int64_t) :: n
"""
CHECKED = """if (aomc_sky_load("day/source.sky", file) /= 0) error stop "no file"
if (aomc_sky_band(file, 0, source) /= 0) error stop "no band"
n = {}(source, source%n - 4, 9_c_int64_t, u(1, :), u(2, :), u(3, :))
print "(i0, 9es14.6)", n, u(1, :)"""


def test_strided_rows_keep_their_rest(fortran, day):
    """Planted: `intent(out)` of the interface before, whose copies come back with what they hold behind photon n."""
    last = sky.read_scene(INPUTS / "clear_day", iterations=100_000).source(1).photons(0, 99_996).ux
    rest = {}
    for name in ("fill", "aomc_sky_fill"):
        n, *u = fortran.said("plain", program(CHECKED.format(name), OLD_FILL), day).split()
        assert n == "4"
        assert same_bits(np.array(u[:4], np.float32).round(6), last.round(6))
        rest[name] = [float(x) for x in u[4:]]
    assert rest["aomc_sky_fill"] == [7.0] * 5
    assert rest["fill"] != [7.0] * 5
    assert "temporary" in fortran.said("wide", program(CHECKED.format("fill"), OLD_FILL), day)


EVERY = """program host
    use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
    use aomc_sky
    implicit none
    integer, parameter :: m = 1300
    type(aomc_sky_file) :: file, other
    type(aomc_sky_source), target :: sources(2)
    type(aomc_sky_source) :: one
    type(aomc_sky_photon{at}) :: photon
    type(aomc_sky_stream) :: stream
    type(aomc_sky_particle) :: p
    character(40) :: path = "day.sky"
    real({real}) :: ux(m), uy(m), uz(m), weight(m), u(3, m), two(2, m), xy(2), three(3)
    real({wrong}) :: wrong(5)
    integer(int32) :: patch(m), two_patches(2, m)
    integer({start}) :: start = 2500, from
    integer({n}) :: n = 600, i, band
    integer(int64) :: left
    integer :: out

    open (newunit=out, file="columns", access="stream", form="unformatted", status="replace")
    call need(aomc_sky_load(path, file))
    do band = 0, 1
        call need(aomc_sky_weighted_band(file, band, sources(band + 1)))
        call need(aomc_sky_witness(sources(band + 1)))
    end do

    call wipe()
    left = aomc_sky_fill{d}(sources(1), start, ux, uy, uz, patch, weight)
    write (out) left, ux, uy, uz, patch, weight
    left = aomc_sky_fill_weighted{d}(sources(1), start, u, two_patches(1, :), two(2, :))
    write (out) left, u, two_patches, two
    call wipe()
    left = aomc_sky_fill{d}(sources(1), start, n, u(1, :), u(2, :), u(3, :), weight=two(1, :))
    write (out) left, u, two
    left = aomc_sky_fill_weighted{d}(sources(2), 0, 900, ux, uy(:40), uz(:50), patch=patch(:1200:30))
    write (out) left, ux, uy, uz, patch

    call wipe()
    left = aomc_sky_numbers{d}(sources(1), start, ux, uy, uz)
    write (out) left, ux, uy, uz
    left = aomc_sky_numbers{d}(sources(1), start, n, u(1, :), n3=u(3, :))
    write (out) left, u
    left = aomc_sky_numbers{some}(sources(1), start, n2=uz)
    write (out) left, uz

    call wipe()
    left = aomc_sky_positions{d}(sources(1), start, two(1, :), two(2, :))
    write (out) left, two
    left = aomc_sky_positions{d}(sources(1), start, n, x=ux)
    write (out) left, ux
    left = aomc_sky_positions{some}(sources(1), start, n, y=uy)
    write (out) left, uy

    do i = 0, 19
        photon = aomc_sky_at{at}(sources(1), i)
        call aomc_sky_position{d}(sources(1), i, xy)
        call aomc_sky_numbers_at{d}(sources(1), i, three)
        write (out) photon%ux, photon%uy, photon%uz, xy, three, real(aomc_sky_weight{d}(sources(1), photon), {real})
        write (out) photon%patch, aomc_sky_component(sources(1), photon%patch), &
            aomc_sky_component(sources(1), int(photon%patch, int64))
    end do

    call need(aomc_sky_particles(stream, sources))
    call follow()
    from = 5000
    call need(aomc_sky_particles(stream, sources, from, to=5200))
    call follow()
    call need(aomc_sky_particles(stream, sources, 1, from - 5000, n))
    call follow()

    call need(aomc_sky_load("runs.sky", other))
    do i = 0, other%n_replicates - 1_int32
        call need(aomc_sky_replicate(other, 1, i, one))
        left = aomc_sky_fill{d}(one, 0, ux, uy, uz)
        write (out) one%n, ux(:left)
        call need(aomc_sky_weighted_replicate(other, 1, i, one))
        left = aomc_sky_fill{d}(one, 0, ux, uy, uz)
        write (out) uy(:left)
    end do
    write (out) aomc_sky_band(other, 0, one)
    call aomc_sky_unload(other)
    call need(aomc_sky_view(file%bytes, file%size, other))
    write (out) other%n_bands, aomc_sky_checksum(file%bytes, file%size), aomc_sky_view(file%bytes, -1, other)

    write (out) aomc_sky_band(file, 0, one), aomc_sky_weighted_band(file, 2, one), &
        aomc_sky_band(file, 2_int64**33, one), aomc_sky_replicate(file, 0, 2_int64**32, one), &
        aomc_sky_weighted_replicate(file, 2_int64**32, -1, one), aomc_sky_component(sources(1), 2_int64**32), &
        aomc_sky_particles(stream, sources, 3, 0, 9), aomc_sky_particles(stream, sources(:0)), &
        aomc_sky_particles(stream, sources, -1_int64), aomc_sky_view(file%bytes, -2_int64**40, other)
    write (out) aomc_sky_fill{d}(sources(1), -1, ux, uy, uz), &
        aomc_sky_fill{d}(sources(1), start, -1, u(1, :), u(2, :), u(3, :)), &
        aomc_sky_fill{d}(sources(1), 3500_int64, u), aomc_sky_fill{d}(sources(1), 0, u(:, :0)), &
        aomc_sky_numbers{d}(sources(1), 2_int64**40, ux), aomc_sky_fill(sources(1), 0, wrong, wrong, wrong)
    print "(a)", aomc_sky_text(AOMC_SKY_WEIGHTS), aomc_sky_text(int(AOMC_SKY_OTHER, int64))
    call aomc_sky_unload(file)

contains

    subroutine need(code)
        integer(kind(aomc_sky_null)), intent(in) :: code
        if (code /= 0) error stop aomc_sky_text(code)
    end subroutine

    subroutine wipe()
        ux = 7
        uy = 7
        uz = 7
        weight = 7
        u = 7
        two = 7
        patch = 7
        two_patches = 7
    end subroutine

    subroutine follow()
        integer(kind(aomc_sky_null)) :: code
        write (out) stream%n, stream%to - stream%at
        do
            code = aomc_sky_next(stream, p)
            if (code <= 0) exit
            write (out) p%ux, p%uy, p%uz, p%weight, p%x, p%y, p%index, int([p%band, p%patch, p%component], int64)
        end do
        call need(code)
    end subroutine
end program
"""


class Columns:
    """Numbers that a program has written, in their order."""

    def __init__(self, path):
        self.data = path.read_bytes()

    def take(self, dtype, *shape):
        n = int(np.prod(shape)) * np.dtype(dtype).itemsize
        part, self.data = self.data[:n], self.data[n:]
        return np.frombuffer(part, dtype).reshape(shape)

    def expect(self, n, *arrays):
        """Assert that n and arrays follow; of an array (k, n) Fortran wrote all k numbers of a photon together."""
        assert self.take(np.int64, 1) == n
        for array in arrays:
            assert same_bits(self.take(array.dtype, *array.T.shape).T, array)


M = 1300


def rows(*columns):
    """Arrays (k, M) of a program: a column from their first element on, 7 elsewhere."""
    made = np.full((len(columns), M), 7, next(c.dtype for c in columns if c is not None))
    for row, column in zip(made, columns, strict=True):
        if column is not None:
            row[: column.size] = column
    return made


def check_columns(columns, source, runs):
    """Assert that the program `EVERY` wrote the photons of Python, and left the rest alone."""
    batch, other = source.photons(0, 2500, numbers=3), source.photons(1, 0, 40)
    u, numbers = (batch.ux, batch.uy, batch.uz), batch.numbers.T
    columns.expect(1000, *(rows(c)[0] for c in (*u, batch.patch, batch.weight)))
    columns.expect(1000, rows(*u), rows(batch.patch, None), rows(None, batch.weight))
    columns.expect(600, rows(*(c[:600] for c in u)), rows(batch.weight[:600], None))
    patch = np.full(M, 7, np.int32)
    patch[:1200:30] = other.patch
    columns.expect(40, *(rows(c)[0] for c in (other.ux, other.uy, other.uz)), patch)

    columns.expect(1000, *(rows(c)[0] for c in numbers))
    columns.expect(600, rows(numbers[0, :600], None, numbers[2, :600]))
    columns.expect(1000, rows(numbers[1])[0])

    columns.expect(1000, rows(batch.x, batch.y))
    columns.expect(600, rows(batch.x[:600])[0])
    columns.expect(600, rows(batch.y[:600])[0])

    first = source.photons(0, 0, 20, numbers=3)
    component = source.component_of(first.patch)
    for k in range(20):
        floats = [first.ux[k], first.uy[k], first.uz[k], first.x[k], first.y[k], *first.numbers[k], first.weight[k]]
        assert same_bits(columns.take(source.dtype, 9), np.array(floats, source.dtype))
        assert columns.take(np.int32, 3).tolist() == [first.patch[k], component[k], component[k]]

    every = by_python(source)
    floats, (index, patch, component) = of_photons(source, 0, 0, 600)
    alone = floats, np.array([index, np.zeros(600), patch, component], np.int64)
    for n, start, stop, (floats, whole) in ((5600, 0, 5600, every), (5600, 5000, 5200, every), (3500, 0, 600, alone)):
        assert columns.take(np.int64, 2).tolist() == [n, stop - start]
        for k in range(start, stop):
            assert same_bits(columns.take(np.float64, 6), floats[:, k])
            assert same_bits(columns.take(np.int64, 4), whole[:, k])

    data, batch = source.to_bytes(), runs.photons(1)
    for replicate in range(3):
        first, end = runs.replicate_range(1, replicate)
        columns.expect(end - first, batch.ux[first:end])
        assert same_bits(columns.take(runs.dtype, end - first), batch.uy[first:end])
    assert columns.take(np.int32, 2).tolist() == [CODES["REPLICATES"], 2]
    assert columns.take(np.uint64, 1) == built().checksum(data)
    codes = ["NOT_OURS", "WEIGHTS", *["NO_BAND"] * 4, "", "NO_BAND", "NO_BAND", "RANGE", "NOT_OURS"]
    assert columns.take(np.int32, 11).tolist() == [CODES.get(code, -1) for code in codes]
    codes = ["RANGE", "RANGE", "", "", "", "OTHER"]
    assert columns.take(np.int64, 6).tolist() == [CODES.get(code, 0) for code in codes]
    assert columns.data == b""


WAYS = [
    ("plain", "float32", "int64", "int32"),
    ("sanitized", "float32", "int32", "int64"),
    ("wide", "float32", "int64", "int64"),
    ("wide", "float64", "int32", "int32"),
    ("sanitized", "float64", "int64", "int32"),
    ("plain", "float64 by name", "int32", "int64"),
]
"""Flags, precision, and kinds of the numbers that go in."""


@pytest.mark.parametrize(("name", "precision", "start", "n"), WAYS)
def test_every_routine(name, precision, start, n, fortran, tmp_path):
    """All forms of all routines: bits, codes, and arrays that are left alone where no photon goes."""
    is_double, d = precision != "float32", "_double" if "name" in precision else ""
    words = {
        "start": start,
        "n": n,
        "d": d,
        "at": "_double" if is_double else "",
        "some": "_double" if is_double else "",
    }
    words |= {"real": "real64", "wrong": "real32"} if is_double else {"real": "real32", "wrong": "real64"}
    text = re.sub(r"\{(\w+)\}", lambda found: words[found[1]], EVERY)
    parts = *disc(40), table(sky.component.Law.CELL_MU2, 6, 9)
    circle = sky.Footprint.circle(2.0)
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=[3500, 2100], components=parts, footprint=circle)
    source = scene.source(seed=9, bias={"direct": 0.2}, precision=precision.split()[0])
    runs = source_of("disc and table", 2500, replicates=3, precision=precision.split()[0])
    sky.write_source(source, tmp_path / "day.sky")
    sky.write_source(runs, tmp_path / "runs.sky")
    weights, other = fortran.said(name, text, tmp_path).splitlines()
    assert "aomc_sky_weighted_band" in weights
    assert "the other precision" in other
    check_columns(Columns(tmp_path / "columns"), source, runs)


def public():
    """Names of the types and routines that the module offers."""
    (names,) = re.findall(r"^    public :: (.*?[^&])\n", TEXT, re.MULTILINE | re.DOTALL)
    return re.findall(r"\w+", names)


def test_no_public_name_is_forgotten():
    """Every one is in the program of all forms, under its name; with `_double` where it has one."""
    text = EVERY.replace("{d}", "").replace("{at}", "").replace("{some}", "")
    missing = {name for name in public() if not re.search(rf"\b{name.removesuffix('_double')}\b", text)}
    assert missing == set()
    functions = re.findall(r"^AOMC_SKY_(?:HOST_)?API .*?\b(aomc_sky_\w+)\(", HEADER.read_text(), re.MULTILINE)
    of_a_gpu = {"aomc_sky_band_at", "aomc_sky_weighted_band_at", "aomc_sky_weighted_replicate_at"}
    assert set(functions) - set(public()) == {*of_a_gpu, "aomc_sky_message"}


def test_every_code_has_its_name():
    """Planted: a code of the header that the module lacks would be in the difference."""
    named = {name: int(code) for name, code in re.findall(r"AOMC_SKY_(\w+) = (-\d+)", TEXT)}
    named["CHECKSUM"] = named.pop("BAD_CHECKSUM")
    assert named == CODES


SIZES = """#include "aomc_sky.h"
int64_t sizes(int k) {
    const int64_t all[] = {sizeof(aomc_sky_file), sizeof(aomc_sky_source), sizeof(aomc_sky_photon),
        sizeof(aomc_sky_photon_double), sizeof(aomc_sky_particle), sizeof(aomc_sky_stream)};
    return all[k];
}
"""
SIZED = """type(aomc_sky_file) :: a
type(aomc_sky_source) :: b
type(aomc_sky_photon) :: c
type(aomc_sky_photon_double) :: d
type(aomc_sky_particle) :: e
type(aomc_sky_stream) :: f
interface
    integer(c_int64_t) function sizes(k) bind(C)
        import
        integer(c_int), value :: k
    end function
end interface
integer(c_int) :: k
print "(6i8)", c_sizeof(a), c_sizeof(b), c_sizeof(c), c_sizeof(d), c_sizeof(e), c_sizeof(f), (sizes(k), k = 0, 5)"""


def test_types_have_the_sizes_of_c(fortran, tmp_path):
    (tmp_path / "sizes.c").write_text(SIZES)
    run(["gcc", f"-I{include_dir()}", "-c", "sizes.c"], tmp_path)
    ours, of_c = fortran.said("plain", program("", SIZED), tmp_path, "sizes.o", "-Wno-error").splitlines()
    assert ours == of_c
    assert ours.split()[:2] == ["96", "512"]


THREADS = """integer(c_int64_t) :: start
real(c_double) :: cosine = 0
real(c_float) :: u(3, 700)
integer(c_int64_t) :: n
type(aomc_sky_file) :: file
type(aomc_sky_source) :: source
if (aomc_sky_load("day/source.sky", file) /= 0) error stop "no file"
if (aomc_sky_band(file, 0, source) /= 0) error stop "no band"
!$omp parallel do private(u, n) reduction(+: cosine) schedule(dynamic) num_threads(3)
do start = 0, source%n - 1, 700
    n = aomc_sky_fill(source, start, u)
    cosine = cosine - sum(int(u(3, :n) * 2.0**20, c_int64_t))
end do
print "(i0)", nint(cosine, c_int64_t)"""


def test_threads_have_blocks_of_their_own(fortran, day):
    """The module is compiled without -fopenmp, which would put every block on the stack."""
    uz = sky.read_scene(INPUTS / "clear_day", iterations=100_000).source(1).photons(0).uz
    total = -np.trunc(uz.astype(float) * 2**20).sum()
    host = fortran.build("plain", program("", THREADS), day, "-fopenmp")
    assert {int(run([str(host)], day)) for _ in range(5)} == {total}


STOPS = {
    "aomc_sky_band(file, 0.0, source)": "integers of 32 or 64 bits",
    "aomc_sky_fill(source, .true., u(1, :), u(2, :), u(3, :))": "integers of 32 or 64 bits",
    "aomc_sky_fill(source, 0, u(:2, :))": "u(3, n)",
    "aomc_sky_particles(stream, sources(::2))": "do not follow each other",
}
REFUSED = [
    "aomc_sky_particles(stream, [source])",
    "aomc_sky_particles(stream, alone)",
    "aomc_sky_fill(source, 0, u(1, :), u(2, :), d)",
    "aomc_sky_fill(source, 0, (u))",
    "aomc_sky_at(source, 0.0)",
]
VARIABLES = """type(aomc_sky_file) :: file
type(aomc_sky_source) :: source, alone(3)
type(aomc_sky_source), target :: sources(3)
type(aomc_sky_stream) :: stream
type(aomc_sky_photon) :: photon
real(c_float) :: u(3, 9)
real(c_double) :: d(9)
integer(c_int64_t) :: n"""


@pytest.mark.parametrize("call", STOPS)
def test_wrong_calls_stop(call, fortran, tmp_path):
    host = fortran.build("plain", program(f"n = {call}\nprint *, n", VARIABLES), tmp_path, "-Wno-unused", "-Wno-error")
    done = subprocess.run([host], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert STOPS[call] in done.stderr


@pytest.mark.parametrize("call", REFUSED)
def test_wrong_calls_are_not_compiled(call, fortran, tmp_path):
    left = "photon" if "_at(" in call else "n"
    (tmp_path / "host.f90").write_text(program(f"{left} = {call}", VARIABLES))
    command = ["gfortran", "-fsyntax-only", f"-I{fortran.module('plain')}", "host.f90"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "no specific function" in done.stderr
