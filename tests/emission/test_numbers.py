"""Numbers that photons carry for their hosts: a function of the rank, the same bits in any range, order and host."""

import numba
import numpy as np
import pytest

from aomc_sky.emission.kernels import plain
from aomc_sky.emission.kernels.numbers import numbers_of_photons
from aomc_sky.emission.photons import number_columns
from aomc_sky.errors import UsageError
from aomc_sky.kernels.arithmetic.constants import NUMBER_STEPS
from aomc_sky.plan.streams import philox_pair
from tests.reference.net import of_net
from tests.support.host_scenes import SCENES, N, directions, source
from tests.support.source_files import same_bits, source_of

JIT = not numba.config.DISABLE_JIT
needs_jit = pytest.mark.skipif(not JIT, reason="hosts need the compiler")
# each pair of options; placement "centre" is the code of "r2" with steps of zero
WAYS = [
    ("shuffled", "r2", "float32"),
    ("patch", "r2", "float64"),
    ("shuffled", "philox", "float64"),
    ("patch", "philox", "float32"),
    ("shuffled", "centre", "float32"),
]


def options(way):
    return dict(zip(("order", "placement", "precision"), way, strict=True))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["table", "wide cells"])
def test_they_are_a_function_of_the_ranks(name, way):
    """Against whole numbers of Python; ranks by patch order, which the shuffled photons are matched to.

    A table's numbers are of the net, those of one cell go on with the lattice of its photons.
    """
    made = source(name, **options(way))
    key = [int(k) for k in made.plan.members()["keys"]]
    rank = np.arange(N)
    if way[0] == "shuffled":
        in_order = source(name, **{**options(way), "order": "patch"}).photons(1, numbers=3)
        batch = made.photons(1, numbers=3)
        rows = [np.column_stack([b.patch, b.directions, b.numbers]) for b in (in_order, batch)]
        assert np.array_equal(*(row[np.lexsort(row.T)] for row in rows))
        made = source(name, **{**options(way), "order": "patch"})
    bits = 24 if way[2] == "float32" else 53
    words = philox_pair(key[1], 0, 1, 3) + philox_pair(key[1], 0, 1, 4)
    numbers = made.photons(1, numbers=3).numbers
    for r in (*rank[:50].tolist(), N - 1):
        if way[1] == "philox":
            expected = philox_pair(key[3], r, 1, 1) + philox_pair(key[3], r, 1, 2)[:1]
        elif name == "table":
            expected = list(of_net(r, words))
        else:
            expected = [(w + r * int(s)) % 2**64 for w, s in zip(words, NUMBER_STEPS, strict=False)]
        assert numbers[r].tolist() == [(word >> (64 - bits)) / 2**bits for word in expected]


@pytest.mark.parametrize("way", WAYS)
def test_photons_are_the_same_for_any_number(way):
    name = "everything" if way[0] == "shuffled" else "narrow cells"
    made = source(name, **options(way))
    plain, most = made.photons(), made.photons(numbers=3)
    assert plain.numbers is None
    assert (most.numbers.shape, most.numbers.dtype) == ((N, 3), made.dtype)
    assert most.numbers.min() >= 0
    assert most.numbers.max() < 1
    for k in range(4):
        batch = made.photons(numbers=k)
        assert directions(batch).tobytes() == directions(plain).tobytes()
        assert np.array_equal(batch.patch, plain.patch)
        assert k == 0 or np.array_equal(batch.numbers, most.numbers[:, :k])


def test_the_first_ones_are_pinned():
    """Whoever changes them announces it under Streams, and gives the record of a source file another switch."""
    made = source("table", order="patch", precision="float64")
    assert made.photons(0, 0, 2, numbers=3).numbers.tolist() == [
        [0.4233876265561859, 0.09230103667799139, 0.47986513961215205],
        [0.7766633360050766, 0.5797541632768803, 0.5780017204403133],
    ]
    assert source("wide cells", order="patch", precision="float64").photons(0, 0, 2, numbers=3).numbers.tolist() == [
        [0.9360273168851968, 0.16986640314226653, 0.7690952537388718],
        [0.5744328381736712, 0.9001180978174738, 0.35566434287562265],
    ]
    batch = source("table").photons(1, numbers=2)
    columns = batch.to_dict()
    assert list(columns) == ["ux", "uy", "uz", "patch", "n1", "n2"]
    assert np.array_equal(columns["n2"], batch.numbers[:, 1])
    made = source("table", replicates=3)
    whole = made.photons(0, numbers=1).numbers[:, 0]
    cut = made.replicate_range(0, 1)[0]
    assert not np.isin(np.sort(whole[:cut])[:100], whole[cut:]).any()


