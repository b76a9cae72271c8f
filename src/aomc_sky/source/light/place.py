"""Where is the sun? Angles, a time and a place, an hour of a weather file, or amc.inp."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.options import say
from aomc_sky.source.light.said import Speakers, first, moment_said, sun_said

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

AMC = "amc.inp"


@dataclass(frozen=True, kw_only=True, slots=True)
class Sun:
    """The sun: `zenith_deg` [0 to 90), `azimuth_deg` from +x towards +y, `disc`, and who said so."""

    zenith_deg: float
    azimuth_deg: float
    disc: bool = False
    origin: str = AMC
    #: on a plane that faces the sun outside the air, as in skies/perez, which scenes of tables do not load [W m-2]
    extraterrestrial_normal: float = 1361.1
    distance_factor: float | None = None  #: of the irradiance at the mean distance; None without a date
    polarisation: RayleighPattern | None = None  #: of the sky's light, around this sun

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


def place_of(speakers: Speakers, sky: str, *, may_have_set: bool = False) -> Sun:
    """The sun; an error where nothing says where it is, or where it has set, in which case `sky` is dark."""
    said, moment = sun_said(speakers), moment_said(speakers)
    if said.zenith_deg is None:
        raise UsageError(
            say(
                f"where is the sun? {sky} needs {{zenith_deg}} (and {{azimuth_deg}} unless it is 0), or {{time}}, "
                "{latitude_deg} and {longitude_deg}"
            )
        )
    if said.zenith_deg >= 90.0 and not may_have_set and said.origin != AMC:
        if moment is not None:
            moment.require_sun()
        raise SceneError(
            f"a sky needs the sun above the horizon, 0 to below 90 degrees, got {said.zenith_deg:g} ({said.origin}); a "
            "sun that has set needs [atmosphere] in sky.toml"
        )
    constant = first([one.perez.model.get("extraterrestrial_normal") for one in speakers])
    if moment is not None:
        constant = moment.extraterrestrial_normal if constant is None else constant * moment.distance_factor
    outside = {} if constant is None else {"extraterrestrial_normal": float(constant)}
    return Sun(
        zenith_deg=said.zenith_deg,
        azimuth_deg=said.azimuth_deg or 0.0,
        disc=bool(said.disc),
        origin=said.origin,
        distance_factor=None if moment is None else moment.distance_factor,
        polarisation=first([one.polarisation for one in speakers]),
        **outside,
    )
