"""Photons that repeat another one: pairs of equal directions, against pairs that are only neighbours.

Photons of a sky of any smooth radiance meet by chance: among those of one small square of the horizontal plane, 2^-17
wide, a pair has equal directions to the last bit about as often as one of the numbers that a direction can have there
is hit twice. In single precision there are 2^14 of them or more, with two random numbers of 24 bits about 5000. So of
the pairs of a square at most a share of 1 / 64 may be equal, whatever the sky; a photon that was copied makes a pair
that is always equal. Directions that many photons have by right, those of beams, are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import Frame, travel_from_sky
from aomc_sky.verify.report import Check, binomial_tail
from aomc_sky.verify.sky.zone_tests import untested
from aomc_sky.verify.sky.zones import fixed_directions

NAME = "photons that repeat another"
MOST_EQUAL = 1 / 64
"""Share of the pairs of a square that may be equal by chance, from above."""
MAX_KEPT = 2**22
"""Photons that are compared; of more, those in a random part of the squares. [32 MB]"""
_MAX_BEAMS = 64
_BEAM_RADIUS = 1e-5
"""Around a beam's direction: a hundred times the rounding of single precision. [rad]"""
_LEAST_WIDTH = 1e-5
"""Lobes that are narrower fill a square unevenly. [rad]"""
_SQUARES_PER_UNIT = 2.0**17
_ID_BITS = 40
_ID_MASK = np.uint64((1 << _ID_BITS) - 1)
_EXACT_BITS = np.uint64(64 - _ID_BITS)


@dataclass(frozen=True, kw_only=True, slots=True)
class RepeatFinder:
    """What photons are compared by."""

    #: Horizontal parts of travel directions that many photons have by right. [shape (n_beam, 2)]
    beams: np.ndarray

    @classmethod
    def of(cls, components: Sequence[Component], frame: Frame, *, at_centres: bool) -> RepeatFinder | str:
        """For a sky, or why repeated photons of it say nothing."""
        if at_centres:
            return "all photons of a patch have one direction"
        for component in components:
            if component.law.is_lobe and _width(component) < _LEAST_WIDTH:
                return f"{component.name} is narrower than {_LEAST_WIDTH:g} rad"
        fixed = fixed_directions(components, at_centres=False)
        is_point = np.ptp(fixed.zenith_deg, axis=1) + np.ptp(fixed.azimuth_deg, axis=1) == 0
        if np.count_nonzero(is_point) > _MAX_BEAMS:
            return "its photons have few directions"
        travel = travel_from_sky(fixed.zenith_deg[is_point, 0], fixed.azimuth_deg[is_point, 0], frame)
        return cls(beams=travel.reshape(-1, 3)[:, :2])

    def sample(self, direction: np.ndarray) -> RepeatSample:
        """The words of photons: 40 bits name the square, well mixed, and 24 bits the direction in it."""
        x, y, z = (np.ascontiguousarray(column, dtype=np.float64) + 0.0 for column in direction.T)
        is_far = np.isfinite(x + y + z)
        for bx, by in self.beams:
            is_far &= (x - bx) ** 2 + (y - by) ** 2 > _BEAM_RADIUS**2
        if not is_far.all():
            x, y, z = x[is_far], y[is_far], z[is_far]
        square = (_square(x) << np.uint64(20)) | _square(y)
        word = _mixed(square) << _EXACT_BITS
        exact = _avalanche(x.view(np.uint64)) ^ (_avalanche(y.view(np.uint64)) * np.uint64(3))
        exact = _avalanche(exact ^ (z.view(np.uint64) * np.uint64(5)))
        word |= exact >> np.uint64(_ID_BITS)
        return RepeatSample(parts=(word,), n=word.size)


@dataclass(frozen=True, kw_only=True, slots=True)
class RepeatSample:
    """Words of photons in a random part of the squares."""

    #: The words, in pieces.
    parts: tuple[np.ndarray, ...] = ()
    #: Photons that were looked at.
    n: int = 0
    #: How often the part was halved. [0 to 39]
    halvings: int = 0

    def __add__(self, other: RepeatSample) -> RepeatSample:
        halvings = max(self.halvings, other.halvings)
        parts = (*self._at(halvings), *other._at(halvings))
        while sum(part.size for part in parts) > MAX_KEPT and halvings < _ID_BITS - 1:
            halvings += 1
            parts = (_within(np.concatenate(parts), halvings),)
        return RepeatSample(parts=parts, n=self.n + other.n, halvings=halvings)

    def _at(self, halvings: int) -> tuple[np.ndarray, ...]:
        if halvings == self.halvings:
            return self.parts
        return tuple(_within(part, halvings) for part in self.parts)

    def pairs(self) -> tuple[int, int]:
        """Pairs of photons of one square, and those of them that are equal."""
        words = np.sort(np.concatenate(self.parts)) if self.parts else np.zeros(0, np.uint64)
        return _pairs(words >> _EXACT_BITS), _pairs(words)

    def check(self, waveband: int) -> Check:
        """Whether more photons are equal than neighbours explain.

        Given the pairs of one square, each is equal with a chance of 1 / 64 at most, and two pairs are equal
        independently of each other: the binomial law from above.
        """
        if self.n < 2:
            return untested(NAME, waveband)
        near, equal = self.pairs()
        kept = 2.0**-self.halvings
        detail = f"{equal} pairs are equal, {near} lie within {1 / _SQUARES_PER_UNIT:.2g}"
        if self.halvings:
            detail += f"; in {kept:.2g} of the sky"
        return Check(
            name=NAME,
            waveband=waveband,
            passed=True,
            found=equal / kept / self.n,
            p_value=binomial_tail(equal, near, MOST_EQUAL),
            detail=detail,
        )


def _width(component: Component) -> float:
    from aomc_sky.skies.lobes.envelope import lobe_of
    from aomc_sky.skies.lobes.patches import TiltedLobe

    kind, param0, param1, rotation = lobe_of(component)
    return TiltedLobe(kind=kind, param0=param0, param1=param1, rotation=rotation).width


def _square(x: np.ndarray) -> np.ndarray:
    """Number of the strip of the plane, (n,) uint64 below 2^20; damaged directions in the outermost."""
    return np.clip((x + 1.0) * _SQUARES_PER_UNIT, 0.0, 2.0**20 - 1).astype(np.uint64)


def _mixed(number: np.ndarray) -> np.ndarray:
    """A permutation of numbers of 40 bits in which every bit depends on all: part of the squares is a random part."""
    for factor in (0x9E3779B97F, 0xBF58476D1D):  # odd, so that the product can be undone
        number = (number * np.uint64(factor)) & _ID_MASK
        number ^= number >> np.uint64(_ID_BITS // 2)
    return number


def _avalanche(word: np.ndarray) -> np.ndarray:
    """The finaliser of splitmix64."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


def _within(words: np.ndarray, halvings: int) -> np.ndarray:
    return words[words >> np.uint64(64 - halvings) == 0]


def _pairs(sorted_words: np.ndarray) -> int:
    """Pairs of equal numbers."""
    if sorted_words.size == 0:
        return 0
    ends = np.flatnonzero(np.append(sorted_words[1:] != sorted_words[:-1], True))
    of_each = np.diff(np.append(-1, ends)).astype(np.int64)
    return int((of_each * (of_each - 1) // 2).sum())
