"""The two forms of the MCPL packing give the same bits."""

from __future__ import annotations

import numpy as np
import pytest

from aomc_sky.formats.mcpl.header import McplHeader
from aomc_sky.kernels.batches import compiled, plain


@pytest.mark.parametrize("n", [0, 1, 4095, 4097])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_plain_numpy_packs_as_the_kernel_does(dtype, n):
    generator = np.random.default_rng(n)
    vectors = np.round(generator.normal(size=(3, n)), 1)  # many ties and zeros
    vectors[:, generator.random(n) < 0.2] *= -1e-38
    ux, uy, uz = vectors.astype(dtype)
    cell = generator.integers(0, 2**21, n).astype(np.int32)
    record = McplHeader(
        n_particles=n, has_user_flags=True, is_double=dtype is np.float64, pdg_code=22, weight=1.0
    ).record
    packed = []
    for pack in (compiled.pack, plain.pack):
        out = np.zeros(n, record)
        fields = [out["packed"][:, k] for k in range(3)]
        pack(ux, uy, uz, cell, dtype(2.5e-6), np.uint32(7 << 20), np.int32(2**20), *fields, out["user_flags"])
        packed.append(out.tobytes())
    assert packed[0] == packed[1]
    assert n == 0 or any(packed[0])
