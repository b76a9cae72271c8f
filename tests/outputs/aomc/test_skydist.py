"""The sky for the AOMC program: read back by the program's rules, it launches our counts and no others."""

import dataclasses
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aomc_sky import DirectBeam, PatchGrid, PerezSky, Scene, Weighting, read_scene
from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.errors import AllocationError, SceneError
from aomc_sky.formats.aomc.amc import LightSource, read_amc
from aomc_sky.outputs.aomc import skydist
from aomc_sky.outputs.aomc.skydist import MOST_PHOTONS, aomc_sky, exact_radiances, write_aomc_folder
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.plan.allocation import allocate
from aomc_sky.skies.tabulated import TabulatedSky, aomc_weight
from tests.support.fortran import GFORTRAN, compile_reader, needs_gfortran
from tests.support.shared import DATA, INPUTS, csv_rows


def launched(program, folder, shape):
    """Photons of (waveband, zenith index - 1, azimuth index) that the program launches in `folder`."""
    config = read_amc(folder / "amc.inp")
    assert config.light_source is LightSource.FILE
    lines = (folder / "lambbot.inp").read_text().splitlines()[1:]
    wavelengths = [line.split()[0] for line in lines[: config.n_wavebands]]
    job = f"{folder / 'skydist.inp'}\n{config.iterations} {len(wavelengths)}\n{' '.join(wavelengths)}\n"
    done = subprocess.run([program], input=job, capture_output=True, text=True, timeout=120, check=True)
    counts = np.zeros(shape, dtype=np.int64)
    rows = np.loadtxt(done.stdout.splitlines(), dtype=np.int64, ndmin=2)
    if rows.size:
        counts[rows[:, 0] - 1, rows[:, 1] - 1, rows[:, 2]] = rows[:, 3]
    return counts


WAVELENGTHS = np.array([412.5, 440.0, 550.0, 675.3])


def four_skies():
    """A steep one with a sun, an overcast one, one of scattered patches, one spike; (4, 89 x 360)."""
    z, a = np.deg2rad(np.arange(1.0, 90.0))[:, None], np.deg2rad(np.arange(360.0))[None, :]
    from_sun = np.arccos(np.clip(np.cos(z) * np.cos(0.7) + np.sin(z) * np.sin(0.7) * np.cos(a - 1.0), -1, 1))
    clear = 0.2 + 30 * np.exp(-from_sun / 0.05) + 0 * a
    overcast = (1 + 2 * np.cos(z)) / 3 + 0 * a
    rng = np.random.default_rng(3)
    scattered = np.where(rng.random((89, 360)) < 0.01, rng.lognormal(0, 3, (89, 360)), 0.0)
    spike = np.zeros((89, 360))
    spike[[0, 40, 88], [0, 123, 359]] = 1.0, 5.0, 2.0
    return np.stack([clear, overcast, scattered, spike]).reshape(4, -1)


ONE = np.array([500.0])


def degree_source(values, n, wavelengths, seed=1):
    sky = TabulatedSky(
        wavelength_nm=wavelengths, values=values, grid=PatchGrid.whole_degrees(), weighting=Weighting.PROJECTED
    )
    return Scene(wavebands=wavelengths, n_photons=n, components=sky).source(seed)


def scene_folder(folder, wavelengths):
    folder.mkdir()
    text = (INPUTS / "overcast" / "amc.inp").read_text().splitlines()
    text[29] = f"{text[29][:48]}{wavelengths.size}"
    (folder / "amc.inp").write_text("\n".join([*text, "a remark of the user", ""]))
    rows = "".join(f"{float(w)!r} 0.0 0.4\n" for w in wavelengths)
    (folder / "lambbot.inp").write_text(f"{wavelengths.size}\n{rows}")
    (folder / "abs.inp").write_text("water\n")
    return folder / "amc.inp"


def exported(sky, folder, wavelengths):
    amc_inp = scene_folder(folder / "scene", wavelengths)
    target = RunFolder(folder / "for_aomc")
    target.path.mkdir()
    names = write_aomc_folder(sky, target, amc_inp)
    assert sorted(names) == sorted(p.name for p in target.path.iterdir())
    assert set(names) == {"skydist.inp", "amc.inp", "lambbot.inp", "abs.inp", "counts.csv"}
    assert np.array_equal(counts_in(target.path, sky.counts.shape), sky.counts)
    return target.path


def counts_in(folder, shape):
    counts = np.zeros(shape, dtype=np.int64)
    for row in csv_rows(folder / "counts.csv"):
        band, zenith, azimuth = (int(row[name]) for name in ("waveband", "zenith_index", "azimuth_index"))
        counts[band - 1, zenith - 1, azimuth] = int(row["photons"])
    return counts


