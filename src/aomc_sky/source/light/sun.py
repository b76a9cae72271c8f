"""The sun of a scene, and how bright sun and sky are by irradiances, or by clearness and brightness."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import InputWarning, ModelLimitWarning, SceneError
from aomc_sky.formats.sky_toml.sections import PerezSection

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


#: Median sky brightness of each bin of clearness in 15 900 hours (Z < 85 degrees) of four public weather files.
MEDIAN_DELTA = (0.18, 0.30, 0.31, 0.29, 0.25, 0.18, 0.14, 0.09)


def refuse_kilowatts(amounts: PerezSection, sun: Sun) -> None:
    """Raise if irradiances are probably in kW m-2."""
    from aomc_sky.skies.perez.irradiances import kilowatts

    if text := kilowatts((amounts.ghi, amounts.dni, amounts.dhi), sun.zenith_deg):
        raise SceneError(f"{amounts}: {text}")


def direct_fraction(amounts: PerezSection, sun: Sun) -> float | None:
    """Share of the beam, dni cos Z / (dni cos Z + dhi); or None with coefficients alone. [0 to 1]"""
    if amounts.coefficients is not None:
        return None
    if amounts.epsilon is not None:
        from aomc_sky.skies.perez.coefficients import beam_ratio

        beam, diffuse = beam_ratio(amounts.epsilon, math.radians(sun.zenith_deg)) * sun.cosine, 1.0
    else:
        normal, diffuse = irradiances(amounts, sun)
        beam = normal * sun.cosine
    if beam + diffuse == 0:
        raise SceneError(f"{amounts} leave no light at all")
    return 1.0 if beam + diffuse == math.inf else beam / (beam + diffuse)


def irradiances(amounts: PerezSection, sun: Sun) -> tuple[float, float]:
    """Direct normal and diffuse horizontal irradiance; of epsilon and Delta at the sun's mean distance. [W m-2]"""
    if amounts.epsilon is None:
        from aomc_sky.skies.perez.irradiances import closed_irradiances

        return closed_irradiances(
            ghi=amounts.ghi,
            dni=amounts.dni,
            dhi=amounts.dhi,
            sun_zenith_deg=sun.zenith_deg,
            extraterrestrial_normal=sun.extraterrestrial_normal,
        )
    from aomc_sky.skies.perez.coefficients import beam_ratio, sky_brightness

    zenith = math.radians(sun.zenith_deg)
    diffuse = (amounts.delta or 0.0) / float(sky_brightness(1.0, zenith))
    return beam_ratio(amounts.epsilon, zenith) * diffuse, diffuse


def perez_arguments(amounts: PerezSection, sun: Sun) -> dict[str, Any]:
    """Arguments of `PerezSky`: coefficients, epsilon and delta, or dni and dhi."""
    from aomc_sky.skies.perez.irradiances import dhi_exceeds_ghi

    if amounts.coefficients is not None:
        return {"coefficients": amounts.coefficients}
    if amounts.epsilon is not None:
        return {"epsilon": amounts.epsilon, "delta": amounts.delta}
    direct, diffuse = irradiances(amounts, sun)
    if diffuse == 0:
        raise SceneError(
            f"{amounts} leave no light for the sky, but bands have diffuse light; give a "
            "positive diffuse irradiance, or direct fractions of 1"
        )
    if is_exceeded := dhi_exceeds_ghi(amounts.ghi, amounts.dni, amounts.dhi):
        warnings.warn(is_exceeded, ModelLimitWarning, stacklevel=2)
    return {"dni": direct, "dhi": diffuse}


def amounts_of_fractions(fractions: np.ndarray, weight: np.ndarray, sun: Sun, origin: str) -> PerezSection:
    """Sky clearness of the photons' mean direct fraction f, and the median brightness of its bin.

    epsilon = 1 + [f / ((1 - f) cos Z)] / (1 + 1.041 Z^3), Delta of `MEDIAN_DELTA`; at least one band with light has a
    direct fraction below 1. Always warns: wavebands are not the whole spectrum.
    """
    from aomc_sky.skies.perez.functions import epsilon_bin, sky_clearness

    mean = mean_fraction(fractions, weight)
    weight = weight / weight.max() if np.any(weight > 0) else np.ones_like(weight)
    diffuse = float(np.sum(weight * (1.0 - fractions)) / np.sum(weight))
    epsilon = float(sky_clearness(mean / sun.cosine, diffuse, math.radians(sun.zenith_deg)))
    warnings.warn(
        f"{origin}: the sky's clearness is computed from the direct fraction; from bands within 400 to 700 nm it is "
        "too low, often by a bin; give dni and dhi in sky.toml or as options",
        InputWarning,
        stacklevel=2,
    )
    words = f"the mean direct fraction {mean:.4g} and the median brightness of that clearness"
    delta = MEDIAN_DELTA[int(epsilon_bin(epsilon))]
    return PerezSection(epsilon=epsilon, delta=delta, origin=origin, words=words)


def mean_fraction(fractions: np.ndarray, weight: np.ndarray) -> float:
    """Direct fraction of all photons; without any light, of all bands alike."""
    weight = weight / weight.max() if np.any(weight > 0) else np.ones_like(weight)  # sums of huge ones stay finite
    return float(np.sum(weight * fractions) / np.sum(weight))
