"""Owen scrambling: every node of the tree flips a coin of its own; points and photons over seeds; the error it buys."""

import numpy as np
import pytest
from scipy.special import gammainc, gammaincc

import aomc_sky as sky
from aomc_sky.kernels import plain_sobol
from aomc_sky.sampling import streams
from aomc_sky.source.sobol_table import _node_keys
from tests.support import chi2
from tests.support.perez_cases import CASES, cell_counts, cell_shares
from tests.support.sampled import (
    azimuth_place,
    cell_component,
    even,
    scene,
    sky_angles,
    square_counts,
    uneven_sky,
    zenith_place_mu2,
)

KEYS = 40_000
SEEDS = 1500
FEW = 1000
LEVELS = 7


@pytest.fixture(scope="module")
def keys():
    """Scrambling keys of many draws, uint32 (2, 8, 2, KEYS); those of real seeds are tested below."""
    return np.random.default_rng(20).integers(0, 2**32, (2, 8, 2, KEYS), dtype=np.uint32)


def owen(x, keys):
    """One number, scrambled by many keys (8, 2, n)."""
    return plain_sobol.scramble(np.full(keys.shape[-1], x, np.uint32), keys)


def digital_shift(x, keys):
    """The same flips in the whole of a level: what is no Owen scrambling."""
    return np.uint32(x) ^ keys[0, 0]


def laine_karras(x, keys):
    """The hash that is common in rendering, in the reversed bits; nested, with few random bits."""
    word = plain_sobol.plain_points(np.full(keys.shape[-1], x, np.uint32))[0]
    seed = keys[0, 0]
    word = word + seed
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        word = word ^ (word * np.uint32(factor))
    return plain_sobol.plain_points(word)[0]


def one_key(x, keys):
    """Our hash with one key for all groups, added once: nodes of equal number share their flips."""
    return plain_sobol.scramble(np.full(keys.shape[-1], x, np.uint32), np.broadcast_to(keys[:1, :1], (8, 2, KEYS)))


def flips(scramble, keys, first, levels):
    """+1 or -1 for each node of some levels below the number `first`, for each key: (2^levels - 1, n)."""
    rows = []
    depth, top = first
    for level in range(levels):
        for node in range(2**level):
            x = np.uint32(top | node << (32 - depth - level) if depth + level else 0)
            rows.append((scramble(x, keys) >> np.uint32(31 - depth - level)) & np.uint32(1))
    return 1.0 - 2.0 * np.array(rows, dtype=np.float32)


def coin_p(coins):
    """p-values that coins are fair, and that any two of them are independent: sums of squared correlations."""
    n_coins, n = coins.shape
    mean = coins.sum(axis=1, dtype=np.float64)
    products = (coins @ coins.T).astype(np.float64)
    pairs = products[np.triu_indices(n_coins, 1)]
    return [tail_p(np.sum(values**2) / n, values.size) for values in (mean, pairs)]


def tail_p(statistic, degrees):
    return chi2.two_sided(gammainc(degrees / 2, statistic / 2), gammaincc(degrees / 2, statistic / 2))


PLACES = {"root": (0, 0), "second group": (4, 0x90000000), "across groups": (2, 0x40000000), "deep": (20, 0x12345000)}


@pytest.mark.parametrize("place", PLACES)
def test_every_node_flips_a_coin_of_its_own(plan, keys, place):
    """127 nodes of seven levels, in the first coordinate: fair, and independent in pairs."""
    for p in coin_p(flips(owen, keys[0], PLACES[place], LEVELS)):
        plan.check(p)


def test_coordinates_flip_coins_of_their_own(plan, keys):
    both = np.concatenate([flips(owen, k, PLACES["root"], 5) for k in keys])
    plan.check(coin_p(both)[1])


def test_triples_of_nodes(plan, keys):
    """A node and its two children: the product of the three coins, which pairs do not see."""
    coins = flips(owen, keys[0], PLACES["root"], LEVELS)
    products = np.array([coins[i] * coins[2 * i + 1] * coins[2 * i + 2] for i in range(2 ** (LEVELS - 1) - 1)])
    plan.check(coin_p(products)[0])
    plan.check(coin_p(products)[1])


