"""Background-sky files become a sky."""

from __future__ import annotations

import os
from pathlib import Path

from aomc_sky.formats.background.data import Animation, BackgroundFile, LobeType, ReferenceType
from aomc_sky.formats.background.file import read_background_file
from aomc_sky.skies.lobes.animation import LobeAnimation, Reference
from aomc_sky.skies.lobes.background import BackgroundSky

_KIND = {LobeType.HENYEY_GREENSTEIN: "hg", LobeType.GGX: "ggx", LobeType.BECKMANN: "beckmann"}
_REFERENCE = {
    ReferenceType.ABSOLUTE: Reference.ABSOLUTE,
    ReferenceType.DIURNAL: Reference.DIURNAL,
    ReferenceType.HEBDOMADAL: Reference.HEBDOMADAL,
}


def read_background(path: str | os.PathLike[str], *, utc_offset_h: float = 0.0) -> BackgroundSky:
    """Read a background-sky file (DIRSIG BackgroundSkyData, HDF5) as a sky.

    Parameters
    ----------
    path : str or path
        The file.
    utc_offset_h : float
        Local time less UTC: where the midnight of diurnal and weekly animations lies. [h]

    Returns
    -------
    BackgroundSky
        Its animations, in absolute units.

    Raises
    ------
    InputFileError
        Everything that is wrong with the file, together.
    MissingExtraError
        h5py is not installed.
    SceneError
        The UTC offset is not finite.
    """
    return background_sky(read_background_file(Path(path)), utc_offset_h=utc_offset_h)


def background_sky(file: BackgroundFile, *, utc_offset_h: float = 0.0) -> BackgroundSky:
    """The sky that a background-sky file, read or built in Python, describes."""
    return BackgroundSky(
        animations={name: _animation(one) for name, one in file.animations.items()},
        wavelength_nm=file.wavelength_nm,
        curves=file.curves,
        utc_offset_h=utc_offset_h,
    )


def _animation(one: Animation) -> LobeAnimation:
    return LobeAnimation(
        kind=tuple(_KIND[LobeType(kind)] for kind in one.lobe_type.tolist()),
        param0=one.param0,
        param1=one.param1,
        coefficient=one.coefficient,
        quaternion=one.quaternion,
        curve=one.curve_index,
        time_days=one.relative_time_days,
        reference=_REFERENCE[one.reference],
        reference_unix_s=float(one.time_point_s),
    )
