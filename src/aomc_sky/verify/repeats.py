"""Photons that repeat another one: pairs of equal directions, compared with pairs of neighbours.

Photons of a smooth sky can have equal directions by chance. In a square of the horizontal plane that is 2^-17 wide,
single precision has 2^14 directions or more, and a sampler with two random numbers of 24 bits has about 5000. For any
sky, at most 1 / 64 of the pairs of a square are therefore equal by chance. A copied photon makes a pair that is always
equal. The directions of beams, which many photons share, are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import Frame, travel_from_sky
from aomc_sky.plan.laws import law_of
from aomc_sky.verify.report import Check
from aomc_sky.verify.zone_tests import untested
from aomc_sky.verify.zones import points_deg

NAME = "photons that repeat another"
MOST_EQUAL = 1 / 64
"""Largest share of equal pairs in a square by chance."""
MAX_KEPT = 2**22
"""Photons that are compared; of more, those in a random part of the squares. [32 MB]"""
_MAX_BEAMS = 64
_BEAM_RADIUS = 1e-5
"""Around a beam's direction: a hundred times the rounding of single precision. [rad]"""
_LEAST_WIDTH = 1e-5
"""A `narrow_lobe` fills a square unevenly. [rad]"""
_SQUARES_PER_UNIT = 2.0**17
_EXACT_BITS = np.uint64(24)
_MOST_HALVINGS = 39


@dataclass(frozen=True, kw_only=True, slots=True)
class RepeatFinder:
    """Turns photons into words that can be compared."""

    beams: np.ndarray  #: horizontal parts of the travel directions of beams [shape (n_beam, 2)]

    @classmethod
    def of(cls, components: Sequence[Component], frame: Frame, *, is_centred: bool) -> RepeatFinder | str:
        """The finder for a sky, or a reason why repeated photons are no fault there."""
        if is_centred:
            return "all photons of a patch have one direction"
        for component in components:
            if law_of(component.law).width_rad(component) < _LEAST_WIDTH:
                return f"{component.name} is narrower than {_LEAST_WIDTH:g} rad"
        points = [points_deg(component, is_centred=False)[1:] for component in components]
        zenith, azimuth = (np.concatenate(angle) for angle in zip(*points, strict=True))
        if zenith.size > _MAX_BEAMS:
            return "its photons have few directions"
        return cls(beams=travel_from_sky(zenith, azimuth, frame).reshape(-1, 3)[:, :2])

    def sample(self, direction: np.ndarray) -> RepeatSample:
        """A word for each photon: 40 bits are a hash of the square, and 24 bits a hash of the direction in it."""
        is_far = np.isfinite(direction).all(axis=1)
        for beam in self.beams:
            is_far &= np.sum((direction[:, :2] - beam) ** 2, axis=1) > _BEAM_RADIUS**2
        x, y, z = np.ascontiguousarray(direction[is_far].T) + 0.0  # one zero, of either sign
        square = _avalanche((_square(x) << np.uint64(20)) | _square(y)) >> _EXACT_BITS
        exact = _avalanche(x.view(np.uint64)) ^ (_avalanche(y.view(np.uint64)) * np.uint64(3))
        exact = _avalanche(exact ^ (z.view(np.uint64) * np.uint64(5))) >> np.uint64(40)
        return RepeatSample(parts=((square << _EXACT_BITS) | exact,), n=square.size)


@dataclass(frozen=True, kw_only=True, slots=True)
class RepeatSample:
    """Words of photons in a random part of the squares."""

    parts: tuple[np.ndarray, ...] = ()  #: the words, in blocks
    n: int = 0  #: photons that were looked at
    halvings: int = 0  #: how often the part was halved [0 to 39]

    def __add__(self, other: RepeatSample) -> RepeatSample:
        halvings = max(self.halvings, other.halvings)
        parts = [_within(part, halvings) for part in (*self.parts, *other.parts)]
        while sum(part.size for part in parts) > MAX_KEPT and halvings < _MOST_HALVINGS:
            halvings += 1
            parts = [_within(np.concatenate(parts), halvings)]
        return RepeatSample(parts=tuple(parts), n=self.n + other.n, halvings=halvings)

    def pairs(self) -> tuple[int, int]:
        """Number of pairs in one square, and of equal pairs."""
        words = np.concatenate([np.zeros(0, np.uint64), *self.parts])
        return _pairs(words >> _EXACT_BITS), _pairs(words)

    def check(self, waveband: int) -> Check:
        """Whether more photons are equal than neighbours explain.

        Each pair of one square is equal with a chance of 1 / 64 at most, independently of other pairs, so the binomial
        law is an upper bound.
        """
        from scipy.special import bdtrc

        if self.n < 2:
            return untested(NAME, waveband)
        near, equal = self.pairs()
        kept = 2.0**-self.halvings
        detail = f"{equal} pairs are equal, {near} lie within {1 / _SQUARES_PER_UNIT:.2g}"
        detail += f"; in {kept:.2g} of the sky" if self.halvings else ""
        p_value = float(bdtrc(equal - 1, near, MOST_EQUAL)) if equal else 1.0
        return Check(name=NAME, waveband=waveband, found=equal / kept / self.n, p_value=p_value, detail=detail)


def _square(x: np.ndarray) -> np.ndarray:
    """Number of the strip of the plane, (n,) uint64 below 2^20; damaged directions in the outermost."""
    return np.clip((x + 1.0) * _SQUARES_PER_UNIT, 0.0, 2.0**20 - 1).astype(np.uint64)


def _avalanche(word: np.ndarray) -> np.ndarray:
    """The finaliser of splitmix64."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


def _within(words: np.ndarray, halvings: int) -> np.ndarray:
    return words[words >> np.uint64(64 - halvings) == 0] if halvings else words


def _pairs(words: np.ndarray) -> int:
    """Pairs of equal numbers."""
    times = np.unique(words, return_counts=True)[1].astype(np.int64)
    return int((times * (times - 1) // 2).sum())
