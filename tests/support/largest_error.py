"""The largest error of a function of float64 numbers: random points, then steps away from the worst of them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Extended = np.longdouble
"""The type of the true values: 11 bits more than float64 on x86."""
HAS_EXTENDED = np.finfo(Extended).nmant >= 63
PI = Extended("3.14159265358979323846264338327950288")


def ulps(got, true):
    """Errors in units in the last place of the true values, by the precision of `got`."""
    unit = np.spacing(np.maximum(np.abs(true).astype(got.dtype), np.finfo(got.dtype).tiny))
    return np.abs(got.astype(Extended) - true) / unit.astype(Extended)


class Numbers(NamedTuple):
    """Arguments from `low` to `high`; `draw(rng, n)` gives the first ones."""

    low: float
    high: float
    draw: Callable[[np.random.Generator, int], np.ndarray]


def uniform(low, high):
    """Numbers from low to high, a half of them close to one of the ends, on all scales."""

    def draw(rng, n):
        near = (high - low) * 10.0 ** rng.uniform(-16, 0, n)
        ends = np.where(rng.random(n) < 0.5, low + near, high - near)
        return np.where(rng.random(n) < 0.5, rng.uniform(low, high, n), ends)

    return Numbers(low, high, draw)


def either_sign(low, high):
    """Numbers of both signs whose sizes go from low to high, on all scales."""
    sizes = np.log10(low), np.log10(high)
    return Numbers(-high, high, lambda rng, n: rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(*sizes, n))


def largest_error(error, numbers, is_valid, *, is_full, seed=1):
    """The largest `error(*arrays)` that a climb finds where `is_valid(*arrays)`, and its arguments."""
    n, rounds, keep, children = (1_000_000, 14, 2_000, 60) if is_full else (20_000, 8, 200, 20)
    rng = np.random.default_rng(seed)

    def tried(arguments):
        arguments = [np.clip(x, own.low, own.high) for x, own in zip(arguments, numbers, strict=True)]
        good = is_valid(*arguments)
        found = np.asarray(error(*(np.where(good, x, x[good][0]) for x in arguments)), dtype=np.float64)
        assert not np.any(np.isnan(found)), "a NaN would hide an error"
        return arguments, np.where(good, found, -1.0)

    with np.errstate(all="ignore"):
        arguments, found = tried([own.draw(rng, n) for own in numbers])
        for _ in range(rounds):
            top = np.argpartition(-found, keep)[:keep]
            step = 10.0 ** rng.uniform(-16, -0.5, (keep, children))
            moved = []
            for x in (argument[top] for argument in arguments):
                factor = 1.0 + step * rng.standard_normal(step.shape) * (rng.random(step.shape) < 0.75)
                to_one = rng.random(step.shape) < 0.2  # steps on the scale of the distance to 1
                new = np.where(to_one, 1.0 - (1.0 - x[:, None]) * factor, x[:, None] * factor)
                moved.append(np.concatenate([x, new.ravel()]))
            arguments, found = tried(moved)
    worst = int(np.argmax(found))
    return found[worst], tuple(float(x[worst]) for x in arguments)
