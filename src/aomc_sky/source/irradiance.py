"""Absolute units of a scene: the irradiance of every component, and the light that the horizon takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import SceneError


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

    def as_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of a plan."""
        return {"irradiance_W_m2_nm": self.of_component, "horizon_loss": self.horizon_loss}
