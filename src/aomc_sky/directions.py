"""Frames, azimuth conventions, sky direction to travel direction: the only angle arithmetic.

A *sky direction* points from the water to where the light comes from; a *travel direction* is the
unit vector along which the photon moves. Travel = -(sky direction). See docs/conventions.md.
"""

from __future__ import annotations

import dataclasses
import enum
import math
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError, floats, member_of, number

C = TypeVar("C")
FrameWord = Literal["up", "down"]
ConventionWord = Literal[
    "enu_from_east",
    "north_clockwise",
    "west_of_south",
    "east_clockwise",
    "north_counterclockwise",
    "south_counterclockwise",
    "west_clockwise",
    "west_counterclockwise",
    "from_sun",
    "from_sun_clockwise",
    "from_antisun",
    "from_antisun_clockwise",
]


class Frame(enum.Enum):
    """Which way z grows: UP is ours (a sky photon has uz < 0), DOWN is AOMC's (uz > 0).

    Examples
    --------
    >>> sky.directions.Frame.UP
    <Frame.UP: 'up'>
    """

    UP = "up"
    DOWN = "down"


class AzimuthConvention(enum.Enum):
    """Direction of azimuth zero and sense of rotation; value = (offset in degrees, orientation).

    The azimuth in our convention, from +x (east) towards +y (north), is offset + orientation * azimuth. The offset of
    the last four is from the sun's azimuth.

    Examples
    --------
    >>> south_west = sky.directions.to_enu_azimuth_deg(
    ...     225.0, sky.directions.AzimuthConvention.NORTH_CLOCKWISE
    ... )
    >>> print(south_west)
    225.0
    """

    ENU_FROM_EAST = (0.0, 1.0)
    NORTH_CLOCKWISE = (90.0, -1.0)
    WEST_OF_SOUTH = (-90.0, -1.0)
    EAST_CLOCKWISE = (0.0, -1.0)
    NORTH_COUNTERCLOCKWISE = (90.0, 1.0)
    SOUTH_COUNTERCLOCKWISE = (-90.0, 1.0)
    WEST_CLOCKWISE = (180.0, -1.0)
    WEST_COUNTERCLOCKWISE = (180.0, 1.0)
    FROM_SUN = (0.0, 1.0, "sun")
    FROM_SUN_CLOCKWISE = (0.0, -1.0, "sun")
    FROM_ANTISUN = (180.0, 1.0, "sun")
    FROM_ANTISUN_CLOCKWISE = (180.0, -1.0, "sun")

    @property
    def is_from_sun(self) -> bool:
        """Whether azimuths count from the sun or the point opposite it."""
        return len(self.value) == 3


def to_enu_azimuth_deg(
    azimuth_deg: ArrayLike, convention: AzimuthConvention | ConventionWord, sun_azimuth_deg: float | None = None
) -> np.ndarray:
    """Convert an azimuth of a named convention to ours.

    Parameters
    ----------
    azimuth_deg : array_like
        Azimuth in `convention`. [deg, any turn]
    convention : AzimuthConvention, or its name in small letters
        The convention the azimuth is given in.
    sun_azimuth_deg : float, optional
        Azimuth of the sun from +x towards +y; a convention that counts from it needs it. [deg]

    Returns
    -------
    ndarray, float64
        Azimuth from +x towards +y. [deg, 0 to 360)

    Raises
    ------
    UsageError
        The convention counts from the sun, and `sun_azimuth_deg` is not given.

    Examples
    --------
    >>> print(
    ...     sky.directions.to_enu_azimuth_deg(
    ...         [0.0, 90.0], sky.directions.AzimuthConvention.NORTH_CLOCKWISE
    ...     )
    ... )
    [90.  0.]
    """
    convention = member_of(AzimuthConvention, convention, "convention")
    offset, orientation = convention.value[:2]
    if convention.is_from_sun:
        if sun_azimuth_deg is None:
            raise UsageError(f"azimuths of {convention.name} count from the sun: give sun_azimuth_deg")
        offset += number("sun_azimuth_deg", sun_azimuth_deg)
    azimuth = floats("azimuth_deg", azimuth_deg)
    if np.any(np.isinf(azimuth)) or math.isinf(offset):
        raise UsageError(f"{'sun_' * math.isinf(offset)}azimuth_deg must be finite")
    turned = np.mod(offset + orientation * azimuth, 360.0)
    return np.where(turned >= 360.0, 0.0, turned)


EDGE_DEG = 0.003
"""Half a unit of the fourth decimal of a radian, and more than float32 rounds: what is so near is the same. [deg]"""


