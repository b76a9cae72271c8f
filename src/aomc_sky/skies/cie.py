"""The fifteen general skies of the CIE, from overcast to clear."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import InitVar, dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.directions import in_both_units, settle_angles
from aomc_sky.errors import SceneError
from aomc_sky.skies.model import Share, check_share, sky_repr
from aomc_sky.skies.perez.sky import PerezSky
from aomc_sky.whole_number import as_number_of

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

TYPES = (
    (4.0, -0.70, 0.0, -1.0, 0.00),  # 1 overcast, steep gradation, the same all around
    (4.0, -0.70, 2.0, -1.5, 0.15),  # 2 overcast, steep gradation, a little brighter towards the sun
    (1.1, -0.80, 0.0, -1.0, 0.00),  # 3 overcast, moderately graded, the same all around
    (1.1, -0.80, 2.0, -1.5, 0.15),  # 4 overcast, moderately graded, a little brighter towards the sun
    (0.0, -1.00, 0.0, -1.0, 0.00),  # 5 uniform
    (0.0, -1.00, 2.0, -1.5, 0.15),  # 6 partly cloudy, no gradation, a little brighter towards the sun
    (0.0, -1.00, 5.0, -2.5, 0.30),  # 7 partly cloudy, no gradation, brighter around the sun
    (0.0, -1.00, 10.0, -3.0, 0.45),  # 8 partly cloudy, no gradation, a distinct corona
    (-1.0, -0.55, 2.0, -1.5, 0.15),  # 9 partly cloudy, the sun behind clouds
    (-1.0, -0.55, 5.0, -2.5, 0.30),  # 10 partly cloudy, brighter around the sun
    (-1.0, -0.55, 10.0, -3.0, 0.45),  # 11 white-blue, a distinct corona
    (-1.0, -0.32, 10.0, -3.0, 0.45),  # 12 clear, low turbidity
    (-1.0, -0.32, 16.0, -3.0, 0.30),  # 13 clear, polluted air
    (-1.0, -0.15, 16.0, -3.0, 0.30),  # 14 cloudless, turbid, a broad corona
    (-1.0, -0.15, 24.0, -2.8, 0.15),  # 15 white-blue, turbid, a broad corona
)
"""a, b of the gradation and c, d, e of the indicatrix of types 1 to 15: table 1 of ISO 15469:2004."""


@in_both_units
@dataclass(frozen=True, kw_only=True, slots=True)
class CIESky(Share):
    """One of the fifteen standard general skies of the CIE: radiance f(p) phi(z) / (f(Z) phi(0)).

    phi(z) = 1 + a exp(b / cos z) and f(p) = 1 + c (exp(d p) - exp(d pi/2)) + e cos^2 p. A sky element has the zenith
    angle z and the angle p from the sun; the sun has the zenith angle Z. ISO 15469:2004 (CIE S 011/E:2003), eqs. (1) to
    (6) and table 1; Darula and Kittler, Proc. eSim (2002). The luminance of the standard is taken as the relative
    radiance of every wavelength. It is the law of Perez times a constant, so photons follow it exactly inside patches.
    The direct beam is not in it.

    Parameters
    ----------
    type : int
        1 to 5 overcast to uniform, 6 to 10 partly cloudy, 11 to 15 clear; 12 is the clear sky of low turbidity. Type 1
        is close to `OvercastSky`: within 0.1 of the zenith's radiance. [1 to 15]
    sun_zenith_deg, or sun_zenith_rad : float
        Zenith angle of the sun. [0 to below 90 degrees]
    sun_azimuth_deg, or sun_azimuth_rad : float
        Azimuth of the sun from +x (east) towards +y (north); 0 by default. [any turn]
    polarisation : RayleighPattern, optional
        Linear polarisation of the light; without it photons carry none.
    strength, irradiance_W_m2_nm : array_like, optional
        As for `UniformSky`. [>= 0]

    Examples
    --------
    >>> model = sky.CIESky(type=12, sun_zenith_deg=40.0, sun_azimuth_deg=0.0)
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components=model)
    >>> scene.source().total
    1000
    """

    option_ranges: ClassVar[dict[str, str]] = {"type": f"1 to {len(TYPES)}"}

    type: int
    sun_zenith_rad: float = None  # type: ignore[assignment]
    sun_azimuth_rad: float = None  # type: ignore[assignment]
    polarisation: RayleighPattern | None = None
    sun_zenith_deg: InitVar[float | None] = None
    sun_azimuth_deg: InitVar[float | None] = None

    __repr__ = sky_repr

    def __post_init__(self, sun_zenith_deg: float | None, sun_azimuth_deg: float | None) -> None:
        as_number_of(self.type, "type of a CIE sky", 1, len(TYPES), error=SceneError)
        check_share(self)
        settle_angles(self, sun_zenith_rad=sun_zenith_deg)
        settle_angles(self, default=0.0, sun_azimuth_rad=sun_azimuth_deg)
        self._law()  # which checks the sun

    def _law(self) -> PerezSky:
        """The indicatrix is k (1 + c/k exp(d p) + e/k cos^2 p) with k = 1 - c exp(d pi/2), 0.7 to 1."""
        a, b, c, d, e = TYPES[int(self.type) - 1]
        k = 1.0 - c * math.exp(d * math.pi / 2)
        return PerezSky(
            sun_zenith_rad=self.sun_zenith_rad,
            sun_azimuth_rad=self.sun_azimuth_rad,
            coefficients=(a, b, c / k, d, e / k),
            strength=self.strength,
            irradiance_W_m2_nm=self.irradiance_W_m2_nm,
            polarisation=self.polarisation,
        )

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of sky elements over that of the zenith, within 1e-12; 0 below the horizon."""
        law = self._law()
        return law.radiance(sky_zenith_rad, sky_azimuth_rad, wavelength_nm) / law.radiance(0.0, 0.0, 550.0)

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches."""
        return tuple(dataclasses.replace(one, name="cie") for one in self._law().lower(wavelength_nm))
