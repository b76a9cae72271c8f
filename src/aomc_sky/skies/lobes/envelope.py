"""The envelope of a lobe for its sampler: the lobe turned to the horizon, and bins of equal probability.

A direction of a lobe has two uniform coordinates, b and psi. The share b of the lobe is farther from the axis. The
azimuth psi is in the stretched plane, from where the horizon is farthest or the zenith nearest. With a = 1 - b::

    hg        p = (1-g)^2 a (1 + g b), q = (1+g)^2 b (1 - g + g b);   R = 2 sqrt(p q), Z = q - p
    ggx       R = sqrt(a), Z = sqrt(b)
    beckmann  R = sqrt(-log b), Z = 1

and the light comes from M (R cos psi, R sin psi, Z), normalised; the photon travels the opposite way. The last row of M
is (k, 0, n_z). The cosine of the zenith angle is thus (n_z Z + k R cos psi) / sqrt(Z^2 + R^2 r^2), with the stretch
r(psi) in that direction.

A photon falls into a bin of the envelope and is uniform in it (trial 0 by rank: in the cell of its bin, with the same
result). It stays with the probability cosine / bound; else it falls anew, into any bin. The emitted law is lobe times
cosine for any bins: they only decide how often photons fall. Cells of the plane (b, psi) are halved where the bound
wastes most. Then each gets as many bins of equal size as its part of the envelope needs.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Law
from aomc_sky.phase import henyey_greenstein
from aomc_sky.skies.lobes.lobe import checked, rotation_matrix

LAWS = {"hg": Law.HG, "ggx": Law.GGX, "beckmann": Law.BECKMANN}
_RELATIVE_SLACK = 1e-9
_SLACK = 4e-15
_FAR = 1e100
_WASTE = 0.1
_CELLS_IN_SIGHT = 32.0
_MAX_CELLS = 768
_MAX_PASSES = 80
_BIN_BITS = (6, 7, 8, 9, 10, 11)
_GOOD_FILL = 0.93


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeFrame:
    """A lobe turned to the horizon, or with arrays several lobes of one kind, one for each cell."""

    kind: str
    asymmetry: np.ndarray  #: g of "hg", else 0, shape (...). [0 <= g < 1]
    stretch: np.ndarray  #: Roughness along local x and y; 1 for "hg", shape (2, ...). [> 0]
    matrix: np.ndarray  #: M of the module's text, shape (3, 3, ...).
    turn: np.ndarray  #: Azimuth in the stretched plane where psi is 0, shape (...). [quarter turns]

    @classmethod
    def of(cls, kind: str, param0: float, param1: float, quaternion: np.ndarray) -> LobeFrame:
        """The frame of a lobe; parameters and errors as for `pdf` and `rotation_matrix`."""
        first, second = (float(x) for x in checked(kind, param0, param1))
        stretch = (1.0, 1.0) if kind == "hg" else (first, second)
        matrix = rotation_matrix(quaternion) * np.array([*stretch, 1.0])
        along_x, along_y, up = matrix[2]
        k = float(np.hypot(along_x, along_y))
        c, s = (along_x / k, along_y / k) if k > 0.0 else (1.0, 0.0)
        turned = np.stack([matrix[:, 0] * c + matrix[:, 1] * s, matrix[:, 1] * c - matrix[:, 0] * s, matrix[:, 2]], 1)
        turned[2] = k, 0.0, up
        asymmetry = first if kind == "hg" else 0.0
        turn = float(np.arctan2(s, c)) * (2 / np.pi)
        return cls(
            kind=kind,
            asymmetry=np.array(asymmetry),
            stretch=np.array(stretch),
            matrix=turned,
            turn=np.array(turn),
        )

    @classmethod
    def stacked(cls, frames: Sequence[LobeFrame]) -> LobeFrame:
        """Several lobes of one kind."""
        names = ("asymmetry", "stretch", "matrix", "turn")
        return cls(
            kind=frames[0].kind,
            **{name: np.stack([getattr(one, name) for one in frames], axis=-1) for name in names},
        )

    def at(self, lobe: np.ndarray) -> LobeFrame:
        """The lobe of each cell, by its index."""
        return LobeFrame(
            kind=self.kind,
            asymmetry=self.asymmetry[lobe],
            stretch=self.stretch[:, lobe],
            matrix=self.matrix[:, :, lobe],
            turn=self.turn[lobe],
        )

    def largest_share(self) -> float:
        """No direction with a larger b is above the horizon; 1 where the axis is. [0 to 1]"""
        k, _, up = self.matrix[2].tolist()
        if up >= 0.0:
            return 1.0
        if k == 0.0:
            return 1.0 if self.kind == "hg" else 0.0
        slope = -up / k
        if self.kind == "hg":
            share = float(henyey_greenstein.cdf(up * up / (1.0 + k), float(self.asymmetry)))
        elif self.kind == "ggx":
            share = 1.0 / (1.0 + slope * slope)
        else:
            share = float(np.exp(-min(slope * slope, 1e4)))
        return min(share * (1.0 + _RELATIVE_SLACK), 1.0)

    def height(self, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """R and Z."""
        if self.kind == "hg":
            g = self.asymmetry
            p, q = (1.0 - g) ** 2 * a * (1.0 + g * b), (1.0 + g) ** 2 * b * (1.0 - g + g * b)
            return 2.0 * np.sqrt(p * q), q - p
        if self.kind == "ggx":
            return np.sqrt(a), np.sqrt(b)
        with np.errstate(divide="ignore"):
            radius = np.sqrt(-np.where(a < 0.25, np.log1p(-np.minimum(a, 0.5)), np.log(b)))
        return radius, np.ones_like(radius)

    def stretch_at(self, psi: np.ndarray) -> np.ndarray:
        """The stretch r at azimuths in quarter turns."""
        phi = (psi + self.turn) * (np.pi / 2)
        return np.hypot(self.stretch[0] * np.cos(phi), self.stretch[1] * np.sin(phi))

    def cosine(self, a: np.ndarray, b: np.ndarray, psi: np.ndarray) -> np.ndarray:
        """Cosine of the zenith angle, 0 below the horizon."""
        radius, z = self.height(a, b)
        k, _, up = self.matrix[2]
        value = up * z + k * radius * np.cos(psi * (np.pi / 2))
        return np.maximum(value, 0.0) / np.hypot(z, radius * self.stretch_at(psi))

    def upper_bound(self, a: np.ndarray, b: np.ndarray, psi: np.ndarray) -> np.ndarray:
        """Upper bound of `cosine` over cells; arguments hold both ends, shape (2, n): a falls, b and psi rise.

        Take the largest cosine c of psi and the smallest r in the cell. Then (n_z Z + k R c) over the root is an upper
        bound if it is positive. As a function of tan t = R r / Z it is N cos(t - t0), whose maximum between two ends is
        known. A margin of 1e-9 of itself covers rounding.
        """
        least = self._least_stretch(psi)
        cosines = np.cos(psi * (np.pi / 2))
        largest = np.where((psi[0] <= 0.0) & (psi[1] >= 0.0), 1.0, cosines.max(axis=0))
        k, _, up = self.matrix[2]
        radius, z = self.height(a, b)
        radius = np.minimum(radius, _FAR)
        length = np.hypot(z, radius * least)
        above, beside = up * z / length, k * largest * radius / length
        slack = _SLACK * (np.abs(above) + np.abs(beside)).max(axis=0)
        side = k * largest / least
        angle, peak = np.arctan2(radius * least, z), np.arctan2(side, up)
        is_inside = (angle.min(axis=0) <= peak) & (peak <= angle.max(axis=0))
        value = np.where(is_inside, np.hypot(up, side), (above + beside).max(axis=0)) + slack
        return np.maximum(value, 0.0) * (1.0 + _RELATIVE_SLACK)

    def _least_stretch(self, psi: np.ndarray) -> np.ndarray:
        """Lower bound of r over azimuths: between whole quarter turns it is monotonic."""
        low, high = np.ceil(psi[0] + self.turn - 1e-12), np.floor(psi[1] + self.turn + 1e-12)
        least = self.stretch_at(psi).min(axis=0)
        for quarter in (low, high):
            extreme = np.where(np.mod(quarter, 2.0) == 0.0, *self.stretch)
            least = np.where(low <= high, np.minimum(least, extreme), least)
        return least * (1.0 - _RELATIVE_SLACK)


# Cells of the plane (b, psi) are arrays (6, n): least b, growth of b, least a, least psi and growth of psi, both in
# quarter turns, and the upper bound of the cosine.


def _bounded(frame: LobeFrame, rows: np.ndarray) -> np.ndarray:
    """Cells with their bounds, from their first five rows."""
    b, db, a, psi, dpsi = rows
    bound = frame.upper_bound(np.stack([a + db, a]), np.stack([b, b + db]), np.stack([psi, psi + dpsi]))
    return np.vstack([rows, bound])


def _mass(cells: np.ndarray) -> np.ndarray:
    """Integral of the envelope over each cell."""
    return np.asarray(cells[1] * (cells[4] / 4.0) * cells[5])


def _waste(frame: LobeFrame, cells: np.ndarray) -> np.ndarray:
    """Envelope less the light, from four points in each cell."""
    b, db, a, psi, dpsi, bound = cells
    light = np.zeros_like(b)
    for s in (0.211, 0.789):
        for t in (0.211, 0.789):
            light += frame.cosine(a + (1 - s) * db, b + s * db, psi + t * dpsi)
    return _mass(cells) * (1.0 - np.minimum(light / (4.0 * bound), 1.0))


def _halves_in_b(rows: np.ndarray) -> np.ndarray:
    b, db, a, psi, dpsi = rows
    half = db / 2
    return np.concatenate([[b, half, a + half, psi, dpsi], [b + half, half, a, psi, dpsi]], axis=1)


def _halves_in_psi(rows: np.ndarray) -> np.ndarray:
    b, db, a, psi, dpsi = rows
    half = dpsi / 2
    return np.concatenate([[b, db, a, psi, half], [b, db, a, psi + half, half]], axis=1)


def _split(frames: LobeFrame, lobe: np.ndarray, cells: np.ndarray, waste: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halves of cells, cut where the bounds gain more, quarters where neither cut gains much; and their lobes."""
    rows, twice = cells[:5], np.tile(lobe, 2)
    in_b, in_psi = (_bounded(frames.at(twice), halves(rows)) for halves in (_halves_in_b, _halves_in_psi))
    gain_b, gain_psi = (_mass(cells) - _mass(part).reshape(2, -1).sum(axis=0) for part in (in_b, in_psi))
    both = np.maximum(gain_b, gain_psi) < 0.2 * waste
    by_b = ~both & (gain_b >= gain_psi)
    by_psi = ~both & ~by_b
    lobe_of_quarters = np.tile(lobe[both], 4)
    quarters = _bounded(frames.at(lobe_of_quarters), _halves_in_psi(_halves_in_b(rows[:, both])))
    by_b, by_psi = np.tile(by_b, 2), np.tile(by_psi, 2)
    made = np.concatenate([in_b[:, by_b], in_psi[:, by_psi], quarters], axis=1)
    return made, np.concatenate([twice[by_b], twice[by_psi], lobe_of_quarters])


