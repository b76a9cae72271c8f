"""What the light itself says of a table or a field: where it is brightest, and whether that fits what is stated."""

from __future__ import annotations

import warnings

import numpy as np

from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg, travel_from_sky
from aomc_sky.errors import InputWarning
from aomc_sky.formats.azimuth import words_of
from aomc_sky.formats.quote import BRIGHTEST

_BRIGHT, _FEWEST_BRIGHT = 0.02, 3  #: Share and number of the directions that are the brightest sky.
_CONTRAST = 1.5  #: The least of them over the median of the sky, from which on the sun's place is looked at.
_DARK = 0.5  #: Share of the median below which darkness says no more: walls, trees and shades.
_AWAY_DEG = 15.0  #: So far from the sun the brightest sky is elsewhere.
_FEWEST = 20
_BETTER, _BETTER_OF_FEW = 2.0, 30.0  #: Factor by which another reading leaves less light open, and more by 1 / n.
_LEAST_OPEN, _ALIKE = 0.01, 1.25
_RING_DEG = 30.0  #: Directions of fewer zenith angles say nothing of what is overhead.
_AGAINST = -0.3  #: Correlation with Rayleigh's pattern of a sign that is probably another one.
_POINTS = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")


def brightest_note(
    radiance: np.ndarray,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray | None,
    irradiance: float,
    unit: float,
    nm: float | None,
) -> str:
    """The line of what was read: the brightest direction, and the irradiance of a wavelength [radiance x sr]."""
    k = int(np.argmax(radiance))
    place = f"zenith angle {round(float(zenith_deg[k]), 1):g}"
    if azimuth_deg is not None:
        azimuth = round(float(azimuth_deg[k]), 1)
        place += f", azimuth {azimuth % 360:g} ({_compass(azimuth)})"
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
    stokes_signs: tuple[float, float] = (1, 1),
) -> None:
    """Warn where the light contradicts what was stated of it, as far as the sun is known (InputWarning).

    Radiances of directions in our convention; `convention` is that of the file, `stokes_signs` those that made Q and
    U ours. Accuracy: docs/howto/measured_sky.md.
    """
    found: list[str] = []
    is_light = radiance > 0
    sun = tuple(one for one in sun_deg if one is not None)
    if len(sun) == 2 and sun[0] < 90.0 and np.sum(is_light) >= _FEWEST:
        light, zenith, azimuth = (one[is_light] for one in (radiance, zenith_deg, azimuth_deg))
        if convention is not None:
            found.append(_sun_elsewhere(light / light.max(), zenith, azimuth, sun, convention))
        if values_q is not None and values_u is not None:
            shares = values_q[is_light] / light, values_u[is_light] / light
            found.append(_other_signs(zenith, azimuth, shares, stokes_signs, sun))
    for message in filter(None, found):
        warnings.warn(message, InputWarning, stacklevel=4)


