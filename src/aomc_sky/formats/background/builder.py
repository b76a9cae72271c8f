"""Background-sky files from lobes as a person describes them: an axis on the sky, a shape, a spectrum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.formats.background.data import (
    Animation,
    BackgroundFile,
    BackgroundInfo,
    Lobe,
    LobeType,
    ReferenceType,
    animation_of_lobes,
    frozen,
)

_KINDS = {"hg": LobeType.HENYEY_GREENSTEIN, "ggx": LobeType.GGX, "beckmann": LobeType.BECKMANN}
_REFERENCES = {one.name.lower(): one for one in ReferenceType}


@dataclass(frozen=True, kw_only=True, slots=True)
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
    zenith_deg, azimuth_deg : float
        Where the axis points; azimuth from +x (east) towards +y (north). [deg]
    turn_deg : float
        Turn of the lobe about its axis. At 0 local x points down along the meridian of the axis, local y along the
        horizon, towards growing azimuth. [deg]
    spectrum : array_like, shape (n_wavelength,)
        Irradiance integrated over the whole sphere. [W m-2 nm-1, >= 0]
    factor : float
        Multiplies the spectrum. [>= 0]
    time_days : float
        Time of this key since the reference of its animation. [d]
    """

    kind: str
    width: float
    width_y: float | None = None
    zenith_deg: float = 0.0
    azimuth_deg: float = 0.0
    turn_deg: float = 0.0
    spectrum: ArrayLike
    factor: float = 1.0
    time_days: float = 0.0


def background_of_lobes(
    animations: Mapping[str, SkyLobe | Sequence[SkyLobe]],
    wavelength_nm: ArrayLike,
    *,
    reference: str = "diurnal",
    time_point_s: int = 0,
    name: str = "",
    author: str = "",
    description: str = "",
    organization: str = "",
) -> BackgroundFile:
    """Build the content of a background-sky file from lobes.

    Parameters
    ----------
    animations : mapping of str to SkyLobe, or to a sequence of them
        One lobe stands still; several are the keys of an animation, in the order of time. The light of the
        animations adds.
    wavelength_nm : array_like, shape (n_wavelength,)
        Wavelengths of the spectra, rising. [nm]
    reference : {"diurnal", "hebdomadal", "absolute"}
        What times count from: midnight, Sunday's midnight, or `time_point_s`.
    time_point_s : int
        The reference time of "absolute". [s since 1970-01-01 UTC]
    name, author, description, organization : str
        Texts for persons.

    Returns
    -------
    BackgroundFile
        For `aomc_sky.write_background`, which checks every value. Equal spectra become one curve.

    Raises
    ------
    UsageError
        An unknown kind or reference.
    SceneError
        A spectrum without one value for each wavelength, or an animation without a lobe.
    """
    if reference not in _REFERENCES:
        raise UsageError(f"reference is one of {', '.join(map(repr, _REFERENCES))}, not {reference!r}")
    samples = np.array(wavelength_nm, dtype=np.float64)
    curves: dict[bytes, np.ndarray] = {}
    built: dict[str, Animation] = {}
    for title, given in animations.items():
        keys = [given] if isinstance(given, SkyLobe) else list(given)
        if not keys:
            raise SceneError(f"animation {title!r} has no lobe")
        lobes = [_lobe(one, _curve_index(one, title, samples, curves)) for one in keys]
        built[title] = animation_of_lobes(lobes, reference=_REFERENCES[reference], time_point_s=time_point_s)
    return BackgroundFile(
        info=BackgroundInfo(name=name, author=author, description=description, organization=organization),
        animations=built,
        wavelength_nm=frozen(samples),
        curves=frozen(np.stack(list(curves.values())) if curves else np.zeros((0, samples.size))),
    )


def _curve_index(lobe: SkyLobe, title: str, samples: np.ndarray, curves: dict[bytes, np.ndarray]) -> int:
    spectrum = np.array(lobe.spectrum, dtype=np.float64)
    if spectrum.shape != samples.shape:
        raise SceneError(f"animation {title!r}: a spectrum of shape {spectrum.shape} for {samples.size} wavelengths")
    curves.setdefault(spectrum.tobytes(), spectrum)
    return list(curves).index(spectrum.tobytes())


def _lobe(lobe: SkyLobe, curve_index: int) -> Lobe:
    if lobe.kind not in _KINDS:
        raise UsageError(f"the kind of a lobe is one of {', '.join(map(repr, _KINDS))}, not {lobe.kind!r}")
    width_y = lobe.width if lobe.width_y is None else lobe.width_y
    return Lobe(
        lobe_type=_KINDS[lobe.kind],
        param0=float(lobe.width),
        param1=0.0 if lobe.kind == "hg" else float(width_y),
        coefficient=float(lobe.factor),
        quaternion=axis_quaternion(lobe.zenith_deg, lobe.azimuth_deg, lobe.turn_deg),
        curve_index=curve_index,
        relative_time_days=float(lobe.time_days),
    )


def axis_quaternion(zenith_deg: float, azimuth_deg: float, turn_deg: float = 0.0) -> tuple[float, float, float, float]:
    """Rotation that takes local +z to a direction of the sky, after a turn about +z.

    R_z(azimuth) R_y(zenith) R_z(turn) as (w, x, y, z), length 1 within 4e-16.
    """
    sine, cosine = sin_cos_deg(np.array([zenith_deg, azimuth_deg, turn_deg], dtype=np.float64) / 2)
    (sz, sa, st), (cz, ca, ct) = sine.tolist(), cosine.tolist()
    w, x, y, z = ca * cz, -sa * sz, ca * sz, sa * cz
    return w * ct - z * st, x * ct + y * st, y * ct - x * st, w * st + z * ct
