"""Photons of a source by its kernels and by their plain twins."""

from __future__ import annotations

import numpy as np

import aomc_sky as sky

Columns = dict[str, np.ndarray]


def empty(source: sky.PhotonSource, n: int) -> Columns:
    kinds = {"ux": source.dtype, "uy": source.dtype, "uz": source.dtype, "patch": np.int32}
    return {name: np.empty(n, kind) for name, kind in kinds.items()}


def both(source: sky.PhotonSource, start: int, stop: int) -> tuple[Columns, Columns]:
    """Directions and patches of photons of the first waveband: compiled, plain."""
    compiled, plain = empty(source, stop - start), empty(source, stop - start)
    source._emitter.fill_compiled(0, start, compiled)
    source._emitter.fill_plain(0, start, plain)
    return compiled, plain
