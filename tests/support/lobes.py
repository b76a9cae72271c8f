"""Skies of lobes, and their components, from a line for each."""

import numpy as np

import aomc_sky as sky


def lobe_sky(*shapes, names=None, wavelength_nm=(400.0, 700.0), spectra=(1e-9, 3e-9)):
    """Lobes of (kind, param0, param1, quaternion), with spectra of their own or one for all."""
    rows = np.broadcast_to(np.asarray(spectra, float), (len(shapes), np.size(wavelength_nm)))
    lobes = (
        sky.lobes.WeightedLobe(
            name=name, kind=kind, param0=a, param1=b, quaternion=np.asarray(turn), wavelength_nm=wavelength_nm,
            spectrum=row,
        )
        for name, (kind, a, b, turn), row in zip(names or [shape[0] for shape in shapes], shapes, rows, strict=True)
    )  # fmt: skip
    return sky.LobeSky(lobes=tuple(lobes))


def lobe_components(*, names, kinds, param0, param1, quaternion, irradiance):
    shapes = zip(kinds, param0, param1, quaternion, strict=True)
    nm = 500.0 + np.arange(np.shape(irradiance)[1])
    return lobe_sky(*shapes, names=names, wavelength_nm=nm, spectra=irradiance).lower(nm)
