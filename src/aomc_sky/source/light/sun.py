"""The sun of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from aomc_sky.directions import sin_cos_deg


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

    @property
    def cosine(self) -> float:
        """Cosine of the zenith angle."""
        return float(sin_cos_deg(self.zenith_deg)[1])

    def as_options(self) -> dict[str, Any]:
        """JSON values for a manifest."""
        return {
            "zenith_deg": self.zenith_deg,
            "azimuth_deg": self.azimuth_deg,
            "disc": self.disc,
            "from": self.origin,
        }
