"""The first photons of lobes, for ever; their envelopes are written by hand, so that no library's sine enters."""

import numpy as np

from aomc_sky.component import Component, Law
from tests.support.sampled import scene

ROOT = np.sqrt(0.5)
TILTED = [-ROOT, 0.0, ROOT, 0.0, -1.0, 0.0, ROOT, 0.0, ROOT]  # axis at 45 degrees; its last row is (k, 0, n_z)
HALVES = [[0.0, 0.5, 0.0, 2.0, 0.5, s, c, 1.0] for s, c in ((-ROOT, ROOT), (ROOT, ROOT), (ROOT, -ROOT), (-ROOT, -ROOT))]


def lobe(law, asymmetry=0.0, stretch=(1.0, 1.0)):
    matrix = np.array(TILTED).reshape(3, 3) * [*stretch, 1.0]
    cell, shared = np.array([[0.5, 0.0, 2.0, 0.0, 0.0, 1.0]]), np.array([*matrix.ravel(), asymmetry])
    one = {"name": law.name, "law": law, "strength": np.ones(1), "mass": np.ones((1, 1))}
    return Component(**one, cell=cell, shared=shared, bounds=np.array(HALVES))


LOBES = (lobe(Law.HG, 0.75), lobe(Law.GGX, stretch=(0.25, 0.5)), lobe(Law.BECKMANN, stretch=(0.5, 0.25)))

WORDS = {
    "philox": {
        "patch": [2, 2, 1, 2, 0, 2],
        "words": [
            ["0xbfe4ece918e695ba", "0x3fce0ce0989bc986", "0xbfe703d32e10e95f"],
            ["0xbfd28428f72f5089", "0xbfaf98d1de0d92f9", "0xbfee9157f722a33b"],
            ["0xbfe77b067f7dc72a", "0x3fd073ccbf5ea210", "0xbfe41fdb37517659"],
            ["0xbfe1006d38dc91d7", "0xbfbef1a203aa2e84", "0xbfead51d7664e248"],
            ["0xbfe035102dab5258", "0x3f96316d0a4bf8a2", "0xbfeb9558be151727"],
            ["0xbfe136991aecb463", "0xbfbfbd82cd14f4df", "0xbfeaaebfc69c304d"],
        ],
    },
    "r2": {
        "patch": [2, 2, 1, 2, 0, 2],
        "words": [
            ["0xbfe654cc9d886e48", "0xbfc3ab1e6854dd8c", "0xbfe662d7690b75d3"],
            ["0xbfced39727a5c8fb", "0xbfa826fd6bf6d371", "0xbfef057c81e2e0e4"],
            ["0xbfe3d59c6a42ac69", "0xbfe46e377d0124c2", "0xbfdd33b5fc7d1897"],
            ["0xbfea326d213fba1e", "0xbfc487bec09725e0", "0xbfe1a554ceb275c6"],
            ["0xbfe3c4306cc62888", "0xbf922b94736c5a08", "0xbfe928ab4fed825c"],
            ["0xbfe75442ade5e95c", "0x3fc5f2ef86fa038e", "0xbfe5346a4a66896f"],
        ],
    },
}


def first_photons(**options):
    """Patches and words of the first photons, from the plain form; the compiled one has the same bits."""
    source = scene(LOBES, 300).source(seed=1, precision="float64", **options)
    found = {name: np.empty(6, np.int32 if name == "patch" else np.float64) for name in ("ux", "uy", "uz", "patch")}
    source._emitter.fill_plain(0, 0, found)
    words = np.column_stack([found[name].view(np.uint64) for name in ("ux", "uy", "uz")])
    return {"patch": found["patch"].tolist(), "words": [[hex(int(w)) for w in row] for row in words]}


def test_first_photons():
    for placement, wanted in WORDS.items():
        assert first_photons(placement=placement) == wanted
