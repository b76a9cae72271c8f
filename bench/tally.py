"""Sums and a histogram over photons, batch by batch, compiled: `quantities.Tally` calls it."""

from __future__ import annotations

import numpy as np

from aomc_sky.kernels.jit import inner, kernel

_BLOCK = 2048


@inner
def _moments(z, sums):
    """Sums of mu and 1 / mu, in float64 and in the order of the photons."""
    mu_sum = 0.0
    inverse_sum = 0.0
    for j in range(z.size):
        mu = -np.float64(z[j])
        mu_sum += mu
        inverse_sum += 1.0 / mu
    sums[0] += mu_sum
    sums[1] += inverse_sum


@inner
def _regions(x, y, z, cone, ring, sums):
    """Photons in the cone and in the ring."""
    n_cone = 0
    n_ring = 0
    for j in range(z.size):
        n_cone += 1 if -(x[j] * cone[0] + y[j] * cone[1] + z[j] * cone[2]) > cone[3] else 0
    for j in range(z.size):
        n_ring += 1 if (-z[j] > ring[0]) & (-z[j] <= ring[1]) else 0
    sums[2] += n_cone
    sums[3] += n_ring


@inner
def _rows(z, row_mu, row):
    """Row of each photon: how many of the falling cosines lie above its own."""
    row[:] = 0
    for k in range(row_mu.size):
        edge = row_mu[k]
        for j in range(z.size):
            row[j] += np.int32(1) if -z[j] < edge else np.int32(0)


@inner
def _sectors(x, y, starts, sector):
    """Sector of each photon, without an angle.

    In the first half turn it is the last whose start lies to the right of the direction, so the number of such
    starts gives it; in the second half the same number runs backwards.
    """
    n_half = np.int32(starts.shape[0])
    sector[:] = 0
    for k in range(n_half):
        cosine, sine = starts[k]
        for j in range(x.size):
            sector[j] += np.int32(1) if x[j] * sine >= y[j] * cosine else np.int32(0)
    cosine, sine = starts[0]
    for j in range(x.size):
        n = sector[j]
        sector[j] = n - 1 if x[j] * sine >= y[j] * cosine else 2 * n_half - 1 - n


@kernel
def tally(ux, uy, uz, cone, ring, row_mu, starts, sums, histogram):
    """Add the photons of a batch to `sums` and `histogram`.

    `cone` is the sky direction of its axis and the cosine of its half-angle; `ring` its lower (not included) and upper
    (included) cosine; `row_mu` the falling cosines between the rows; `starts` (n_sector / 2, 2) cosine and sine of the
    starts of the first half of the equal sectors, in sky azimuth. `sums` holds the sums of mu and 1 / mu and the
    photons in the cone and in the ring, `histogram` int64 (n_row, n_sector) photons.
    """
    row = np.empty(_BLOCK, np.int32)
    sector = np.empty(_BLOCK, np.int32)
    for lo in range(0, ux.size, _BLOCK):
        hi = min(lo + _BLOCK, ux.size)
        x, y, z = ux[lo:hi], uy[lo:hi], uz[lo:hi]
        r, s = row[: hi - lo], sector[: hi - lo]
        _moments(z, sums)
        _regions(x, y, z, cone, ring, sums)
        _rows(z, row_mu, r)
        _sectors(x, y, starts, s)
        for j in range(r.size):
            histogram[r[j], s[j]] += 1
