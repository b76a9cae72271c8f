"""Scenes in absolute units: irradiances in [sky] of sky.toml, and the backgrounds."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.errors import SceneError
from aomc_sky.formats.sky_toml.keys import BackgroundSection, SkySection
from aomc_sky.formats.sky_toml.rules import moment_text
from aomc_sky.formats.text_file import refuse
from aomc_sky.source.scene import SceneDraft
from aomc_sky.wavebands import Wavebands

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.sky import LobeSky

BEAM = "direct"
_MAX_SHOWN = 12


def background_options(sections: Sequence[BackgroundSection], folder: str) -> list[dict[str, Any]]:
    """Keys of [[background]] as JSON values for a manifest; paths do not depend on the folder of the scene."""
    return [
        {
            **dataclasses.asdict(one),
            "file": os.path.relpath(one.file, folder or os.curdir),
            "time": moment_text(one.time),
            "animation": None if one.animation is None else list(one.animation),
        }
        for one in sections
    ]


def with_absolute_units(
    draft: SceneDraft, section: SkySection, skies: Sequence[LobeSky], bands: Wavebands, toml_path: str
) -> SceneDraft:
    """State the irradiance of every component, and add the lobes of the backgrounds.

    A draft in relative units stays as it is. With backgrounds the strengths are irradiances in the same unit, with a
    row for each distinct set of base row, wavelength and irradiances. E708: backgrounds beside relative light.
    """
    is_absolute = section.diffuse_irradiance is not None or section.direct_irradiance is not None
    known = draft.irradiance
    if not skies and not is_absolute:
        return draft
    base = known.of_component if known is not None else _base_irradiance(draft, section, bands, toml_path)
    if not skies:
        return dataclasses.replace(draft, irradiance=Irradiance(of_component=base))
    return _joined(draft, base, skies, bands)


def _joined(draft: SceneDraft, base: np.ndarray, skies: Sequence[LobeSky], bands: Wavebands) -> SceneDraft:
    """Sun, sky and lobes with strengths in one unit."""
    from aomc_sky.skies.lobes.light import background_light

    components = draft.components
    keys = np.column_stack([draft.row_of_band, bands.wavelength_nm, base])
    _, first, rows = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    light = background_light(skies, bands.wavelength_nm[first], taken=[c.name for c in components])
    if not components and not light.components:
        reason = "all their lobes lie below the horizon" if light.hidden else "their lobes have no light at that time"
        raise SceneError(f"the backgrounds are the only source of light, but {reason}")
    old_rows = draft.row_of_band[first]
    scaled = [
        dataclasses.replace(
            component,
            strength=base[first, k],
            **{name: _rows(getattr(component, name), old_rows) for name in ("mass", "weight", "slope")},
        )
        for k, component in enumerate(components)
    ]
    rows = rows.ravel()
    lobes = np.stack([c.strength[rows] for c in light.components], axis=1) if light.components else base[:, :0]
    notes = [f"below the horizon, so without photons: {', '.join(light.hidden)}"] if light.hidden else []
    return dataclasses.replace(
        draft,
        components=(*scaled, *light.components),
        row_of_band=rows,
        notes=(*draft.notes, *notes),
        irradiance=Irradiance(of_component=np.hstack([base, lobes]), horizon_loss=light.horizon_loss[rows]),
    )


def _rows(values: np.ndarray | None, rows: np.ndarray) -> Any:
    """The needed rows of masses, weights or slopes, if there are any; a single row is for all."""
    return values if values is None or values.shape[0] == 1 else values[rows]


def _base_irradiance(draft: SceneDraft, section: SkySection, bands: Wavebands, toml_path: str) -> np.ndarray:
    """Irradiance of sun and sky, shape (n_band, n_component). [W m-2 nm-1]"""
    components, rows = draft.components, draft.row_of_band
    if not components:
        return np.zeros((bands.n_bands, 0))
    share = np.stack([c.strength[rows] * (c.mass.max(axis=1) > 0)[rows if len(c.mass) > 1 else 0] for c in components])
    is_beam = np.array([c.name == BEAM for c in components])
    beam, sky = share[is_beam].sum(axis=0), share[~is_beam].sum(axis=0)
    _refuse_unknown(section, beam, sky, bands, toml_path)
    diffuse = np.array(section.diffuse_irradiance or np.zeros(bands.n_bands))
    if section.direct_irradiance is not None:
        direct = np.array(section.direct_irradiance)
    else:
        direct = np.divide(diffuse * beam, sky, out=np.zeros_like(diffuse), where=sky > 0)
    for name, expected, modelled in (("diffuse", diffuse, sky), ("direct", direct, beam)):
        _refuse_contradiction(name, expected, modelled, bands)
    total = np.where(is_beam[:, None], beam, sky)
    level = np.where(is_beam[:, None], direct, diffuse)
    irradiance: np.ndarray = np.divide(share * level, total, out=np.zeros_like(share), where=total > 0).T
    return irradiance


def _refuse_contradiction(name: str, expected: np.ndarray, modelled: np.ndarray, bands: Wavebands) -> None:
    idle = np.flatnonzero((expected > 0) & ~(modelled > 0))
    if idle.size:
        band = int(idle[0])
        raise SceneError(
            f"sky.toml: {name}_irradiance is {expected[band]:g} W m-2 nm-1 in waveband {band + 1} at "
            f"{bands.wavelength_nm[band]:g} nm, but the scene has no {name} light there; write 0.0 for it"
        )


def _refuse_unknown(section: SkySection, beam: np.ndarray, sky: np.ndarray, bands: Wavebands, toml_path: str) -> None:
    """Raise, with the lines to write, where no file says how bright sun or sky is."""
    missing = []
    if section.diffuse_irradiance is None and np.any(sky > 0):
        missing.append("diffuse")
    if section.direct_irradiance is None and np.any((beam > 0) & ~(sky > 0)):
        missing.append("direct")
    if not missing:
        return
    at = ", ".join(f"{w:g}" for w in bands.wavelength_nm[:_MAX_SHOWN]) + (", ..." if bands.n_bands > _MAX_SHOWN else "")
    values = ", ".join(["1.0"] * bands.n_bands)
    lines = "".join(f"{name}_irradiance = [{values}]\n" for name in missing)
    raise refuse(
        toml_path,
        "the light of a background is in W m-2 nm-1, but no file says how bright sun and sky are",
        code="E708",
        advice="write their irradiances on a horizontal plane into sky.toml, one value for each waveband "
        f"({at} nm):\n\n[sky]\n{lines}",
    )
