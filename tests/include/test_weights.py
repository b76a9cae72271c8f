"""Weights and components in the source file: bits of every column, codes for damage, and who may open such a file."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.cli.main import main
from aomc_sky.emission.emitter import Emitter
from aomc_sky.emission.source_file import source_bytes
from tests.include.test_damage import CODES, code_of, code_said, entry, read_under_sanitizers, with_bytes, word
from tests.support.builds import fortran_flags
from tests.support.host_programs import needs, run
from tests.support.host_scenes import WAVEBANDS, disc, perez, table
from tests.support.sampled import table_of
from tests.support.shared import INPUTS
from tests.support.source_files import (
    LOBES,
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
CASES = ("table", "disc and table", "everything", *LOBES)
WAYS = [way for way in itertools.product(CASES, *OPTIONS) if way[0] not in LOBES or way[3] != "centre"]


def columns(driver, source, start, n, *, with_patch=True, with_weight=True):
    """Directions, patches and weights of n photons by the header; None for a column that is left out."""
    rows, patch = np.full((3, n), np.nan, source.dtype), np.full(n, -7, np.int32) if with_patch else None
    weight = np.full(n, np.nan, source.dtype) if with_weight else None
    assert driver.fill_weighted(start, rows, patch, weight) == n
    return rows, patch, weight


def compare_weighted(driver, source):
    """Assert that all columns of every band are those of `source.photons`."""
    assert driver.view(source.to_bytes()) == 0
    for band in range(source.n_bands):
        assert driver.weighted_band(band) == 0
        total = source.n_photons(band)
        start = total // 3
        batch = source.photons(band, start)
        directions = np.stack([batch.ux, batch.uy, batch.uz])
        for with_patch, with_weight in itertools.product((True, False), repeat=2):
            has = {"with_patch": with_patch, "with_weight": with_weight}
            rows, patch, weight = columns(driver, source, start, total - start, **has)
            assert same_bits(rows, directions)
            assert patch is None or same_bits(patch, batch.patch)
            assert weight is None or same_bits(weight, batch.weight)
        plain = np.empty_like(rows)
        assert driver.fill(start, plain) == total - start
        assert same_bits(plain, directions)
        (_, _, uz, *_), single = driver.at(np.arange(start, start + 100), source.dtype)
        assert same_bits(driver.weights(uz, single).astype(source.dtype), batch.weight[:100])
        assert same_bits(driver.components(single), source.component_of(single))


@pytest.mark.parametrize(("name", "precision", "order", "placement"), WAYS)
def test_columns_are_those_of_python(name, precision, order, placement):
    source = biased(name, 3011, precision=precision, order=order, placement=placement)
    assert np.unique(source.photons(0).weight).size > 1
    compare_weighted(built(), source)


@pytest.mark.parametrize("order", OPTIONS[1])
def test_a_sky_and_its_beam_in_some_ten_thousand_patches(order):
    parts = *perez(90, 120), *disc(40)
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=100_003, components=parts)
    compare_weighted(built("-O3 -march=native"), scene.source(seed=4, bias={"direct": 0.2}, order=order))
    compare_weighted(built("-O3 -march=native"), scene.source(seed=4, bias={"direct": 0.2}, method="iid"))


def of_listed_values():
    """A table of listed values, whose photons have weights of their patches."""
    values = np.random.default_rng(3).lognormal(0, 1, (7, 11))
    return table_of(values, weighting="listed").lower([450.0, 550.0])


def by_solid_angle(parts, n=3011, **options):
    """Photons by solid angle with the weights that turn them into flux, and photons of other laws beside them."""
    weight = np.random.default_rng(8).uniform(0.5, 2.0, parts[0].mass.shape)
    first = dataclasses.replace(parts[0], weight=weight)
    scene = sky.Scene(wavebands=WAVEBANDS, n_photons=n, components=(first, *parts[1:]))
    return scene.source(seed=3, weights=True, **options)


BY_ANGLE = {
    "alone": lambda: (table(sky.component.Law.CELL_MU, 7, 11),),
    "beside all others": lambda: (table(sky.component.Law.CELL_MU, 3, 2, "coarse"), *perez(6, 5), *disc(35)),
    "not by angle": lambda: (*disc(20), table(sky.component.Law.CELL_MU2, 6, 9)),
    "listed": of_listed_values,
}
HAS_MU = {"alone", "beside all others"}


@pytest.mark.parametrize(("name", "precision", "order", "placement"), list(itertools.product(BY_ANGLE, *OPTIONS)))
def test_weights_of_photons_by_solid_angle(name, precision, order, placement):
    """Weight times mu in cells of that law alone; in one order the header makes blocks, in the other runs."""
    source = by_solid_angle(BY_ANGLE[name](), precision=precision, order=order, placement=placement)
    assert np.unique(source.photons(0).weight).size > 1
    data = source.to_bytes()
    assert (np.frombuffer(data, "<u8")[RECORDS // 8 + 32] >> np.uint64(8)) == (name in HAS_MU)
    compare_weighted(built(), source)
    assert built().band(0) == CODES["WEIGHTS"]


def test_the_light_of_photons_by_solid_angle_is_that_of_flux_and_a_planted_mu_shows():
    """Mean cosine of a uniform sky, 2/3; planted: weights without their mu give 1/2, mu twice 3/4."""
    uniform = sky.UniformSky(per_solid_angle=True)
    source = sky.Scene(wavebands=[550.0], n_photons=200_000, components=uniform).source(1, weights=True)
    data, driver, means = source.to_bytes(), built(), []
    for changed in (data, with_bytes(data, RECORDS + 8 * 32, word(0))):
        assert driver.view(changed) == 0
        assert driver.weighted_band(0) == 0
        (_, _, uz), _, weight = columns(driver, source, 0, driver.n)
        means.append(-float(np.average(uz, weights=weight)))
    assert means == pytest.approx([2 / 3, 1 / 2], abs=1e-3)
    assert -float(np.average(uz, weights=weight * uz**2)) == pytest.approx(3 / 4, abs=1e-3)


@pytest.mark.parametrize("n", [1, 2, 511, 2**32 + 5])
@pytest.mark.parametrize("order", OPTIONS[1])
def test_few_and_many_photons(n, order):
    source, driver = biased("disc and table", n, order=order), built()
    assert driver.view(source.to_bytes()) == 0
    assert driver.weighted_band(1) == 0
    start = max(n - 700, 0)
    batch = source.photons(1, start)
    rows, patch, weight = columns(driver, source, start, n - start)
    assert same_bits(rows, np.stack([batch.ux, batch.uy, batch.uz]))
    assert same_bits(patch, batch.patch)
    assert same_bits(weight, batch.weight)


@pytest.mark.parametrize("order", OPTIONS[1])
def test_without_a_bias_every_weight_is_1(order):
    source, driver = source_of("everything", 3000, order=order), built()
    driver.open(source)
    batch = source.photons(0)
    _, patch, weight = columns(driver, source, 0, 3000)
    assert same_bits(patch, batch.patch)
    assert same_bits(weight, np.ones(3000, np.float32))
    cells = np.arange(-1, source.plan.n_cells + 1)
    weight = driver.weights(np.full(cells.size, -0.5, np.float32), cells)
    assert driver.components(cells).tolist() == [-1, *source.component_of(cells[1:-1]), -1]
    assert weight[1:-1].tolist() == [1.0] * source.plan.n_cells
    assert np.isnan(weight[[0, -1]]).all()
    assert driver.weighted_band(1) == 0
    assert driver.n == 3000


def test_a_host_that_ignores_weights_gets_no_light():
    driver = built()
    assert driver.view(biased("disc and table", 500).to_bytes()) == 0
    assert driver.band(0) == CODES["WEIGHTS"]
    assert driver.n == 0
    assert "aomc_sky_weighted_band" in driver.message(CODES["WEIGHTS"])
    rows = np.empty((3, 5), np.float32)
    assert driver.fill(0, rows) == CODES["OTHER"]  # it is empty
    assert driver.weighted_band(9) == driver.band(9) == CODES["NO_BAND"]
    assert driver.weighted_band(0) == 0
    assert driver.fill_weighted(-1, rows, None, None) == CODES["RANGE"]
    assert driver.fill_weighted(0, rows.astype(float), None, None) == CODES["OTHER"]
    assert driver.fill_weighted(500, rows, None, None) == 0
    assert driver.fill_weighted(497, rows, None, None) == 3


OLD = ("kind >= 1 && kind <= AOMC_SKY_LAST_KIND", "kind >= 1 && kind <= AOMC_SKY_STOKES")
LOADED = """#include "aomc_sky.h"
int main(int n, char **names) {
    aomc_sky_file file;
    aomc_sky_source s;
    int code = n == 2 ? aomc_sky_load(names[1], &file) : 1;
    if (code == 0) code = aomc_sky_band(&file, 0, &s);
    if (code != 0) return puts(aomc_sky_message(code)), 0;
    printf("%d photons, component %d, ", (int)s.n, aomc_sky_component(&s, 0));
    printf("weight %g", aomc_sky_weight(&s, aomc_sky_at(&s, 0)));
    return 0;
}
"""


def test_an_older_header_refuses_weights_and_replicates_and_skips_components(tmp_path):
    """Planted: a header that knows no section behind `stokes`, as that of 0.4."""
    text = (include_dir() / "aomc_sky.h").read_text()
    assert text.count(OLD[0]) == 1
    (tmp_path / "aomc_sky.h").write_text(text.replace(*OLD))
    (tmp_path / "use.c").write_text(LOADED)
    run(["gcc", "-I.", "-o", "use", "use.c", "-lm"], tmp_path)
    several = source_of("table", 500, replicates=2)
    for name, source in (("biased", biased("table", 500)), ("several", several), ("plain", source_of("table", 500))):
        sky.write_source(source, tmp_path / f"{name}.sky")
    for name in ("biased", "several"):
        assert "newer layout" in run(["./use", f"{name}.sky"], tmp_path)
    assert run(["./use", "plain.sky"], tmp_path) == "500 photons, component -1, weight 1"


def directory_without(data, name):
    """The file with a directory of the first band that does not lead to a section."""
    at, _, _ = entry(data, name)
    begin, n = np.frombuffer(data, "<u8", 2, RECORDS + 40).tolist()
    rest = data[at + 24 : begin + 24 * n]
    changed = data[:at] + rest + data[at + len(rest) :]
    return with_bytes(changed, RECORDS + 48, word(n - 1))


def test_older_files_have_no_components_and_no_light_of_a_photon():
    driver = built()
    absolute = sky.Scene(wavebands=[500.0], n_photons=700, components=sky.UniformSky(irradiance_W_m2_nm=1.4))
    for source, light in ((absolute.source(seed=1), 1.4 / 700), (source_of("table", 500), 1.0)):
        new = source.to_bytes()
        old = directory_without(with_bytes(new, RECORDS + 8 * 31, word(0)), "components")
        for data, component in ((new, 0), (old, -1)):
            driver.open(data)
            assert driver.photon_light == pytest.approx(light, rel=1e-15)
            first = np.array([0])
            weight = driver.weights(np.array([-0.5], source.dtype), first)
            assert (weight.item(), driver.components(first).item()) == (1.0, component)


@pytest.fixture(scope="module")
def data():
    return biased("lobes and all", 5000).to_bytes()


DAMAGES = [
    ("weight", 0, (-1.0, -1e-38, np.nan, np.inf, -np.inf), "TABLE"),
    ("weight", -1, (-2.0, np.nan, np.inf), "TABLE"),
    ("components", 0, (0, -1, 10**9), "TABLE"),
    ("components", 1, (0, 1, -(2**31)), "TABLE"),
    ("components", -1, (10**6, 2**31 - 1, 1), "TABLE"),
]


def damaged(data, name, index, value):
    """The sealed bytes with another number in a section."""
    _, offset, count = entry(data, name)
    dtype = "<i4" if name == "components" else "<f4"
    return with_bytes(data, offset + 4 * (index % count), np.array(value, dtype).tobytes())


def words_that_are_damaged(data):
    """Sealed damages of every new word, and the codes that they have."""
    for name, index, values, code in DAMAGES:
        yield from ((damaged(data, name, index, value), code) for value in values)
    for value in (-1.0, np.nan, np.inf, -np.inf):
        yield with_bytes(data, RECORDS + 8 * 31, word(float(value))), "TABLE"
    for name in ("weight", "components"):
        at, offset, count = entry(data, name)
        counts = (count + 10**9, 2**63, 0) if name == "components" else (count - 1, count + 1, 2**63, 0)
        for place, new in ((8, (len(data) // 64 * 64, 2**63, offset + 8)), (16, counts)):
            yield from ((with_bytes(data, at + place, word(value)), "DIRECTORY") for value in new)
        kind, width = section_names().index(name) + 1, 8  # of another width
        yield with_bytes(data, at, word(kind | width << 32)), "DIRECTORY"
    at, _, _ = entry(data, "components")
    yield with_bytes(data, at + 16, word(1)), "TABLE"  # the end of the first is not the last cell
    at, _, _ = entry(data, "weight")
    yield with_bytes(data, at, word(section_names().index("components") + 1 | 4 << 32)), "DIRECTORY"  # twice


def test_damages_have_codes(data):
    assert code_of(data) == "ok"
    assert code_of(damaged(data, "weight", 3, 3e38)) == "ok"
    assert code_of(damaged(data, "weight", 3, 0.0)) == "ok"
    for number, (changed, code) in enumerate(words_that_are_damaged(data)):
        assert code_of(changed) == code, number


def test_damages_under_sanitizers(data, tmp_path):
    all_damages = [*words_that_are_damaged(data), (damaged(data, "weight", 3, 0.25), "ok"), (data, "ok")]
    said = read_under_sanitizers([changed for changed, _ in all_damages], tmp_path)
    assert [code_said(line) for line in said] == [code for _, code in all_damages]


def light_of_first(data, source):
    """Share of the light of the first component, by the weights that the header gives."""
    driver = built()
    assert driver.view(data) == 0
    assert driver.weighted_band(0) == 0
    _, patch, weight = columns(driver, source, 0, driver.n)
    component = driver.components(np.arange(source.plan.n_cells))
    return float(weight[component[patch] == 0].sum(dtype=float)) / driver.n


def test_weights_give_the_light_and_planted_ones_do_not(monkeypatch):
    """Planted: 1 / w for w, and photons shared out by mass for those by launch."""
    parts = *disc(40), table(sky.component.Law.CELL_MU2, 6, 9)
    source = sky.Scene(wavebands=WAVEBANDS, n_photons=20_000, components=parts).source(seed=2, bias={"direct": 0.2})
    light = float(source.mass(0)[0])
    assert light == pytest.approx(0.5)
    assert light_of_first(source.to_bytes(), source) == pytest.approx(light, abs=1e-3)
    unbiased = sky.Scene(wavebands=WAVEBANDS, n_photons=20_000, components=parts).source(seed=2).plan
    by_mass = Emitter(dataclasses.replace(source.plan, cumulative=unbiased.cumulative))
    assert abs(light_of_first(source_bytes(by_mass), source) - light) > 0.1
    monkeypatch.setattr(sky.Plan, "weight", lambda plan, band: plan.bias[plan.row_of(band)])
    assert abs(light_of_first(source.to_bytes(), source) - light) > 0.1


def test_the_light_of_a_photon_sums_to_that_of_the_band():
    day = {"sun_zenith_deg": 40.0, "dni": 850.0, "dhi": 95.0, "spectrum": "spectrl2"}
    pytest.importorskip("pvlib")
    source = sky.weather_scene(wavebands=[443, 555], n_photons=5000, **day).source(seed=1, bias={"direct": 0.2})
    driver = built()
    assert driver.view(source.to_bytes()) == 0
    for band in (0, 1):
        assert driver.weighted_band(band) == 0
        irradiance = sum(source.irradiance(band).values())
        assert driver.photon_light == pytest.approx(irradiance / source.n_photons(band), rel=1e-15)
        _, _, weight = columns(driver, source, 0, driver.n)
        assert driver.photon_light * weight.sum(dtype=float) == pytest.approx(irradiance, rel=1e-3)


PROGRAM = """program shares
    use, intrinsic :: iso_fortran_env, only: int32, int64, {real}, real64
    use aomc_sky
    implicit none
    type(aomc_sky_file) :: file
    type(aomc_sky_source) :: source
    type(aomc_sky_photon{suffix}) :: photon
    real({real}), dimension(1000) :: ux, uy, uz, weight, before, again
    integer(int32) :: patch(1000), component
    integer(int64) :: start = 0, n, k
    real(real64) :: light(0:1) = 0
    integer :: code
    code = aomc_sky_load("day.sky" // achar(0), file)
    if (code /= 0) error stop aomc_sky_text(int(code, int64))
    print "(a)", aomc_sky_text(int(aomc_sky_band(file, 0, source), int64))
    code = aomc_sky_weighted_band(file, 0, source)
    if (code /= 0) error stop aomc_sky_text(int(code, int64))
    weight = 7
    do
        before = weight
        n = aomc_sky_fill_weighted{suffix}(source, start, 1000_int64, ux, uy, uz, patch, weight)
        if (n <= 0) exit
        do k = 1, n
            component = aomc_sky_component(source, patch(k))
            light(component) = light(component) + weight(k)
            photon = aomc_sky_at{suffix}(source, start + k - 1)
            if (weight(k) /= real(aomc_sky_weight{suffix}(source, photon), {real})) error stop "another weight"
        end do
        if (aomc_sky_fill_weighted{suffix}(source, start, n, ux, uy, uz, weight=again) /= n) error stop "no photons"
        if (any(again(:n) /= weight(:n))) error stop "another column"
        if (any(weight(n + 1:) /= before(n + 1:))) error stop "numbers behind the last photon were changed"
        start = start + n
    end do
    print "(3es24.16)", light / source%n, source%photon_light
end program
"""


@needs("gfortran")
@pytest.mark.parametrize(("precision", "real", "suffix"), [("float32", "real32", ""), ("float64", "real64", "_double")])
def test_fortran(precision, real, suffix, tmp_path):
    source = biased("disc and table", 2500, precision=precision)
    sky.write_source(source, tmp_path / "day.sky")
    text = PROGRAM.format(real=real, suffix=suffix)
    (tmp_path / "shares.f90").write_text(text)
    run(["gfortran", "-o", "shares", "shares.f90", *fortran_flags()], tmp_path)
    message, numbers = run(["./shares"], tmp_path).strip().split("\n")
    assert "aomc_sky_weighted_band" in message
    batch = source.photons(0)
    component = source.component_of(batch.patch)
    light = [batch.weight[component == k].sum(dtype=float) / len(batch) for k in (0, 1)]
    assert np.allclose(np.array(numbers.split(), float), [*light, 1.0], rtol=1e-12)


def test_a_biased_run_writes_exports_and_verifies_its_source(tmp_path, told):
    scene = str(INPUTS / "perez_sky" / "amc.inp")
    words = ["run", scene, "--iterations", "2000", "--bias", "direct=0.2", "--format", "source"]
    assert main([*words, "--out", str(tmp_path / "day"), "-q"]) == 0
    source = sky.PhotonSource(sky.Plan.load(tmp_path / "day" / "plan.npz"))
    assert (tmp_path / "day" / "source.sky").read_bytes() == source.to_bytes()
    compare_weighted(built(), source)
    assert main(["verify", str(tmp_path / "day"), "-q"]) == 0
    target = tmp_path / "copy.sky"
    assert main(["export", str(tmp_path / "day"), "--to", "source", "--out", str(target)]) == 0
    assert target.read_bytes() == source.to_bytes()
    assert "has weights: yes" in told("info", target).out
    assert json.loads(told("info", target, "--json").out)["has_weights"] is True
    target.write_bytes(source_of("table", 100).to_bytes())
    assert "has weights: no" in told("info", target).out


@needs("nvcc")
def test_the_compiler_of_a_gpu_takes_the_new_functions(tmp_path):
    (tmp_path / "use.cu").write_text(
        '#include "aomc_sky.h"\n'
        "__global__ void one(aomc_sky_source s, double *out) { aomc_sky_photon p = aomc_sky_at(&s, 0);\n"
        "out[0] = aomc_sky_weight(&s, p); out[1] = aomc_sky_component(&s, p.patch) * s.photon_light; }\n"
        "int main() { aomc_sky_file f; aomc_sky_source s; return aomc_sky_weighted_band_at(&f, 0, NULL, &s) == 0; }\n"
    )
    run(["nvcc", "-fmad=false", f"-I{include_dir()}", "-ptx", "-o", "use.ptx", "use.cu"], tmp_path)
    assert ".entry" in (tmp_path / "use.ptx").read_text()
