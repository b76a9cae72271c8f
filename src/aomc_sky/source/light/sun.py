"""The sun of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from aomc_sky.directions import sin_cos_deg

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern


@dataclass(frozen=True, kw_only=True, slots=True)
class Sun:
    """The sun: `zenith_deg` [0 to 90), `azimuth_deg` from +x towards +y, `disc`, and who said so."""

    zenith_deg: float
    azimuth_deg: float
    disc: bool = False
    origin: str = "amc.inp"
    #: on a plane that faces the sun outside the air, as in skies/perez, which scenes of tables do not load [W m-2]
    extraterrestrial_normal: float = 1361.1
    distance_factor: float | None = None  #: of the irradiance at the mean distance; None without a date
    polarisation: RayleighPattern | None = None  #: of the sky's light

    @property
    def cosine(self) -> float:
        """Cosine of the zenith angle."""
        return float(sin_cos_deg(self.zenith_deg)[1])

    @property
    def rad(self) -> tuple[float, float]:
        """Zenith angle and azimuth. [rad]"""
        return math.radians(self.zenith_deg), math.radians(self.azimuth_deg)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a scene says of the polarisation of its sky."""
        if self.polarisation is None:
            return ()
        return (
            f"polarisation of the sky: Rayleigh's pattern, largest degree {self.polarisation.max_degree:g}, around the "
            f"sun at a zenith angle of {self.zenith_deg:g} and an azimuth of {self.azimuth_deg:g} degrees",
        )

    def as_options(self) -> dict[str, Any]:
        """JSON values for a manifest."""
        return {
            "zenith_deg": self.zenith_deg,
            "azimuth_deg": self.azimuth_deg,
            "disc": self.disc,
            "from": self.origin,
            **({} if self.polarisation is None else {"polarisation": self.polarisation.max_degree}),
        }
