"""The transport example against quadrature, exact laws, doubling and published values."""

import re

import fresnel
import mpmath
import numba
import numpy as np
import philox
import pytest
import run_slab
import transport
from tally import ABSORBED, BOTTOM, LEAVING, MAX_PHOTONS, ONE_PHOTON, REFLECTED
from water import water_layer

import aomc_sky as sky
from tests.kernels.arithmetic.test_rng import KNOWN
from tests.reference import layer
from tests.support.shared import INPUTS, REPOSITORY

INDEX = 1.34
KEY = philox.transport_key(1)
SIGMAS = 5.0

N = 200_000


def sampler(model, **options):
    scene = sky.Scene(wavebands=[500.0], n_photons=N, components=model)
    return scene.source(1, precision="float64").numba_sampler(0, **options).sample


@pytest.fixture(scope="module")
def diffuse():
    return sampler(sky.UniformSky())


@pytest.fixture(scope="module")
def slanting():
    return sampler(sky.DirectBeam(sun_zenith_deg=40.0))


def turbid(optical_depth, albedo, **more):
    scattering, absorption = albedo * optical_depth, (1 - albedo) * optical_depth
    return water_layer(depth_m=1, absorption_per_m=absorption, scattering_per_m=scattering, **more)


def absorbing(optical_depth, index=INDEX):
    return turbid(optical_depth, 0.0, refractive_index=index)


def shares(part, n):
    return np.asarray(part) / (float(n) * ONE_PHOTON)


def deviations(part, expected, n):
    """Differences over standard deviations; a mean of numbers in [0, 1] spreads by p (1 - p) / n at most."""
    p = np.asarray(expected, dtype=np.float64)
    return np.abs(shares(part, n) - p) / np.sqrt(p * (1 - p) / n)


def light(photons, n):
    """Assert that every part of every photon has one end."""
    assert int(photons.fate.sum()) == n * ONE_PHOTON


def exact_transmission():
    """Transmitted share of a uniform sky's irradiance, to 1e-12."""

    def integrand(mu):
        air = mpmath.acos(mu)
        water = mpmath.asin(mpmath.sin(air) / INDEX)
        across = mpmath.sin(air - water) / mpmath.sin(air + water)
        along = mpmath.tan(air - water) / mpmath.tan(air + water)
        return 2 * mu * (1 - (across**2 + along**2) / 2)

    value, error = mpmath.quad(integrand, [0, 0.1, 0.5, 1], error=True)
    assert error < 1e-12
    return float(value)


class TestSurface:
    BAR = 3e-6
    """What six replicates of N photons say of their mean, at most."""

    def test_transmitted_irradiance_of_a_uniform_sky(self, diffuse):
        """Two millionths wide; defects lie far outside. Every sampler compiles the loop anew, so there are two."""
        truth = exact_transmission()
        assert truth == pytest.approx(0.9324893878, abs=1e-10)
        assert abs(self.transmitted(diffuse, INDEX) - truth) < 4 * self.BAR
        for defect in ((diffuse, INDEX - 0.001), (sampler(sky.UniformSky(per_solid_angle=True)), INDEX)):
            assert abs(self.transmitted(*defect) - truth) > 20 * self.BAR

    def transmitted(self, sample, index):
        tally = transport.simulate(sample, N, absorbing(1.0, index), KEY, [0.0])
        assert tally.down[0] == tally.refracted.sum() == N * ONE_PHOTON - tally.fate[REFLECTED]
        return float(shares(tally.down[0], N))

    def test_refracted_directions(self, diffuse):
        """A uniform sky fills the columns evenly, the rows by what the surface lets through."""
        tally = transport.simulate(diffuse, N, absorbing(1.0), KEY, [])
        table = shares(tally.refracted, N)
        cells = np.full(table.shape, 1 / table.size)
        edges = np.sqrt(np.linspace(0, 1, table.shape[0] + 1))
        nodes, weights = np.polynomial.legendre.leggauss(40)
        for row in range(table.shape[0]):
            low, high = edges[row], edges[row + 1]
            mu = low + (high - low) * (nodes + 1) / 2
            through = 1 - layer.fresnel(mu, INDEX)
            cells[row] = (high - low) * np.sum(weights * mu * through) / table.shape[1]
        assert np.max(np.abs(table - cells) / np.sqrt(cells / N)) < 1.0  # stratified: well below chance
        assert np.max(np.abs(table[::-1] - cells) / np.sqrt(cells / N)) > SIGMAS


