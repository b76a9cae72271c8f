"""A scene lit by the sun and a sky model: with the split of each waveband between the two."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.component import scaled
from aomc_sky.errors import InputWarning, SceneError, UsageError
from aomc_sky.formats.aomc.amc import AmcConfig, DifcolTable
from aomc_sky.formats.sky_toml.keys import SPECTRL2, SkySection
from aomc_sky.plan.options import Order, Placement, SamplingOptions
from aomc_sky.plan.sampling.allocation import AllocationMethod
from aomc_sky.skies.model import sky_model
from aomc_sky.source.light.inputs import (
    DIFCOL,
    PerezInputs,
    SkyInputs,
    difcol_of_inputs,
    direct_fraction,
    inputs_of_difcol,
    missing_inputs,
)
from aomc_sky.source.light.plugin import diffuse_of_plugin
from aomc_sky.source.light.shares import Diffuse, beam_of
from aomc_sky.source.read.files import FIELD, SceneFiles
from aomc_sky.source.scene import SceneDraft, photons_of_intensity, require_projected

if TYPE_CHECKING:
    from aomc_sky.source.read.field import SkyField

AOMC_INTERNAL_PRESET = SamplingOptions(
    allocation=AllocationMethod.MULTINOMIAL, placement=Placement.PHILOX, order=Order.SHUFFLED
)


@dataclass(frozen=True, kw_only=True, slots=True)
class BandSplit:
    """Split of the light of every waveband between beam and sky."""

    difcol: DifcolTable  #: contents of difcol.inp, or a substitute
    origin: str  #: source of the split, for the notes
    units: SkySection  #: irradiances of sun and sky from a spectrum, or else from sky.toml
    options: dict[str, Any] = field(default_factory=dict)  #: entries of a spectrum in the manifest


def band_split(files: SceneFiles, inputs: SkyInputs, sky: str | None, wavelength_nm: np.ndarray) -> BandSplit:
    """Split each waveband by difcol.inp, a spectrum, or one broadband fraction (with a warning)."""
    n_bands, units = files.config.n_wavebands, files.toml_or_empty.sky
    if files.difcol is not None:
        _warn_of_other_light(files.difcol, inputs)
        return BandSplit(difcol=files.difcol, origin=DIFCOL, units=units)
    if not files.is_internal:
        if sky == "perez" and inputs.perez is None:
            raise missing_inputs()
        difcol = DifcolTable(direct_fraction=np.zeros(n_bands), intensity=np.ones(n_bands))
        return BandSplit(difcol=difcol, origin="the sky model replaces skydist.inp", units=units)
    path = str(Path(files.paths["amc"]).parent / DIFCOL)
    difcol = difcol_of_inputs(inputs.perez, inputs.sun, path, n_bands)
    if inputs.spectrum == SPECTRL2:
        return _by_spectrum(inputs, units, wavelength_nm)
    if inputs.spectrum is None:
        _warn_of_one_fraction(float(difcol.direct_fraction[0]))
    return BandSplit(difcol=difcol, origin=f"{inputs.perez} without difcol.inp", units=units)


def _by_spectrum(inputs: SkyInputs, units: SkySection, wavelength_nm: np.ndarray) -> BandSplit:
    from aomc_sky.source.light.spectral_split import spectral_split

    assert inputs.perez is not None, "difcol_of_inputs has used it"
    found = spectral_split(inputs.perez, inputs.sun, wavelength_nm)
    if units.diffuse_irradiance is None and units.direct_irradiance is None:
        units = dataclasses.replace(
            units,
            diffuse_irradiance=tuple(found.diffuse_irradiance.tolist()),
            direct_irradiance=tuple(found.direct_irradiance.tolist()),
        )
    return BandSplit(
        difcol=DifcolTable(direct_fraction=found.direct_fraction, intensity=np.ones(wavelength_nm.size)),
        origin=f"{inputs.perez}, {found}",
        units=units,
        options={"spectrum": found.as_options()},
    )


_MORE_DIRECT = 0.1
"""Allowed excess of the direct fraction of visible bands over that of the whole spectrum."""


def _warn_of_other_light(difcol: DifcolTable, inputs: SkyInputs) -> None:
    """Warn where the bands of difcol.inp have far more beam than an hour of a weather file."""
    given, weight = inputs.perez, difcol.intensity
    if given is None or not inputs.is_of_file or not has_diffuse_light(difcol) or not weight.max() > 0:
        return
    other = direct_fraction(given, inputs.sun)
    assert other is not None, "a file has irradiances"
    weight = weight / weight.max()
    mean = float(np.sum(weight * difcol.direct_fraction) / np.sum(weight))
    if mean > other + _MORE_DIRECT:
        warnings.warn(
            f"difcol.inp shares the photons, {mean:.3g} of them direct, but {given} say {other:.3g}: it is of clearer "
            "weather; remove difcol.inp and write --spectrum spectrl2 to share them by these irradiances",
            InputWarning,
            stacklevel=2,
        )


def _warn_of_one_fraction(fraction: float) -> None:
    """Warn where beam and sky both shine, so that the fraction differs between wavebands."""
    if 0.0 < fraction < 1.0:
        warnings.warn(
            f"without difcol.inp every waveband has the broadband direct fraction {fraction:.3g}, but blue light is "
            "more diffuse and red light less; write --spectrum spectrl2 (in sky.toml: [perez] spectrum) or difcol.inp; "
            "--spectrum flat keeps this fraction without a warning",
            InputWarning,
            stacklevel=2,
        )


def sun_and_sky_draft(
    files: SceneFiles,
    split: BandSplit,
    inputs: SkyInputs,
    wavelength_nm: np.ndarray,
    *,
    weighting: str | None,
    compat: str | None,
) -> tuple[SceneDraft, SkySection]:
    """A scene lit by the sun and a sky model, and its irradiances where they are known.

    Without a name of a sky it is "perez", and "uniform" under `compat`.
    """
    difcol, config = split.difcol, files.config
    if weighting not in (None, "projected", "solid-angle", "aomc"):
        raise UsageError(f"weighting {weighting!r} is for sky files; a sky model has 'projected' or 'solid-angle'")
    per_solid_angle = bool(compat) or weighting == "solid-angle"
    is_lit = has_diffuse_light(difcol)
    sky_rows = np.zeros(difcol.direct_fraction.size, np.int64)
    if files.sky_field is not None and is_lit:
        sky_rows = files.sky_field.table_index(wavelength_nm)
    if files.plugin is None:
        pairs, rows = np.unique(np.column_stack([difcol.direct_fraction, sky_rows]), axis=0, return_inverse=True)
        fractions, row_of_band = pairs[:, 0], rows.ravel()
    else:  # its radiance may depend on the wavelength
        fractions, row_of_band = difcol.direct_fraction, np.arange(difcol.direct_fraction.size)
    components = beam_of(inputs.sun, fractions)
    model = ("uniform" if compat else files.sky or "perez") if is_lit else None
    diffuse = Diffuse()
    if model == "perez":
        diffuse = _perez(inputs, difcol, weighting, fractions, replaces_file=not files.is_internal)
    elif model is not None and files.plugin is not None:
        require_projected(weighting, f"the sky model {files.plugin}")
        diffuse = diffuse_of_plugin(files.plugin, inputs.sun, fractions, wavelength_nm)
    elif model is not None and files.sky_field is not None:
        diffuse = _of_field(files.sky_field, files.folder, weighting, fractions, pairs[:, 1].astype(np.int64))
    elif model is not None:
        diffuse = Diffuse(components=sky_model(model)(per_solid_angle=per_solid_angle).lower(fractions))
    components += scaled(diffuse.components, 1.0 - fractions)
    intensity = difcol.intensity
    photons = _program_photons(intensity, config) if compat else photons_of_intensity(intensity, config.iterations)
    units = split.units
    if diffuse.irradiance is not None and units.diffuse_irradiance is None:
        units = dataclasses.replace(units, diffuse_irradiance=diffuse.irradiance)
    draft = SceneDraft(
        components=tuple(components),
        n_photons=photons,
        row_of_band=row_of_band,
        notes=(*inputs.notes, _split_note(split, model, inputs), *diffuse.notes),
        options={
            "sky": model,
            "weighting": "solid-angle" if per_solid_angle else "projected",
            "sun": inputs.sun.as_options(),
            **diffuse.options,
            **split.options,
        },
        preset=AOMC_INTERNAL_PRESET if compat else SamplingOptions(),
    )
    if files.sky_field is not None and is_lit:
        draft = dataclasses.replace(draft, sky_wavelength_nm=files.sky_field.wavelength_of(sky_rows))
    return draft, units


def has_diffuse_light(difcol: DifcolTable) -> bool:
    """Whether the sky has a part of any band with light, or of any band if none has light."""
    lit = difcol.intensity > 0
    return bool(np.any(difcol.direct_fraction[lit if lit.any() else slice(None)] < 1))


def _perez(
    inputs: SkyInputs, difcol: DifcolTable, weighting: str | None, fractions: np.ndarray, *, replaces_file: bool
) -> Diffuse:
    """The Perez sky; the manifest keeps the warnings about its limits."""
    require_projected(weighting, "the Perez sky")
    from aomc_sky.source.weather_scene import perez_sky, sky_options

    weather = inputs.perez or inputs_of_difcol(difcol, inputs.sun)
    sky, limited = perez_sky(inputs.model, weather, inputs.sun)
    shown = {**sky_options(sky), **inputs.model, "from": str(weather), "limited": limited}
    notes = [_perez_note(shown, weather)]
    if replaces_file and (missing := sky.missing_beam("write 0 as the light source of amc.inp to launch both")):
        notes.append(missing)
    return Diffuse(components=sky.lower(fractions), notes=tuple(notes), options={"perez": shown})


def _of_field(field: SkyField, folder: str, weighting: str | None, fractions: np.ndarray, rows: np.ndarray) -> Diffuse:
    """The radiance field of sky.toml, a row for each pair of a direct fraction and a wavelength of the field."""
    if weighting not in (None, "projected", "solid-angle"):
        raise UsageError(f"a radiance field has weighting 'projected' or 'solid-angle', not {weighting!r}")
    components = field.lower(rows, per_solid_angle=weighting == "solid-angle")
    dark = np.flatnonzero((components[0].strength == 0) & (fractions > 0) & (fractions < 1))
    if dark.size:
        raise SceneError(
            f"{field.section.file} is dark at {field.sky.wavelength_nm[rows[dark[0]]]:g} nm, but "
            f"{1 - fractions[dark[0]]:g} of the light there is diffuse"
        )
    return Diffuse(components=components, notes=field.notes, options={"field": field.as_options(folder)})


def _perez_note(shown: dict[str, Any], weather: PerezInputs) -> str:
    if shown["epsilon"] is None or (weather.section.epsilon is not None and weather.origin != DIFCOL):
        return f"Perez sky: {weather}"  # the text has the numbers already
    return f"Perez sky: epsilon {shown['epsilon']:.4g}, Delta {shown['delta']:.4g}, from {weather}"


def _program_photons(intensity: np.ndarray, config: AmcConfig) -> np.ndarray:
    """The program's NINT of a product of 32-bit floats."""
    product = intensity.astype(np.float32) * np.float32(config.iterations)
    return np.floor(product.astype(np.float64) + 0.5).astype(np.int64)


def _split_note(split: BandSplit, used_sky: str | None, inputs: SkyInputs) -> str:
    difcol, origin = split.difcol, split.origin
    if used_sky is None:
        return f"{origin}: all light is direct, so no sky is modelled"
    low, high = float(difcol.direct_fraction.min()), float(difcol.direct_fraction.max())
    shown = f"{low:g}" if low == high else f"{low:g} to {high:g}"
    given = inputs.perez if origin == DIFCOL and used_sky == "perez" else None
    other = None if given is None else direct_fraction(given, inputs.sun)
    hint = "" if given is None or other is None else f" ({given.text} alone: {other:.3g})"
    rest = "the field of sky.toml" if used_sky == FIELD else f"{'an' if used_sky[0] in 'aeiou' else 'a'} {used_sky} sky"
    return f"{origin}: direct fraction {shown}{hint}, the rest from {rest}"