def read_back(folder):
    source = read_scene(folder, compat="aomc").source()
    return source.counts.reshape(source.n_bands, source.grid.n_zenith, source.grid.n_azimuth)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return compile_reader("aomc_launch", tmp_path_factory.mktemp("program"))


@pytest.mark.parametrize("n", [1_000, 100_000, 10_000_000, 16_000_000])
def test_four_skies_in_one_file_launch_our_counts(tmp_path, request, n):
    """Read back here, and by the program's rules in Fortran where there is a compiler."""
    order = [2, 0, 3, 1]  # wavebands need not ascend
    wavelengths = WAVELENGTHS[order]
    source = degree_source(four_skies()[order], n, wavelengths, seed=9)
    sky = aomc_sky(source)
    assert (sky.notes, sky.iterations) == ((), n)
    assert np.array_equal(sky.counts.reshape(4, -1), source.counts)
    folder = exported(sky, tmp_path, wavelengths)
    assert np.array_equal(read_back(folder), sky.counts)
    first = (folder / "amc.inp").read_text().splitlines()
    assert (first[0][48:60], first[-1]) == (f"{n:<12}", "a remark of the user")
    if GFORTRAN:
        assert np.array_equal(launched(request.getfixturevalue("program"), folder, sky.counts.shape), sky.counts)


@needs_gfortran
def test_a_photon_in_the_wrong_patch_would_be_seen(tmp_path, program):
    sky = aomc_sky(degree_source(four_skies()[:1], 1_000_000, WAVELENGTHS[:1]))
    folder = exported(sky, tmp_path, WAVELENGTHS[:1])
    lines = (folder / "skydist.inp").read_text().splitlines()
    wave, zenith, azimuth, value = lines[2000].split()
    lines[2000] = f"{wave} {zenith} {azimuth} {float(value) * 1.2!r}"
    (folder / "skydist.inp").write_text("\n".join(lines))
    assert not np.array_equal(launched(program, folder, sky.counts.shape), sky.counts)
    assert not np.array_equal(read_back(folder), sky.counts)


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 2**32 - 1), st.integers(1, 200_000), st.integers(1, 4))
def test_random_skies_and_wavelengths(tmp_path_factory, seed, n, n_bands):
    rng = np.random.default_rng(seed)
    wavelengths = rng.permutation(np.unique(rng.uniform(350, 800, n_bands).round(rng.integers(0, 6))))
    values = np.where(rng.random((wavelengths.size, 89 * 360)) < 0.02, rng.lognormal(0, 2, 89 * 360), 0.0)
    values[:, rng.integers(89 * 360)] = 1.0
    source = degree_source(values, n, wavelengths, seed)
    sky = aomc_sky(source)
    assert np.array_equal(sky.counts.reshape(wavelengths.size, -1), source.counts)
    assert np.array_equal(read_back(exported(sky, tmp_path_factory.mktemp("sky"), wavelengths)), sky.counts)


def test_only_some_wavebands_leave_the_others_dark(tmp_path):
    source = degree_source(four_skies(), np.array([500, 100, 500, 700]), WAVELENGTHS)
    sky = aomc_sky(source, [0, 2])
    assert sky.counts.sum(axis=(1, 2)).tolist() == [500, 0, 500, 0]
    folder = exported(sky, tmp_path, WAVELENGTHS)
    with pytest.warns(UserWarning, match="all weights are zero"):
        assert np.array_equal(read_back(folder), sky.counts)


@needs_gfortran
def test_different_totals_are_planned_anew_with_one(tmp_path, program):
    """amc.inp knows one number: each waveband gets the largest, exactly as a run of so many would have it."""
    n = np.array([500_000, 100_000, 250_000, 0])
    source = degree_source(four_skies(), n, WAVELENGTHS, seed=5)
    sky = aomc_sky(source)
    same = degree_source(four_skies(), np.array([500_000, 500_000, 500_000, 0]), WAVELENGTHS, seed=5)
    assert np.array_equal(sky.counts.reshape(4, -1), same.counts)
    assert sky.iterations == 500_000
    assert "100000 to 500000 photons" in sky.notes[0]
    folder = exported(sky, tmp_path, WAVELENGTHS)
    assert np.array_equal(launched(program, folder, sky.counts.shape), sky.counts)


def test_another_grid_is_shared_out_anew():
    sky = PerezSky(sun_zenith_rad=0.6, sun_azimuth_rad=1.0, epsilon=4.0, delta=0.15, grid=PatchGrid.regular(30, 60))
    scene = Scene(wavebands=[500.0], n_photons=200_000, components=(sky,))
    result = aomc_sky(scene.source(4))
    assert "distributed again" in result.notes[0]
    expected = 200_000 * sky.patch_mass(PatchGrid.whole_degrees())
    assert int(result.counts.sum()) == 200_000
    assert np.abs(result.counts.ravel() - expected).max() < 1.0