class TestNumbers:
    """A first free path, angle and azimuth that go with the photon: the same light, known better."""

    DEPTHS = (0.5, 1.0)

    def shares(self, water, numbers):
        sample = sampler(sky.DirectBeam(sun_zenith_deg=40.0), numbers=numbers)
        tally = transport.simulate(sample, N, water, KEY, self.DEPTHS, numbers=numbers)
        light(tally, N)
        return np.array([tally.down, tally.up])

    def test_a_beam_in_absorbing_water(self):
        """Its free path decides all: far closer to T exp(-tau / mu) than chance, which is one deviation."""
        mu = fresnel.refracted_mu(np.cos(np.deg2rad(40)), INDEX)
        truth = (1 - layer.fresnel(np.cos(np.deg2rad(40)), INDEX)) * np.exp(-np.array(self.DEPTHS) / mu)
        assert np.max(deviations(self.shares(absorbing(1.5), 1)[0], truth, N)) < 0.05

    @pytest.mark.slow
    def test_the_same_light_in_turbid_water(self, slanting):
        water = turbid(1.5, 0.6, asymmetry=0.5)
        chance = transport.simulate(slanting, N, water, KEY, self.DEPTHS)
        by_chance = shares([chance.down, chance.up], N)
        assert np.max(deviations(self.shares(water, 3), by_chance, N)) < SIGMAS * np.sqrt(2)


class TestAbsorption:
    DEPTHS = (0.0, 0.1, 0.5, 1.0, 2.0)

    def test_beam(self, slanting):
        """Beer and Lambert along the refracted path; along the unrefracted one it would be seen."""
        tally = transport.simulate(slanting, N, absorbing(2.0), KEY, self.DEPTHS)
        air = np.cos(np.deg2rad(40))
        through = 1 - layer.fresnel(np.array(air), INDEX)
        path = 1 / np.sqrt(1 - (np.sin(np.deg2rad(40)) / INDEX) ** 2)
        assert shares(tally.down[0], N) == pytest.approx(through, abs=1e-9)
        assert np.all(deviations(tally.down[1:], through * np.exp(-np.multiply(self.DEPTHS[1:], path)), N) < SIGMAS)
        assert np.any(deviations(tally.down[1:], through * np.exp(-np.divide(self.DEPTHS[1:], air)), N) > SIGMAS)
        assert tally.fate[BOTTOM] == tally.down[-1]
        assert not tally.up.any()
        light(tally, N)


class TestRandomNumbers:
    @pytest.mark.parametrize(("counter", "key", "words"), KNOWN)
    def test_known_answers(self, counter, key, words):
        key = np.uint64(key[0] | key[1] << 32)
        assert tuple(int(w) for w in philox.philox4x32(*map(np.uint64, counter), key)) == words


class TestScattering:
    def test_published_layer(self):
        """Van de Hulst's layer, R = 0.09739 and T = 0.66096 (Wang, Jacques and Zheng 1995), and ours."""
        vertical = sampler(sky.DirectBeam(sun_zenith_deg=0.0))
        tally = transport.simulate(vertical, N, turbid(2.0, 0.9, asymmetry=0.75, refractive_index=1.0), KEY, [])
        exact = layer.at_normal_incidence(layer.nodes(24), 2.0, 0.9, 0.75 ** np.arange(48))
        assert exact == pytest.approx((0.09739, 0.66096), abs=6e-6)
        assert np.all(deviations(tally.fate[[LEAVING, BOTTOM]], exact, N) < SIGMAS)
        light(tally, N)
        isotropic = transport.simulate(vertical, N, turbid(2.0, 0.9, asymmetry=0.0, refractive_index=1.0), KEY, [])
        assert np.all(deviations(isotropic.fate[[LEAVING, BOTTOM]], exact, N) > SIGMAS)

    @pytest.mark.parametrize(
        ("rayleigh_share", "moments"),
        [(0.0, 0.924 ** np.arange(96)), (1.0, np.array([1, 0, 0.1])), (0.5, None)],
        ids=["Henyey-Greenstein", "Rayleigh", "both"],
    )
    def test_uniform_sky_over_a_bright_bottom(self, diffuse, rayleigh_share, moments):
        """Surface from both sides, multiple scattering and the bottom together, against doubling."""
        if moments is None:
            moments = 0.5 * 0.924 ** np.arange(96)
            moments[:3] += 0.5 * np.array([1, 0, 0.1])
        water = turbid(2.0, 0.75, rayleigh_share=rayleigh_share, bottom_reflectance=0.3)
        exact = layer.under_uniform_sky(layer.nodes(32, INDEX), 2.0, 0.75, moments, 0.3)
        tally = transport.simulate(diffuse, N, water, KEY, [2.0])
        at_bottom = exact.to_bottom * (1 - 0.3)
        absorbed = 1 - exact.reflected - exact.leaving - at_bottom
        fates = [exact.reflected, exact.leaving, absorbed, at_bottom]
        assert np.all(deviations(tally.fate, fates, N) < SIGMAS)
        light(tally, N)
        mirror = turbid(2.0, 0.75, rayleigh_share=rayleigh_share, bottom_reflectance=0.33)
        assert np.any(deviations(transport.simulate(diffuse, N, mirror, KEY, []).fate, fates, N) > SIGMAS)

    def test_nothing_is_lost_without_absorption(self, diffuse):
        """All light leaves again, to the last part of a photon; net irradiance is 0 at every depth."""
        n = 20_000
        water = turbid(3.0, 1.0, asymmetry=0.5, bottom_reflectance=1.0)
        tally = transport.simulate(diffuse, n, water, KEY, [0.5, 1.5, 3.0])
        light(tally, n)
        assert tally.fate[ABSORBED] == tally.fate[BOTTOM] == 0
        np.testing.assert_array_equal(tally.down, tally.up)

    def test_depths_balance(self, diffuse):
        """Net irradiance at the surface minus that at the bottom is what the water absorbs."""
        tally = transport.simulate(diffuse, 20_000, turbid(2.0, 0.8, bottom_reflectance=0.2), KEY, [0.0, 1.0, 2.0])
        net = tally.down - tally.up
        assert net[0] - net[-1] == tally.fate[ABSORBED]
        assert net[-1] == tally.fate[BOTTOM]
        entered = ONE_PHOTON * 20_000 - tally.fate[REFLECTED]
        assert net[0] == entered - tally.fate[LEAVING]
        assert net[0] > net[1] > net[2]


