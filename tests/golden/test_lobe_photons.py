"""The first photons of lobes, for ever; their envelopes are written by hand, so that no library's sine enters."""

import numpy as np

from aomc_sky.component import Component, Law
from tests.support.sampled import scene

ROOT = np.sqrt(0.5)
TILTED = [ROOT, 0.0, ROOT, 0.0, 1.0, 0.0, ROOT, 0.0, ROOT]  # axis at 45 degrees; its last row is (k, 0, n_z)
HALVES = [[0.0, 0.5, 0.0, 2.0, 0.5, s, c, 1.0] for s, c in ((-ROOT, ROOT), (ROOT, ROOT), (ROOT, -ROOT), (-ROOT, -ROOT))]


def lobe(law, asymmetry=0.0, stretch=(1.0, 1.0)):
    matrix = np.array(TILTED).reshape(3, 3) * [*stretch, 1.0]
    return Component(
        name=law.name,
        law=law,
        strength=np.ones(1),
        mass=np.ones((1, 1)),
        cell=np.array([[0.5, 0.0, 2.0, 0.0, 0.0, 1.0]]),
        shared=np.array([*matrix.ravel(), asymmetry]),
        bounds=np.array(HALVES),
    )


LOBES = (lobe(Law.HG, 0.75), lobe(Law.GGX, stretch=(0.25, 0.5)), lobe(Law.BECKMANN, stretch=(0.5, 0.25)))

WORDS = {
    "philox": {
        "patch": [1, 2, 2, 0, 0, 0],
        "words": [
            ["0xbfe60c45db9c52a1", "0xbfccc84a494615ed", "0xbfe60c45db9c52a1"],
            ["0xbfe6853f288c887a", "0xbfb8db84fc1754f5", "0xbfe6853f288c887a"],
            ["0xbfe62b7420b173db", "0xbfc99d36e5a0e902", "0xbfe62b7420b173db"],
            ["0xbfe5c5c67f4ada9f", "0xbfd16ce7df50dbde", "0xbfe5c5c67f4ada9f"],
            ["0xbfe6a04d23f3a244", "0x3f857093ba08c718", "0xbfe6a04d23f3a244"],
            ["0xbfe6910d5aad349e", "0x3fb2c15641ab8d74", "0xbfe6910d5aad349e"],
        ],
    },
    "r2": {
        "patch": [1, 2, 2, 0, 0, 0],
        "words": [
            ["0xbfe61eb7cf08ca72", "0xbfcaf4910739da93", "0xbfe61eb7cf08ca72"],
            ["0xbfe64e60314a0897", "0x3fc57e1e420eec30", "0xbfe64e60314a0897"],
            ["0xbfe69b67116c7486", "0xbfa5b925937d3ca0", "0xbfe69b67116c7486"],
            ["0xbfe47ea296f2f172", "0x3fdb1feb595c605b", "0xbfe47ea296f2f172"],
            ["0xbfe40bc37b032521", "0xbfddafb3ca7cacad", "0xbfe40bc37b032521"],
            ["0xbfe682430fe3d6d9", "0x3fba2ca14d670fe8", "0xbfe682430fe3d6d9"],
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