def refused(source, words):
    with pytest.raises(SceneError, match=words):
        aomc_sky(source)


def test_what_the_format_cannot_carry_is_refused():
    skies = four_skies()
    refused(degree_source(skies[3:], 16_000_001, ONE), "16000001 photons.*--iterations 16000000")
    refused(degree_source(skies[3:], 0, ONE), "no waveband")
    twice = degree_source(skies[[0, 0]], 1000, np.array([500.0, 500.0]))
    assert np.array_equal(twice.mass(0), twice.mass(1))  # a table has one sky for a wavelength
    refused(twice, "waveband 2 at 500 nm has the wavelength of another one.*--waveband 2")
    close = np.array([500.0, np.nextafter(np.float32(500), np.float32(501))], dtype=np.float64)
    refused(degree_source(skies[:2], 1000, close), "at least 0.001 nm apart")


def test_of_two_wavebands_of_one_wavelength_one_is_exported(tmp_path):
    """Of two wavebands of one wavelength one is exported; the other launches the same."""
    twice = degree_source(four_skies()[[0, 0]], 1000, np.array([500.0, 500.0]))
    sky = aomc_sky(twice, [1])
    assert np.array_equal(sky.counts[1].ravel(), twice.counts[1])
    assert np.array_equal(sky.counts[0], sky.counts[1])
    assert np.array_equal(read_back(exported(sky, tmp_path, np.array([500.0, 500.0]))), sky.counts)
    sky = aomc_sky(degree_source(np.tile(np.eye(1, 89 * 360, 40 * 360), (2, 1)), 77, np.array([500.0, 500.0])))
    assert sky.table.wavelength_nm.tolist() == [500.0]
    assert sky.counts[:, 40, 0].tolist() == [77, 77]


def test_all_reasons_at_once():
    beam = DirectBeam(sun_zenith_deg=40.4, sun_azimuth_deg=120.6, strength=0.5)
    (disc,) = DirectBeam(sun_zenith_deg=50, radius_deg=0.2665, strength=0.5).lower(ONE)
    both = (beam, dataclasses.replace(disc, name="disc"))
    source = Scene(wavebands=ONE, n_photons=20_000_001, components=both).source(2)
    refused(source, "20000001 photons.*'direct'.*--sun-zenith 40 --sun-azimuth 121.*'disc'.*disc = false")


def beam_source(**beam):
    return Scene(wavebands=ONE, n_photons=1000, components=DirectBeam(**beam)).source()


def test_a_beam_from_a_whole_degree_is_carried():
    sky = aomc_sky(beam_source(sun_zenith_deg=40, sun_azimuth_deg=-30))
    assert sky.counts[0, 39, 330] == sky.counts.sum() == 1000


@pytest.mark.parametrize(
    ("zenith", "azimuth", "radius"), [(40.5, 0, 0), (40, 0.25, 0), (0, 0, 0), (40, 0, 0.2665), (89.9, 0, 0.2665)]
)
def test_other_beams_are_refused(zenith, azimuth, radius):
    beam = beam_source(sun_zenith_deg=zenith, sun_azimuth_deg=azimuth, radius_deg=radius)
    refused(beam, "'direct'.*1000 photons")


@pytest.mark.parametrize("law", [Law.CELL_MU2, Law.CELL_MU])
def test_light_moves_to_degrees_by_the_law_of_its_patch(law):
    """One patch from 10.25 to 40.75 degrees: each degree gets what the law has between its bounds."""
    grid = PatchGrid(zenith_bounds_deg=np.array([[10.25, 40.75]]), azimuth_bounds_deg=np.array([[350.0, 371.0]]))
    component = Component(
        name="sky", law=law, strength=np.ones(1), mass=np.ones((1, 1)), cell=cells_of_grid(grid, law), grid=grid
    )
    counts = aomc_sky(Scene(wavebands=[500.0], n_photons=10**6, components=(component,)).source()).counts[0]
    edges = np.deg2rad(np.clip(np.arange(0.5, 90), 10.25, 40.75))
    ring = -np.diff(np.cos(edges) ** (2 if law is Law.CELL_MU2 else 1))
    column = np.array([0.5, *[1.0] * 9, *[1.0] * 11, 0.5])
    azimuths = np.r_[350:360, 0:12]
    share = np.outer(ring / ring.sum(), column / column.sum())
    assert np.abs(counts[:, azimuths] - 10**6 * share).max() < 1.0
    assert counts[:, azimuths].sum() == counts.sum() == 10**6


def launches(radiance, n):
    return allocate(aomc_weight(radiance), n, method="aomc")


def assert_exact(counts):
    radiance = exact_radiances(counts)
    assert radiance.dtype == np.float32
    assert np.array_equal(radiance > 0, counts > 0)
    assert np.array_equal(launches(radiance, int(counts.sum())), counts)


