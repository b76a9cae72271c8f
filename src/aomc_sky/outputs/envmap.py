"""The diffuse light of a run as a latitude-longitude map of radiance for renderers, with the beam beside it.

A map is an array (.npy), or a picture of Radiance (.hdr) or OpenEXR (.exr), as a person inside the sky sees it.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.component import Component
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.emission.radiance import patch_radiance
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.aomc.degree_counts import carried_over
from aomc_sky.outputs.manifest import CONVENTIONS
from aomc_sky.plan.laws import beam_deg, law_of

MAP, AXES = "envmap.npy", "envmap.json"
"""The map in a folder, and the meaning of its numbers."""

N_ROWS, N_COLUMNS = 360, 720
"""Pixels of half a degree over the whole sphere; the lower half is dark."""

RGBE_ERROR = 1.0 / 256.0
"""Largest error of a value of an .hdr picture, over the largest of its pixel, as Radiance reads it."""

_RGBE_MOST = 2.0**127


def pictured(name: str, wavelength_nm: Sequence[float]) -> list[int]:
    """The bands that are red, green and blue in a picture: the longest wavelength is red. One band is grey.

    UsageError for another number of bands.
    """
    if len(wavelength_nm) not in (1, 3):
        raise UsageError(
            f"{name} is a picture, which holds one waveband (grey) or three (red, green, blue), and there are "
            f"{len(wavelength_nm)}: add --waveband I, three times for colours, or write a .npy file"
        )
    return sorted(range(len(wavelength_nm)), key=lambda k: -wavelength_nm[k])


def map_file(source: PhotonSource, bands: Sequence[int], name: str) -> tuple[bytes, int]:
    """Head and size of the file of a map, by the ending of its name. [bytes]"""
    pixels, ending = N_ROWS * N_COLUMNS, Path(name).suffix.lower()
    if ending == ".npy":
        head, shape = io.BytesIO(), (len(bands), N_ROWS, N_COLUMNS)
        np.lib.format.write_array_header_1_0(head, {"descr": "<f4", "fortran_order": False, "shape": shape})
        return head.getvalue(), len(head.getvalue()) + 4 * len(bands) * pixels
    if ending == ".hdr":
        text = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nSOFTWARE=aomc-sky\nPLAN={source.plan.sha256}\n\n"
        text += f"-Y {N_ROWS} +X {N_COLUMNS}\n"
        return text.encode("ascii"), len(text) + 4 * pixels
    exr = _exr_head(source.plan.sha256, len(bands))
    return exr, len(exr) + N_ROWS * (8 + 4 * N_COLUMNS * len(bands))


def n_parts(name: str, n_bands: int) -> int:
    """Parts of `map_bytes`."""
    return n_bands if name.lower().endswith(".npy") else 1


def map_bytes(source: PhotonSource, bands: Sequence[int], name: str) -> Iterator[bytes]:
    """What follows the head, in parts: float32 (n_bands, N_ROWS, N_COLUMNS), or the pixels of a picture."""
    ending = Path(name).suffix.lower()
    if ending == ".npy":
        yield from (one.astype("<f4").tobytes() for one in maps(source, bands))
        return
    order = pictured(name, [source.plan.bands[band].wavelength_nm for band in bands])
    found = list(maps(source, bands))
    # as a person sees it who turns to the right: from west over north, east in the middle
    colours = np.stack([np.roll(found[k][:, ::-1], N_COLUMNS // 2, axis=1) for k in order])
    yield _rgbe(colours) if ending == ".hdr" else _exr_rows(colours)


def _rgbe(colours: np.ndarray) -> bytes:
    """Pixels of a Radiance picture: three mantissas of eight bits, cut as Radiance cuts them, and their exponent.

    The mantissa of the largest colour is 128 or more, so that no pixel looks like a mark of run-length coding.
    """
    rgb = np.broadcast_to(colours, (3, *colours.shape[1:])).astype(np.float64)
    _, exponent = np.frexp(rgb.max(axis=0))
    if rgb.max() >= _RGBE_MOST:
        raise SceneError(f"a radiance of {rgb.max():.3g} is more than a .hdr picture can hold", "write a .exr file")
    is_lit = rgb.max(axis=0) >= 1.0 / _RGBE_MOST
    pixels = np.zeros((*rgb.shape[1:], 4), np.uint8)
    pixels[..., :3] = np.where(is_lit, np.ldexp(rgb, 8 - exponent), 0.0).transpose(1, 2, 0)
    pixels[..., 3] = np.where(is_lit, exponent + 128, 0)
    return pixels.tobytes()


_CHANNELS = {1: "Y", 3: "BGR"}
"""Channels of an .exr picture in the order of the file, which is that of their names."""


def _exr_head(plan_sha256: str, n_channels: int) -> bytes:
    """Head of an OpenEXR picture without compression, and the places of its lines."""
    box = struct.pack("<4i", 0, 0, N_COLUMNS - 1, N_ROWS - 1)
    float32 = struct.pack("<xiB3xii", 2, 0, 1, 1)
    channels = b"".join(name.encode() + float32 for name in _CHANNELS[n_channels])
    attributes = (
        ("channels", "chlist", channels + b"\0"),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("plan", "string", plan_sha256.encode("ascii")),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
        ("software", "string", b"aomc-sky"),
    )
    head = struct.pack("<2i", 20000630, 2)
    for name, kind, value in attributes:
        head += f"{name}\0{kind}\0".encode("ascii") + struct.pack("<i", len(value)) + value
    first, step = len(head) + 1 + 8 * N_ROWS, 8 + 4 * N_COLUMNS * n_channels
    return head + b"\0" + (first + step * np.arange(N_ROWS)).astype("<u8").tobytes()


def _exr_rows(colours: np.ndarray) -> bytes:
    """Lines of an OpenEXR picture: number, size, and a row of each channel."""
    rows = np.zeros(N_ROWS, [("y", "<i4"), ("size", "<i4"), ("values", "<f4", (len(colours), N_COLUMNS))])
    rows["y"], rows["size"] = np.arange(N_ROWS), 4 * N_COLUMNS * len(colours)
    rows["values"] = colours[::-1].transpose(1, 0, 2)
    return rows.tobytes()


def maps(source: PhotonSource, bands: Sequence[int]) -> Iterator[np.ndarray]:
    """The map of each band: mean radiance of each pixel, weighted with the cosine; float32 (N_ROWS, N_COLUMNS)."""
    grid = PatchGrid.regular(N_ROWS // 2, N_COLUMNS)
    shares: dict[tuple[str, int], np.ndarray] = {}
    for band in bands:
        row = source.plan.bands[band].row
        radiance = np.zeros((N_ROWS, N_COLUMNS), np.float32)
        for component, light in zip(source.components, source.cell_irradiances(band), strict=True):
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


def axes_of(source: PhotonSource, bands: Sequence[int], name: str = MAP) -> dict[str, Any]:
    """The meaning of the map's numbers, and the beams, which are not in the map, as JSON values."""
    wavelength_nm = [source.plan.bands[band].wavelength_nm for band in bands]
    is_picture = Path(name).suffix.lower() != ".npy"
    first, step = (180.0, -360.0 / N_COLUMNS) if is_picture else (0.0, 360.0 / N_COLUMNS)
    lights = [[float(light.sum()) for light in source.cell_irradiances(band)] for band in bands]
    is_beam = [law_of(component.law).is_beam for component in source.components]
    is_absolute = source.irradiance(0) is not None
    unit = "W m-2 nm-1" if is_absolute else "share of the irradiance of all light on a horizontal plane"
    axes: dict[str, Any] = {
        "quantity": "radiance, the mean over each pixel weighted with the cosine of the zenith angle",
        "unit": "W m-2 sr-1 nm-1" if is_absolute else "sr-1, over the irradiance of all light on a horizontal plane",
        "axes": ["zenith", "azimuth", "channel"] if is_picture else ["waveband", "zenith", "azimuth"],
        "wavelength_nm": wavelength_nm,
        "zenith_deg": {"first_edge": 0.0, "step": 180.0 / N_ROWS, "n": N_ROWS, "of": "the sky element, 0 overhead"},
        "azimuth_deg": {"first_edge": first, "step": step, "n": N_COLUMNS, "of": CONVENTIONS["azimuth"]},
        "irradiance_unit": unit,
        "irradiance_of_map": [sum(e for e, beam in zip(es, is_beam, strict=True) if not beam) for es in lights],
        "beams": [
            _beam(component.name, *beam, [es[k] for es in lights])
            for k, component in enumerate(source.components)
            if (beam := beam_deg(component)) is not None
        ],
        "plan_sha256": source.plan.sha256,
    }
    if is_picture:
        order = pictured(name, wavelength_nm)
        colours = ("red", "green", "blue") if len(order) == 3 else ("grey",)
        axes["channels_nm"] = {colour: wavelength_nm[k] for colour, k in zip(colours, order, strict=True)}
    return axes


def _beam(name: str, zenith: float, azimuth: float, radius: float, irradiance: list[float]) -> dict[str, Any]:
    return {
        "name": name,
        "zenith_deg": zenith,
        "azimuth_deg": azimuth,
        "radius_deg": radius,
        "irradiance_on_a_horizontal_plane": irradiance,
    }


def axes_text(source: PhotonSource, bands: Sequence[int], name: str) -> bytes:
    """The bytes of the file of the meaning."""
    return (json.dumps(axes_of(source, bands, name), indent=1) + "\n").encode("ascii")
