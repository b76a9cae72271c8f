"""Lobes with their light in absolute units, as they stand at one time, and the components that the sampler gets."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component
from aomc_sky.errors import SceneError, floats, require_kind
from aomc_sky.phase.vectorised import real
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.lobes.envelope import LAWS, LobeFrame, envelopes_of
from aomc_sky.skies.lobes.horizon import LobeWeightingWord, mass_above_horizon, masses_of_lobe
from aomc_sky.skies.lobes.lobe import KindWord, checked, pdf, to_local, vertical_in_local
from aomc_sky.skies.model import Share, check_share, with_share

#: A smaller projected share of a lobe counts as none.
LEAST_MASS = 1e-200
_NO_PLAIN_WORD = re.compile(r"[^A-Za-z0-9_.:+#()@ -]")
_MAX_NAME = 80
FLOAT32_TOLERANCE = 1e-6  # files are float32: 0.400 um is 0.4000000059 there, and 1e30 is above 1e30


#: Beyond this roughness, and this ratio of both, numbers of the sampler overflow, and photons may travel upward.
ROUGHNESS, ROUGHNESS_RATIO = (1e-30, 1e30), 1e20


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class WeightedLobe:
    """One lobe as it stands at one time, with its light.

    Parameters
    ----------
    name : str
        What the lobe is called in counts.csv and in the manifest.
    kind : str
        "hg", "ggx" or "beckmann".
    param0, param1 : float
        g and nothing [0 <= g < 1], or the roughness along local x and y [1e-30 to 1e30; ratio up to 1e20].
    quaternion : ndarray, float64, shape (4,)
        Rotation (w, x, y, z) from local to world, of any length but 0.
    wavelength_nm : ndarray, float64, shape (n_wavelength,)
        Wavelengths of the spectrum, rising. [nm]
    spectrum : ndarray, float64, shape (n_wavelength,)
        Spectral irradiance integrated over the whole sphere. [W m-2 nm-1, >= 0]

    Examples
    --------
    >>> glow = sky.lobes.WeightedLobe(
    ...     name="glow",
    ...     kind="ggx",
    ...     param0=0.3,
    ...     param1=0.3,
    ...     quaternion=np.array([1.0, 0.0, 0.0, 0.0]),
    ...     wavelength_nm=np.array([440.0, 550.0]),
    ...     spectrum=np.array([1e-8, 2e-8]),
    ... )
    >>> sky.LobeSky(lobes=(glow,)).lobes[0].name
    'glow'
    """

    name: str
    kind: KindWord
    param0: float
    param1: float
    quaternion: np.ndarray
    wavelength_nm: np.ndarray
    spectrum: np.ndarray

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("quaternion", "wavelength_nm", "spectrum"):
            array = np.array(floats(name, getattr(self, name)))
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        checked(self.kind, self.param0, self.param1)
        least, most = sorted((self.param0, self.param1))
        slack = 1 + FLOAT32_TOLERANCE
        is_usable = ROUGHNESS[0] <= least * slack and most <= min(ROUGHNESS[1], ROUGHNESS_RATIO * least) * slack
        if self.kind != "hg" and not is_usable:
            raise SceneError(
                f"the roughness of a lobe that sends photons must be from {ROUGHNESS[0]:g} to {ROUGHNESS[1]:g}, with a "
                f"ratio up to {ROUGHNESS_RATIO:g}, got {self.param0:g} and {self.param1:g}; for light from one "
                "direction write DirectBeam"
            )
        if self.quaternion.shape != (4,):
            raise SceneError("the quaternion of a lobe has four components (w, x, y, z)")
        vertical_in_local(self.quaternion)
        checked_samples(self.wavelength_nm, np.atleast_2d(self.spectrum))

    def irradiance(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Spectral irradiance integrated over the whole sphere, linear in wavelength [nm]. [W m-2 nm-1]

        SceneError: a wavelength is outside the spectrum by more than 1e-6 of itself.
        """
        row: np.ndarray = spectra_at(wavelength_nm, self.wavelength_nm, self.spectrum[None])[0]
        return row

    def share(self, weighting: LobeWeightingWord) -> float:
        """Share of the lobe above the horizon, "plain", or on a horizontal plane, "projected". [0 to 1]"""
        return float(mass_above_horizon(self.kind, self.param0, self.param1, self.quaternion, weighting=weighting))


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class LobeSky(Share):
    """A sky of lobes in absolute units: a background sky at one time, or lobes made by hand.

    Parameters
    ----------
    lobes : tuple of WeightedLobe
        The lobes; their light adds. No lobe: a black sky.
    texts : tuple of str
        Notes for a person, such as what the file says in words.
    strength, irradiance_W_m2_nm : array_like, optional
        Instead of its own irradiance, as for `UniformSky`. [>= 0]

    Examples
    --------
    >>> town = sky.lobes.WeightedLobe(
    ...     name="town",
    ...     kind="hg",
    ...     param0=0.8,
    ...     param1=0.0,
    ...     quaternion=np.array([1.0, 0.0, 0.0, 0.0]),
    ...     wavelength_nm=np.array([550.0]),
    ...     spectrum=np.array([1e-8]),
    ... )
    >>> sky.Scene(
    ...     wavebands=[550.0], n_photons=1000, components=sky.LobeSky(lobes=(town,))
    ... ).source().total
    1000
    """

    lobes: tuple[WeightedLobe, ...]
    texts: tuple[str, ...] = field(default=(), compare=False)

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_share(self)
        object.__setattr__(self, "lobes", tuple(self.lobes))
        for lobe in self.lobes:
            require_kind(lobe, WeightedLobe, "lobes=(sky.lobes.WeightedLobe(...),)")
        names = [lobe.name for lobe in self.lobes]
        if len(set(names)) < len(names):
            raise SceneError(f"the names of the lobes of a sky must differ, got {', '.join(names)}")

    def irradiance(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Spectral irradiance of all lobes, over the whole sphere, as `WeightedLobe.irradiance`. [W m-2 nm-1]"""
        return sum((lobe.irradiance(wavelength_nm) for lobe in self.lobes), np.zeros(np.shape(wavelength_nm)))

    def notes(self, wavelength_nm: ArrayLike) -> tuple[str, ...]:
        """What the files of the lobes say in words."""
        return self.texts

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """Components with the exact flux law, in absolute units, a row for each wavelength.

        One for each lobe of which light reaches a horizontal plane, called as the lobe; letters that a table or netCDF
        cannot hold are replaced. Its `strength` is the irradiance of the plane, `below_horizon` the share of the lobe
        below the horizon. Lobes with a projected share below `LEAST_MASS` are left out. About 1 to 3 ms a lobe; equal
        lobes share the work. SceneError: a wavelength is outside the spectra.
        """
        names = [plain_name(lobe.name) for lobe in self.lobes]
        if len(set(names)) < len(names):
            raise SceneError(f"the names of lobes must differ, got {names}")
        wavelength = np.atleast_1d(floats("wavelength_nm", wavelength_nm))
        light = {name: lobe.irradiance(wavelength) for name, lobe in zip(names, self.lobes, strict=True)}
        shape = {
            name: (lobe.kind, lobe.param0, lobe.param1, lobe.quaternion.tobytes())
            for name, lobe in zip(names, self.lobes, strict=True)
            if light[name].max(initial=0.0) > 0.0
        }
        unit = _unit_lobes(dict.fromkeys(shape.values()))
        parts = []
        for name in shape:
            if shape[name] in unit:
                plane = light[name] * unit[shape[name]].strength[0]
                parts.append(replace(unit[shape[name]], name=name, strength=plane, irradiance_W_m2_nm=plane))
        return with_share(self, tuple(parts))

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of the sky: the sum over the lobes of irradiance times density. [W m-2 sr-1 nm-1]

        SceneError: a wavelength is outside the spectra.
        """
        zenith, azimuth = np.broadcast_arrays(sky_zenith_rad, sky_azimuth_rad)
        sine = np.sin(zenith)
        world = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)], axis=-1)
        total = np.zeros(np.broadcast_shapes(zenith.shape, np.shape(wavelength_nm)))
        for lobe in self.lobes:
            density = pdf(lobe.kind, lobe.param0, lobe.param1, to_local(lobe.quaternion, world))
            total = total + lobe.irradiance(wavelength_nm) * density
        return total


