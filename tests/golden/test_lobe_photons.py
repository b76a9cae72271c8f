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
        "patch": [2, 2, 1, 2, 0, 2],
        "words": [
            ["0xbfe60c385ab8f0db", "0xbfccc99543211784", "0xbfe60c385ab8f0db"],
            ["0xbfe69d315a622e55", "0x3fa19b48431edb02", "0xbfe69d315a622e55"],
            ["0xbfe5bcd360e376f0", "0xbfd1c56a351659b7", "0xbfe5bcd360e376f0"],
            ["0xbfe682c2280fa562", "0x3fb9f5c14d6d1e11", "0xbfe682c2280fa562"],
            ["0xbfe69fb41705a43d", "0xbf9233e5228180de", "0xbfe69fb41705a43d"],
            ["0xbfe680dd0788c6c0", "0x3fbac4d454dfc341", "0xbfe680dd0788c6c0"],
        ],
    },
    "r2": {
        "patch": [2, 2, 1, 2, 0, 2],
        "words": [
            ["0xbfe65bfd73b854f6", "0x3fc3a519611bac37", "0xbfe65bfd73b854f6"],
            ["0xbfe67084aa2e80f1", "0xbfc0760af582cf31", "0xbfe67084aa2e80f1"],
            ["0xbfe015b7c1441b5d", "0x3fe681bdcea75ac3", "0xbfe015b7c1441b5d"],
            ["0xbfe629db0e4943dd", "0x3fc9c9515b39f409", "0xbfe629db0e4943dd"],
            ["0xbfe69fe198b1cfc4", "0x3f9057032453cfd2", "0xbfe69fe198b1cfc4"],
            ["0xbfe6420377811dc1", "0xbfc709fefdc1281a", "0xbfe6420377811dc1"],
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
