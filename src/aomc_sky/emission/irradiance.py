"""Irradiance of a scene: in absolute units of each component, and planar over scalar of a band's photons.

`cell_moments` gives the exact means of mu and 1/mu over the cells of each law: the books of a run are compared with
them, and an irradiance of the horizontal plane becomes that of a sphere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law, are_lobes
from aomc_sky.errors import SceneError
from aomc_sky.plan.options import Placement
from aomc_sky.plan.plan import Plan

_GAUSS_POINTS = 64


@dataclass(frozen=True, kw_only=True, slots=True)
class Moments:
    """Exact means over the photons of a band."""

    mean_mu: float  #: mean cosine of the zenith angle of launched photons [0 to 1; NaN without light]
    mean_inverse_mu: float  #: scalar over planar irradiance of flux-law photons [1 to inf]

    @property
    def planar_over_scalar(self) -> float:
        """Ed / Eo = 1 / mean(1 / mu), 0 where the mean of 1 / mu diverges."""
        return 1.0 / self.mean_inverse_mu


def _cell_mu2(head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    far, near = np.sqrt(head[:, 2]), np.sqrt(head[:, 2] + head[:, 1])
    total = near + far
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (2.0 / 3.0) * (near * near + near * far + far * far) / total
        inverse = 2.0 / total
    return np.where(total > 0, mean, 0.0), inverse


def _cell_mu(head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    far, growth = head[:, 2], head[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = growth / far
        inverse = np.where(far > 0, np.where(ratio > 0, np.log1p(ratio) / growth, 1.0 / far), np.inf)
    return far + growth / 2.0, inverse


def _disc(head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    sin_z, cos_z, sin_r, cos_r = head.T
    drop = sin_r**2 / (1.0 + cos_r)  # 1 - cos r without cancellation
    along = cos_z**2 * drop * (1 + cos_r + cos_r**2) / 3.0
    across = sin_z**2 / 2.0 * drop**2 * (1 - drop / 3.0)
    return 2.0 * (along + across) / (sin_r**2 * cos_z), 2.0 * drop / (sin_r**2 * cos_z)


def _disc_at_horizon(head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points in s with mu = top (1 - s^2), which takes the root at the upper rim away."""
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    s, weights = (nodes + 1) / 2, weights / 2
    mean, inverse = np.empty(head.shape[0]), np.empty(head.shape[0])
    for k, (top2, _, chord2, cos_z) in enumerate(head):
        top = np.sqrt(top2)
        mu = top * (1 - s * s)
        sin_z = np.sqrt(1 - cos_z**2)
        # chord^2 = (difference of heights)^2 + (difference of radii)^2 + 4 r r' sin^2(azimuth / 2)
        radius = np.sqrt(1 - mu * mu)
        rest = chord2 - (mu - cos_z) ** 2 - (radius - sin_z) ** 2
        width = 2 * np.arcsin(np.sqrt(np.clip(rest / (4 * radius * sin_z), 0.0, 1.0)))
        measure = weights * 2 * top * s * width
        flux = np.sum(measure * mu)
        mean[k], inverse[k] = np.sum(measure * mu * mu) / flux, np.sum(measure) / flux
    return mean, inverse


