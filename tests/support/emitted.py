"""Photons of a source by its kernels and by their plain twins."""

import numpy as np


def empty(source, n):
    kinds = {"ux": source.dtype, "uy": source.dtype, "uz": source.dtype, "patch": np.int32}
    return {name: np.empty(n, kind) for name, kind in kinds.items()}


def compared(source, start, stop, band=0):
    """The photons of a waveband by the kernels, which are those of plain numpy to the bit: unit vectors from above."""
    compiled, plain = empty(source, stop - start), empty(source, stop - start)
    source._emitter.fill_compiled(band, start, compiled)
    source._emitter.fill_plain(band, start, plain)
    for name, values in compiled.items():
        np.testing.assert_array_equal(values, plain[name], err_msg=name)
    length = np.sqrt(sum(compiled[name].astype(np.float64) ** 2 for name in ("ux", "uy", "uz")))
    assert np.max(np.abs(length - 1)) < (3e-7 if source.dtype == np.float32 else 6e-16)
    assert np.all(compiled["uz"] <= 0)
    return compiled
