"""What the light itself says of a table or a field: where it is brightest, and whether that fits what is stated."""

from __future__ import annotations

import warnings

import numpy as np

from aomc_sky.directions import AzimuthConvention, sin_cos_deg, to_enu_azimuth_deg, travel_from_sky
from aomc_sky.errors import InputWarning
from aomc_sky.formats.azimuth import words_of
from aomc_sky.formats.quote import BRIGHTEST

_CONTRAST = 1.5  #: The brightest 2 % of the sky, over its median, from which on the sun's place is looked at.
_BRIGHT = 0.98
_AWAY_DEG, _SIDE_AWAY_DEG = 30.0, 40.0  #: So far from the sun the brightest sky, and the brighter side, are elsewhere.
_SIDE = 0.15  #: Amplitude of the logarithm around the horizon from which on a side is the brighter one.
_FEWEST = 12
_NEAR_DEG, _FAR_DEG = 8.0, 16.0
_AGAINST = -0.3  #: Correlation with Rayleigh's pattern of a sign that is probably another one.
_FEWEST_TURN, _MOST_TURN = 0.75, 1.001
_POINTS = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")


def brightest_note(
    radiance: np.ndarray,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray,
    irradiance: float,
    unit: float,
    nm: float | None,
) -> str:
    """The line of what was read: the brightest direction, and the irradiance of a wavelength [radiance x sr]."""
    k = int(np.argmax(radiance))
    zenith, azimuth = (round(float(one[k]), 1) for one in (zenith_deg, azimuth_deg))
    place = f"zenith angle {zenith:g}, azimuth {azimuth % 360:g} ({_compass(azimuth)})"
    at = "" if nm is None else f" at {nm:g} nm"
    light = f"Ed {irradiance * unit:.4g} W m-2 nm-1" if unit else f"Ed {irradiance:.4g} (relative)"
    return f"{BRIGHTEST} {place}; {light}{at}"


def _compass(azimuth_deg: float) -> str:
    """The point of the compass of an azimuth from +x (east) towards +y (north)."""
    return _POINTS[round(azimuth_deg / 45.0) % 8]


def warn_of_light(
    radiance: np.ndarray,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray,
    *,
    sun_deg: tuple[float | None, float | None],
    convention: AzimuthConvention | None,
    values_q: np.ndarray | None = None,
    values_u: np.ndarray | None = None,
) -> None:
    """Warn where the light contradicts what was stated of it, as far as the sun is known (InputWarning).

    Radiances of directions in our convention; `convention` is that of the file. Accuracy: docs/howto/measured_sky.md.
    """
    found = [_not_in_degrees(zenith_deg, azimuth_deg)]
    if None not in sun_deg:
        sun = float(sun_deg[0] or 0.0), float(sun_deg[1] or 0.0)
        if convention is not None and radiance.size >= _FEWEST and sun[0] < 90.0:
            found.append(_sun_elsewhere(radiance, zenith_deg, azimuth_deg, sun, convention))
        if values_q is not None and values_u is not None:
            found.append(_other_signs(zenith_deg, azimuth_deg, values_q, values_u, sun))
    for message in filter(None, found):
        warnings.warn(message, InputWarning, stacklevel=4)


