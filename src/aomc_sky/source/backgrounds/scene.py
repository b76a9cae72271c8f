"""Background-sky files at one time, ready to be shown and sampled without AMC files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.formats.background.data import BackgroundFile
from aomc_sky.formats.report import nearest
from aomc_sky.formats.sky_toml.keys import BackgroundSection
from aomc_sky.skies.lobes.horizon import mass_above_horizon
from aomc_sky.skies.lobes.lobe import rotation_matrix
from aomc_sky.skies.lobes.sky import LobeSky, WeightedLobe, plain_name
from aomc_sky.source.backgrounds.light import read_background_files, sky_at

_TOLERANCE = 1e-6  # 0.400 um is 0.4000000059 in float32


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeScene:
    """Backgrounds at one time and at some wavelengths."""

    sections: tuple[BackgroundSection, ...]  #: files, time, animations
    skies: tuple[LobeSky, ...]  #: the sky of each file
    wavelength_nm: np.ndarray  #: (n_wl,)

    @property
    def lobes(self) -> tuple[tuple[str, WeightedLobe], ...]:
        """Names and lobes of all files, in their order."""
        several = len(self.skies) > 1
        return tuple(
            (plain_name(f"{number}:{lobe.name}" if several else lobe.name), lobe)
            for number, sky in enumerate(self.skies, start=1)
            for lobe in sky.lobes
        )

    def irradiance(self, *, above: str = "sphere") -> np.ndarray:
        """Irradiance of each lobe, (n_lobe, n_wl): `above` says which part of it counts. [W m-2 nm-1]

        "sphere": the whole lobe; "plain": its part above the horizon; "projected": that part on a horizontal plane.
        """
        rows = [lobe.irradiance(self.wavelength_nm) * self.share(lobe, above) for _, lobe in self.lobes]
        return np.array(rows).reshape(-1, self.wavelength_nm.size)

    @property
    def horizon_loss(self) -> np.ndarray:
        """Share of the light of all lobes from below the horizon, shape (n_wl,); 0 without light. [0 to 1]"""
        sphere, above = (self.irradiance(above=part).sum(axis=0) for part in ("sphere", "plain"))
        share = np.divide(sphere - above, sphere, out=np.zeros_like(sphere), where=sphere > 0)
        return np.clip(share, 0.0, 1.0)

    def share(self, lobe: WeightedLobe, above: str) -> float:
        """Share of a lobe that counts, see `irradiance`."""
        if above == "sphere":
            return 1.0
        return float(mass_above_horizon(lobe.kind, lobe.param0, lobe.param1, lobe.quaternion, weighting=above))


def axis_of(lobe: WeightedLobe) -> tuple[float, float]:
    """Zenith angle and azimuth of the axis of a lobe. [deg; azimuth from +x towards +y, 0 to below 360]"""
    x, y, z = rotation_matrix(lobe.quaternion)[:, 2]
    return float(np.degrees(np.arctan2(np.hypot(x, y), z))), float(np.degrees(np.arctan2(y, x)) % 360.0)


def read_lobe_scene(sections: Sequence[BackgroundSection], wavelength_nm: Sequence[float] | None) -> LobeScene:
    """Read background-sky files, by default at the wavelengths of the first that lie inside the spectra of all. [nm]

    UsageError: an animation that no file has, a wavelength outside the spectra of one.
    """
    files = read_background_files([section.file for section in sections])
    _refuse_absent(sections, files)
    skies = tuple(sky_at(files[section.file], section) for section in sections)
    return LobeScene(sections=tuple(sections), skies=skies, wavelength_nm=_wavelengths(files, wavelength_nm))


def _refuse_absent(sections: Sequence[BackgroundSection], files: dict[str, BackgroundFile]) -> None:
    known = dict.fromkeys(name for file in files.values() for name in file.animations)
    for section in sections:
        for name in section.animation or ():
            if name not in known:
                best, listed = plain_name(nearest(name, known)), ", ".join(map(plain_name, known))
                raise UsageError(f"no file has an animation {name!r}; the nearest is {best}, there are: {listed}")


def _wavelengths(files: dict[str, BackgroundFile], requested: Sequence[float] | None) -> np.ndarray:
    low = max(file.wavelength_nm[0] for file in files.values())
    high = min(file.wavelength_nm[-1] for file in files.values())
    if requested is None:
        first = next(iter(files.values())).wavelength_nm
        common = first[(first >= low) & (first <= high)]
        if common.size == 0:
            raise UsageError("the spectra of the files have no wavelength in common")
        return common
    for value in requested:
        if not low * (1 - _TOLERANCE) <= value <= high * (1 + _TOLERANCE):
            raise UsageError(f"--wavelength {value:g} is outside the spectra of the files, {low:g} to {high:g} nm")
    return np.array(requested, dtype=np.float64)
