"""Kernels are compiled with the slices that a plan needs: variants keep apart; the next process finds their code."""

import numba
import pytest

from tests.support.processes import with_numba
from tests.support.shared import INPUTS

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")

PHOTONS = """
import sys, warnings
import numpy as np
import aomc_sky as sky
from aomc_sky.kernels.backend import announce_photons
warnings.simplefilter("ignore")
announce_photons(10**9)  # compiled kernels and not their plain twins
inputs, *scenes = sys.argv[1:]
for scene in scenes:
    source = sky.read_scene(f"{inputs}/{scene}", iterations=4000).source(5)
    batch = source.photons()
    source.numba_sampler().fill
    names = [name for name in ("ux", "uy", "uz", "patch", "x", "y") if getattr(batch, name) is not None]
    plain = {name: np.empty_like(getattr(batch, name)) for name in names}
    source._emitter.fill_plain(0, 0, plain)
    equal = all(np.array_equal(getattr(batch, name), values) for name, values in plain.items())
    print(scene, equal, *sorted(name for name in ("lobes", "perez") if f"aomc_sky.skies.{name}" in sys.modules))
"""
SAID = ["overcast True", "perez_sky True perez", "night_sky True lobes perez"]


def said(*scenes, **variables):
    """For each scene whether its photons are right, and the slices that are loaded by then."""
    return with_numba(PHOTONS, INPUTS, *scenes, **variables).splitlines()


def test_a_variant_with_a_queue_after_the_others():
    pytest.importorskip("h5py")
    assert said("overcast", "perez_sky", "night_sky") == SAID


@pytest.mark.slow
def test_the_next_process_finds_the_code_of_every_variant(tmp_path):
    pytest.importorskip("h5py")

    def kept():
        return {path.name: path.read_bytes() for path in tmp_path.rglob("*.nbc")}

    assert said("overcast", "perez_sky", "night_sky", NUMBA_CACHE_DIR=str(tmp_path)) == SAID
    first = kept()
    texts = {name.split("-")[0] for name in first}
    variants = ("", "_perez", "_lobes")
    assert texts >= {f"{text}{hooks}" for text in ("emit.emit", "sampler._next") for hooks in variants}
    last = said("night_sky", "perez_sky", "overcast", NUMBA_CACHE_DIR=str(tmp_path))[-1]
    assert last == "overcast True lobes perez"
    assert kept() == first