def _refined(frames: Sequence[LobeFrame]) -> list[np.ndarray]:
    """Cells of each lobe that cover all of it that is above the horizon; those without light are dropped.

    All lobes are refined together, and each gets the cells that it would get alone.
    """
    stack, n_lobes = LobeFrame.stacked(frames), len(frames)
    lobe = np.repeat(np.arange(n_lobes), 4)
    top, ones = np.array([frame.largest_share() for frame in frames])[lobe], np.ones(lobe.size)
    rows = np.stack([0 * ones, top, 1 - top, np.tile(np.arange(-2.0, 2.0), n_lobes), ones])
    cells = _bounded(stack.at(lobe), rows)
    done: list[np.ndarray] = [cells[:, :0]] * n_lobes
    for k in range(_MAX_PASSES + 1):
        is_lit = cells[5] > 0.0
        cells, lobe = cells[:, is_lit], lobe[is_lit]
        waste, mass = _waste(stack.at(lobe), cells), _mass(cells)
        coarse = np.zeros(lobe.size, bool)
        edges = np.flatnonzero(np.diff(lobe, prepend=-1, append=n_lobes)).tolist()
        for part in (slice(*pair) for pair in itertools.pairwise(edges)):
            total = float(mass[part].sum())
            wasteful = waste[part] > _WASTE * total / _CELLS_IN_SIGHT
            is_done = not wasteful.any() or waste[part].sum() < _WASTE * total or wasteful.size > _MAX_CELLS
            if is_done or k == _MAX_PASSES:
                done[lobe[part.start]] = cells[:, part]
                lobe[part] = n_lobes  # out of the way
            else:
                coarse[part] = wasteful
        is_kept = ~coarse & (lobe < n_lobes)
        if not coarse.any():
            break
        made, lobe_of_made = _split(stack, lobe[coarse], cells[:, coarse], waste[coarse])
        cells, lobe = np.concatenate([cells[:, is_kept], made], axis=1), np.concatenate([lobe[is_kept], lobe_of_made])
        order = np.argsort(lobe, kind="stable")
        cells, lobe = cells[:, order], lobe[order]
    return done


