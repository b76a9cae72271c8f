"""The smallest host of all: a loop that asks for every photon by its index and adds the directions up."""

from __future__ import annotations

from aomc_sky.kernels.jit import inner


def make_loop(sample):
    """Return a jitted ``loop(n)`` that takes the photons 0 to n - 1 from a jitted ``sample(i) -> (ux, uy, uz)``.

    The sums of the three components come back, so that no part of the photons can be left out.
    """

    @inner
    def loop(n):
        x_sum, y_sum, z_sum = 0.0, 0.0, 0.0
        for i in range(n):
            x, y, z = sample(i)
            x_sum += x
            y_sum += y
            z_sum += z
        return x_sum, y_sum, z_sum

    return loop
