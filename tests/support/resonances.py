"""Errors of equal patches over seeds, and the grids whose rings are nearly a period of the steps of the places."""

from fractions import Fraction

import numpy as np

from bench.quantities import FIRST_SECTOR_DEG, N_ROWS, N_SECTORS, histogram_grid
from tests.support.sampled import scene, table_of

STEPS = {"u": 13925035116211876495, "v": 10511698010929265437, "ring": 0x9E3779B97F4A7C15}
"""The steps of the places as fractions of 2^64, and the golden ratio between rings."""

CONES = ((33.37, 217.71, 5.0), (33.37, 217.71, 20.0), (55.0, 100.3, 5.0), (55.0, 100.3, 20.0))
"""Zenith angle, azimuth and half angle, off the edges of the grids. [deg]"""


def denominators(step, largest):
    """Denominators up to `largest` of the convergents and the intermediate fractions of step / 2^64."""
    found, rest, before, last = [], Fraction(step, 1 << 64), 0, 1
    while rest.numerator and last <= largest:
        rest = 1 / rest
        whole = int(rest)
        rest -= whole
        found += [before + k * last for k in range(1, min(whole, largest) + 1)]
        before, last = last, before + whole * last
    return sorted({q for q in found if q <= largest})


def resonant_rings(smallest, largest):
    """Photons of a ring that are nearly a period of either step, or twice one."""
    either = {q for name in ("u", "v") for q in denominators(STEPS[name], largest)}
    return sorted(q for q in either | {2 * q for q in either} if smallest <= q <= largest)