@pytest.mark.parametrize("defect", [digital_shift, laine_karras, one_key])
def test_planted_scramblings(plan_only, keys, defect):
    worst = 1.0
    for place in ("root", "second group", "across groups"):
        coins = flips(defect, keys[0], PLACES[place], LEVELS)
        worst = min(worst, *coin_p(coins))
    if defect is one_key:  # nodes of equal number in different groups
        root, child = (flips(defect, keys[0], p, 1) for p in ((0, 0), (4, 0)))
        worst = min(worst, coin_p(np.concatenate([root, child]))[1])
    plan_only.catches(worst)


def mean_spread_p(scramble, keys, n):
    """p-value of the squared errors of the mean of x over n points: Owen's variance is n^-3 / 12 exactly."""
    x = plain_sobol.plain_points(np.arange(n, dtype=np.uint32))[0]
    means = np.mean([(scramble(one, keys) + 0.5) / 2.0**32 for one in x], axis=0)
    return tail_p(np.sum((means - 0.5) ** 2) * 12.0 * n**3, means.size)


def test_the_error_is_what_theory_says(plan, keys):
    plan.check(mean_spread_p(owen, keys[0], 64))
    plan.catches(mean_spread_p(digital_shift, keys[0], 64))


def point_words(index, seeds, component=0):
    """Scrambled points of a component over seeds, with the keys of a run: two arrays (n_seed, n_index)."""
    plain = plain_sobol.plain_points(np.asarray(index, dtype=np.uint32))
    found = [[], []]
    for seed in range(seeds):
        node_keys = _node_keys(streams.stream_key(seed, streams.SCRAMBLE), component, 0)
        for d in (0, 1):
            found[d].append(plain_sobol.scramble(plain[d], node_keys[d]))
    return [np.array(part) for part in found]


@pytest.fixture(scope="module")
def points():
    return point_words([0, 1, 6, 1_000_003], SEEDS)


def test_one_point_over_seeds_is_uniform(plan, points):
    for j in range(4):
        x, y = (part[:, j] / 2.0**32 for part in points)
        plan.check(chi2.ks_p(x))
        plan.check(chi2.chi2_p(square_counts(x, y, 8).ravel(), even(SEEDS, 64)))
    plan.catches(chi2.ks_p(np.full(SEEDS, 0.3)))


def test_two_points_over_seeds_part_where_they_should(plan, points):
    """Points 0 and 1 lie in different halves; below that their digits are independent."""
    x = points[0]
    assert np.all((x[:, 0] ^ x[:, 1]) >> np.uint32(31) == 1)
    first, second = ((x[:, j] << np.uint32(1)) / 2.0**32 for j in (0, 1))
    plan.check(chi2.chi2_p(square_counts(first, second, 8).ravel(), even(SEEDS, 64)))
    keys = np.random.default_rng(3).integers(0, 2**32, (8, 2, SEEDS), dtype=np.uint32)
    a, b = ((digital_shift(x, keys) << np.uint32(1)) / 2.0**32 for x in (0, 1 << 31))
    plan.catches(chi2.chi2_p(square_counts(a, b, 8).ravel(), even(SEEDS, 64)))


def test_over_seeds_each_photon_is_uniform(plan):
    """Photon 37 of many runs: its patch follows the masses, and it is uniform in the patch."""
    table = uneven_sky(2, 3)
    found = [
        scene(table.lower([500]), 60).source(seed=seed, method="sobol", precision="float64").photons(0, 37, 38)
        for seed in range(FEW)
    ]
    patch = np.array([int(batch.patch[0]) for batch in found])
    _, sin2, azimuth = (np.concatenate(parts) for parts in zip(*map(sky_angles, found), strict=True))
    ring, column = np.divmod(patch, 3)
    s, t = np.where(ring == 0, sin2 / 0.5, (sin2 - 0.5) / 0.5), azimuth / 120 - column
    plan.check(chi2.ks_p(s))
    plan.check(chi2.ks_p(t))
    mass = table.mass(0) / table.mass(0).sum()
    plan.check(chi2.chi2_p(np.bincount(patch, minlength=6), mass * FEW))
    plan.catches(chi2.chi2_p(np.bincount(patch, minlength=6), even(FEW, 6)))
    plan.catches(chi2.ks_p(1 - np.sqrt(1 - s)))  # uniform in mu instead of mu^2


