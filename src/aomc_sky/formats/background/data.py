"""What a background-sky file holds: lobe animations and the spectra they share, and its names, units and layouts."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np


class LobeType(enum.IntEnum):
    """Functional form of a lobe, with the number that stands in the file."""

    HENYEY_GREENSTEIN = 1
    GGX = 2
    BECKMANN = 3


class ReferenceType(enum.IntEnum):
    """What relative times count from, with the number that stands in the file."""

    ABSOLUTE = 1
    """A point in time; the animation does not repeat."""
    DIURNAL = 2
    """The most recent midnight."""
    HEBDOMADAL = 3
    """Midnight at the begin of the most recent Sunday."""

    @property
    def period_days(self) -> float:
        """Latest relative time that a key can have. [d]"""
        return {ReferenceType.ABSOLUTE: np.inf, ReferenceType.DIURNAL: 1.0}.get(self, 7.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class Lobe:
    """One lobe at one time, the unit from which animations are built.

    Parameters
    ----------
    lobe_type : LobeType
        Functional form.
    param0, param1 : float
        Asymmetry g and nothing [0 <= g < 1], or the roughness along local x and local y [> 0].
    coefficient : float
        Factor of the curve. [>= 0]
    quaternion : tuple of float
        Rotation (w, x, y, z) from the local frame, axis +z, to the world; of any length but 0.
    curve_index : int
        Row of the spectra. [from 0]
    relative_time_days : float
        Time since the reference time. [d]
    """

    lobe_type: LobeType
    param0: float
    param1: float = 0.0
    coefficient: float = 1.0
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    curve_index: int = 0
    relative_time_days: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Animation:
    """Lobes over time: the keys of one animation, in the order of time.

    Parameters
    ----------
    lobe_type : ndarray, uint8, shape (n_key,)
        Functional form of each key, values of `LobeType`.
    param0, param1 : ndarray, float64, shape (n_key,)
        Shape parameters, see `Lobe`.
    coefficient : ndarray, float64, shape (n_key,)
        Factors of the curve. [>= 0]
    quaternion : ndarray, float64, shape (n_key, 4)
        Rotations (w, x, y, z) from the local frame, axis +z, to the world (x east, y north, z up).
        [length 1 within 4e-16]
    curve_index : ndarray, int64, shape (n_key,)
        Rows of the spectra. [0 to n_curve - 1]
    relative_time_days : ndarray, float64, shape (n_key,)
        Times since the reference time, never falling; of equal ones the later key wins. [d]
    reference : ReferenceType
        What relative times count from.
    time_point_s : int
        The reference time of type ABSOLUTE in seconds since 1970-01-01 UTC; without meaning otherwise. [s]
    """

    lobe_type: np.ndarray
    param0: np.ndarray
    param1: np.ndarray
    coefficient: np.ndarray
    quaternion: np.ndarray
    curve_index: np.ndarray
    relative_time_days: np.ndarray
    reference: ReferenceType
    time_point_s: int = 0

    def __len__(self) -> int:
        return int(self.lobe_type.size)


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundInfo:
    """What a file says of itself; an empty text is absent.

    Parameters
    ----------
    name, author, description, organization : str
        Texts for persons.
    file_type : int
        Number of the data model; 5 in the files known to us, the format does not state it.
    format_version : int
        Version of the format. [1]
    """

    name: str = ""
    author: str = ""
    description: str = ""
    organization: str = ""
    file_type: int = 5
    format_version: int = 1


@dataclass(frozen=True, kw_only=True, slots=True)
class BackgroundFile:
    """A background-sky file in our units.

    Parameters
    ----------
    info : BackgroundInfo
        What the file says of itself.
    animations : mapping of str to Animation
        The animations by name; their light adds.
    wavelength_nm : ndarray, float64, shape (n_wavelength,)
        Wavelengths of the curves, rising. [nm]
    curves : ndarray, float64, shape (n_curve, n_wavelength)
        Spectral irradiance, integrated over the sphere. [W m-2 nm-1, >= 0]
    """

    info: BackgroundInfo = field(default_factory=BackgroundInfo)
    animations: Mapping[str, Animation]
    wavelength_nm: np.ndarray
    curves: np.ndarray


def animation_of_lobes(
    lobes: Sequence[Lobe], *, reference: ReferenceType = ReferenceType.DIURNAL, time_point_s: int = 0
) -> Animation:
    """Make an animation from a list of lobes in the order of time.

    Parameters
    ----------
    lobes : sequence of Lobe
        The keys; one lobe alone stands still.
    reference : ReferenceType
        What their relative times count from.
    time_point_s : int
        The reference time of type ABSOLUTE. [s since 1970-01-01 UTC]

    Returns
    -------
    Animation
        Its values are checked where they are written or made a sky of.
    """
    quaternion = np.array([lobe.quaternion for lobe in lobes], np.float64).reshape(-1, 4)
    return Animation(
        lobe_type=frozen(np.array([lobe.lobe_type for lobe in lobes], np.uint8)),
        param0=frozen(np.array([lobe.param0 for lobe in lobes], np.float64)),
        param1=frozen(np.array([lobe.param1 for lobe in lobes], np.float64)),
        coefficient=frozen(np.array([lobe.coefficient for lobe in lobes], np.float64)),
        quaternion=normalised(quaternion),
        curve_index=frozen(np.array([lobe.curve_index for lobe in lobes], np.int64)),
        relative_time_days=frozen(np.array([lobe.relative_time_days for lobe in lobes], np.float64)),
        reference=ReferenceType(reference),
        time_point_s=int(time_point_s),
    )


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


EXTRA = "hdf5"
NM_PER_UM = 1e3
SI_PER_FILE_UNIT = 10.0
"""W m-2 nm-1 in one W cm-2 um-1."""

TEXTS = {"Name": "name", "Author": "author", "Description": "description", "Organization": "organization"}
NUMBERS = {"FileType": "file_type", "FormatVersion": "format_version"}
OPTIONAL = ("Description", "Organization")
INFORMING = tuple(f"{prefix}{name}" for prefix in ("Info/", "@") for name in ("FileType", *TEXTS))
"""Members that say something to persons and nothing to us: no reason to refuse a file, whatever they hold."""
WANTED = (
    *(f"{prefix}{name}" for prefix in ("Info/", "@") for name in (*NUMBERS, *TEXTS)),
    "LobeAnims/*/Lobes",
    "LobeAnims/*/ReferenceTime",
    "SpectralCurves",
    "SpectralSamples",
)
LOBE = np.dtype(
    [
        ("Type", "<u4"),
        ("Param0", "<f4"),
        ("Param1", "<f4"),
        ("Coeff", "<f4"),
        ("LocalTransform", "<f4", (4,)),
        ("CurveIndex", "<u4"),
        ("RelativeTime", "<f4"),
    ]
)
REFERENCE = np.dtype({"names": ["Type", "TimePoint"], "formats": ["<u4", "<u8"], "offsets": [0, 8], "itemsize": 16})