class EqualPatches:
    """A grid of equal patches with `each` photons in each of them, and the errors of its photons.

    Places are functions of a seed: the patches (n,), and u along the flux and v along the azimuth in them.
    """

    def __init__(self, n_zenith, n_azimuth, each=1):
        self.n_zenith, self.n_azimuth, self.each = n_zenith, n_azimuth, each
        self.n = n_zenith * n_azimuth * each
        self._edges = np.sin(np.deg2rad(np.arange(n_zenith + 1) * 90.0 / n_zenith)) ** 2
        grid = histogram_grid()
        self._rows = 1.0 - grid.mu_edges[1:-1] ** 2
        self.truth = self._truth()

    def errors(self, places, seeds):
        """Relative root mean square error of every quantity over seeds."""
        squares = dict.fromkeys(self.truth, 0.0)
        for seed in range(seeds):
            found = self.quantities(*places(seed))
            for name, true in self.truth.items():
                squares[name] += float(np.sum((found[name] - true) ** 2) / np.sum(np.square(true)))
        return {name: float(np.sqrt(square / seeds)) for name, square in squares.items()}

    def errors_of_independent(self):
        """The same of independent photons, in closed form but for `planar`, which has no share."""
        norms = {name: float(np.sqrt(np.sum(np.square(true)))) for name, true in self.truth.items()}
        variance = {name: float(np.sum(true * (1.0 - true))) / self.n for name, true in self.truth.items()}
        return {name: float(np.sqrt(variance[name])) / norms[name] for name in self.truth if name != "planar"}

    def quantities(self, patch, u, v):
        """Shares of photons, and for `planar` the mean of mu."""
        ring, column = np.divmod(patch, self.n_azimuth)
        sin2 = self._edges[ring] + np.diff(self._edges)[ring] * u
        mu, sine = np.sqrt(1.0 - sin2), np.sqrt(sin2)
        azimuth = (column + v) * (2 * np.pi / self.n_azimuth)
        from_edge = column + v - self.n_azimuth // 3
        turned = np.mod(np.rad2deg(azimuth) - FIRST_SECTOR_DEG, 360.0)
        row = np.searchsorted(self._rows, sin2, side="right")
        sector = np.minimum((turned / (360.0 / N_SECTORS)).astype(int), N_SECTORS - 1)
        found = {
            "planar": mu.mean(),
            "half a column": np.mean((from_edge >= 0) & (from_edge < 0.5)),
            "a third of a column": np.mean((from_edge >= 0.2) & (from_edge < 0.2 + 1 / 3)),
            "half-plane": np.mean(turned < 180.0),
            "histogram": np.bincount(row * N_SECTORS + sector, minlength=N_ROWS * N_SECTORS) / patch.size,
        }
        cosine, east, north = mu, sine * np.cos(azimuth), sine * np.sin(azimuth)
        for k, (zenith, towards, half) in enumerate(CONES):
            z, a = np.deg2rad([zenith, towards])
            inside = cosine * np.cos(z) + np.sin(z) * (east * np.cos(a) + north * np.sin(a)) >= np.cos(np.deg2rad(half))
            found[f"cone {k}"] = np.mean(inside)
        return found

    def _truth(self):
        """Exact where a closed form is known, else the mean over a fine lattice in every patch."""
        points = max(6, int(np.sqrt(2e5 / (self.n_zenith * self.n_azimuth))))
        middle = (np.arange(points) + 0.5) / points
        u, v = (x.ravel() for x in np.meshgrid(middle, middle, indexing="ij"))
        n_patch = self.n_zenith * self.n_azimuth
        found = self.quantities(np.repeat(np.arange(n_patch), u.size), np.tile(u, n_patch), np.tile(v, n_patch))
        mu = np.sqrt(1.0 - self._edges)
        mean_mu = np.mean(2 / 3 * (mu[:-1] ** 3 - mu[1:] ** 3) / np.diff(self._edges))
        width = 1.0 / self.n_azimuth
        return found | {
            "planar": mean_mu,
            "half a column": width / 2,
            "a third of a column": width / 3,
            "half-plane": 0.5,
        }

    def emitted(self, **options):
        """The places of the package's own photons, read off their directions in float64."""
        known = scene(table_of(np.ones((self.n_zenith, self.n_azimuth))), self.n)

        def places(seed):
            batch = known.source(seed=seed, precision="float64", order="patch", **options).photons()
            ring, column = np.divmod(batch.patch.astype(np.int64), self.n_azimuth)
            sin2 = np.square(batch.ux) + np.square(batch.uy)
            turns = np.arctan2(-batch.uy, -batch.ux) / (2 * np.pi) * self.n_azimuth
            v = np.mod(turns - column + 0.5, self.n_azimuth) - 0.5
            u = (sin2 - self._edges[ring]) / np.diff(self._edges)[ring]
            return batch.patch.astype(np.int64), np.clip(u, 0.0, 1.0), np.clip(v, 0.0, 1.0 - 1e-12)

        return places

    def by_rank(self, golden=False):
        """Places by the rank in the band alone, as up to `aomc-sky/1`; `golden` adds ring x golden ratio to v."""

        def places(seed):
            rank = np.arange(self.n, dtype=np.uint64)
            patch = (rank // np.uint64(self.each)).astype(np.int64)
            shift = np.random.default_rng([seed, self.n]).integers(0, 1 << 64, 2, dtype=np.uint64)
            u = shift[0] + rank * np.uint64(STEPS["u"])
            v = shift[1] + rank * np.uint64(STEPS["v"])
            if golden:
                v = v + (patch // self.n_azimuth).astype(np.uint64) * np.uint64(STEPS["ring"])
            return patch, u * 2.0**-64, v * 2.0**-64

        return places

    def jittered(self):
        """Independent places, the same counts."""

        def places(seed):
            rng = np.random.default_rng([seed, self.n, 1])
            return np.arange(self.n) // self.each, rng.random(self.n), rng.random(self.n)

        return places


def grids(rings, smallest=5, largest=400):
    """Rings, columns and photons of a patch (one, two or four) for every resonant number of photons of a ring."""
    for photons in resonant_rings(smallest, largest):
        for each in (1, 2, 4):
            if photons % each == 0 and photons // each >= smallest:
                for n_zenith in rings:
                    yield n_zenith, photons // each, each