def _lobe(head: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both stand in the cell."""
    return head[:, 0], head[:, 2]


_OF_LAW = {
    Law.CELL_MU2: _cell_mu2,
    Law.BEAM: _cell_mu2,
    Law.CELL_MU: _cell_mu,
    Law.DISC: _disc,
    Law.DISC_AT_HORIZON: _disc_at_horizon,
    Law.HG: _lobe,
    Law.GGX: _lobe,
    Law.BECKMANN: _lobe,
}


def _perez(component: Component) -> tuple[np.ndarray, np.ndarray]:
    from aomc_sky.skies.perez.patches import patch_moments

    grid, shared = component.grid, component.shared
    assert grid is not None
    assert shared is not None
    mean, inverse = patch_moments(grid.zenith_bounds_deg / 90.0, grid.azimuth_bounds_deg / 90.0, shared)
    return mean.ravel(), inverse.ravel()


def cell_moments(components: tuple[Component, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Mean of mu and of 1 / mu over each cell of the components, (n_cell,) each.

    Relative error below 1e-14; for a disc at the horizon below 1e-10, for a Perez sky see `skies.perez.patches`.
    """
    parts = [_perez(c) if c.law is Law.PEREZ else _OF_LAW[c.law](c.cell[:, :4]) for c in components]
    return np.concatenate([mean for mean, _ in parts]), np.concatenate([inverse for _, inverse in parts])


def mean_moments(mass: np.ndarray, mean_mu: np.ndarray, mean_inverse_mu: np.ndarray) -> Moments:
    """Moments of a band from those of its cells; cells without mass do not count."""
    lit = mass > 0
    if not lit.any():
        return Moments(mean_mu=float("nan"), mean_inverse_mu=float("nan"))
    share = mass[lit] / mass[lit].sum()
    # sums of numpy: a product of BLAS wakes its threads, and has other last digits with another number of them
    mu, inverse = (float(np.sum(share * of_cells[lit])) for of_cells in (mean_mu, mean_inverse_mu))
    return Moments(mean_mu=mu, mean_inverse_mu=inverse)


def scalar_has_variance(plan: Plan, band: int) -> bool:
    """Whether w / mu of a band's photons has a finite variance: no light down to the horizon, or weights that tame it.

    Next to the horizon the flux law has the density 2 mu in mu, so that the mean of 1 / mu is finite and that of
    1 / mu^2 grows like a logarithm without bound.
    """
    if plan.options["placement"] == Placement.CENTRE.value:
        return True  # a finite number of directions
    arrays = plan.arrays
    lit = arrays["mass"][arrays["row_of_band"][band]] > 0
    law, cell = arrays["law"], arrays["cell"]
    is_tamed = (law == Law.CELL_MU) & (arrays["weight"].size > 0)  # their weight carries a factor mu
    touches = np.where(law == Law.DISC, cell[:, 1] <= cell[:, 2], cell[:, 2] <= 0)  # cos z <= sin r; far edge at mu 0
    touches = (touches | (law == Law.DISC_AT_HORIZON) | are_lobes(law)) & ~is_tamed
    return not bool(np.any(lit & touches))


@dataclass(frozen=True, kw_only=True, slots=True)
class Irradiance:
    """What a horizontal plane receives from each component of a scene, waveband by waveband.

    Parameters
    ----------
    of_component : array_like, float64, shape (n_band, n_component)
        Irradiance of the light from above the horizon on a horizontal plane. [W m-2 nm-1, >= 0]
    horizon_loss : array_like, float64, shape (n_band,), optional
        Of the light of the lobes, integrated over the sphere, the share that comes from below the horizon and
        sends no photons; 0 without lobes. [0 to 1]
    """

    of_component: np.ndarray
    horizon_loss: np.ndarray = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        horizon_loss: np.ndarray | None = self.horizon_loss
        irradiance = np.array(self.of_component, dtype=np.float64)
        loss = np.zeros(irradiance.shape[:1]) if horizon_loss is None else np.array(horizon_loss, dtype=np.float64)
        if irradiance.ndim != 2 or loss.shape != irradiance.shape[:1]:
            raise SceneError("absolute irradiances have one row for each waveband and one column for each component")
        if not np.all((irradiance >= 0.0) & (irradiance < np.inf)) or not np.all((loss >= 0.0) & (loss <= 1.0)):
            raise SceneError(
                "absolute irradiances must be finite and not negative, and the horizon loss must lie from 0 to 1"
            )
        for name, array in (("of_component", irradiance), ("horizon_loss", loss)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @classmethod
    def of_components(cls, components: Sequence[Component], row_of_band: np.ndarray) -> Irradiance | None:
        """What components say of themselves, by the row (n_band,) that serves each band; None where one is relative."""
        known = [c.irradiance_W_m2_nm for c in components if c.irradiance_W_m2_nm is not None]
        if len(known) < len(components):
            return None
        plane = np.stack(known)
        above = np.stack([_over_hemisphere(c, row) for c, row in zip(components, plane, strict=True)])
        kept = np.array([1.0 - c.below_horizon for c in components])[:, None]
        total = np.divide(above, kept, out=np.zeros_like(above), where=kept > 0)
        is_lobe = np.array([c.law.is_lobe for c in components])[:, None]
        sphere, lost = np.sum(total * is_lobe, axis=0), np.sum((total - above) * is_lobe, axis=0)
        loss = np.divide(lost, sphere, out=np.zeros_like(lost), where=sphere > 0)
        return cls(of_component=plane.T[row_of_band], horizon_loss=np.clip(loss, 0.0, 1.0)[row_of_band])

    def as_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of a plan."""
        return {"irradiance_W_m2_nm": self.of_component, "horizon_loss": self.horizon_loss}


def _over_hemisphere(component: Component, plane: np.ndarray) -> np.ndarray:
    """Irradiance of a lobe integrated over the hemisphere, from that of the horizontal plane."""
    if not component.law.is_lobe:
        return np.zeros_like(plane)
    over: np.ndarray = plane * cell_moments((component,))[1][0]  # the mean of 1 / mu
    return over