def within_sky_deg(sky_zenith_deg: np.ndarray) -> np.ndarray:
    """Zenith angles; those that rounding has put beyond 0 or 90 degrees, by up to `EDGE_DEG`, are there."""
    size = np.abs(sky_zenith_deg)
    zenith = np.where((size > 90.0) & (size <= 90.0 + EDGE_DEG), np.copysign(90.0, sky_zenith_deg), sky_zenith_deg)
    return np.where((zenith < 0.0) & (zenith >= -EDGE_DEG), 0.0, zenith)


def at_quarter_deg(azimuth_deg: np.ndarray) -> np.ndarray:
    """Azimuths; those within `EDGE_DEG` of a multiple of 90 degrees are there."""
    quarter = 90.0 * np.rint(azimuth_deg / 90.0)
    return np.where(np.abs(azimuth_deg - quarter) <= EDGE_DEG, quarter, azimuth_deg)


_TWINS = {"_deg": "_rad", "_rad": "_deg"}


def given_angle(name: str, value: Any, twin: Any, default: float | None = None) -> Any:
    """An angle in the unit that `name` ends in, from an argument of this name or its `twin` in the other unit.

    Radians are degrees times pi/180 in float64, as `math.radians` has them, and degrees the other way round: within
    1 ulp, and exactly the rounded value for multiples of 90 degrees. UsageError for both at once, for neither without a
    `default`, and for values that are not numbers.
    """
    other = name[:-4] + _TWINS[name[-4:]]
    if twin is None:
        if value is None and default is None:
            raise UsageError(f"give {other} or {name}")
        angle = floats(name, default if value is None else value)
    elif value is not None:
        raise UsageError(f"{name} and {other} are one angle: give one of them")
    else:
        angle = floats(other, twin)
        angle = np.rad2deg(angle) if name.endswith("_deg") else np.deg2rad(angle)
    return float(angle) if angle.ndim == 0 else angle


def one_angle(name: str, value: Any, twin: Any) -> float | None:
    """One number as `given_angle` has it, or None without any."""
    given = (name, value) if twin is None else (name[:-4] + _TWINS[name[-4:]], twin)
    if given[1] is None:
        return None
    number(*given)
    return float(given_angle(name, value, twin))


def settle_angles(model: object, default: float | None = None, **twins: Any) -> None:
    """Give the fields of a frozen dataclass that have these names their `given_angle`, one number each."""
    for name, twin in twins.items():
        own = getattr(model, name)
        angle = one_angle(name, own, twin)
        object.__setattr__(model, name, given_angle(name, own, twin, default) if angle is None else angle)


def in_both_units(model: type[C]) -> type[C]:
    """Decorate a dataclass whose angles have twins, fields of `InitVar` that its `__post_init__` settles.

    A twin becomes a property: the angle in its unit. `dataclasses.replace` then knows the fields alone.
    """
    fields: dict[str, Any] = model.__dataclass_fields__  # type: ignore[attr-defined]
    kept = {field.name for field in dataclasses.fields(model)}  # type: ignore[arg-type]
    for twin in [name for name in fields if name[-4:] in _TWINS and name not in kept]:
        del fields[twin]
        setattr(model, twin, _converted(twin, twin[:-4] + _TWINS[twin[-4:]]))
    return model


def angle_as_given(name: str, value: Any) -> str:
    """`name=value` of a field that has a twin, in the unit in which the number is the shorter one; empty for others.

    Both give the same angle, and the shorter one is what a person wrote.
    """
    if name[-4:] not in _TWINS or not isinstance(value, float) or not math.isfinite(value):
        return ""
    twin = name[:-4] + _TWINS[name[-4:]]
    short = float(f"{given_angle(twin, None, value):.12g}")
    is_same = given_angle(name, None, short) == value
    by = len(repr(value)) - len(repr(short))
    return f"{twin}={short!r}" if is_same and (by > 0 or (by == 0 and twin.endswith("_deg"))) else ""


def _converted(name: str, twin: str) -> property:
    return property(lambda model: given_angle(name, None, getattr(model, twin)))


# sin(pi r / 2) / r and cos(pi r / 2) as polynomials in r^2 for |r| <= 1/2, highest power first. They are minimax
# polynomials, fitted at 50 digits with rounded coefficients. The last bits of libm and numpy depend on version and
# processor; photons must not.
SIN_QUARTER = (
    5.633933781537854e-08,
    -3.59864335298231e-06,
    0.0001604411507421909,
    -0.004681754132340976,
    0.07969262624604301,
    -0.6459640975062443,
    1.5707963267948966,
)
COS_QUARTER = (
    -6.329396344967424e-09,
    4.710678405505227e-07,
    -2.5202039028029178e-05,
    0.0009192602745468447,
    -0.020863480763340773,
    0.2536695079010478,
    -1.2337005501361697,
    1.0,
)


def _horner(coefficients: tuple[float, ...], t: np.ndarray) -> np.ndarray:
    value = np.full_like(t, coefficients[0])
    for coefficient in coefficients[1:]:
        value *= t
        value += coefficient
    return value