def _unit_lobes(shapes: Iterable[tuple[str, float, float, bytes]]) -> dict[tuple[str, float, float, bytes], Component]:
    """Components of lobes with the irradiance 1 over the sphere, without those that lie below the horizon."""
    frames: dict[str, dict[Any, LobeFrame]] = {kind: {} for kind in LAWS}
    masses = {}
    for shape in shapes:
        kind, first, second, quaternion = shape[0], float(shape[1]), float(shape[2]), np.frombuffer(shape[3])
        masses[shape] = masses_of_lobe(kind, first, second, vertical_in_local(quaternion))
        if masses[shape][1] > LEAST_MASS:
            frames[kind][shape] = LobeFrame.of(kind, first, second, quaternion)
    units = {}
    for kind, own in frames.items():
        for (shape, frame), (cells, _) in zip(own.items(), envelopes_of(list(own.values())), strict=True):
            above, projected, squared = masses[shape]
            units[shape] = Component(
                name=kind,
                law=LAWS[kind],
                strength=np.array([projected]),
                mass=np.ones((1, 1)),
                cell=np.array([[squared / projected, 0.0, above / projected, 0.0, 0.0, 1.0]]),
                shared=np.array([*frame.matrix.ravel(), frame.asymmetry]),
                bounds=cells,
                below_horizon=max(1.0 - above, 0.0),
            )
    return units


def plain_name(name: str) -> str:
    """The name of a file with letters that columns of counts.csv and variables of netCDF may have."""
    return _NO_PLAIN_WORD.sub("_", name.replace("/", ":"))[:_MAX_NAME].strip()


def spectra_at(wavelength_nm: ArrayLike, sample_nm: np.ndarray, curves: np.ndarray) -> np.ndarray:
    """Curves at wavelengths, linear between their samples, shape (n_curve, ...).

    The end samples hold for a wavelength outside by no more than 1e-6 of itself; farther outside is an error.
    """
    wavelength = real(wavelength_nm)
    low, high = sample_nm[0], sample_nm[-1]
    inside = (wavelength >= low * (1 - FLOAT32_TOLERANCE)) & (wavelength <= high * (1 + FLOAT32_TOLERANCE))
    if not np.all(inside):
        first = wavelength[~inside].flat[0]
        raise SceneError(f"{first:g} nm is outside the background's curves, {low:g} to {high:g} nm")
    return np.stack([np.interp(wavelength, sample_nm, curve) for curve in curves])


def checked_samples(sample_nm: np.ndarray, curves: np.ndarray) -> None:
    """Refuse wavelengths that do not rise and curves that do not fit them or are no light."""
    rises = sample_nm.ndim == 1 and sample_nm.size > 0 and bool(np.all(np.diff(sample_nm) > 0.0))
    if not rises or not np.all(np.isfinite(sample_nm)):
        raise SceneError("the wavelengths of a background sky must be finite and must increase")
    if curves.ndim != 2 or curves.shape[1] != sample_nm.size:
        raise SceneError("every curve of a background sky has one value for each wavelength")
    if not np.all((curves >= 0.0) & (curves < np.inf)):
        raise SceneError("the curves of a background sky must be finite and not negative")