def _not_in_degrees(zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> str:
    """Whether the angles of a whole sky are within a quarter and a turn in radians."""
    height, turn = float(np.max(np.abs(zenith_deg), initial=0.0)), float(np.ptp(azimuth_deg))
    if _FEWEST_TURN < height / (np.pi / 2) < _MOST_TURN and _FEWEST_TURN < turn / (2 * np.pi) < _MOST_TURN:
        return (
            f"zenith angles go to {height:g} degrees and azimuths over {turn:g}: are they radians? (--angle-unit rad)"
        )
    return ""


def _apart(one_deg: float, other_deg: float) -> float:
    return abs((one_deg - other_deg + 180.0) % 360.0 - 180.0)


def _brightest(radiance: np.ndarray, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> tuple[float, float]:
    """Zenith angle and azimuth of the middle of the brightest light. [deg]"""
    bright = radiance >= np.quantile(radiance, _BRIGHT)
    x, y, z = -(radiance[bright] @ travel_from_sky(zenith_deg[bright], azimuth_deg[bright]))
    return float(np.rad2deg(np.arctan2(np.hypot(x, y), z))), float(np.rad2deg(np.arctan2(y, x)))


def _brighter_side(radiance: np.ndarray, zenith_deg: np.ndarray, azimuth_deg: np.ndarray) -> tuple[float, float]:
    """Azimuth of the brighter side, and how much brighter it is: the first harmonic of log L beside functions of mu."""
    mu = sin_cos_deg(zenith_deg)[1]
    x, y = -travel_from_sky(zenith_deg, azimuth_deg).T[:2]
    terms = np.stack([np.ones_like(mu), mu, mu * mu, np.exp(-mu / 0.15), x, y], axis=1)
    log = np.log(np.maximum(radiance, 1e-3 * np.median(radiance)))
    along, across = np.linalg.lstsq(terms, log, rcond=None)[0][-2:]
    return float(np.rad2deg(np.arctan2(across, along))), float(np.hypot(along, across))


def _sun_elsewhere(
    radiance: np.ndarray,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray,
    sun: tuple[float, float],
    convention: AzimuthConvention,
) -> str:
    """Where the brightest sky is not at the sun, and with other azimuths or elevations it would be there."""
    if np.quantile(radiance, _BRIGHT) < _CONTRAST * np.median(radiance) or not np.any(radiance > 0):
        return ""
    zenith, azimuth = _brightest(radiance, zenith_deg, azimuth_deg)
    side, amplitude = _brighter_side(radiance, zenith_deg, azimuth_deg)
    sine = float(sin_cos_deg(sun[0])[0])

    def is_at_sun(one: float, way: float, share: float) -> bool:
        return _apart(one, sun[1]) * sine < _AWAY_DEG * share and _apart(way, sun[1]) < _SIDE_AWAY_DEG * share

    shown = f"the brightest sky is in the {_compass(azimuth)}, at zenith angle {zenith:.3g}, and the sun is in the "
    shown += f"{_compass(sun[1])}, at {sun[0]:.3g}"
    if _apart(azimuth, sun[1]) * sine < _AWAY_DEG:
        is_below = abs(zenith - (90.0 - sun[0])) < _NEAR_DEG and abs(zenith - sun[0]) > _FAR_DEG
        return f"{shown}: are the zenith angles elevations? (--coordinate elevation=NAME)" if is_below else ""
    if amplitude < _SIDE or _apart(side, sun[1]) < _SIDE_AWAY_DEG:
        return ""
    others = []
    for one in AzimuthConvention:
        moved = [_as_if(angle, convention, one, sun[1]) for angle in (azimuth, side)]
        others += [one] if is_at_sun(moved[0], moved[1], 0.5) else []
    if not others:
        return ""
    words = " or ".join(words_of(one) for one in others)
    return f"{shown}; with azimuths {words} it would be at the sun (--azimuth-convention)"


def _as_if(azimuth_deg: float, stated: AzimuthConvention, other: AzimuthConvention, sun_deg: float) -> float:
    """The azimuth of a direction, had the numbers of the file another convention."""
    offset, turn = stated.value[:2]
    in_file = turn * (azimuth_deg - offset - (sun_deg if stated.is_from_sun else 0.0))
    return float(to_enu_azimuth_deg(in_file, other, sun_deg))


def _other_signs(
    zenith_deg: np.ndarray, azimuth_deg: np.ndarray, q: np.ndarray, u: np.ndarray, sun: tuple[float, float]
) -> str:
    """Where Q or U has the other sign than Rayleigh's pattern around the sun."""
    from aomc_sky.skies.polarisation import RayleighPattern

    angles = np.deg2rad(zenith_deg), np.deg2rad(azimuth_deg)
    pattern = RayleighPattern(max_degree=1.0).stokes(
        *angles, sun_zenith_rad=np.deg2rad(sun[0]), sun_azimuth_rad=np.deg2rad(sun[1])
    )
    likeness = [
        float(a @ b / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-300)) for a, b in zip((q, u), pattern, strict=True)
    ]
    against = [name for name, one in zip("QU", likeness, strict=True) if one < _AGAINST]
    if not against:
        return ""
    signs = " ".join("-1" if one < _AGAINST else "1" for one in likeness)
    shown = ", ".join(f"{name} {one:.2f}" for name, one in zip("QU", likeness, strict=True))
    return (
        f"{' and '.join(against)}: another sign than that of Rayleigh's pattern around the sun (correlation of "
        f"{shown}); are they of another convention? (--stokes-signs {signs})"
    )
