"""A scene: wavebands, photons of each, where they enter, and light; and how it becomes a plan.

`build_plan` settles a scene: joint masses, exact integer counts, keys.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

import aomc_sky
from aomc_sky.component import Component
from aomc_sky.directions import given_angle
from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.errors import InputWarning, SceneError, UsageError, require_kind, unmasked
from aomc_sky.float_mode import in_default_mode
from aomc_sky.formats.report import beyond_memory
from aomc_sky.plan.allocation import (
    MAX_PHOTONS,
    AllocationMethod,
    AllocationWord,
    PlanBand,
    checked_photons,
    cumulative_counts,
    normalise,
)
from aomc_sky.plan.bias import bias_of
from aomc_sky.plan.laws import law_of
from aomc_sky.plan.options import (
    Footprint,
    MethodWord,
    OrderWord,
    Placement,
    PlacementWord,
    PrecisionWord,
    SamplingOptions,
    resolve_options,
)
from aomc_sky.plan.plan import Plan
from aomc_sky.plan.streams import STREAM_VERSION, checked_seed
from aomc_sky.record import same_content
from aomc_sky.skies.direct_beam import solar_irradiance
from aomc_sky.skies.model import has_share
from aomc_sky.source.importance import importance_of
from aomc_sky.source.masses import aomc_cumulative, plan_components, refuse_bias
from aomc_sky.wavebands import Wavebands, as_wavebands
from aomc_sky.whole_number import as_index, as_number_of

if TYPE_CHECKING:
    from aomc_sky.emission.photon_source import PhotonSource
    from aomc_sky.emission.radiance import Radiance
    from aomc_sky.skies.model import Lowers, Share, SkyModel

    ComponentLike = Component | SkyModel | Lowers | Share | Callable[..., ArrayLike] | str

ARRAYS_HELD = 3
"""Copies of a plan's arrays in memory while a run writes it: measured, 3.06 for 9e6 cells."""


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Scene:
    """The light and the wavebands of a run.

    Parameters
    ----------
    wavebands : Wavebands, or array_like of float64, shape (n_band,)
        The wavebands of the run, or their wavelengths. [nm]
    n_photons : array_like, int64, shape (n_band,)
        Photons of each band, or one number for all. [0 to 2^62]
    components : Component, sky model or function, or a sequence of them
        The light. A model (`UniformSky`, `DirectBeam`, `TabulatedSky`) is lowered at the wavelengths of the bands, a
        row for each; "uniform" is a model by its name. A function of (sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        becomes a `FunctionSky`. Each of several models has its share, `strength` or `irradiance_W_m2_nm`. Names are
        unique.
    row_of_band : array_like, int, shape (n_band,), optional
        Row of the components' strengths and masses that serves each band; by default row = band, or
        row 0 for components with one row.
    sky_wavelength_nm : array_like, float64, shape (n_band,), optional
        Wavelength of the sky that serves each band, NaN where a sky has none; by default that of the only table. [nm]
    footprint : Footprint
        Where photons enter the surface.
    preset : SamplingOptions
        Sampling choices that hold unless a caller chooses.
    preset_name : str, optional
        Name of a preset that no choice may contradict (``--compat aomc``).
    notes : tuple of str
        Lines that a run prints for its user.
    input_files : mapping
        Role ("amc", "skydist" ...) to path of the files the scene came from.
    options : mapping
        How the files were read: JSON values.
    bias : mapping of str to float
        Share of the photons of components unless a caller chooses; see `source`.
    irradiance : Irradiance, optional
        Absolute units; by default those of the components, if all of them have any (`LobeSky`). Its `component_names`
        are those of the scene, its `total` (n_band,) is their sum.
        Photons follow `strength` alone.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[440.0, 550.0], n_photons=1000, components="overcast")
    >>> source = scene.source(seed=1)
    >>> source.n_bands, source.n_photons(0)
    (2, 1000)
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
    bias: Mapping[str, float] = field(default_factory=dict)
    irradiance: Irradiance | Any = None  # Any in place of None: who knows that it is there need not ask
    _radiance: dict[int, list[Radiance]] = field(init=False, repr=False, compare=False, default_factory=dict)

    if TYPE_CHECKING:  # what may be given, for type checkers; the fields above are what it becomes

        def __init__(
            self,
            *,
            wavebands: Wavebands | ArrayLike,
            n_photons: ArrayLike,
            components: ComponentLike | Sequence[ComponentLike],
            row_of_band: ArrayLike | None = None,
            sky_wavelength_nm: ArrayLike | None = None,
            footprint: Footprint = ...,
            preset: SamplingOptions = ...,
            preset_name: str | None = None,
            notes: tuple[str, ...] = (),
            input_files: Mapping[str, str] = ...,
            options: Mapping[str, Any] = ...,
            bias: Mapping[str, float] = ...,
            irradiance: Irradiance | None = None,
        ) -> None: ...

    __eq__ = same_content

    def __repr__(self) -> str:
        nm = self.wavebands.wavelength_nm
        bands = f"{nm.size} wavebands {nm.min():g} to {nm.max():g} nm" if nm.size > 1 else f"{nm[0]:g} nm"
        names = ", ".join(c.name for c in self.components[:4]) + (", ..." if len(self.components) > 4 else "")
        return f"<Scene: {sum(map(int, self.n_photons))} photons, {bands}; {names}>"

    def _repr_html_(self) -> str:
        from aomc_sky.emission.notebook import MOST_ROWS, html

        nm, photons = self.wavebands.wavelength_nm.tolist(), self.n_photons.tolist()
        known = self.irradiance
        unit = "" if known is None else " [W m-2 nm-1]"
        rows = []
        for band in range(min(len(nm), MOST_ROWS)):
            row = self.row_of_band[band]
            light = [c.strength[row] for c in self.components] if known is None else known.of_component[band]
            rows.append((band, f"{nm[band]:g}", photons[band], *(f"{float(x):.4g}" for x in light)))
        head = ("band", "nm", "photons", *(f"{c.name}{unit}" for c in self.components))
        return html(repr(self)[1:-1], head, rows, len(nm), lambda: self.plot(bands=range(min(len(nm), 3)), size_px=640))

    if TYPE_CHECKING:  # with its arguments
        plot = aomc_sky.plot
    else:

        def plot(self, path: str | Path | None = None, **options: Any) -> Any:
            """Draw the sky dome of each waveband: `aomc_sky.plot` of this scene, with its arguments and its figure."""
            return aomc_sky.plot(self, path, **options)

    @in_default_mode
    def __post_init__(self) -> None:
        self._require_kinds()
        object.__setattr__(self, "wavebands", as_wavebands(self.wavebands))
        n_bands = self.wavebands.n_bands
        of_models = self._lower_components()
        if not self.components:
            raise SceneError("a scene needs at least one component that shines")
        names = [c.name for c in self.components]
        if len(set(names)) != len(names):
            raise SceneError(
                f"component names must differ, got {names}; to rename a model's, give its model.lower(wavelength_nm), "
                'each as dataclasses.replace(component, name="...")'
            )
        laws = [c.law for c in self.components]
        for law in (law for law in laws if laws.count(law) > 1 and law_of(law).instead):
            of_law = " and ".join(repr(c.name) for c in self.components if c.law is law)
            raise SceneError(
                f"components {of_law} are of law {law.name}, of which a scene can have one; the others can be "
                f"{law_of(law).instead}"
            )
        n_rows = {c.strength.size for c in self.components}
        if len(n_rows) != 1:
            raise SceneError(f"components must have equally many rows, got {sorted(n_rows)}")
        rows: np.ndarray | None = self.row_of_band
        if rows is None:
            rows = np.zeros(n_bands, np.int64) if n_rows == {1} else np.arange(n_bands)
        table = of_models if self.sky_wavelength_nm is None else self.sky_wavelength_nm
        self._set("n_photons", _whole_photons(self.n_photons, n_bands))
        if np.asarray(rows).dtype.kind not in "iu":
            raise SceneError(f"row_of_band must be whole numbers, got an array of {np.asarray(rows).dtype}")
        self._set("row_of_band", np.array(rows, dtype=np.int64))
        self._set("sky_wavelength_nm", np.array(table, dtype=np.float64))
        is_row = (self.row_of_band >= 0) & (self.row_of_band < n_rows.pop())
        if self.row_of_band.shape != (n_bands,) or not np.all(is_row):
            raise SceneError(f"row_of_band must name an existing row for each of {n_bands} bands")
        if self.sky_wavelength_nm.shape != (n_bands,):
            raise SceneError(f"sky_wavelength_nm must have one entry for each of {n_bands} bands")
        if self.irradiance is None:
            absolute = [c.name for c in self.components if c.irradiance_W_m2_nm is not None]
            relative = [c.name for c in self.components if c.irradiance_W_m2_nm is None]
            if absolute and relative:
                raise SceneError(
                    f"component {absolute[0]!r} is in W m-2 nm-1 and {relative[0]!r} is relative",
                    f"give {relative[0]!r} irradiance_W_m2_nm=, or {absolute[0]!r} strength=",
                )
            object.__setattr__(self, "irradiance", Irradiance.of_components(self.components, self.row_of_band))
        expected = (n_bands, len(self.components))
        if self.irradiance is not None and self.irradiance.of_component.shape != expected:
            raise SceneError(f"irradiance must have one entry for each of {n_bands} bands and {expected[1]} components")
        if self.irradiance is not None:
            object.__setattr__(self, "irradiance", dataclasses.replace(self.irradiance, component_names=tuple(names)))
            warn_of_too_much_light(self.wavebands.wavelength_nm, self.irradiance.of_component.sum(axis=1))

    def _require_kinds(self) -> None:
        """UsageError for what no later step looks at, or looks at too late."""
        require_kind(self.footprint, Footprint, "footprint=sky.Footprint.circle(10.0)")
        require_kind(self.preset, SamplingOptions, "no preset=, and the choices to source()")
        require_kind(self.notes, tuple, "notes=('a line',)")
        for name, given in (("notes", self.notes), ("preset_name", (self.preset_name or "",))):
            if not all(isinstance(line, str) for line in given):
                raise UsageError(f"{name} must be text, got {given!r}")
        for name in ("input_files", "options"):
            require_kind(getattr(self, name), Mapping, f"{name}={{}}")
        _require_mapping(self.bias, "bias")
        if self.irradiance is not None:
            require_kind(self.irradiance, Irradiance, "the components irradiance_W_m2_nm=")

    def _lower_components(self) -> np.ndarray:
        """Replace models and functions by their components, and append their notes.

        The result is the wavelength of the table that serves each band, NaN without one table.
        """
        given = self.components if isinstance(self.components, (tuple, list)) else (self.components,)
        parts: list[Component] = []
        said: list[str] = []
        without_beam: list[str] = []
        of_tables: list[np.ndarray] = []
        for part in given:
            if isinstance(part, Component):
                parts.append(part)
                continue
            from aomc_sky.skies.function_sky import as_sky_model

            model = as_sky_model(part)
            components = model.lower(self.wavebands.wavelength_nm)
            is_absolute = all(c.irradiance_W_m2_nm is not None for c in components)
            if len(given) > 1 and not has_share(model) and not is_absolute:
                raise SceneError(
                    f"a scene of {len(given)} components needs the share of each, and {type(model).__name__} "
                    f"{components[0].name!r} has none",
                    "give it strength= (relative irradiance) or irradiance_W_m2_nm=",
                )
            parts += components
            if hasattr(model, "table_wavelength_nm"):
                of_tables.append(model.table_wavelength_nm(self.wavebands.wavelength_nm))
            model_notes = model.notes(self.wavebands.wavelength_nm) if hasattr(model, "notes") else ()
            said += [note for note in model_notes if note not in (*self.notes, *said)]
            without_beam.append(model.missing_beam() if hasattr(model, "missing_beam") else "")
        missing = () if any(law_of(component.law).is_beam for component in parts) else filter(None, without_beam)
        object.__setattr__(self, "components", tuple(parts))
        object.__setattr__(self, "notes", (*self.notes, *missing, *said))
        return of_tables[0] if len(of_tables) == 1 else np.full(self.wavebands.n_bands, np.nan)

    def radiance(
        self,
        band: int = 0,
        sky_zenith_rad: ArrayLike | None = None,
        sky_azimuth_rad: ArrayLike | None = None,
        *,
        sky_zenith_deg: ArrayLike | None = None,
        sky_azimuth_deg: ArrayLike | None = None,
    ) -> np.ndarray:
        """Radiance of the diffuse light of a band as its photons have it, for next-event estimates in another code.

        The result has the broadcast shape of the angles, in W m-2 sr-1 nm-1 where `irradiance` is known. Otherwise it
        is in sr-1, for an irradiance 1 of all light on a horizontal plane, beam included. The beam and the disc of the
        sun are not part of it: `irradiance` has them. Accuracy: 1e-10 of the integral, 1e-13 of the law of a direction;
        tables and functions have the radiance of their patches. Cost: up to 20 ms for the first direction of a band,
        then 20 to 80 us for one direction, 0.3 us for each of many.

        Parameters
        ----------
        band : int
            Waveband. [0 to n_bands - 1]
        sky_zenith_rad, or sky_zenith_deg : array_like
            Zenith angle of the sky element, 0 overhead. [0 to 90 degrees]
        sky_azimuth_rad, or sky_azimuth_deg : array_like
            Its azimuth from +x (east) towards +y (north). [any turn]
        """
        from aomc_sky.emission.radiance import band_radiance, sum_of

        zenith = given_angle("sky_zenith_rad", sky_zenith_rad, sky_zenith_deg)
        azimuth = given_angle("sky_azimuth_rad", sky_azimuth_rad, sky_azimuth_deg)
        parts = self._radiance.get(band)
        if parts is None:
            band = as_index(band, "band")
            if not 0 <= band < self.wavebands.n_bands:
                raise IndexError(f"band {band} does not exist; bands run from 0 to {self.wavebands.n_bands - 1}")
            row = int(self.row_of_band[band])
            total = np.array([c.strength[row] if c.mass_of(row).max(initial=0.0) > 0 else 0.0 for c in self.components])
            if self.irradiance is not None:
                total = self.irradiance.of_component[band]
            elif total.max() > 0:
                total = normalise(total)
            parts = self._radiance[band] = band_radiance(self.components, row, total.tolist())
        return sum_of(parts, zenith, azimuth)

    def _set(self, name: str, array: np.ndarray) -> None:
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    def refuse_dark_bands(self) -> None:
        """Raise for the first band that wants photons and has no light."""
        is_lit = np.any([(c.strength > 0) & (c.mass.max(axis=1, initial=0.0) > 0) for c in self.components], axis=0)
        for band in np.flatnonzero((self.n_photons > 0) & ~is_lit[self.row_of_band]).tolist():
            sky = self.sky_wavelength_nm[band]
            where = "" if np.isnan(sky) else f" (the sky's values at {sky:g} nm are all zero)"
            raise SceneError(
                f"waveband {band + 1} at {self.wavebands.wavelength_nm[band]:g} nm has no light{where}, so its "
                f"{self.n_photons[band]} photons cannot be launched",
                "give the sky a positive value there or remove the waveband",
            )

    @in_default_mode
    def source(
        self,
        seed: int = 0,
        *,
        allocation: AllocationMethod | AllocationWord | None = None,
        method: MethodWord | None = None,
        placement: PlacementWord | None = None,
        order: OrderWord | None = None,
        precision: PrecisionWord = "float32",
        weights: bool = False,
        replicates: int = 1,
        bias: Mapping[str, float] | None = None,
        importance: Mapping[str, ArrayLike | Callable[..., ArrayLike]] | None = None,
        max_memory_bytes: int | None = None,
    ) -> PhotonSource:
        """Settle the photon counts and return the source that emits them.

        The source is stateless and picklable. Its systematic counts differ from N p, with p the exact share of a cell,
        by less than 1 + N 2^-62 + N p 2^-52 photons (2^-51 with several components): by 1 up to 1e14 photons of a
        waveband, by up to 23 at 1e18 where p is 0.1. An option that is None takes the preset of the scene.

        Parameters
        ----------
        seed : int
            Seed of the run; equal scene, seed and options give equal photons. [0 to 2^64 - 1]
        allocation : {"systematic", "largest-remainder", "multinomial", "aomc"}, optional
            How integers are shared out.
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
            Independent randomisations that share the photons of each band, for error bars; not for `aomc`
            allocation, which has no randomness. [1 to 4096, at most the photons of a band]
        bias : mapping of str to float, optional
            Share of the photons of components, by their names; the others share the rest by their light. A photon then
            has a weight, the share of the light over that of the photons, mean 1, so that the light stays exact. It
            serves tallies of a weak part, and harms those of all light: their variance is 1.6 to 21 times as large.
            By default what the scene has. [above 0 to 1]
        importance : mapping of str to array_like or function, optional
            Photons per light of the patches of components: (n_zenith, n_azimuth) or a function of zenith angle and
            azimuth [rad], in any scale. Shares of components stay.
        max_memory_bytes : int, optional
            Refuse a plan that takes more before it takes any; 2 GiB by default. [bytes]
        """
        from aomc_sky.emission.photon_source import PhotonSource

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
        for name, given in (("bias", bias), ("importance", importance)):
            if given is not None:
                _require_mapping(given, name)
        if max_memory_bytes is not None:
            max_memory_bytes = as_number_of(max_memory_bytes, "max_memory_bytes", 0, 2**63 - 1)
        shared = (self.bias if bias is None else bias, importance)
        return PhotonSource(build_plan(self, checked_seed(seed), options, max_memory_bytes, *shared))


def _require_mapping(given: object, name: str) -> None:
    """UsageError unless shares or weights of components are a mapping."""
    if not isinstance(given, Mapping):
        raise UsageError(f"{name} is a mapping of names of components, got {given!r}", "write {'direct': 0.2}")


def warn_of_too_much_light(wavelength_nm: np.ndarray, irradiance: np.ndarray) -> None:
    """Warn of an irradiance (n_band,) of the horizontal plane that no sky has.

    Clouds double the light of the sun at most; a unit that is read wrongly makes factors of 10 and more.
    """
    sun = solar_irradiance(wavelength_nm)
    band = int(np.argmax(irradiance / sun))
    if irradiance[band] > 2 * sun[band]:
        warnings.warn(
            f"waveband {band + 1} at {wavelength_nm[band]:g} nm has {irradiance[band]:.3g} W m-2 nm-1 on the "
            f"horizontal plane, {irradiance[band] / sun[band]:.2g} times the sun outside the atmosphere: a unit may "
            "be wrong, or a measured direction sees the sun",
            InputWarning,
            stacklevel=4,
        )


def _whole_photons(n_photons: object, n_bands: int) -> np.ndarray:
    photons = np.asarray(unmasked("n_photons", n_photons))
    if photons.ndim == 0:
        photons = np.full(n_bands, photons)
    if photons.shape != (n_bands,):
        raise SceneError(f"n_photons must have one entry for each of {n_bands} bands, got shape {photons.shape}")
    kind = photons.dtype.kind
    is_whole = kind in "iu" or (kind == "f" and np.all(photons == np.rint(photons)))
    if not is_whole and not (kind == "O" and all(type(n) is int for n in photons)):  # beyond 64 bits
        raise SceneError("n_photons must be whole numbers")
    if np.any(photons < 0) or np.any(photons > MAX_PHOTONS):
        raise SceneError(f"n_photons must lie within 0 and 2^62 = {MAX_PHOTONS}")
    return np.array(photons, dtype=np.int64)


def require_projected(weighting: str | None, what: str) -> None:
    """Refuse another weighting for a sky whose photons pass the horizontal sea surface."""
    if weighting not in (None, "projected"):
        raise UsageError(
            f"{what} sends photons through the horizontal sea surface; weighting {weighting!r} does not",
            "leave --weighting out, or write --sky uniform",
        )


def build_plan(
    scene: Scene,
    seed: int,
    options: SamplingOptions,
    max_memory_bytes: int | None = None,
    bias: Mapping[str, float] | None = None,
    importance: Mapping[str, Any] | None = None,
) -> Plan:
    """Settle the photon counts of a scene, and everything else that its photons depend on.

    Each row of counts sums exactly to the request, except under `aomc` allocation.
    """
    components, chosen = scene.components, _plan_options(scene, seed, options)
    lobes = [c.name for c in components if law_of(c.law).covers_sky]
    if lobes and options.placement is Placement.CENTRE:
        raise SceneError(
            f"placement 'centre' puts photons in the middle of patches, and the lobe {lobes[0]!r} has none",
            "take placement r2 or philox",
        )
    rows, row_of_band = np.unique(scene.row_of_band, return_inverse=True)
    _refuse_large_plan(
        scene, sum(component.n_cells for component in components), rows.size, options.replicates, max_memory_bytes
    )
    few = np.flatnonzero((scene.n_photons > 0) & (scene.n_photons < options.replicates))
    if few.size:
        raise SceneError(
            f"waveband {few[0] + 1} has {scene.n_photons[few[0]]} photons, too few for {options.replicates} replicates",
            "ask for more photons or for fewer replicates",
        )
    checked_photons(int(scene.n_photons.max()), options.allocation)
    parts = plan_components(scene.components, rows, options.weights)
    factors = None
    if bias or importance:
        refuse_bias(parts, options)
        factors = bias_of(parts, bias or {}, importance_of(scene.components, importance or {}))
        factors.flags.writeable = False
        chosen |= {"bias": {n: float(x) for n, x in (bias or {}).items()}, "importance": sorted(importance or {})}
    absolute = scene.irradiance
    bands = tuple(
        PlanBand(
            wavelength_nm=float(scene.wavebands.wavelength_nm[band]),
            sky_wavelength_nm=float(scene.sky_wavelength_nm[band]),
            requested=int(scene.n_photons[band]),
            row=int(row_of_band[band]),
            irradiance_W_m2_nm=None if absolute is None else tuple(absolute.of_component[band].tolist()),
            horizon_loss=0.0 if absolute is None else float(absolute.horizon_loss[band]),
        )
        for band in range(scene.wavebands.n_bands)
    )
    if options.allocation is AllocationMethod.AOMC:
        cumulative = aomc_cumulative(scene.components, scene.n_photons, scene.row_of_band)
    else:
        scene.refuse_dark_bands()
        cumulative = cumulative_counts(bands, parts, chosen, factors)
    cumulative.flags.writeable = False
    return Plan(bands=bands, components=parts, cumulative=cumulative, options=chosen, bias=factors)


def _refuse_large_plan(scene: Scene, n_cells: int, n_rows: int, replicates: int, limit: int | None) -> None:
    n_bands = scene.wavebands.n_bands
    held = [array for c in scene.components for array in (c.cell, c.slope, c.stokes) if array is not None]
    cell_bytes = sum(array.nbytes for array in held)
    arrays = 8 * replicates * n_bands * (n_cells + 1) + 8 * n_rows * n_cells + cell_bytes
    if too_large := beyond_memory(ARRAYS_HELD * arrays, limit):
        shown = f"{n_bands} wavebands of {n_cells} cells" + f" in {replicates} replicates" * (replicates > 1)
        raise UsageError(f"a plan of {shown} takes {too_large.message}", f"take larger cells, or {too_large.advice}")


def _plan_options(scene: Scene, seed: int, options: SamplingOptions) -> dict[str, object]:
    chosen = dataclasses.asdict(options)
    return {
        "stream": STREAM_VERSION,
        "seed": int(seed),
        **{name: getattr(value, "value", value) for name, value in chosen.items()},
        "footprint": [scene.footprint.shape.value, scene.footprint.size_x_m, scene.footprint.size_y_m],
        "components": [c.name for c in scene.components],
        "azimuth_first_index": [0 if c.grid is None else c.grid.azimuth_first_index for c in scene.components],
    }
