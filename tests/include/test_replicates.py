"""Replicates in one source file: the photons of each with the bits of Python, codes for hosts that know of none."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.include.test_damage import CODES, code_of, code_said, entry, read_under_sanitizers, with_bytes, word
from tests.support.builds import fortran_flags
from tests.support.host_programs import needs, run
from tests.support.host_scenes import WAVEBANDS, disc, table
from tests.support.shared import INPUTS
from tests.support.source_files import (
    OPTIONS,
    RECORDS,
    biased,
    built,
    needs_gcc,
    same_bits,
    section_names,
    source_of,
)

pytestmark = needs_gcc
CASES = ("table", "disc and table", "everything", "lobes and all")
WAYS = [way for way in itertools.product(CASES, *OPTIONS) if way[0] != "lobes and all" or way[3] != "centre"]
FOOTPRINT = sky.Footprint.circle(3.0)
REPLICATES = 128
"""Where the head has their number."""


def compare_replicates(driver, source):
    """Assert that the photons of every replicate, one after the other, are those of `source.photons`."""
    assert driver.view(source.to_bytes()) == 0
    for band in range(source.n_bands):
        batch = source.photons(band, numbers=3)
        light = 1.0 if source.irradiance(band) is None else sum(source.irradiance(band).values()) / max(len(batch), 1)
        for replicate in range(source.replicates):
            first, end = source.replicate_range(band, replicate)
            assert driver.replicate(band, replicate, weighted=True) == 0
            assert driver.n == end - first
            assert driver.photon_light == light or not len(batch)
            rows, patch = np.empty((3, end - first), source.dtype), np.empty(end - first, np.int32)
            weight = np.empty(end - first, source.dtype)
            assert driver.fill_weighted(0, rows, patch, weight) == end - first
            assert same_bits(rows, np.stack([batch.ux, batch.uy, batch.uz])[:, first:end])
            assert same_bits(patch, batch.patch[first:end])
            assert batch.weight is None or same_bits(weight, batch.weight[first:end])
            assert driver.numbers(0, rows) == end - first
            assert same_bits(rows, np.ascontiguousarray(batch.numbers.T)[:, first:end])
            if source.has_positions:
                assert driver.positions(0, rows[0], rows[1]) == end - first
                assert same_bits(rows[:2], np.stack([batch.x, batch.y])[:, first:end])
            assert driver.witness == 0


@pytest.mark.parametrize(("name", "precision", "order", "placement"), WAYS)
def test_photons_of_replicates_are_those_of_python(name, precision, order, placement):
    options = {"precision": precision, "order": order, "placement": placement, "replicates": 3}
    compare_replicates(built(), biased(name, 2003, **options))


@pytest.mark.parametrize("order", OPTIONS[1])
def test_replicates_over_a_footprint_in_units_with_few_photons_and_a_dark_band(order):
    day = sky.UniformSky(irradiance_W_m2_nm=1.4)
    scene = sky.Scene(wavebands=[450.0, 550.0, 650.0], n_photons=[1000, 7, 0], components=day, footprint=FOOTPRINT)
    compare_replicates(built(), scene.source(seed=5, replicates=7, order=order))
    compare_replicates(built("-O3 -march=native"), source_of("lobes", 5000, replicates=16, order=order))


def test_hosts_that_know_of_no_replicates_get_no_photons():
    driver, source = built(), source_of("table", 600, replicates=4)
    assert driver.view(source.to_bytes()) == 0
    for opened in (driver.band, driver.weighted_band):
        assert opened(0) == CODES["REPLICATES"]
        assert driver.n == 0
    assert "aomc_sky_replicate" in driver.message(CODES["REPLICATES"])
    assert [driver.replicate(0, r) for r in (0, 3, 4, -1)] == [0, 0, CODES["NO_BAND"], CODES["NO_BAND"]]
    assert driver.replicate(2, 0) == CODES["NO_BAND"]
    assert driver.view(biased("table", 600, replicates=2).to_bytes()) == 0
    assert driver.replicate(0, 1) == CODES["WEIGHTS"]
    assert driver.n == 0
    assert driver.replicate(0, 1, weighted=True) == 0
    assert driver.view(source_of("table", 600).to_bytes()) == 0  # one replicate is the band
    assert (driver.replicate(0, 0), driver.replicate(0, 1)) == (0, CODES["NO_BAND"])


def test_a_stream_over_all_replicates_has_the_light_of_the_band():
    scene = sky.Scene(wavebands=[450.0, 550.0], n_photons=900, components=sky.UniformSky(irradiance_W_m2_nm=1.4))
    driver = built()
    driver.take_bands(scene.source(seed=5, replicates=5).to_bytes())
    (floats, _), n = driver.stream(0, 2**62, 4000)
    assert n == floats.shape[1] == 1800
    assert floats[3].sum() == pytest.approx(2.8, rel=1e-12)


def test_replicates_share_their_tables():
    """Sixteen runs in a waveband of 32 400 patches and its disc: less than twice the size of one."""
    parts = table(sky.component.Law.CELL_MU2, 90, 360), *disc(30)
    scene = sky.Scene(wavebands=WAVEBANDS[:1], n_photons=50_000, components=parts[1:] + parts[:1])
    one, sixteen = (len(scene.source(seed=1, replicates=r).to_bytes()) for r in (1, 16))
    assert one < sixteen < 2 * one


@pytest.fixture(scope="module")
def data():
    return biased("lobes and all", 5000, replicates=3).to_bytes()


def words_that_are_damaged(data):
    """Sealed damages of every new word, and the codes that they have."""
    for value in (0, 1, 2):  # records of others, and sections that say 3
        yield with_bytes(data, REPLICATES, word(value)), "DIRECTORY"
    for value in (4, 2**31 - 1, 2**31, 2**63, 2**64 - 1):
        yield with_bytes(data, REPLICATES, word(value)), "DIRECTORY"
    for record in range(6):
        for value in (99, 2**32, 2**64 - 1):
            yield with_bytes(data, RECORDS + 320 * record + 8 * 35, word(value)), "DIRECTORY"
    at, offset, _ = entry(data, "replicates")
    for value in (2, 0, 2**32 - 1):
        yield with_bytes(data, offset, word(value)), "DIRECTORY"
    for place, new in ((8, (len(data) // 64 * 64, 2**63, offset + 8)), (16, (0, 2, 2**63))):
        yield from ((with_bytes(data, at + place, word(value)), "DIRECTORY") for value in new)
    kind = section_names().index("replicates") + 1
    yield with_bytes(data, at, word(kind | 8 << 32)), "DIRECTORY"
    yield with_bytes(data, at, word(40 | 4 << 32)), "DIRECTORY"  # none


def test_damages_have_codes(data, tmp_path):
    damages = [*words_that_are_damaged(data), (data, "ok")]
    assert [code_of(changed) for changed, _ in damages] == [code for _, code in damages]
    said = read_under_sanitizers([changed for changed, _ in damages], tmp_path)
    assert [code_said(line) for line in said] == [code for _, code in damages]


def test_a_replicate_of_another_is_found():
    """Planted: the photons of one replicate for those of another, by their records."""
    data = source_of("table", 600, replicates=2).to_bytes()
    size = 320 * 2
    first, second = data[RECORDS : RECORDS + size], data[RECORDS + size : RECORDS + 2 * size]
    changed = with_bytes(data, RECORDS, second + first)
    assert code_of(changed) == "DIRECTORY"


PROGRAM = """program runs
    use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
    use aomc_sky
    implicit none
    type(aomc_sky_file) :: file
    type(aomc_sky_source) :: source
    real(real32), dimension(1000) :: ux, uy, uz
    integer(int32) :: r
    integer(int64) :: n
    if (aomc_sky_load("day.sky" // achar(0), file) /= 0) error stop "no file"
    print "(a)", aomc_sky_text(int(aomc_sky_band(file, 0, source), int64))
    do r = 0, file%n_replicates - 1
        if (aomc_sky_replicate(file, 1, r, source) /= 0) error stop "no replicate"
        n = aomc_sky_fill(source, 0_int64, 1000_int64, ux, uy, uz)
        print "(i0, es24.16)", n, sum(real(uz(:n), real64))
    end do
end program
"""


@needs("gfortran")
def test_fortran(tmp_path):
    source = source_of("disc and table", 2500, replicates=4)
    sky.write_source(source, tmp_path / "day.sky")
    (tmp_path / "runs.f90").write_text(PROGRAM)
    run(["gfortran", "-o", "runs", "runs.f90", *fortran_flags()], tmp_path)
    message, *lines = run(["./runs"], tmp_path).strip().split("\n")
    assert "aomc_sky_replicate" in message
    uz = source.photons(1).uz.astype(float)
    for replicate, line in enumerate(lines):
        first, end = source.replicate_range(1, replicate)
        n, total = line.split()
        assert int(n) == end - first
        assert float(total) == pytest.approx(uz[first:end].sum(), rel=1e-12)
    assert len(lines) == 4


def test_a_run_writes_exports_and_verifies_its_replicates(tmp_path, told):
    scene = str(INPUTS / "perez_sky" / "amc.inp")
    words = ["run", scene, "--iterations", "2000", "--replicates", "4", "--format", "source"]
    assert main([*words, "--out", str(tmp_path / "day"), "-q"]) == 0
    source = sky.PhotonSource(sky.Plan.load(tmp_path / "day" / "plan.npz"))
    assert (tmp_path / "day" / "source.sky").read_bytes() == source.to_bytes()
    compare_replicates(built(), source)
    assert main(["verify", str(tmp_path / "day"), "-q"]) == 0
    shown = json.loads(told("info", tmp_path / "day" / "source.sky", "--json").out)
    assert shown["replicates"] == 4
    assert [band["photons"] for band in shown["bands"]] == list(source.launched)
    assert "replicates: 4" in told("info", tmp_path / "day" / "source.sky").out
    other = dataclasses.replace(source.plan, options=source.plan.options | {"seed": 77})
    (tmp_path / "day" / "source.sky").write_bytes(sky.PhotonSource(other).to_bytes())
    assert main(["verify", str(tmp_path / "day"), "-q"]) == 1