def envelopes_of(frames: Sequence[LobeFrame]) -> list[tuple[np.ndarray, float]]:
    """Envelopes of lobes of one kind that are not all below the horizon: cells, shape (n, 8), and integral of each.

    Columns: least b, a bin's width in b, least a, number of bins; half the width in psi in quarter turns [up to 1/2],
    sine and cosine of the centre; bound of the cosine. The bins of a cell stand side by side in b. Their number in all
    cells is a power of two. Photons fall into each with the same probability, and bound x area is the same for all. The
    integral over the lobe's projected mass is the mean number of tries.
    """
    return [_with_bins(cells) for cells in _refined(frames)] if frames else []


def _with_bins(cells: np.ndarray) -> tuple[np.ndarray, float]:
    cells = cells[:, np.lexsort((cells[0], cells[3]))]
    b, db, a, psi, dpsi, _ = cells
    mass = _mass(cells)
    for bits in _BIN_BITS:
        n = 1 << bits
        if mass.size > n / 2 and bits != _BIN_BITS[-1]:
            continue
        # bins of each cell, at most n in all, that make the largest mass of a bin nearly as small as it can be
        low, high = float(mass.sum()) / n, float(mass.sum()) / n + float(mass.max())
        while high - low > 1e-4 * high:
            middle = 0.5 * (low + high)
            fits = np.ceil(mass / middle).sum() <= n
            low, high = (low, middle) if fits else (middle, high)
        count = np.ceil(mass / high).astype(np.int64)
        count[np.argmax(mass / count)] += n - count.sum()
        largest = float((mass / count).max())
        if mass.sum() >= _GOOD_FILL * n * largest:
            break
    width, centre = db / count, (psi + dpsi / 2) * (np.pi / 2)
    bound = largest / (width * dpsi / 4)
    columns = [b, width, a, count, dpsi / 2, np.sin(centre), np.cos(centre), bound]
    return np.stack(columns, axis=1), n * largest
