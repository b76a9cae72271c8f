"""One waveband of a plan: its numbers, without the photons of its cells."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class PlanBand:
    """One waveband of a plan."""

    wavelength_nm: float  #: [nm]
    sky_wavelength_nm: float  #: of the sky that it takes; NaN where the sky has none [nm]
    requested: int  #: photons of all replicates together
    row: int  #: of the components' masses, weights and slopes
    #: Irradiance of each component on a horizontal plane, None where it is not known. [W m-2 nm-1]
    irradiance_W_m2_nm: tuple[float, ...] | None = None  # noqa: N815
    #: Of the light of the lobes, the share that comes from below the horizon and sends no photons. [0 to 1]
    horizon_loss: float = 0.0
