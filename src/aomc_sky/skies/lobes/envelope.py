"""The envelope of a lobe's sampler: bins of equal probability over the lobe's own coordinates, each with a bound.

A photon falls into a bin, is uniform in it, and stays with the probability cosine / bound; one that does not stay
falls anew, into any bin. So the emitted law is lobe times cosine whatever the bins are: they only settle how often
photons fall. Cells of the plane (b, psi) of `LobeFrame` are halved where the bound wastes most, then each gets as many
bins of equal size as its part of the envelope asks for.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from aomc_sky.skies.lobes.frame import LobeFrame

_WASTE = 0.1
_CELLS_IN_SIGHT = 32.0
_MAX_CELLS = 768
_MAX_PASSES = 80
_BIN_BITS = (6, 7, 8, 9, 10, 11)
_GOOD_FILL = 0.93


@dataclass(frozen=True, kw_only=True, slots=True)
class _Cells:
    """Cells of the plane (b, psi), an entry each."""

    b: np.ndarray  #: Least b.
    db: np.ndarray  #: Growth of b.
    a: np.ndarray  #: Least a.
    psi: np.ndarray  #: Least psi. [quarter turns]
    dpsi: np.ndarray  #: Growth of psi. [quarter turns]
    bound: np.ndarray  #: Upper bound of the cosine.

    @classmethod
    def of(cls, frame: LobeFrame, rows: np.ndarray) -> _Cells:
        """Cells with their bounds from `rows` (5, n)."""
        b, db, a, psi, dpsi = rows
        bound = frame.upper_bound(np.stack([a + db, a]), np.stack([b, b + db]), np.stack([psi, psi + dpsi]))
        return cls(b=b, db=db, a=a, psi=psi, dpsi=dpsi, bound=bound)

    @property
    def rows(self) -> np.ndarray:
        """Shape (5, n)."""
        return np.stack([self.b, self.db, self.a, self.psi, self.dpsi])

    @property
    def mass(self) -> np.ndarray:
        """Integral of the envelope over each cell."""
        return self.db * (self.dpsi / 4.0) * self.bound

    def taken(self, chosen: np.ndarray) -> _Cells:
        """Chosen cells."""
        return _Cells(**{f.name: getattr(self, f.name)[chosen] for f in fields(self)})

    def waste(self, frame: LobeFrame) -> np.ndarray:
        """Envelope less the light, from four points in each cell."""
        light = np.zeros_like(self.b)
        for s in (0.211, 0.789):
            for t in (0.211, 0.789):
                light += frame.cosine(self.a + (1 - s) * self.db, self.b + s * self.db, self.psi + t * self.dpsi)
        return self.mass * (1.0 - np.minimum(light / (4.0 * self.bound), 1.0))


def _halves_in_b(rows: np.ndarray) -> np.ndarray:
    b, db, a, psi, dpsi = rows
    half = db / 2
    return np.concatenate([[b, half, a + half, psi, dpsi], [b + half, half, a, psi, dpsi]], axis=1)


def _halves_in_psi(rows: np.ndarray) -> np.ndarray:
    b, db, a, psi, dpsi = rows
    half = dpsi / 2
    return np.concatenate([[b, db, a, psi, half], [b, db, a, psi + half, half]], axis=1)


def _split(frame: LobeFrame, cells: _Cells, waste: np.ndarray) -> _Cells:
    """Halves of cells, cut where the bounds gain more; quarters where neither cut gains much."""
    rows = cells.rows
    in_b, in_psi = (_Cells.of(frame, cut(rows)) for cut in (_halves_in_b, _halves_in_psi))
    gain_b, gain_psi = (cells.mass - part.mass.reshape(2, -1).sum(axis=0) for part in (in_b, in_psi))
    both = np.maximum(gain_b, gain_psi) < 0.2 * waste
    by_b = ~both & (gain_b >= gain_psi)
    by_psi = ~both & ~by_b
    parts = [in_b.taken(np.tile(by_b, 2)), in_psi.taken(np.tile(by_psi, 2))]
    parts.append(_Cells.of(frame, _halves_in_psi(_halves_in_b(rows[:, both]))))
    return _joined(parts)


def _joined(parts: list[_Cells]) -> _Cells:
    """The cells of all parts; those without light are dropped."""
    cells = _Cells(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(_Cells)})
    return cells.taken(cells.bound > 0.0)


def _refined(frame: LobeFrame) -> _Cells:
    """Cells that cover all of the lobe that is above the horizon."""
    top, ones = frame.largest_share(), np.ones(4)
    cells = _joined([_Cells.of(frame, np.stack([0 * ones, top * ones, (1 - top) * ones, np.arange(-2.0, 2.0), ones]))])
    for _ in range(_MAX_PASSES):
        waste, total = cells.waste(frame), float(cells.mass.sum())
        coarse = waste > _WASTE * total / _CELLS_IN_SIGHT
        if not coarse.any() or waste.sum() < _WASTE * total or cells.b.size > _MAX_CELLS:
            break
        cells = _joined([cells.taken(~coarse), _split(frame, cells.taken(coarse), waste[coarse])])
    return cells


def _apportioned(mass: np.ndarray, n: int) -> np.ndarray:
    """Bins of each cell, at most n in all, that make the largest mass of a bin nearly as small as it can be."""
    low, high = float(mass.sum()) / n, float(mass.sum()) / n + float(mass.max())
    while high - low > 1e-4 * high:
        middle = 0.5 * (low + high)
        fits = np.ceil(mass / middle).sum() <= n
        low, high = (low, middle) if fits else (middle, high)
    return np.ceil(mass / high).astype(np.int64)


def envelope_of(frame: LobeFrame) -> tuple[np.ndarray, float]:
    """Envelope of a lobe that is not all below the horizon: its cells, shape (n, 8), and its integral.

    Columns: least b, width of a bin in b, least a, number of bins; half the width in psi in quarter turns [up to 1/2],
    sine and cosine of the centre; bound of the cosine. The bins of a cell stand side by side in b. Their number in all
    cells is a power of two; photons fall into each with the same probability, and bound x area is the same for all. The
    integral over the lobe's projected mass is the mean number of tries.
    """
    cells = _refined(frame)
    cells = cells.taken(np.lexsort((cells.b, cells.psi)))
    mass = cells.mass
    for bits in _BIN_BITS:
        n = 1 << bits
        if mass.size > n / 2 and bits != _BIN_BITS[-1]:
            continue
        count = _apportioned(mass, n)
        count[np.argmax(mass / count)] += n - count.sum()
        largest = float((mass / count).max())
        if mass.sum() >= _GOOD_FILL * n * largest:
            break
    width, centre = cells.db / count, (cells.psi + cells.dpsi / 2) * (np.pi / 2)
    bound = largest / (width * cells.dpsi / 4)
    columns = [cells.b, width, cells.a, count, cells.dpsi / 2, np.sin(centre), np.cos(centre), bound]
    return np.stack(columns, axis=1), n * largest
