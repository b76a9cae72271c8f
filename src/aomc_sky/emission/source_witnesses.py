"""Photons of a source that every compiler of ``aomc_sky.h`` must give: the witnesses of a band.

A compiler that contracts products and sums changes few photons of some laws. The witnesses are therefore chosen by the
way that they take: each law in each component, decided in trial 0, at once or by the luminance, in trial 1, and later.
Where a law works in float64 whatever the precision, they hold its numbers before they are rounded, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.component import Law
from aomc_sky.emission.band import StreamWords
from aomc_sky.emission.emitter import Emitter
from aomc_sky.kernels.arithmetic.elementary import unit
from aomc_sky.kernels.arithmetic.rng import later_words
from aomc_sky.kernels.cells.laws import discs_at_horizon, positions_in_cells
from aomc_sky.kernels.cells.order import SHORT_LIMIT, high_step, mix, ranks_of_photons, split_order

N_WITNESSES = 32
WITNESS_WORDS = 12
UNKNOWN = np.uint64(0x7FF8000000000000)
"""Says that a witness knows nothing of this number; it is that of a NaN."""

_MANY, _SOME = 4096, 512  # photons of a shuffled band, and of a component in patch order
_OTHER_KEY = np.uint64(1)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Candidates:
    """Photons among which witnesses are chosen."""

    index: np.ndarray
    rank: np.ndarray
    cell: np.ndarray
    direction: tuple[np.ndarray, ...]
    numbers: np.ndarray
    position: tuple[np.ndarray, ...]


def witnesses(emitter: Emitter, band: int) -> np.ndarray:
    """The witnesses of a band with photons, 12 words each: uint64, up to 32 x 12 of them.

    The words are index, patch, direction, three numbers, and three numbers inside: the direction of a lobe in float64,
    or the luminance of the Perez sky; then the bits of x and y, those of y turned by 32, in one word.
    """
    found = _candidates(emitter, band)
    way, inside = np.zeros(found.index.size, np.int64), np.full((found.index.size, 3), UNKNOWN)
    law, lobes = emitter.plan.law[found.cell], emitter._lobe_tables
    for is_own, ways in (
        (law == Law.DISC_AT_HORIZON, _horizon_ways),
        ((law == Law.PEREZ) & (emitter._perez_tables is not None), _perez_ways),
        (lobes is not None and lobes.lobe[found.cell] >= 0, _lobe_ways),
    ):
        own = np.flatnonzero(is_own)
        if own.size:
            way[own] = ways(emitter, band, found, own, inside)
    component = np.searchsorted(emitter.plan.component_start, found.cell, side="right")
    chosen = _spread(component * 4 + way)
    bits = np.uint32 if emitter.dtype.itemsize == 4 else np.uint64
    words = np.zeros((chosen.size, WITNESS_WORDS), np.uint64)
    words[:, 0], words[:, 1] = found.index[chosen], found.cell[chosen]
    for c in range(3):
        words[:, 2 + c] = found.direction[c].view(bits)[chosen]
        words[:, 5 + c] = np.ascontiguousarray(found.numbers[:, c]).view(bits)[chosen]
    words[:, 8:11] = inside[chosen]
    x, y = (column.view(bits)[chosen].astype(np.uint64) for column in found.position)
    words[:, 11] = x ^ (y << np.uint64(32) | y >> np.uint64(32))
    return words.ravel()


def _spread(way: np.ndarray) -> np.ndarray:
    """Up to 32 of the candidates, in turn one of each way."""
    turn = np.zeros(way.size, np.int64)
    for one in np.unique(way):
        turn[way == one] = np.arange(np.count_nonzero(way == one))
    return np.sort(np.lexsort((way, turn))[:N_WITNESSES])


def _candidates(emitter: Emitter, band: int) -> _Candidates:
    """Photons of every component with the bits of the emission: some thousand, and three of what is rare."""
    cumulative, start = emitter.plan.cumulative[band], emitter.plan.component_start
    n, order = emitter.n_photons(band), emitter._stream(band).order
    ends = list(zip(cumulative[start[:-1]].tolist(), cumulative[start[1:]].tolist(), strict=True))
    if order.size:
        ranges = [(0, min(n, _MANY))]
    else:
        begins = [(max(first, (first + end - _SOME) // 2), end) for first, end in ends if end > first]
        ranges = [(begin, min(begin + _SOME, end)) for begin, end in begins]
    batches = [_photons(emitter, band, *part) for part in ranges]
    seen = np.concatenate([batch.rank for batch in batches])
    for first, end in ends:
        if end > first and not np.any((seen >= first) & (seen < end)):
            for rank in sorted({first, (first + end) // 2, end - 1}):
                photon = _index_of_rank(rank, n, order[3:].tolist())
                batches.append(_photons(emitter, band, photon, photon + 1))
    parts = [[getattr(batch, name) for batch in batches] for name in ("index", "rank", "cell", "numbers")]
    index, rank, cell, numbers = (np.concatenate(part) for part in parts)
    direction = tuple(np.concatenate([batch.direction[c] for batch in batches]) for c in range(3))
    position = tuple(np.concatenate([batch.position[c] for batch in batches]) for c in range(2))
    return _Candidates(index=index, rank=rank, cell=cell, direction=direction, numbers=numbers, position=position)


def _photons(emitter: Emitter, band: int, start: int, stop: int) -> _Candidates:
    """The photons [start, stop) of a band."""
    arrays: dict[str, Any] = {name: np.zeros(stop - start, emitter.dtype) for name in ("ux", "uy", "uz", "x", "y")}
    arrays |= {"patch": np.empty(stop - start, np.int32), "numbers": np.empty((stop - start, 3), emitter.dtype)}
    emitter.fill_plain(band, start, arrays)
    index = np.arange(start, stop, dtype=np.uint64)
    order = emitter._stream(band).order
    rank = ranks_of_photons(start, stop, int(order[0]), order[3:]) if order.size else index
    direction = (arrays["ux"], arrays["uy"], arrays["uz"])
    rest = {"numbers": arrays["numbers"], "position": (arrays["x"], arrays["y"])}
    return _Candidates(index=index, rank=rank, cell=arrays["patch"], direction=direction, **rest)


def _index_of_rank(rank: int, n: int, keys: list[int]) -> int:
    """The photon that has a rank: the passes of `kernels.cells.order` backwards."""
    s, b = (int(x) for x in split_order(np.uint64(n)))
    mask = (1 << s) - 1
    is_short = n <= int(SHORT_LIMIT)

    def hashed(half: int, key: int) -> int:
        return int(mix(np.uint32(half), np.uint32(key)))

    def step(low: int, key: int) -> int:
        return ((hashed(low, key) >> 16) * b) >> 16 if is_short else int(high_step(np.uint32(low), key, np.uint64(b)))

    i = rank
    while True:
        high, low = i >> s, i & mask
        high = (high - step(low, keys[2])) % b
        low = (low - (hashed(high, keys[1]) >> (32 - s))) & mask
        high = (high - step(low, keys[0])) % b
        i = high << s | low
        if i < n:
            return i


def _is_taken(place: Callable[..., tuple[np.ndarray, ...]], stream: StreamWords, words: tuple[Any, ...]) -> np.ndarray:
    """Whether photons are taken by these words; `place` wants words and the key from which later trials are drawn.

    A photon that has the same direction whatever the key is needed no later trial.
    """
    one, other = (place(words, key) for key in (stream.placement_key, stream.placement_key ^ _OTHER_KEY))
    return np.asarray(np.logical_and.reduce([a == b for a, b in zip(one, other, strict=True)]))


def _ways(
    place: Callable[..., tuple[np.ndarray, ...]], stream: StreamWords, rank: np.ndarray, first: tuple[Any, ...]
) -> Any:
    """0 for photons that trial 0 takes, 1 for those of trial 1, else 2."""
    later = (None, *later_words(stream.placement_key, rank, stream.band, np.uint64(1)))
    return np.where(_is_taken(place, stream, first), 0, np.where(_is_taken(place, stream, later), 1, 2))


def _cells_and_places(emitter: Emitter, band: int, found: _Candidates, own: np.ndarray) -> tuple[Any, Any, Any]:
    """Parameters of the cells of chosen photons, and their places in them."""
    stream, cell = emitter._stream(band), found.cell[own]
    ring_offset = stream.ring_offsets[emitter._rings.ring_of_cell[cell]]
    words = (stream.jitter, stream.placement_key, stream.band, stream.shifts, stream.steps, ring_offset)
    p = tuple(emitter._cells[cell, j] for j in range(6))
    return p, *positions_in_cells(found.rank[own], *words, emitter.dtype.type(0))


def _horizon_ways(emitter: Emitter, band: int, found: _Candidates, own: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Trials of a disc at the horizon: the first one or another."""
    stream, (p, u, v) = emitter._stream(band), _cells_and_places(emitter, band, found, own)
    rank = found.rank[own]

    def place(words: tuple[Any, ...], key: Any) -> Any:
        return discs_at_horizon(p, *words, key, rank, stream.band)  # type: ignore[call-arg]

    return np.where(_is_taken(place, stream, (u, v)), 0, 1)


