"""The direct beam of the sun: a direction, or the solar disc."""

from __future__ import annotations

from dataclasses import InitVar, dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law
from aomc_sky.directions import arcsin_deg, in_both_units, settle_angles, sin_cos_deg
from aomc_sky.errors import SceneError
from aomc_sky.skies.model import Share, check_share, sky_repr, with_share

SOLAR_RADIUS_DEG = 0.2665  #: Mean angular radius of the solar disc.
SMALLEST_CUT_DEG = 1e-4  #: Radius below which the angle of a disc's upper rim has too few digits beside 90 degrees.


#: The sun at its mean distance: wavelength and irradiance outside the atmosphere of ASTM G173-03, mean over 10 nm, at
#: wavelengths between which a line is within 5 % of it. [nm, W m-2 nm-1]
_SOLAR_NM = (
    300, 321, 331, 361, 369, 387, 394, 405, 434, 454, 537, 673, 872, 1130, 1428, 1820, 1984, 2210, 2558, 2984, 3478,
    4000,
)  # fmt: skip
_SOLAR = (
    0.5256, 0.7482, 0.9939, 0.9876, 1.1632, 1.0418, 1.1110, 1.7195, 1.6084, 2.0341, 1.8546, 1.5192, 0.9601, 0.5645,
    0.3273, 0.1594, 0.1194, 0.0807, 0.0456, 0.0257, 0.0145, 0.0087,
)  # fmt: skip
SOLAR_BOUND = 1.15  #: No sun is as bright: 5 % for the line, 3.4 % for the distance, 6 % for lines within 10 nm.


def solar_irradiance(wavelength_nm: np.ndarray) -> np.ndarray:
    """The sun's outside the atmosphere, within 5 % of the mean over 10 nm; infinite beyond 300 to 4000 nm.

    In W m-2 nm-1, on a surface that faces the sun at its mean distance.
    """
    return np.interp(wavelength_nm, _SOLAR_NM, _SOLAR, left=np.inf, right=np.inf)


@in_both_units
@dataclass(frozen=True, kw_only=True, slots=True)
class DirectBeam(Share):
    """Light from the sun alone.

    Parameters
    ----------
    sun_zenith_deg, or sun_zenith_rad : float
        Zenith angle of the sun's centre. [deg, 0 to 90; below 90 for a beam without extent]
    sun_azimuth_deg, or sun_azimuth_rad : float
        Azimuth of the sun, from +x towards +y; by default 0. [deg]
    radius_deg, or radius_rad : float
        0, the default, for a parallel beam; else the radius of a disc of uniform radiance, cut at the horizon.
        [deg, 0 to 10; 0.0001 or more where the horizon cuts it]
    strength, irradiance_W_m2_nm : array_like, optional
        Share of the light in a scene of several models, as for `UniformSky`. [>= 0]

    Notes
    -----
    Photons pass the horizontal surface, so those of a disc are cosine-weighted.

    Examples
    --------
    >>> scene = sky.Scene(
    ...     wavebands=[550.0], n_photons=100, components=sky.DirectBeam(sun_zenith_deg=60.0)
    ... )
    >>> print(scene.source().photons().uz[:2])
    [-0.5 -0.5]
    """

    sun_zenith_deg: float = None  # type: ignore[assignment]
    sun_azimuth_deg: float = None  # type: ignore[assignment]
    radius_deg: float = None  # type: ignore[assignment]
    sun_zenith_rad: InitVar[float | None] = None
    sun_azimuth_rad: InitVar[float | None] = None
    radius_rad: InitVar[float | None] = None

    __repr__ = sky_repr

    def __post_init__(
        self, sun_zenith_rad: float | None, sun_azimuth_rad: float | None, radius_rad: float | None
    ) -> None:
        check_share(self)
        settle_angles(self, sun_zenith_deg=sun_zenith_rad)
        settle_angles(self, default=0.0, sun_azimuth_deg=sun_azimuth_rad, radius_deg=radius_rad)
        if not 0 <= self.radius_deg <= 10:
            raise SceneError(f"the radius of the solar disc must lie within 0 to 10 degrees, got {self.radius_deg}")
        limit_ok = 0 <= self.sun_zenith_deg < 90 or (self.sun_zenith_deg == 90 and self.radius_deg > 0)
        if not limit_ok or not np.isfinite(self.sun_azimuth_deg):
            raise SceneError(
                f"a direct beam needs the sun above the horizon (zenith angle 0 to below 90 degrees), "
                f"got zenith {self.sun_zenith_deg}, azimuth {self.sun_azimuth_deg}"
            )
        if self._is_cut and self.radius_deg < SMALLEST_CUT_DEG:
            raise SceneError(
                f"the radius of a disc that the horizon cuts must be {SMALLEST_CUT_DEG:g} degrees or more, got "
                f"radius_deg {self.radius_deg:g} at the zenith angle {self.sun_zenith_deg:.10g}",
                "write 0.2665 for the sun, or 0 for a parallel beam of a sun above the horizon",
            )

    @property
    def _is_cut(self) -> bool:
        """Whether a part of the disc lies below the horizon."""
        return self.sun_zenith_deg + self.radius_deg > 90

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One cell of law BEAM, DISC, or DISC_AT_HORIZON where the horizon cuts the disc."""
        sin_z, cos_z = (float(x) for x in sin_cos_deg(self.sun_zenith_deg))
        sin_r, cos_r = (float(x) for x in sin_cos_deg(self.radius_deg))
        if self.radius_deg == 0:
            law, head = Law.BEAM, (sin_z**2, 0.0, cos_z**2, 0.0)
        elif not self._is_cut:
            law, head = Law.DISC, (sin_z, cos_z, sin_r, cos_r)
        else:
            top = float(sin_cos_deg(self.sun_zenith_deg - self.radius_deg)[1]) ** 2
            chord2 = 4 * float(sin_cos_deg(self.radius_deg / 2)[0]) ** 2
            law, head = Law.DISC_AT_HORIZON, (top, arcsin_deg(sin_r / sin_z) / 90.0, chord2, cos_z)
        sine, cosine = sin_cos_deg(self.sun_azimuth_deg)
        component = Component(
            name="direct",
            law=law,
            strength=np.ones(np.size(wavelength_nm)),
            mass=np.ones((1, 1)),
            cell=np.array([[*head, float(sine), float(cosine)]]),
        )
        return with_share(self, (component,))
