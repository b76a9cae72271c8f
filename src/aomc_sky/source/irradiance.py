"""Absolute units of a scene: the irradiance of every component, and the light that the horizon takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component
from aomc_sky.errors import SceneError
from aomc_sky.source.moments import cell_moments


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
        given: np.ndarray | None = self.horizon_loss
        irradiance = np.array(self.of_component, dtype=np.float64)
        loss = np.zeros(irradiance.shape[:1]) if given is None else np.array(given, dtype=np.float64)
        if irradiance.ndim != 2 or loss.shape != irradiance.shape[:1]:
            raise SceneError("absolute irradiances have one row for each waveband and one column for each component")
        if not np.all((irradiance >= 0.0) & (irradiance < np.inf)) or not np.all((loss >= 0.0) & (loss <= 1.0)):
            raise SceneError("absolute irradiances must be finite and not negative, the horizon loss a share")
        for name, array in (("of_component", irradiance), ("horizon_loss", loss)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @classmethod
    def of_components(cls, components: Sequence[Component], row_of_band: np.ndarray) -> Irradiance | None:
        """What components say of themselves; None where one of them is relative.

        Parameters
        ----------
        components : sequence of Component
            Components of a scene.
        row_of_band : ndarray, int64, shape (n_band,)
            Row of the components that serves each band.
        """
        known = [c.irradiance_W_m2_nm for c in components if c.irradiance_W_m2_nm is not None]
        if len(known) < len(components):
            return None
        plane = np.stack(known)
        above = np.stack([_over_hemisphere(c, row) for c, row in zip(components, plane, strict=True)])
        kept = np.array([1.0 - c.below_horizon for c in components])[:, None]
        whole = np.divide(above, kept, out=np.zeros_like(above), where=kept > 0)
        is_lobe = np.array([c.law.is_lobe for c in components])[:, None]
        sphere, lost = np.sum(whole * is_lobe, axis=0), np.sum((whole - above) * is_lobe, axis=0)
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