def _perez_ways(emitter: Emitter, band: int, found: _Candidates, own: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Trials of the Perez sky, 3 for what is taken without its luminance; the luminance goes into `inside`."""
    from aomc_sky.skies.perez.kernels.cells import accept_words, is_taken_at_once, luminance, measured, place_perez

    stream, perez = emitter._stream(band), emitter._perez_tables
    p, *first = _cells_and_places(emitter, band, found, own)
    rank, cell = found.rank[own], found.cell[own]
    tables = (perez.word[cell], perez.bound[cell], perez.sky)
    word = accept_words(rank, stream.accept, stream.placement_key, stream.band, stream.jitter)

    def place(words: tuple[Any, ...], key: Any) -> Any:
        u, v = (unit(w, emitter.dtype.type(0)) if w.dtype == np.uint64 else w for w in words[1:3])
        return place_perez(p, tables, u, v, words[3], key, rank, stream.band)

    direction = (d[own] for d in found.direction)
    chord, mu, _ = measured(*direction, word, tables[1], *perez.sky[8:11])  # type: ignore[call-arg]
    inside[own, 0] = luminance(mu, chord, perez.sky).view(np.uint64)
    return np.where(is_taken_at_once(word, tables[0]), 3, _ways(place, stream, rank, (None, *first, word)))


def _lobe_ways(emitter: Emitter, band: int, found: _Candidates, own: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Trials of lobes; their directions in float64 go into `inside`."""
    from aomc_sky.skies.lobes.kernels.law import lobe_words, place_lobes

    stream, lobes = emitter._stream(band), emitter._lobe_tables
    rank, lobe = found.rank[own], lobes.lobe[found.cell[own]]
    accept, proposals = emitter._lobe_steps(band)

    def place(words: tuple[Any, ...], key: Any) -> Any:
        return place_lobes(lobe, lobes.tables, words, key, rank, stream.band)

    words = (stream.shifts, stream.steps, accept, stream.placement_key, stream.band, stream.jitter)
    first = lobe_words(rank, lobe, proposals, *words)
    for c, values in enumerate(place(first, stream.placement_key)):
        inside[own, c] = values.view(np.uint64)
    return np.asarray(_ways(place, stream, rank, first))
