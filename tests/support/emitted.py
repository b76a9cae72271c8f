"""Photons of a source by its kernels and by their plain twins."""

import numpy as np


def empty(source, n):
    kinds = {"ux": source.dtype, "uy": source.dtype, "uz": source.dtype, "patch": np.int32}
    return {name: np.empty(n, kind) for name, kind in kinds.items()}


def both(source, start, stop, band=0):
    """Directions and patches of photons of a waveband: compiled, plain."""
    compiled, plain = empty(source, stop - start), empty(source, stop - start)
    source._emitter.fill_compiled(band, start, compiled)
    source._emitter.fill_plain(band, start, plain)
    return compiled, plain