@st.composite
def skies(draw):
    """Counts of a random sky: smooth, spiky, sparse or with a few patches that hold most of the photons."""
    n_azimuth = draw(st.sampled_from([1, 3, 24, 360]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    mass = rng.random((89, n_azimuth)) ** draw(st.sampled_from([0.0, 1.0, 20.0]))
    mass[rng.random(mass.shape) < draw(st.sampled_from([0.0, 0.5, 0.97]))] = 0.0
    for share in draw(st.lists(st.sampled_from([0.1, 0.3, 0.5, 1.0, 3.0]), max_size=3)):
        mass[rng.integers(89), rng.integers(n_azimuth)] = share * max(mass.sum(), 1.0)
    mass[rng.integers(89), rng.integers(n_azimuth)] += 1.0
    n = draw(st.one_of(st.sampled_from([1, 1000, 10**5, 10**7, MOST_PHOTONS]), st.integers(1, MOST_PHOTONS)))
    return rng.multinomial(n, (mass / mass.sum()).ravel()).reshape(mass.shape)


@given(skies())
def test_the_program_launches_exactly_these_counts(counts):
    assert_exact(counts)


def test_one_patch_of_most_photons_in_a_bright_sky_needs_more_than_the_first_guess():
    rng = np.random.default_rng(5)
    mass = 0.85 + 0.3 * rng.random((66, 178))
    mass[46, 77] = 3 * mass.sum()
    assert_exact(rng.multinomial(10**7, (mass / mass.sum()).ravel()).reshape(mass.shape))


def test_plain_float32_values_would_not_do():
    """The planted defect: counts divided by the weight of radiance 1, without a look at what comes out."""
    rng = np.random.default_rng(8)
    wrong = 0
    for _ in range(200):
        counts = np.zeros((89, 1), dtype=np.int64)
        counts[rng.integers(1, 88, 3), 0] = rng.integers(4_200_000, 5_300_000, 3)
        plain = (counts / aomc_weight(np.ones(counts.shape)).astype(np.float64)).astype(np.float32)
        wrong += not np.array_equal(launches(plain, int(counts.sum())), counts)
        assert_exact(counts)
    assert wrong > 20


def test_counts_that_cannot_be_had_are_an_error_and_never_silent(monkeypatch):
    with pytest.raises(AllocationError, match="16000001 photons in a band"):
        exact_radiances(np.array([[MOST_PHOTONS + 1], *[[0]] * 88]))
    monkeypatch.setattr(skydist, "allocate", lambda weight, n, method: np.zeros(weight.shape, np.int64))
    with pytest.raises(AllocationError, match="no 32-bit radiances"):
        exact_radiances(np.full((89, 1), 7))


COMPAT_CASES = [
    ("document_example", 999_999), ("repository_sky", 10), ("repository_sky", 1000), ("repository_sky", 100_000_007),
    ("steep_special_rings", 10_000_000), ("wavelength_order_shuffled", 1000),
]  # fmt: skip


@needs_gfortran
@pytest.mark.filterwarnings("ignore::aomc_sky.errors.InputWarning")
@pytest.mark.parametrize(("name", "iterations"), COMPAT_CASES)
def test_a_compat_run_is_exported_as_the_program_launches_it(tmp_path, program, name, iterations):
    """Drifting totals and all, beyond 2^24 too: the launch of the real program, photon for photon."""
    folder = DATA / "aomc" / name
    source = read_scene(folder, compat="aomc", iterations=iterations).source()
    sky = aomc_sky(source)
    assert sky.iterations == iterations
    rows = csv_rows(folder / "totals.csv")
    totals = [int(row["launched"]) for row in rows if int(row["iterations"]) == iterations]
    assert sky.counts.sum(axis=(1, 2)).tolist() == source.counts.sum(axis=1).tolist() == totals
    assert ("the program's own rounding" in "".join(sky.notes)) is any(n != iterations for n in totals)
    made = exported(sky, tmp_path, source.plan.wavelength_nm)
    assert np.array_equal(launched(program, made, sky.counts.shape), sky.counts)


def test_a_compat_run_that_launches_nothing(tmp_path):
    """A uniform sky of one degree at 10 000 iterations, of which the program rounds every patch to 0."""
    degrees = {"grid": PatchGrid.lattice(89, 360), "weighting": Weighting.AOMC, "midpoint_rule": True}
    sky = TabulatedSky(wavelength_nm=ONE, values=np.ones((1, 89 * 360)), **degrees)
    scene = Scene(wavebands=ONE, n_photons=10_000, components=sky)
    result = aomc_sky(scene.source(allocation="aomc", placement="centre", order="patch"))
    assert result.counts.sum() == 0
    assert result.iterations == 10_000
    assert not read_back(exported(result, tmp_path, ONE)).any()
