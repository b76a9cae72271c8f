"""The first words of every stream, for ever, the first photons of small scenes, and counts of small tables.

streams.json has the words of the generators and never changes. photons.json has counts, photons and their numbers: a
change there is a change for equal input, which raises the minor version and is announced under *Streams* in the
changelog. Other directions change `STREAM_VERSION`, too, and other numbers the switches of a source file's record.
`python -m tests.golden.test_streams` writes photons.json anew.
"""

import json
from pathlib import Path

import numba
import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.kernels.cells import order
from aomc_sky.plan import streams
from aomc_sky.plan.allocation import allocate
from tests.support.backend import photons_by
from tests.support.sampled import table_of

WORDS = Path(__file__).with_name("streams.json")
PHOTONS = Path(__file__).with_name("photons.json")
SEEDS = (0, 1, 2**64 - 1)
STREAMS = (streams.ALLOCATION, streams.ORDER, streams.SHIFT, streams.PLACEMENT, streams.POSITION)
METHODS = (None, "stratified", "iid")


def hexadecimal(rows):
    return [[hex(int(word)) for word in row] for row in rows]


def small_scene():
    table = table_of([[1.0, 2.0, 3.0, 4.0], [0.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0]])
    beam = sky.DirectBeam(sun_zenith_deg=30, sun_azimuth_deg=45)
    components = (*table.lower([500.0]), *beam.lower([500.0]))
    return sky.Scene(wavebands=[500.0], n_photons=1000, components=components, footprint=sky.Footprint.circle(2.0))


def small_photons(seed, **options):
    source = small_scene().source(seed=seed, precision="float64", **options)
    batch = source.photons(0, 0, 4)
    rows = np.column_stack([batch.ux, batch.uy, batch.uz, batch.x, batch.y])
    return {
        "counts": source.counts[0].tolist(),
        "patch": batch.patch.tolist(),
        "words": hexadecimal(np.ascontiguousarray(rows).view(np.uint64)),
    }


def narrow_photons(precision):
    """Words of photons of cells that take the short series of sine and cosine."""
    scene = sky.Scene(wavebands=[500.0], n_photons=1000, components=table_of(np.ones((3, 180))))
    batch = scene.source(seed=1, precision=precision).photons(0, 0, 4)
    return hexadecimal(batch.directions.view(np.uint32 if precision == "float32" else np.uint64))


def number_words(seed, components, n):
    """Words of the numbers of the first four photons: of the net, or of the lattice of many photons of one cell."""
    scene = sky.Scene(wavebands=[500.0], n_photons=n, components=components)
    batch = scene.source(seed=seed, precision="float64").photons(0, 0, 4, numbers=3)
    return hexadecimal(np.ascontiguousarray(batch.numbers).view(np.uint64))


def golden_words():
    def pair(seed, name, method):
        return [hex(word) for word in streams.philox_pair(streams.stream_key(seed, name, method), 5, 1, 2)]

    named = [(f"{method or 'any'} {name}", name, method) for method in METHODS for name in STREAMS]
    words = {str(seed): {key: pair(seed, *of) for key, *of in named} for seed in SEEDS}
    keys = np.array([0x01234567, 0x89ABCDEF, 0x55555555], dtype=np.uint64)
    orders = {str(n): order.ranks_of_photons(0, 6, n, keys).tolist() for n in (6, 1000, 2**32, 2**32 + 1, 2**62)}
    return {"words": words, "orders": orders}


def golden_photons():
    ways = [(seed, {"placement": placement}) for seed in SEEDS for placement in ("r2", "philox")]
    ways += [(seed, {"method": "iid"}) for seed in SEEDS]
    photons = {f"{seed} {next(iter(way.values()))}": small_photons(seed, **way) for seed, way in ways}
    narrow = {precision: narrow_photons(precision) for precision in ("float32", "float64")}
    kinds = {"net": (table_of(np.ones((3, 4))), 1000), "lattice": ("uniform", 20_000)}
    numbers = {f"{seed} {name}": number_words(seed, *kind) for seed in SEEDS for name, kind in kinds.items()}
    return {"version": streams.STREAM_VERSION, "photons": photons, "narrow": narrow, "numbers": numbers}


SLOW = () if numba.config.DISABLE_JIT else pytest.mark.slow


@pytest.fixture(scope="module", params=[False, pytest.param(True, marks=SLOW)], ids=["numpy", "kernels"])
def computed(request):
    """By numpy, to which kernels are equal to the bit; and by kernels, where they are Python or when slow."""
    with photons_by(kernels=request.param):
        return golden_words() | golden_photons()


def test_keys_differ_by_seed_method_and_name():
    seeds = (*range(200), 2**64 - 1)
    keys = {streams.stream_key(seed, name, method) for seed in seeds for method in METHODS for name in STREAMS}
    assert len(keys) == len(seeds) * len(METHODS) * len(STREAMS)


@pytest.mark.parametrize("part", ["words", "orders"])
def test_streams_never_change(part, computed):
    assert computed[part] == json.loads(WORDS.read_text())[part]


@pytest.mark.parametrize("part", ["version", "photons", "narrow", "numbers"])
def test_photons_change_with_the_version_of_the_streams_alone(part, computed):
    assert computed[part] == json.loads(PHOTONS.read_text())[part]


MASS = [0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0, 34.0, 55.0]

COUNTS = json.loads(Path(__file__).with_name("counts.json").read_text())


@pytest.mark.parametrize(("method", "seed", "n", "counts"), COUNTS, ids=lambda value: str(value)[:20])
def test_counts(method, seed, n, counts):
    assert allocate(MASS, n, method=method, seed=seed).tolist() == counts


if __name__ == "__main__":
    with photons_by(kernels=False):
        PHOTONS.write_text(json.dumps(golden_photons(), indent=1) + "\n")
