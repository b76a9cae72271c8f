"""A number density from a code block: checked over all altitudes, with its jumps and bends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.language.block import Block
from aomc_sky.atmosphere.numerics.adaptive_integral import integrate
from aomc_sky.atmosphere.numerics.kinks import find_kinks
from aomc_sky.errors import SceneError

# two kinks nearer than this [m] are one to every solver, and one so near the ground or the top is none
_SAME_KINK_M = 1e-6
_N_SAMPLES = 16384
_N_NEAR_GROUND = 1024
# samples: a layer that falls to a half within so many on both sides is thin beside every scale height
_THIN = 128
_MAX_LAYERS = 100


@dataclass(frozen=True, kw_only=True, slots=True)
class NumberDensity:
    """Particles per volume by altitude; calling it evaluates the block and checks what comes out. Pure."""

    block: Block
    given: Mapping[str, np.ndarray | float]
    top_m: float  #: Altitude above which there is nothing. [m]

    def __call__(self, altitude_m: np.ndarray) -> np.ndarray:
        """Density at altitudes, finite and not negative; one outside by rounding is taken for the end that it passed.
        [m-3]

        An InputFileError names an altitude where the block gives something else. Cost: 10 to 60 us and 5 to 30 ns an
        altitude.
        """
        altitude_m = np.clip(np.asarray(altitude_m, dtype=np.float64), 0.0, self.top_m)
        value = self.block(altitude_m, self.given).reshape(altitude_m.shape)
        bad = ~((value >= 0.0) & (value < np.inf))
        if bad.any():
            first = int(np.flatnonzero(bad.ravel())[0])
            found = float(value.ravel()[first])
            advice = "write max(0.0, ...) around it" if found < 0.0 else "write what is finite there"
            message = f"a density is finite and not negative; it is {found:.6g}"
            raise self.block.refused_at(float(altitude_m.ravel()[first]), message, advice)
        return value

    def kinks(self) -> np.ndarray:
        """Find the altitudes where the density jumps or bends, and check it on all samples and beside all kinks.

        A thin smooth layer (it falls to a half within a 128th of the atmosphere on both sides) counts as three bends,
        its peak and its halves, so that no quadrature steps over it.

        Rising, inside the atmosphere. [m] An InputFileError says where the density is negative or undefined, or that it
        has too many pieces.

        Accuracy: the first number of the upper piece, for pieces of more than ``top_m / 16384``; a thinner piece is
        found where a bend leads to it (``abs(altitude - h) < 2.0``).
        """
        # a block that never ends, or fails everywhere, is reported for two altitudes at once
        self(np.array([0.0, self.top_m]))
        even = np.linspace(0.0, self.top_m, _N_SAMPLES + 1)
        samples = np.union1d(even, np.geomspace(self.top_m * 1e-9, even[1], _N_NEAR_GROUND))
        try:
            found = find_kinks(lambda altitude: self.block.trace(altitude, self.given), samples)
        except SceneError as error:
            raise self.block.refused_at(None, str(error)) from None
        layers = [even[layer] for layer in _thin_layers(self(even))]
        # one that a bend bounds is known already
        smooth = [one for one in layers if not ((found >= one[0]) & (found <= one[2])).any()]
        found = np.unique(np.concatenate([found, *smooth]))
        inside = found[(found > _SAME_KINK_M) & (found < self.top_m - _SAME_KINK_M)]
        if inside.size:
            inside = inside[np.r_[True, np.diff(inside) > _SAME_KINK_M]]
        self(np.concatenate([samples, inside, np.nextafter(inside, 0.0)]))
        return inside

    def column(self, kinks_m: np.ndarray) -> float:
        """Particles above each square metre of ground, to about 1e-10; `kinks_m` are those of `kinks`. [m-2]"""
        # in a cubic root for scale heights of metres, evenly for layers of metres
        step = np.linspace(0.0, 1.0, 65) ** 3
        even = self.top_m * np.union1d(step, np.linspace(0.0, 1.0, 1025))
        edges = np.unique(np.concatenate([even, kinks_m]))
        return float(integrate(lambda altitude: self(altitude)[None], edges, tolerance=1e-12).value[0])


def _thin_layers(value: np.ndarray) -> list[list[int]]:
    """For each thin layer the indices where it has half of its peak, of its peak, and where it has half again."""
    peaks = 1 + np.flatnonzero((value[1:-1] > value[:-2]) & (value[1:-1] >= value[2:]))
    found = []
    for peak in peaks[np.argsort(-value[peaks], kind="stable")][:_MAX_LAYERS].tolist():
        first = max(0, peak - _THIN)
        below = np.flatnonzero(value[first:peak] < 0.5 * value[peak])
        above = np.flatnonzero(value[peak + 1 : peak + 1 + _THIN] < 0.5 * value[peak])
        if below.size and above.size:
            found.append([first + int(below[-1]), peak, peak + 1 + int(above[0])])
    return found
