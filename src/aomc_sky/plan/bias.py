"""Photons shared out otherwise than light: the factor of every cell.

For each row and cell the light has the share p (`mass`), the photons have the share q = p b (`launch`), and a photon
has the weight w = 1 / b, whose mean is 1. Counts come from q by systematic or multinomial allocation, so that
E[n] w = N p in every cell. With D_k = sum over j <= k of (n_j - N q_j), |D_k| < 1 along the walk of systematic
allocation, summation by parts bounds the mean weight of one run: |mean w - 1| <= (1 / N) sum |w_k - w_(k+1)|. Weights
are not rescaled: that would make the light wrong on average.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Real

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import UsageError

MAX_WEIGHT = 1e6
"""Photons of a larger weight are refused: hardly any run would have one."""
MIN_WEIGHT = 1e-30
"""And of a smaller one: they would be many photons without light, and 0 in float32."""
_ONE = 1e-9
"""How far from 1 the sum of all shares may be."""


def bias_of(
    components: Sequence[Component], shares: Mapping[str, float], importance: Mapping[str, np.ndarray]
) -> np.ndarray:
    """The factor b of each cell, float64 (n_row, n_cell); 1 where there is no light.

    `shares` are shares of the photons by names of components; the others share the rest by their light. `importance` is
    the number of photons per light of the patches of a component, in any scale, (n_cell,).
    """
    names = [component.name for component in components]
    _check_shares(names, shares)
    shares = {name: float(share) for name, share in shares.items()}
    bias = np.ones((len(components[0].mass), sum(component.n_cells for component in components)))
    for row in range(len(bias)):
        light = [math.fsum(component.mass[row]) for component in components]
        if not any(light):
            continue
        start = 0
        for component, photons, of_light in zip(components, _photons(names, light, shares), light, strict=True):
            mass, part = component.mass[row], bias[row, start : start + component.n_cells]
            start += component.n_cells
            if not of_light:
                continue
            wanted = importance.get(component.name)
            factor = np.full(mass.size, photons / of_light)
            if wanted is not None:
                factor = photons * wanted / math.fsum(mass * wanted)
            np.copyto(part, factor, where=mass > 0)
            weights = 1.0 / factor[mass > 0]
            if not (weights.min() >= MIN_WEIGHT and weights.max() <= MAX_WEIGHT):
                raise UsageError(
                    f"photons of {component.name!r} would have weights from {weights.min():.3g} to "
                    f"{weights.max():.3g}; {MIN_WEIGHT:g} to {MAX_WEIGHT:g} are allowed",
                    "give it another share, or its patches a smaller range of importance",
                )
    return bias


def _check_shares(names: Sequence[str], shares: Mapping[str, float]) -> None:
    for name, share in shares.items():
        if name not in names:
            raise UsageError(f"bias: there is no component {name!r}", f"the components are {', '.join(names)}")
        if isinstance(share, bool) or not isinstance(share, Real):
            raise UsageError(f"bias: the share of {name!r} is no number, got {share!r}")
        if not 0.0 < share <= 1.0:
            raise UsageError(
                f"bias: the share of {name!r} is {share:g}",
                "write more than 0, at most 1; a component without photons is left out of the scene",
            )
    total = math.fsum(shares.values())
    if len(shares) == len(names) and abs(total - 1.0) > _ONE:
        raise UsageError(f"bias: the shares of all components sum to {total:g}", "write shares that sum to 1")


def _photons(names: Sequence[str], light: Sequence[float], shares: Mapping[str, float]) -> list[float]:
    """The share of the photons of each component of a row; one that is dark there has none."""
    given = math.fsum(shares.get(name, 0.0) for name, part in zip(names, light, strict=True) if part)
    rest = math.fsum(part for name, part in zip(names, light, strict=True) if name not in shares)
    if rest and given >= 1.0:
        others = [name for name, part in zip(names, light, strict=True) if part and name not in shares]
        raise UsageError(
            f"bias: the shares sum to {given:g} and leave no photon to {' and '.join(map(repr, others))}",
            "write smaller shares",
        )
    scale = 1.0 if rest else 1.0 / given
    photons = []
    for name, part in zip(names, light, strict=True):
        own = scale * shares[name] if name in shares else (1.0 - given) * part / rest if rest else 0.0
        photons.append(own if part else 0.0)
    return photons


def checked_bias(bias: np.ndarray, mass: np.ndarray) -> str:
    """What is wrong with the factors of a plan of these masses, (n_row, n_cell) each; empty for good ones."""
    if bias.shape != mass.shape:
        return f"found shape {bias.shape}, expected that of mass, {mass.shape}"
    low, high = 1.0 / MAX_WEIGHT, 1.0 / MIN_WEIGHT
    if not np.all((bias >= low / (1 + _ONE)) & (bias <= high * (1 + _ONE))):
        return f"expected factors from {low:g} to {high:g}"
    launch, is_lit = np.sum(mass * bias, axis=1), mass.any(axis=1)
    if not np.all(np.abs(launch - 1.0)[is_lit] <= _ONE):
        return "expected that mass times bias sums to 1"
    return ""