def _sun_elsewhere(
    radiance: np.ndarray,
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray,
    sun: tuple[float, float],
    convention: AzimuthConvention,
) -> str:
    """Where the brightest sky is not at the sun, and with other azimuths or elevations the light would fit the sun."""
    bright = radiance >= np.sort(radiance)[-max(_FEWEST_BRIGHT, int(np.ceil(_BRIGHT * radiance.size)))]
    x, y, z = middle = -(radiance[bright] @ travel_from_sky(zenith_deg[bright], azimuth_deg[bright]))
    is_at_sun = -(middle @ travel_from_sky(*sun)) > np.cos(np.deg2rad(_AWAY_DEG)) * np.linalg.norm(middle)
    if is_at_sun or radiance[bright].min() < _CONTRAST * np.median(radiance):
        return ""
    terms = np.vander(zenith_deg / 45.0 - 1.0, 5)  # functions of the elevation as well
    light = _rest(terms, np.log(np.maximum(radiance, max(_DARK * np.median(radiance), 1e-300))))
    readings = {one: (zenith_deg, _as_if(azimuth_deg, convention, one, sun[1])) for one in AzimuthConvention}
    left = {one: _left_open(light, terms, reading, sun) for one, reading in readings.items()}
    of_elevations = _left_open(light, terms, (90.0 - zenith_deg, azimuth_deg), sun)
    is_ring = np.ptp(zenith_deg) < _RING_DEG
    least = min(left.values()) if is_ring else min(of_elevations, *left.values())
    if left[convention] < (_BETTER + _BETTER_OF_FEW / radiance.size) * least:
        return ""
    zenith, azimuth = (float(np.rad2deg(one)) for one in (np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)))
    shown = f"the brightest sky is in the {_compass(azimuth)}, at zenith angle {zenith:.3g}, and the sun is in the "
    shown += f"{_compass(sun[1])}, at {sun[0]:.3g}"
    if least < min(left.values()):
        return f"{shown}: are the zenith angles elevations? (--coordinate elevation=NAME)"
    words = " or ".join(words_of(one) for one in sorted(left, key=left.__getitem__) if left[one] < _ALIKE * least)
    return f"{shown}; with azimuths {words} the light would lie around the sun (--azimuth-convention)"


def _rest(terms: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What these terms do not explain of values."""
    return np.asarray(values - terms @ np.linalg.lstsq(terms, values, rcond=None)[0])


def _left_open(
    light: np.ndarray, terms: np.ndarray, reading_deg: tuple[np.ndarray, np.ndarray], sun: tuple[float, float]
) -> float:
    """The share of the light that is no function of the angle to the sun, as Perez has it; above 1 if dark there."""
    cosine = np.clip(travel_from_sky(*reading_deg) @ travel_from_sky(*sun), -1.0, 1.0)
    glow = _rest(terms, np.stack([np.exp(-3.0 * np.arccos(cosine)), cosine * cosine], axis=1))
    explained = float((light @ light - np.sum(_rest(glow, light) ** 2)) / max(light @ light, 1e-12 * light.size))
    return max(1.0 - (explained if light @ glow[:, 0] > 0 else -explained), _LEAST_OPEN)


def _as_if(azimuth_deg: np.ndarray, stated: AzimuthConvention, other: AzimuthConvention, sun_deg: float) -> np.ndarray:
    """Azimuths, had the numbers of the file another convention."""
    offset, turn = stated.value[:2]
    in_file = turn * (azimuth_deg - offset - (sun_deg if stated.is_from_sun else 0.0))
    return to_enu_azimuth_deg(in_file, other, sun_deg)


def _other_signs(
    zenith_deg: np.ndarray,
    azimuth_deg: np.ndarray,
    stokes: tuple[np.ndarray, np.ndarray],
    signs: tuple[float, float],
    sun: tuple[float, float],
) -> str:
    """Where Q or U has the other sign than Rayleigh's pattern around the sun."""
    from aomc_sky.skies.polarisation import RayleighPattern

    angles = np.deg2rad(zenith_deg), np.deg2rad(azimuth_deg)
    pattern = RayleighPattern(max_degree=1.0).stokes(
        *angles, sun_zenith_rad=np.deg2rad(sun[0]), sun_azimuth_rad=np.deg2rad(sun[1])
    )
    likeness = [
        float(a @ b / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-300)) for a, b in zip(stokes, pattern, strict=True)
    ]
    against = [name for name, one in zip("QU", likeness, strict=True) if one < _AGAINST]
    if not against:
        return ""
    shown = ", ".join(f"{name} {one:.2f}" for name, one in zip("QU", likeness, strict=True))
    right = " ".join(f"{-sign if one < _AGAINST else sign:g}" for sign, one in zip(signs, likeness, strict=True))
    return (
        f"{' and '.join(against)}: another sign than that of Rayleigh's pattern around the sun (correlation of "
        f"{shown}); are they of another convention? (--stokes-signs {right})"
    )
