"""The content of a background-sky file: lobe animations and the spectra they share.

It is read from a file, or built in Python from lobes as a person describes them: an axis on the sky, a shape, a
spectrum.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import InitVar, dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import in_both_units, settle_angles, sin_cos_deg
from aomc_sky.errors import SceneError, floats, require_kind, require_one_of
from aomc_sky.phase.vectorised import real
from aomc_sky.record import same_content, short_repr

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.lobe import KindWord

_DAY_S = 86400.0
_EPOCH_WEEKDAY = 4.0  # 1970-01-01 was a Thursday, four days after Sunday


class LobeType(enum.IntEnum):
    """Functional form of a lobe, with its number in the file."""

    HENYEY_GREENSTEIN = 1
    GGX = 2
    BECKMANN = 3


ReferenceWord = Literal["absolute", "diurnal", "hebdomadal"]


class ReferenceType(enum.IntEnum):
    """The zero of relative times, with its number in the file."""

    ABSOLUTE = 1
    """A point in time; the animation does not repeat."""
    DIURNAL = 2
    """The most recent midnight."""
    HEBDOMADAL = 3
    """Midnight at the begin of the most recent Sunday."""


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Animation:
    """Lobes over time: the keys of one animation, in the order of time; arrays of shape (n_key,).

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> animation = sky.lobes.background_of_lobes({"town": town}, [550.0]).animations[
    ...     "town"
    ... ]
    >>> len(animation), animation.kind
    (1, ('hg',))
    """

    lobe_type: np.ndarray  #: uint8, values of `LobeType`
    #: float64: asymmetry g and nothing [0 <= g < 1], or the roughness along local x and local y. [> 0]
    param0: np.ndarray
    param1: np.ndarray
    coefficient: np.ndarray  #: float64, factors of the curve. [>= 0]
    #: float64 (n_key, 4), rotations (w, x, y, z) from the local frame, axis +z, to the world (x east, y north, z up).
    #: [length 1 within 4e-16]
    quaternion: np.ndarray
    curve_index: np.ndarray  #: int64, rows of the spectra. [0 to n_curve - 1]
    #: float64, times since the reference time, never falling; of equal ones the later key wins. [d]
    relative_time_days: np.ndarray
    reference: ReferenceType  #: The zero of relative times
    time_point_s: int = 0  #: The reference time of type ABSOLUTE; no meaning otherwise. [s since 1970-01-01 UTC]

    __eq__ = same_content
    __repr__ = short_repr

    def __len__(self) -> int:
        return int(self.lobe_type.size)

    @property
    def kind(self) -> tuple[str, ...]:
        """The kind of each key, as `aomc_sky.lobes` has them."""
        return tuple(_KIND_OF.get(lobe_type, str(lobe_type)) for lobe_type in self.lobe_type.tolist())

    def relative_days(self, unix_time_s: ArrayLike, *, utc_offset_h: float = 0.0) -> np.ndarray:
        """Days since the reference, of a repeating animation in [0, 1) or [0, 7).

        `unix_time_s` counts seconds since 1970-01-01 UTC. `utc_offset_h` is local time less UTC, for the midnight of
        repeating animations.
        """
        time, offset = real(unix_time_s), real(utc_offset_h)
        if not np.all(np.isfinite(time)) or not np.all(np.isfinite(offset)):
            raise SceneError("a time and its UTC offset must be finite")
        if self.reference is ReferenceType.ABSOLUTE:
            return (time - float(self.time_point_s)) / _DAY_S
        local = time + 3600.0 * utc_offset_h
        if self.reference is ReferenceType.DIURNAL:
            return np.mod(local, _DAY_S) / _DAY_S
        return np.mod(local + _EPOCH_WEEKDAY * _DAY_S, 7.0 * _DAY_S) / _DAY_S

    def between(self, relative_days: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Keys before and after a time in days, int64, and the share of the later one [0 to 1).

        Both keys are equal up to the first and from the last key on: the end keys hold, also at midnight.
        """
        time, keys = np.asarray(relative_days, dtype=np.float64), self.relative_time_days
        last = keys.size - 1
        after = np.searchsorted(keys, time, side="right")
        low = np.clip(after - 1, 0, last)
        high = np.where((time <= keys[0]) | (after > last), low, np.minimum(after, last))
        span = keys[high] - keys[low]
        fraction = np.where(high > low, (time - keys[low]) / np.where(high > low, span, 1.0), 0.0)
        return low, high, fraction


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundInfo:
    """Title and version of a file; an empty text is absent."""

    #: Texts for persons
    name: str = ""
    author: str = ""
    description: str = ""
    organization: str = ""
    file_type: int = 5  #: Number of the data model; 5 in the files known to us, the format does not state it
    format_version: int = 1  #: Version of the format. [1]


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class BackgroundFile:
    """A background-sky file in our units.

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> file = sky.lobes.background_of_lobes({"town": town}, [550.0])
    >>> list(file.animations), file.curves.tolist()
    (['town'], [[1e-08]])
    """

    info: BackgroundInfo = field(default_factory=BackgroundInfo)
    animations: Mapping[str, Animation]  #: The animations by name; their light adds
    wavelength_nm: np.ndarray  #: float64 (n_wavelength,), rising. [nm]
    #: float64 (n_curve, n_wavelength), spectral irradiance integrated over the sphere. [W m-2 nm-1, >= 0]
    curves: np.ndarray
    texts: tuple[str, ...] = field(default=(), compare=False)  #: A note that quotes attributes of the spectra, if any

    __eq__ = same_content
    __repr__ = short_repr


