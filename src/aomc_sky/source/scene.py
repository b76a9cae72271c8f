"""A scene: wavebands, how many photons each gets, where they enter, and what shines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.errors import SceneError
from aomc_sky.float_mode import in_default_mode
from aomc_sky.footprint import Footprint
from aomc_sky.sampling.allocation import MAX_PHOTONS
from aomc_sky.source.irradiance import Irradiance
from aomc_sky.source.options import SamplingOptions, resolve_options
from aomc_sky.wavebands import Wavebands
from aomc_sky.whole_number import as_index

if TYPE_CHECKING:
    from aomc_sky.source.photon_source import PhotonSource


@dataclass(frozen=True, kw_only=True, slots=True)
class Scene:
    """What a run models, and nothing else.

    Parameters
    ----------
    wavebands : Wavebands
        The wavebands of the run.
    n_photons : array_like, int64, shape (n_band,)
        Photons wanted in each band. [0 to 2^62]
    components : tuple of Component, or of sky models
        What shines. A model (`UniformSky`, `DirectBeam`, `TabulatedSky`) is lowered at the
        wavelengths of the bands, a row for each. Names are unique.
    row_of_band : array_like, int, shape (n_band,), optional
        Row of the components' strengths and masses that serves each band; by default row = band, or
        row 0 for components with one row.
    sky_wavelength_nm : array_like, float64, shape (n_band,), optional
        Wavelength of the sky that serves each band, NaN where a sky has none. [nm]
    footprint : Footprint
        Where photons enter the surface.
    preset : SamplingOptions
        Sampling choices that hold unless a caller chooses.
    preset_name : str, optional
        Name of a preset that no choice may contradict (``--compat aomc``).
    notes : tuple of str
        What a run should tell its user, a line each.
    input_files : mapping
        Role ("amc", "skydist" ...) to path of the files the scene came from.
    options : mapping
        How the files were read: JSON values.
    irradiance : Irradiance, optional
        Absolute units; by default what the components say of themselves, where all of them do (`LobeSky`).
        Photons follow `strength` alone.
    """

    wavebands: Wavebands
    n_photons: np.ndarray
    components: tuple[Component, ...]
    row_of_band: np.ndarray = None  # type: ignore[assignment]
    sky_wavelength_nm: np.ndarray = None  # type: ignore[assignment]
    footprint: Footprint = field(default_factory=Footprint)
    preset: SamplingOptions = field(default_factory=SamplingOptions)
    preset_name: str | None = None
    notes: tuple[str, ...] = ()
    input_files: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    irradiance: Irradiance | None = None

    @in_default_mode
    def __post_init__(self) -> None:
        n_bands = self.wavebands.n_bands
        object.__setattr__(self, "components", self._lowered())
        if not self.components:
            raise SceneError("a scene needs at least one component that shines")
        names = [c.name for c in self.components]
        if len(set(names)) != len(names):
            raise SceneError(f"component names must differ, got {names}")
        if sum(c.law is Law.PEREZ for c in self.components) > 1:
            raise SceneError("a scene can have one component of law PEREZ; give the others within='uniform'")
        n_rows = {c.strength.size for c in self.components}
        if len(n_rows) != 1:
            raise SceneError(f"components must have equally many rows, got {sorted(n_rows)}")
        rows: np.ndarray | None = self.row_of_band
        if rows is None:
            rows = np.zeros(n_bands, np.int64) if n_rows == {1} else np.arange(n_bands)
        table: np.ndarray | None = self.sky_wavelength_nm
        self._set("n_photons", _whole_photons(self.n_photons, n_bands))
        if np.asarray(rows).dtype.kind not in "iu":
            raise SceneError(f"row_of_band must be whole numbers, got an array of {np.asarray(rows).dtype}")
        self._set("row_of_band", np.array(rows, dtype=np.int64))
        self._set("sky_wavelength_nm", np.full(n_bands, np.nan) if table is None else np.array(table, dtype=np.float64))
        is_row = (self.row_of_band >= 0) & (self.row_of_band < n_rows.pop())
        if self.row_of_band.shape != (n_bands,) or not np.all(is_row):
            raise SceneError(f"row_of_band must name an existing row for each of {n_bands} bands")
        if self.sky_wavelength_nm.shape != (n_bands,):
            raise SceneError(f"sky_wavelength_nm must have one entry for each of {n_bands} bands")
        if self.irradiance is None:
            object.__setattr__(self, "irradiance", Irradiance.of_components(self.components, self.row_of_band))
        expected = (n_bands, len(self.components))
        if self.irradiance is not None and self.irradiance.of_component.shape != expected:
            raise SceneError(f"irradiance must have one entry for each of {n_bands} bands and {expected[1]} components")

    def _lowered(self) -> tuple[Component, ...]:
        """The components, those of models among them."""
        parts: list[Component] = []
        for part in self.components:
            parts += [part] if isinstance(part, Component) else part.lower(self.wavebands.wavelength_nm)
        return tuple(parts)

    def _set(self, name: str, array: np.ndarray) -> None:
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    def is_lit(self, band: int) -> bool:
        """Whether any component sends light in a band."""
        row = int(self.row_of_band[as_index(band, "band")])
        return any(c.strength[row] > 0 and c.mass_of(row).max(initial=0.0) > 0 for c in self.components)

    def refuse_dark_band(self, band: int) -> NoReturn:
        """Raise the error for a band that wants photons and has no light."""
        band = as_index(band, "band")
        wavelength = self.wavebands.wavelength_nm[band]
        sky = self.sky_wavelength_nm[band]
        where = "" if np.isnan(sky) else f" (the sky's values at {sky:g} nm are all zero)"
        raise SceneError(
            f"waveband {band + 1} at {wavelength:g} nm has no light{where}, so its {int(self.n_photons[band])} "
            "photons cannot be launched; give the sky a positive value there or remove the waveband"
        )

    @in_default_mode
    def source(
        self,
        seed: int = 0,
        *,
        allocation: str | None = None,
        method: str | None = None,
        placement: str | None = None,
        order: str | None = None,
        precision: str = "float32",
        weights: bool = False,
        replicates: int = 1,
        max_memory_bytes: int | None = None,
    ) -> PhotonSource:
        """Settle the photon counts and return the source that emits them.

        Parameters
        ----------
        seed : int
            Seed of the run; equal scene, seed and options give equal photons. [0 to 2^64 - 1]
        allocation : {"systematic", "largest-remainder", "multinomial", "aomc"}, optional
            How integers are shared out. None here and below: the scene's preset.
        method : {"stratified", "iid"}, optional
            "iid" means multinomial counts and Philox placement.
        placement : {"r2", "philox", "centre"}, optional
            Where a photon lies in its cell.
        order : {"shuffled", "patch"}, optional
            Keyed random order, every prefix a fair sample; or cell by cell.
        precision : {"float32", "float64"}
            Of directions, positions and weights.
        weights : bool
            Carry a weight per photon where the launch law is not the flux law.
        replicates : int
            Independent randomisations that share the photons of each band, for error bars; no choice for
            `aomc` allocation, which has no randomness. [1 to 4096, at most the photons of a band]
        max_memory_bytes : int, optional
            Refuse a plan that takes more before it takes any; 2 GiB by default. [bytes]

        Returns
        -------
        PhotonSource
            Stateless and picklable.
        """
        from aomc_sky.sampling.streams import checked_seed
        from aomc_sky.source.build_plan import build_plan
        from aomc_sky.source.photon_source import PhotonSource

        options = resolve_options(
            self.preset,
            preset_name=self.preset_name,
            allocation=allocation,
            method=method,
            placement=placement,
            order=order,
            precision=precision,
            weights=weights,
            replicates=replicates,
        )
        return PhotonSource(build_plan(self, checked_seed(seed), options, max_memory_bytes))


def _whole_photons(n_photons: object, n_bands: int) -> np.ndarray:
    given = np.asarray(n_photons)
    if given.ndim == 0:
        given = np.full(n_bands, given)
    if given.shape != (n_bands,):
        raise SceneError(f"n_photons must have one entry for each of {n_bands} bands, got shape {given.shape}")
    if given.dtype.kind not in "iu" and not (given.dtype.kind == "f" and np.all(given == np.rint(given))):
        raise SceneError("n_photons must be whole numbers")
    if np.any(given < 0) or np.any(given > MAX_PHOTONS):
        raise SceneError(f"n_photons must lie within 0 and 2^62 = {MAX_PHOTONS}")
    return np.array(given, dtype=np.int64)
