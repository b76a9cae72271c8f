"""How the light of every waveband is split between beam and sky, and who says so."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import InputWarning
from aomc_sky.formats.amc.band_files import DifcolTable
from aomc_sky.formats.sky_toml.keys import SPECTRL2, SkySection
from aomc_sky.source.light.inputs import DIFCOL, SkyInputs
from aomc_sky.source.light.perez import difcol_of_inputs, missing_inputs
from aomc_sky.source.read.files import SceneFiles


@dataclass(frozen=True, kw_only=True, slots=True)
class BandSplit:
    """Direct fraction and intensity of every band.

    Parameters
    ----------
    difcol : DifcolTable
        What difcol.inp says, or what stands in for it.
    origin : str
        Who says so, for the notes.
    units : SkySection
        Irradiances of sun and sky where a spectrum tells them, else what sky.toml says.
    options : dict
        What a manifest has of a spectrum.
    """

    difcol: DifcolTable
    origin: str
    units: SkySection
    options: dict[str, Any] = field(default_factory=dict)


def band_split(files: SceneFiles, inputs: SkyInputs, sky: str | None, wavelength_nm: np.ndarray) -> BandSplit:
    """Say how each waveband is split: by difcol.inp, a spectrum, or one broadband fraction, with a warning."""
    n_bands, units = files.config.n_wavebands, files.toml.sky
    if files.difcol is not None:
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
        origin=f"{inputs.perez}, spectra of SPCTRL2 at turbidity {found.turbidity:.3g}",
        units=units,
        options={"spectrum": found.as_options()},
    )


def _warn_of_one_fraction(fraction: float) -> None:
    """Warn where beam and sky both shine, so that the fraction differs between wavebands."""
    if 0.0 < fraction < 1.0:
        warnings.warn(
            f"without difcol.inp every waveband has the broadband direct fraction {fraction:.3g}, but blue light is "
            "more diffuse and red light less; write --spectrum spectrl2 (in sky.toml: [perez] spectrum) or difcol.inp; "
            "--spectrum flat keeps this and leaves the warning out",
            InputWarning,
            stacklevel=2,
        )
