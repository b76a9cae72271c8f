"""Irradiance of a scene: in absolute units of each component, and planar over scalar of a band's photons.

`cell_moments` gives the exact means of mu and 1/mu over the cells of each law. The sums of a run are compared with
them, and they turn planar into scalar irradiance.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import SceneError, UsageError, shown_value
from aomc_sky.plan.laws import law_of
from aomc_sky.record import same_content


@dataclass(frozen=True, kw_only=True, slots=True)
class Moments:
    """Exact means over the photons of a band."""

    mean_mu: float  #: mean cosine of the zenith angle of launched photons [0 to 1; NaN without light]
    mean_inverse_mu: float  #: scalar over planar irradiance of flux-law photons [1 to inf]

    #: Ed / Eo = 1 / mean(1 / mu), 0 where the mean of 1 / mu diverges
    planar_over_scalar: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "planar_over_scalar", 1.0 / self.mean_inverse_mu)


def cell_moments(components: tuple[Component, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Mean of mu and of 1 / mu over each cell of the components, (n_cell,) each.

    Relative error below 1e-14; for a disc at the horizon below 1e-12, for a Perez sky see `skies.perez.patches`.
    """
    parts = [law_of(c.law).moments(c) for c in components]
    return np.concatenate([mean for mean, _ in parts]), np.concatenate([inverse for _, inverse in parts])


def mean_moments(mass: np.ndarray, mean_mu: np.ndarray, mean_inverse_mu: np.ndarray) -> Moments:
    """Moments of a band from those of its cells; cells without mass do not count."""
    lit = mass > 0
    if not lit.any():
        return Moments(mean_mu=float("nan"), mean_inverse_mu=float("nan"))
    share = mass[lit] / mass[lit].sum()
    # sums of numpy: a product of BLAS wakes its threads, and has other last digits with another number of them
    mu, inverse = (float(np.sum(share * moment[lit])) for moment in (mean_mu, mean_inverse_mu))
    return Moments(mean_mu=mu, mean_inverse_mu=inverse)


def moments_of_rows(masses: Iterable[np.ndarray], mean_mu: np.ndarray, mean_inverse_mu: np.ndarray) -> list[Moments]:
    """`mean_moments` of several masses of the same cells."""
    return [mean_moments(mass, mean_mu, mean_inverse_mu) for mass in masses]


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Irradiance:
    """Irradiance of a horizontal plane by each component of a scene and waveband.

    Parameters
    ----------
    of_component : array_like, float64, shape (n_band, n_component)
        Irradiance of the light from above the horizon on a horizontal plane. [W m-2 nm-1, >= 0]
    horizon_loss : array_like, float64, shape (n_band,), optional
        Of the light of the lobes, integrated over the sphere, the share that comes from below the horizon and
        sends no photons; 0 without lobes. [0 to 1]
    component_names : tuple of str, optional
        Names of the columns; a scene fills in those of its components.

    Examples
    --------
    >>> scene = sky.weather_scene(
    ...     wavebands=[443.0, 555.0], sun_zenith_deg=40.0, spectrum="spectrl2"
    ... )
    >>> scene.irradiance
    Irradiance(direct 0.912 to 1.09, perez 0.186 to 0.296, total 1.21 to 1.28 W m-2 nm-1)
    >>> print(scene.irradiance.of("direct").round(3))
    [0.912 1.092]
    """

    of_component: np.ndarray
    horizon_loss: np.ndarray = None  # type: ignore[assignment]
    component_names: tuple[str, ...] = ()

    __eq__ = same_content

    def __repr__(self) -> str:
        named = [*zip(self.component_names, self.of_component.T, strict=False), ("total", self.total)]
        return f"Irradiance({', '.join(f'{name} {_spread(values)}' for name, values in named)} W m-2 nm-1)"

    @property
    def total(self) -> np.ndarray:
        """Irradiance of all components together, (n_band,). [W m-2 nm-1]"""
        return self.of_component.sum(axis=1)

    def of(self, name: str) -> np.ndarray:
        """Irradiance of the component of this name, (n_band,). [W m-2 nm-1]"""
        if name not in self.component_names:
            raise UsageError(f"there is no component {name!r}", f"the names are {', '.join(self.component_names)}")
        return self.of_component[:, self.component_names.index(name)]

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
        names = self.component_names
        if not isinstance(names, tuple) or (names and len(names) != irradiance.shape[1]):
            raise SceneError(f"component_names are a tuple, one name for each column, got {shown_value(names)}")

    @classmethod
    def of_components(cls, components: Sequence[Component], row_of_band: np.ndarray) -> Irradiance | None:
        """The irradiances of components, by the row (n_band,) of each band. Any relative component gives None."""
        known = [c.irradiance_W_m2_nm for c in components if c.irradiance_W_m2_nm is not None]
        if len(known) < len(components):
            return None
        plane = np.stack(known)
        # light of lobes over the hemisphere: that of the horizontal plane times the mean of 1 / mu; 0 for other laws
        above = np.array([law_of(c.law).moments(c)[1][0] if law_of(c.law).covers_sky else 0.0 for c in components])
        above, kept = above[:, None] * plane, np.array([1.0 - c.below_horizon for c in components])[:, None]
        total = np.divide(above, kept, out=np.zeros_like(above), where=kept > 0)
        sphere, lost = np.sum(total, axis=0), np.sum(total - above, axis=0)
        loss = np.divide(lost, sphere, out=np.zeros_like(lost), where=sphere > 0)
        return cls(of_component=plane.T[row_of_band], horizon_loss=np.clip(loss, 0.0, 1.0)[row_of_band])


def _spread(values: np.ndarray) -> str:
    """The range of an irradiance over the wavebands."""
    if not values.size:
        return "none"
    low, high = (f"{float(end):.3g}" for end in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"