class TestSimulate:
    def test_threads_and_chunks_change_nothing(self, diffuse, monkeypatch):
        water = turbid(2.0, 0.9)
        whole = transport.simulate(diffuse, 5_500, water, KEY, [1.0], n_threads=1)
        monkeypatch.setattr(transport, "CHUNK", 1_000)
        for n_threads in (1, 2, 3):
            again = transport.simulate(diffuse, 5_500, water, KEY, [1.0], n_threads=n_threads)
            for one, other in zip(whole, again, strict=True):
                np.testing.assert_array_equal(one, other)
        other_key = transport.simulate(diffuse, 5_500, water, philox.transport_key(2), [1.0])
        assert other_key.fate[ABSORBED] != whole.fate[ABSORBED]

    def test_horizontal_light_stays_outside(self):
        @numba.njit
        def grazing(i):
            return 1.0, 0.0, -0.0

        tally = transport.simulate(grazing, 3, turbid(2.0, 0.9), KEY, [0.0])
        assert tally.fate[REFLECTED] == 3 * ONE_PHOTON

    def test_bad_depths_and_too_many_photons(self, diffuse):
        depths = [(1, at, "ascend") for at in ([1.0, 0.5], [-0.1], [2.1], [float("nan")])]
        for n, at, words in (*depths, (MAX_PHOTONS + 1, [], "replicates")):
            with pytest.raises(sky.UsageError, match=words):
                transport.simulate(diffuse, n, turbid(2.0, 0.9), KEY, at)


class TestCommand:
    ARGUMENTS = (str(INPUTS / "clear_day/amc.inp"), "--photons", "20000", "--replicates", "2", "--depth", "5")

    def test_table(self, capsys):
        assert run_slab.main([*self.ARGUMENTS, "--levels", "3"]) == 0
        lines = capsys.readouterr().out.splitlines()
        shares_printed = [float(line.split()[-2]) for line in lines[1:5]]
        assert sum(shares_printed) == pytest.approx(1, abs=3e-6)
        assert [float(line.split()[0]) for line in lines[-3:]] == [0.0, 2.5, 5.0]
        net = [float(line.split()[1]) - float(line.split()[3]) for line in lines[-3:]]
        assert net[0] - net[2] == pytest.approx(shares_printed[2], abs=3e-6)

    def test_bad_numbers(self, capsys):
        for words in ("--depth 0", "--absorption nan", "--bottom 1.5", "--asymmetry 1", "--waveband 9"):
            assert run_slab.main([*self.ARGUMENTS, *words.split()]) == 2
            assert words[2:].split()[0] in capsys.readouterr().err

    def test_the_last_level_is_the_bottom(self):
        """Rounding must not put it below, for any depth."""
        for k in range(1, 400):
            water = water_layer(depth_m=k / 7, absorption_per_m=0.05, scattering_per_m=0.15)
            assert run_slab.optical_depths_of(np.linspace(0, k / 7, 6), water)[-1] == water.optical_depth


PAGE = (REPOSITORY / "docs" / "transport_example.md").read_text()


def block_of(start):
    """The fenced block of the page whose text begins so."""
    return next(text for text in re.findall(r"^```\w*\n(.*?)^```$", PAGE, re.M | re.S) if text.startswith(start))


class TestPage:
    def test_ten_lines(self, capsys, monkeypatch):
        """They run as they stand, and print the mean cosine of the sky."""
        monkeypatch.chdir(REPOSITORY)
        exec(compile(block_of("import numba"), "page", "exec"), {})
        source = sky.read_scene(INPUTS / "clear_day", iterations=100_000).source(1)
        assert float(capsys.readouterr().out) == pytest.approx(source.exact_moments(0).mean_mu, abs=1e-4)

    @pytest.mark.slow
    def test_shown_run(self, capsys, monkeypatch):
        """The page shows what the command prints; a logarithm's last bit may turn a photon or two."""
        monkeypatch.chdir(REPOSITORY)
        command, _, shown = block_of("$ python examples/slab/run_slab.py").partition("\n")
        assert run_slab.main(command.split()[3:]) == 0
        pattern = r"\d+\.\d+(?:e-\d+)?"
        printed = re.findall(pattern, capsys.readouterr().out)
        np.testing.assert_allclose(np.float64(printed), np.float64(re.findall(pattern, shown)), atol=2e-5)