def frozen(array: np.ndarray) -> np.ndarray:
    """The same array, read-only from now on."""
    array.setflags(write=False)
    return array


def normalised(quaternion: np.ndarray) -> np.ndarray:
    """Quaternions of length 1, read-only; one of length 0 or with a value that is not finite stays as it is.

    Scaled by the largest component first, so that no square underflows or overflows.
    """
    largest = np.abs(quaternion).max(axis=1, keepdims=True, initial=0.0)
    usable = np.isfinite(largest) & (largest > 0.0)
    scaled = quaternion / np.where(usable, largest, 1.0)
    length = np.sqrt(np.sum(np.square(np.where(usable, scaled, 1.0)), axis=1, keepdims=True))
    return frozen(np.where(usable, scaled / length, quaternion))


#: The laws of `aomc_sky.lobes` by name.
KINDS = {"hg": LobeType.HENYEY_GREENSTEIN, "ggx": LobeType.GGX, "beckmann": LobeType.BECKMANN}
_KIND_OF = {int(lobe_type): kind for kind, lobe_type in KINDS.items()}
_REFERENCES = {one.name.lower(): one for one in ReferenceType}


@in_both_units
@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class SkyLobe:
    """Light from around one direction of the sky, at one time.

    Parameters
    ----------
    kind : {"hg", "ggx", "beckmann"}
        The law, see `aomc_sky.lobes.pdf`.
    width : float
        Asymmetry g of "hg" [0 <= g < 1], or the roughness along local x. [> 0]
    width_y : float, optional
        Roughness along local y; by default the same. [> 0]
    zenith_deg, or zenith_rad; azimuth_deg, or azimuth_rad : float
        Where the axis points; azimuth from +x (east) towards +y (north). By default 0. [deg]
    turn_deg, or turn_rad : float
        Turn of the lobe about its axis. At 0, the default, local x points down along the meridian of the axis, local y
        along the horizon, towards growing azimuth. [deg]
    spectrum : array_like, shape (n_wavelength,)
        Irradiance integrated over the whole sphere. [W m-2 nm-1, >= 0]
    factor : float
        Multiplies the spectrum. [>= 0]
    time_days : float
        Time of this key since the reference of its animation. [d]

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(
    ...     kind="hg", width=0.8, zenith_deg=85.0, azimuth_deg=30.0, spectrum=[1e-8, 2e-8]
    ... )
    >>> sky.lobes.background_of_lobes({"town": town}, [440.0, 550.0]).wavelength_nm
    array([440., 550.])
    """

    kind: KindWord
    width: float
    width_y: float | None = None
    zenith_deg: float = None  # type: ignore[assignment]
    azimuth_deg: float = None  # type: ignore[assignment]
    turn_deg: float = None  # type: ignore[assignment]
    spectrum: ArrayLike
    factor: float = 1.0
    time_days: float = 0.0
    zenith_rad: InitVar[float | None] = None
    azimuth_rad: InitVar[float | None] = None
    turn_rad: InitVar[float | None] = None

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self, zenith_rad: float | None, azimuth_rad: float | None, turn_rad: float | None) -> None:
        settle_angles(self, default=0.0, zenith_deg=zenith_rad, azimuth_deg=azimuth_rad, turn_deg=turn_rad)