@pytest.mark.parametrize(("way", "start"), list(zip(WAYS, (2**33 + 17, 0) * 3, strict=False)))
def test_plain_equals_compiled(way, start):
    made = source("table", 3 * 10**10 if start else N, **options(way))
    arguments = made._emitter.number_arguments(0)
    by_numpy, compiled = np.empty((2, 3, 5001 if JIT else 60), made.dtype)
    plain.numbers(start, by_numpy.T, *arguments)
    numbers_of_photons(np.uint64(start), *number_columns(compiled.T), *arguments)
    assert same_bits(by_numpy, compiled)


def test_wrong_arguments():
    made = source("table")
    for wrong in (-1, 4, True):
        for call in (made.photons, lambda numbers: next(made.batches(numbers=numbers))):
            with pytest.raises(UsageError, match="numbers must be a whole number from 0 to 3"):
                call(numbers=wrong)
    two = made.photons(0, 0, 10, numbers=2)
    for out in (made.photons(0, 0, 10), made.photons(0, 0, 10, numbers=3), made.photons(0, 0, 9, numbers=2)):
        with pytest.raises(ValueError, match="out"):
            made.photons(0, 0, 10, out=out, numbers=2)
    object.__setattr__(two, "numbers", np.ascontiguousarray(two.numbers))
    with pytest.raises(ValueError, match=r"out\.numbers must be a writable Fortran-ordered float32 array of 2 columns"):
        made.photons(0, 0, 10, out=two, numbers=2)
    assert [c.size for c in number_columns(made.photons(0, 0, 10, numbers=2).numbers)] == [10, 10, 0]


LOOPS = [("table", WAYS[3], 3, N), ("lobes", WAYS[0], 0, N)]
MORE_LOOPS = [
    ("sloped", WAYS[2], 0, N),
    *((name, way, 0, N) for name in SCENES for way in WAYS[:4]),
    ("table", WAYS[4], 0, N),
]
MORE_LOOPS += [("everything", WAYS[3], 3, N), ("everything", WAYS[1], 1, N), ("table", WAYS[0], 0, 3 * 10**12)]


@needs_jit
@pytest.mark.parametrize(
    ("name", "way", "k", "n"), [*LOOPS, *(pytest.param(*loop, marks=pytest.mark.slow) for loop in MORE_LOOPS)]
)
def test_inside_a_loop_of_numba(name, way, k, n):
    """One by one in any order, and many at once: the photons and numbers of the source to the bit."""
    made = source_of(name, [10, n], **options(way))
    sampler = made.numba_sampler(1, numbers=k)
    assert (sampler.n, sampler.band, sampler.precision) == (n, 1, made.dtype)
    sample, start = sampler.sample, 0 if n == N else 2**41 + 12345

    @numba.njit
    def loop(indices, out):
        for i in indices:
            photon = sample(start + i)
            for c in range(out.shape[0]):
                out[c, i] = photon[c]

    batch = made.photons(1, start, start + N, numbers=k)
    expected = np.vstack([directions(batch), *([batch.numbers.T] if k else [])])
    out, filled = np.zeros((2, 3 + k, N), made.dtype)
    loop(np.random.default_rng(1).permutation(N), out)
    assert out.tobytes() == expected.tobytes()
    assert sampler.fill(start, filled) == N
    assert filled.tobytes() == expected.tobytes()
    assert sampler.fill(n - 3, filled) == 3
    assert n > N or np.array_equal(filled[:, :3], expected[:, -3:])
    assert np.array_equal(filled[:, 3:], expected[:, 3:])
    with pytest.raises(ValueError, match=rf"\({3 + k}, n\)"):
        sampler.fill(0, np.empty((2, 10), made.dtype))
    with pytest.raises(IndexError):
        sample(n)
