"""A phase function from a code block: checked, and divided by its integral over the sphere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.atmosphere.language.block import Block
from aomc_sky.atmosphere.numerics.adaptive_integral import Integral, integrate
from aomc_sky.atmosphere.numerics.kinks import find_kinks
from aomc_sky.errors import SceneError

Given = Mapping[str, np.ndarray | float]
_N_PANELS = 64
_N_SAMPLES = 4096
_TOLERANCE = 1e-12
_MAX_ERROR = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class PhaseBlock:
    """A phase function of some wavelengths, of integral 1 over the sphere; calling it evaluates the block. Pure."""

    block: Block  #: The code: four wavelengths at once
    given: Sequence[Given]  #: Values of the names that it reads, for each set of four wavelengths
    rows: Sequence[tuple[int, int]]  #: For each wavelength its set and its place in it
    norm: np.ndarray  #: (n_wl,) integral over the sphere of what the block gives, for each wavelength; it is divided by

    def __call__(self, mu: np.ndarray, row: int) -> np.ndarray:
        """Phase function at cosines of scattering angles (n,); 1 is straight on, and one outside by rounding is taken
        for its end. [sr-1]

        An InputFileError names a cosine where the block gives something negative or not finite. Accuracy: that of the
        norm, 1e-10. Cost: 20 to 80 us and 20 to 100 ns a cosine.
        """
        mu = np.clip(np.asarray(mu, dtype=np.float64), -1.0, 1.0)
        group, component = self.rows[row]
        return (_checked(self.block, mu, self.given[group])[component] / self.norm[row]).reshape(mu.shape)


def read_phase_block(block: Block, given: Sequence[Given], rows: Sequence[tuple[int, int]]) -> PhaseBlock:
    """Check a phase function at all cosines and find its integrals.

    An InputFileError where it is negative, infinite or undefined somewhere, or zero everywhere, or its integral does
    not settle.
    """
    integrals = [sphere_integral(block, one) for one in given]
    norm = np.array([integrals[group].value[component] for group, component in rows])
    error = np.array([integrals[group].error[component] for group, component in rows])
    if not (norm > 0.0).all():
        message = "the phase function is zero everywhere, it has no integral to be divided by"
        raise block.refused_at(None, message, "write one that scatters some light")
    if (error > _MAX_ERROR * norm).any():
        message = f"the integral of the phase function over the sphere does not settle to {_MAX_ERROR:g} of it"
        raise block.refused_at(None, message, "is its peak narrower than a number of 64 bits can tell?")
    norm.flags.writeable = False
    return PhaseBlock(block=block, given=tuple(given), rows=tuple(rows), norm=norm)


def sphere_integral(block: Block, given: Given) -> Integral:
    """Integrate a phase function over the sphere: 2 pi times the integral over mu from -1 to 1.

    With ``1 - mu = 2 t^4`` the integral runs over t from 0 to 1 with ``d mu = 8 t^3 dt``, which draws a forward peak of
    width 1e-12 in 1 - mu out to a thousandth of the range; panels are halved until a further halving changes none by
    1e-12 of the whole.

    One integral for each component of the block.

    Accuracy: 1e-10, and 1e-16 over the width of the peak in 1 - mu where that is more, since the block is given mu.
    """
    # a block that never ends, or fails everywhere, is reported for two cosines at once
    _checked(block, np.array([1.0, -1.0]), given)
    samples = _mu_of(np.linspace(1.0, 0.0, _N_SAMPLES + 1))
    try:
        kinks = find_kinks(lambda mu: block.trace(mu, given), samples)
    except SceneError as error:
        raise block.refused_at(None, str(error)) from None
    _checked(block, np.concatenate([samples, kinks]), given)
    bends = ((1.0 - kinks) / 2.0) ** 0.25
    edges = np.unique(np.concatenate([np.linspace(0.0, 1.0, _N_PANELS + 1), bends]))

    def integrand(t: np.ndarray) -> np.ndarray:
        return _checked(block, _mu_of(t), given) * (16.0 * np.pi * t**3)

    return integrate(integrand, edges, tolerance=_TOLERANCE)


def _mu_of(t: np.ndarray) -> np.ndarray:
    return 1.0 - 2.0 * t**4


def _checked(block: Block, mu: np.ndarray, given: Given) -> np.ndarray:
    value = block(mu, given)
    bad = ~((value >= 0.0) & (value < np.inf))
    if bad.any():
        component, lane = np.argwhere(bad)[0]
        message = f"a phase function is finite and not negative; component {component} is {value[component, lane]:.6g}"
        raise block.refused_at(float(mu.ravel()[lane]), message, "write what is 0 or more there")
    return value