def background_of_lobes(
    animations: Mapping[str, SkyLobe | Sequence[SkyLobe]],
    wavelength_nm: ArrayLike,
    *,
    reference: ReferenceWord = "diurnal",
    time_point_s: int = 0,
    name: str = "",
    author: str = "",
    description: str = "",
    organization: str = "",
) -> BackgroundFile:
    """Content of a file of lobes, for `aomc_sky.lobes.write_background`; equal spectra become one curve.

    UsageError: an unknown kind or reference. SceneError: a spectrum without one value for each wavelength, or an
    animation without a lobe.

    Parameters
    ----------
    animations : mapping of str to SkyLobe, or to a sequence of them
        One lobe stands still; several are the keys of an animation, in the order of time. The light of all adds.
    wavelength_nm : array_like, shape (n_wavelength,)
        Wavelengths of the spectra, rising. [nm]
    reference : {"diurnal", "hebdomadal", "absolute"}
        What times count from: midnight, Sunday's midnight, or `time_point_s`.
    time_point_s : int
        The reference time of "absolute". [s since 1970-01-01 UTC]
    name, author, description, organization : str
        Texts for persons.

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> background = sky.lobes.background_of_lobes({"town": town}, [550.0])
    >>> print(background.wavelength_nm)
    [550.]
    """
    require_one_of(_REFERENCES, reference, "reference")
    samples = np.array(floats("wavelength_nm", wavelength_nm))
    require_kind(animations, Mapping, "sky.lobes.background_of_lobes({'town': lobe}, [550.0])")
    curves: dict[bytes, np.ndarray] = {}
    built: dict[str, Animation] = {}
    for title, one_or_more in animations.items():
        keys = [one_or_more] if isinstance(one_or_more, SkyLobe) else list(one_or_more)
        if not keys:
            raise SceneError(f"animation {title!r} has no lobe")
        rows = []
        for lobe in keys:
            require_kind(lobe, SkyLobe, "sky.lobes.SkyLobe(kind='hg', width=0.8, spectrum=[1e-8])")
            require_one_of(KINDS, lobe.kind, "the kind of a lobe")
            spectrum = np.array(floats(f"the spectrum of {title!r}", lobe.spectrum))
            if spectrum.shape != samples.shape:
                message = f"a spectrum of shape {spectrum.shape} for {samples.size} wavelengths"
                raise SceneError(f"animation {title!r}: {message}")
            curves.setdefault(spectrum.tobytes(), spectrum)
            rows.append(list(curves).index(spectrum.tobytes()))
        built[title] = _animation(keys, rows, _REFERENCES[reference], int(time_point_s))
    return BackgroundFile(
        info=BackgroundInfo(name=name, author=author, description=description, organization=organization),
        animations=built,
        wavelength_nm=frozen(samples),
        curves=frozen(np.stack(list(curves.values())) if curves else np.zeros((0, samples.size))),
    )


def _animation(
    lobes: Sequence[SkyLobe], curve_index: list[int], reference: ReferenceType, time_point_s: int
) -> Animation:
    quaternion = [axis_quaternion(one.zenith_deg, one.azimuth_deg, one.turn_deg) for one in lobes]
    width_y = [0.0 if one.kind == "hg" else one.width if one.width_y is None else one.width_y for one in lobes]
    return Animation(
        lobe_type=frozen(np.array([KINDS[one.kind] for one in lobes], np.uint8)),
        param0=frozen(np.array([one.width for one in lobes], np.float64)),
        param1=frozen(np.array(width_y, np.float64)),
        coefficient=frozen(np.array([one.factor for one in lobes], np.float64)),
        quaternion=normalised(np.array(quaternion, np.float64)),
        curve_index=frozen(np.array(curve_index, np.int64)),
        relative_time_days=frozen(np.array([one.time_days for one in lobes], np.float64)),
        reference=reference,
        time_point_s=time_point_s,
    )


def axis_quaternion(zenith_deg: float, azimuth_deg: float, turn_deg: float = 0.0) -> tuple[float, float, float, float]:
    """Rotation that takes local +z to a direction of the sky, after a turn about +z.

    R_z(azimuth) R_y(zenith) R_z(turn) as (w, x, y, z), length 1 within 4e-16.
    """
    sine, cosine = sin_cos_deg(np.array([zenith_deg, azimuth_deg, turn_deg], dtype=np.float64) / 2)
    (sz, sa, st), (cz, ca, ct) = sine.tolist(), cosine.tolist()
    w, x, y, z = ca * cz, -sa * sz, ca * sz, sa * cz
    return w * ct - z * st, x * ct + y * st, y * ct - x * st, w * st + z * ct
