"""Photons of a source by its kernels and by their plain twins."""

from __future__ import annotations

import numpy as np

import aomc_sky as sky

Columns = dict[str, np.ndarray]


def empty(source: sky.PhotonSource, n: int) -> Columns:
    kinds = {"ux": source.dtype, "uy": source.dtype, "uz": source.dtype, "patch": np.int32}
    return {name: np.empty(n, kind) for name, kind in kinds.items()}


def both(source: sky.PhotonSource, start: int, stop: int, band: int = 0) -> tuple[Columns, Columns]:
    """Directions and patches of photons of a waveband: compiled, plain."""
    compiled, plain = empty(source, stop - start), empty(source, stop - start)
    source._emitter.fill_compiled(band, start, compiled)
    source._emitter.fill_plain(band, start, plain)
    return compiled, plain