def test_one_cell_is_filled_evenly():
    """Far below chance, and a planted per cent shows."""
    dome = ((0.0, 90.0), (0.0, 360.0))
    batch = scene(cell_component(sky.Law.CELL_MU2, *dome), 2**20).source(seed=6, method="sobol", precision="float64")
    mu, sin2, azimuth = sky_angles(batch.photons())
    s, t = zenith_place_mu2(mu, sin2, dome[0]), azimuth_place(azimuth, dome[1])
    assert chi2.per_degree(square_counts(s, t).ravel(), even(2**20, 256)) < 1e-3
    off = s + 0.01 / (2 * np.pi * 4) * np.sin(2 * np.pi * 4 * s)
    assert chi2.per_degree(square_counts(off, t).ravel(), even(2**20, 256)) > 0.1
    independent = np.random.default_rng(1).random((2, 2**20))
    assert chi2.per_degree(square_counts(*independent).ravel(), even(2**20, 256)) > 0.1


def perez_counts(case, within, n):
    """Photons of a Perez sky in cells of an eighth of a patch; the sun at 25 degrees of azimuth."""
    model = sky.PerezSky(
        sun_zenith_rad=float(np.deg2rad(case.sun_zenith_deg)),
        sun_azimuth_rad=float(np.deg2rad(25)),
        epsilon=case.epsilon,
        delta=case.delta,
        grid=sky.PatchGrid.regular(9, 36),
        within=within,
    )
    batch = scene((model,), n).source(seed=6, method="sobol", precision="float64").photons()
    mu, sin2, azimuth = sky_angles(batch)
    return cell_counts(mu, sin2, np.deg2rad(azimuth - 25))


@pytest.mark.parametrize("name", CASES)
def test_the_perez_sky_inside_patches(plan, name):
    """The exact law in cells finer than patches: not farther than chance, and clearly nearer where they are large."""
    case, n = CASES[name], 1 << 21
    counts, expected = perez_counts(case, "exact", n), cell_shares(case.law) * n
    plan.check(upper_p(counts, expected))
    large = expected >= 1000
    assert chi2.per_degree(counts[large], expected[large]) < 0.5


def test_planted_constant_patches(plan_only):
    case, n = CASES["narrow aureole"], 1 << 21
    plan_only.catches(upper_p(perez_counts(case, "uniform", n), cell_shares(case.law) * n))


def upper_p(counts, expected):
    """Upper tail alone: photons that fill cells better than chance are no defect."""
    observed, wanted = chi2.pool(counts, expected)
    return float(gammaincc((observed.size - 1) / 2, chi2.chi2_statistic(observed, wanted) / 2))


def planar_error(seeds, n, method):
    """Relative RMSE of the mean of mu on a clear sky of constant patches, and that of independent photons."""
    model = sky.PerezSky(sun_zenith_rad=np.deg2rad(40), sun_azimuth_rad=0.3, epsilon=6.8, delta=0.1, within="uniform")
    clear = scene(model.lower([500]), n)
    errors = []
    for seed in range(seeds):
        source = clear.source(seed=seed, method=method, precision="float64")
        mu = np.concatenate([-batch.uz for batch in source.batches()])
        errors.append(mu.mean() - source.exact_moments(0).mean_mu)
    return np.sqrt(np.mean(np.square(errors))), mu.std() / np.sqrt(n)


@pytest.mark.slow
def test_planar_error_of_a_million_photons():
    """At most 1/2000 of the error of independent photons (measured: 1/600 000); the default would fail."""
    error, independent = planar_error(64, 2**20, "sobol")
    assert error < independent / 2000
    default, _ = planar_error(4, 2**20, "stratified")
    assert default > independent / 2000


def test_planar_error_falls_as_a_scrambled_net():
    """N^-3/2: from 2^10 to 2^14 photons by a factor near 64, where independent photons gain 4."""
    few, independent = planar_error(24, 2**10, "sobol")
    many, _ = planar_error(24, 2**14, "sobol")
    assert few / many > 24
    assert few < independent / 15
