"""The diffuse light of a run as a latitude-longitude map of radiance for renderers, with the beam beside it."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from aomc_sky.component import Component, Law, beam_direction_deg
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.radiance import cell_irradiances, patch_radiance
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.aomc.degree_counts import carried_over
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.plan.laws import law_of

MAP, AXES = "envmap.npy", "envmap.json"

N_ROWS, N_COLUMNS = 360, 720
"""Pixels of half a degree over the whole sphere; the lower half is dark."""


def head_of_map(n_bands: int) -> bytes:
    """Head of the npy file: float32 (n_bands, N_ROWS, N_COLUMNS)."""
    head = io.BytesIO()
    shape = (n_bands, N_ROWS, N_COLUMNS)
    np.lib.format.write_array_header_1_0(head, {"descr": "<f4", "fortran_order": False, "shape": shape})
    return head.getvalue()


def maps(source: PhotonSource, bands: Sequence[int]) -> Iterator[np.ndarray]:
    """The map of each band: mean radiance of each pixel, weighted with the cosine; float32 (N_ROWS, N_COLUMNS)."""
    grid = PatchGrid.regular(N_ROWS // 2, N_COLUMNS)
    shares: dict[tuple[str, int], np.ndarray] = {}
    for band in bands:
        row = source.plan.bands[band].row
        radiance = np.zeros((N_ROWS, N_COLUMNS), np.float32)
        for component, light in zip(source.components, cell_irradiances(source, band), strict=True):
            if not law_of(component.law).is_beam and light.sum() > 0:
                key = component.name, 0 if law_of(component.law).radiance is not None else row  # 0: in all rows
                if key not in shares:
                    shares = {k: v for k, v in shares.items() if k[1] in (0, row)}
                    shares[key] = _shares(component, row, grid)
                _, values = patch_radiance(component.law, grid, shares[key] * light.sum())
                radiance[: N_ROWS // 2] += values.reshape(N_ROWS // 2, N_COLUMNS)
        yield radiance


def _shares(component: Component, row: int, grid: PatchGrid) -> np.ndarray:
    """Share of the photons of a component in each pixel."""
    law = law_of(component.law)
    if law.shares is not None:
        return law.shares(component, grid)
    mass = carried_over(component.of_row(row), grid)[0]
    return mass / mass.sum()


def axes_of(source: PhotonSource, bands: Sequence[int]) -> dict[str, Any]:
    """The meaning of the map's numbers, and the beams, which are not in the map, as JSON values."""
    lights = [[float(light.sum()) for light in cell_irradiances(source, band)] for band in bands]
    is_beam = [law_of(component.law).is_beam for component in source.components]
    is_absolute = source.irradiance(0) is not None
    unit = "W m-2 nm-1" if is_absolute else "share of the irradiance of all light on a horizontal plane"
    return {
        "quantity": "radiance, the mean over each pixel weighted with the cosine of the zenith angle",
        "unit": "W m-2 sr-1 nm-1" if is_absolute else "sr-1, over the irradiance of all light on a horizontal plane",
        "axes": ["waveband", "zenith", "azimuth"],
        "wavelength_nm": [source.plan.bands[band].wavelength_nm for band in bands],
        "zenith_deg": {"first_edge": 0.0, "step": 180.0 / N_ROWS, "n": N_ROWS, "of": "the sky element, 0 overhead"},
        "azimuth_deg": {"first_edge": 0.0, "step": 360.0 / N_COLUMNS, "n": N_COLUMNS, "of": CONVENTIONS["azimuth"]},
        "irradiance_unit": unit,
        "irradiance_of_map": [sum(e for e, beam in zip(es, is_beam, strict=True) if not beam) for es in lights],
        "beams": [
            _beam(component, [es[k] for es in lights])
            for k, component in enumerate(source.components)
            if is_beam[k] and beam_direction_deg(component) is not None
        ],
        "plan_sha256": source.plan.sha256,
    }


def _beam(component: Component, irradiance: list[float]) -> dict[str, Any]:
    zenith, azimuth = beam_direction_deg(component) or (0.0, 0.0)
    radius = 0.0
    if component.law is Law.DISC:
        radius = float(np.rad2deg(np.arctan2(component.cell[0, 2], component.cell[0, 3])))
    elif component.law is Law.DISC_AT_HORIZON:
        radius = float(2.0 * np.rad2deg(np.arcsin(np.sqrt(component.cell[0, 2]) / 2.0)))
    return {
        "name": component.name,
        "zenith_deg": zenith,
        "azimuth_deg": azimuth,
        "radius_deg": radius,
        "irradiance_on_a_horizontal_plane": irradiance,
    }


def axes_text(source: PhotonSource, bands: Sequence[int]) -> bytes:
    """The bytes of the file `AXES`."""
    return (json.dumps(axes_of(source, bands), indent=1) + "\n").encode("ascii")