def sin_cos_deg(angle_deg: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of any finite angle in degrees: exact at every multiple of 90, the same bits everywhere.

    Within 2.5 ulp of the true values for |angle| up to 720.
    """
    angle = floats("an angle", angle_deg)
    if np.any(np.isinf(angle)):
        raise UsageError("an angle must be finite")
    quarter = np.rint(angle / 90.0)
    rest = (angle - 90.0 * quarter) / 90.0  # the difference is exact
    s, c = _horner(SIN_QUARTER, rest * rest) * rest, _horner(COS_QUARTER, rest * rest)
    turn = np.mod(quarter, 4.0)
    is_odd = (turn == 1) | (turn == 3)
    sine, cosine = np.where(is_odd, c, s), np.where(is_odd, s, c)
    sine, cosine = np.where(turn >= 2, -sine, sine), np.where((turn == 1) | (turn == 2), -cosine, cosine)
    return sine + 0.0, cosine + 0.0  # + 0.0 turns -0 into 0


def arcsin_deg(sine: float) -> float:
    """Inverse of the sine, 0 to 0.9, by Newton's steps on `sin_cos_deg`: its bits are ours too; within 4 ulp."""
    angle = sine * (180.0 / math.pi)
    for _ in range(8):
        s, c = sin_cos_deg(angle)
        angle += (sine - float(s)) / float(c) * (180.0 / math.pi)
    return angle


def travel_from_sky(
    sky_zenith_deg: ArrayLike, sky_azimuth_deg: ArrayLike, frame: Frame | FrameWord = Frame.UP
) -> np.ndarray:
    """Travel direction of light that comes from a point of the sky.

    Parameters
    ----------
    sky_zenith_deg : array_like
        Zenith angle of the sky element, 0 overhead. [deg, 0 to 90]
    sky_azimuth_deg : array_like
        Azimuth of the sky element from +x towards +y. [deg]
    frame : Frame, or {"up", "down"}
        `Frame.UP` (z upward, uz < 0) or `Frame.DOWN` (z downward, uz > 0).

    Returns
    -------
    ndarray, float64, shape (..., 3)
        Unit vector along which the photon moves.

    Examples
    --------
    >>> print(
    ...     sky.directions.travel_from_sky(90.0, 0.0)
    ... )  # from the east: it goes to the west
    [-1.  0.  0.]
    """
    sin_z, cos_z = sin_cos_deg(sky_zenith_deg)
    sin_a, cos_a = sin_cos_deg(sky_azimuth_deg)
    sin_z, cos_z, sin_a, cos_a = np.broadcast_arrays(sin_z, cos_z, sin_a, cos_a)
    uz = -cos_z if member_of(Frame, frame, "frame") is Frame.UP else cos_z
    return np.stack([-sin_z * cos_a, -sin_z * sin_a, uz], axis=-1) + 0.0


def sky_from_travel(direction: ArrayLike, frame: Frame | FrameWord = Frame.UP) -> tuple[np.ndarray, np.ndarray]:
    """Sky direction that light with this travel direction comes from.

    Parameters
    ----------
    direction : array_like, shape (..., 3)
        Unit vectors ux, uy, uz.
    frame : Frame, or {"up", "down"}
        The frame of `direction`.

    Returns
    -------
    sky_zenith_rad, sky_azimuth_rad : ndarray, float64
        Zenith angle [rad, 0 to pi] and azimuth [rad, 0 to 2 pi) of the sky element.

    Examples
    --------
    >>> zenith_rad, azimuth_rad = sky.directions.sky_from_travel([0.0, -0.6, -0.8])
    >>> print(np.degrees([zenith_rad, azimuth_rad]).round(2))
    [36.87 90.  ]
    """
    u = floats("direction", direction)
    if u.shape[-1:] != (3,):
        raise UsageError(f"direction must be ux, uy, uz of each photon, of shape (..., 3); got shape {u.shape}")
    if np.any(np.isinf(u)) or not np.any(u, axis=-1).all():
        raise UsageError("direction must be finite and not 0")
    return sky_angles(u, frame)


def sky_angles(u: np.ndarray, frame: Frame | FrameWord = Frame.UP) -> tuple[np.ndarray, np.ndarray]:
    """`sky_from_travel` of photons that may be damaged."""
    cos_z = -u[..., 2] if member_of(Frame, frame, "frame") is Frame.UP else u[..., 2]
    zenith = np.arctan2(np.hypot(u[..., 0], u[..., 1]), cos_z)
    azimuth = np.arctan2(-u[..., 1] + 0.0, -u[..., 0] + 0.0)
    azimuth = np.where(azimuth < 0, azimuth + 2 * np.pi, azimuth)
    return zenith, np.where(azimuth >= 2 * np.pi, 0.0, azimuth)
