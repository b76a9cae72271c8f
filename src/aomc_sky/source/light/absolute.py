"""The light of a scene in absolute units: irradiances of beam and sky that are known, and the lobes of backgrounds."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aomc_sky.component import Component
from aomc_sky.emission.irradiance import Irradiance
from aomc_sky.errors import SceneError
from aomc_sky.formats.text_file import refuse
from aomc_sky.source.light.inputs import LightInputs
from aomc_sky.wavebands import Wavebands

if TYPE_CHECKING:
    from aomc_sky.skies.lobes.sky import LobeSky

BEAM = "direct"
_MAX_SHOWN = 12


@dataclass(frozen=True, kw_only=True, slots=True)
class Light:
    """The light of a scene: components, and the row of them that serves each waveband."""

    components: tuple[Component, ...] = ()
    row_of_band: np.ndarray
    sky_wavelength_nm: np.ndarray | None = None
    intensity: np.ndarray | None = None  #: (n_band,) photons per iteration; None: 1
    notes: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    irradiance: Irradiance | None = None


class Levels(NamedTuple):
    """Irradiances of beam and sky on a horizontal plane, (n_band,), where they are known. [W m-2 nm-1]"""

    direct: np.ndarray | None = None
    diffuse: np.ndarray | None = None

    @property
    def is_unknown(self) -> bool:
        """Whether nothing is known."""
        return self.direct is None and self.diffuse is None

    @classmethod
    def said_by(cls, inputs: LightInputs) -> Levels:
        """Those of [sky]."""
        both = (inputs.direct_irradiance, inputs.diffuse_irradiance)
        return cls(*(None if one is None else np.array(one, dtype=np.float64) for one in both))


def in_absolute_units(
    light: Light, levels: Levels, skies: Sequence[LobeSky], bands: Wavebands, toml_path: str
) -> Light:
    """State the irradiance of every component, and add the lobes of the backgrounds.

    Light in relative units stays as it is. With backgrounds the strengths are irradiances in the same unit, with a row
    for each distinct set of base row, wavelength and irradiances. E708: backgrounds beside relative light.
    """
    if light.irradiance is not None:
        base = light.irradiance.of_component
    elif skies or not levels.is_unknown:
        base = _base_irradiance(light, levels, bands, toml_path, has_background=bool(skies))
    else:
        return light
    if not skies:
        dark = np.flatnonzero(base.sum(axis=1) == 0)
        if dark.size and not levels.is_unknown:
            raise SceneError(
                f"waveband {dark[0] + 1} at {bands.wavelength_nm[dark[0]]:g} nm has no light: direct_irradiance and "
                "diffuse_irradiance are 0 there; write a positive value, or choose others by --waveband"
            )
        return dataclasses.replace(light, irradiance=Irradiance(of_component=base))
    return _joined(light, base, skies, bands)


def _joined(light: Light, base: np.ndarray, skies: Sequence[LobeSky], bands: Wavebands) -> Light:
    """Sun, sky and lobes with strengths in one unit."""
    from aomc_sky.skies.lobes.light import background_light

    components = light.components
    keys = np.column_stack([light.row_of_band, bands.wavelength_nm, base])
    _, first, rows = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    added = background_light(skies, bands.wavelength_nm[first], taken=[c.name for c in components])
    if not components and not added.components:
        reason = "all their lobes lie below the horizon" if added.hidden else "their lobes have no light at that time"
        raise SceneError(f"the backgrounds are the only source of light, but {reason}")
    old_rows = light.row_of_band[first]
    own = [
        dataclasses.replace(
            component,
            strength=base[first, k],
            **{name: _rows_of(getattr(component, name), old_rows) for name in ("mass", "weight", "slope", "stokes")},
        )
        for k, component in enumerate(components)
    ]
    rows = rows.ravel()
    lobes = np.stack([c.strength[rows] for c in added.components], axis=1) if added.components else base[:, :0]
    notes = [f"below the horizon, so without photons: {', '.join(added.hidden)}"] if added.hidden else []
    return dataclasses.replace(
        light,
        components=(*own, *added.components),
        row_of_band=rows,
        notes=(*light.notes, *notes),
        irradiance=Irradiance(of_component=np.hstack([base, lobes]), horizon_loss=added.horizon_loss[rows]),
    )


def _rows_of(values: np.ndarray | None, rows: np.ndarray) -> Any:
    """The needed rows of masses, weights or slopes, if there are any; a single row is for all."""
    return values if values is None or values.shape[0] == 1 else values[rows]


def _base_irradiance(
    light: Light, levels: Levels, bands: Wavebands, toml_path: str, *, has_background: bool
) -> np.ndarray:
    """Irradiance of sun and sky, shape (n_band, n_component). [W m-2 nm-1]"""
    components, rows = light.components, light.row_of_band
    if not components:
        return np.zeros((bands.n_bands, 0))
    share = np.stack([c.strength[rows] * (c.mass.max(axis=1) > 0)[rows if len(c.mass) > 1 else 0] for c in components])
    is_beam = np.array([c.name == BEAM for c in components])
    beam, sky = share[is_beam].sum(axis=0), share[~is_beam].sum(axis=0)
    _refuse_unknown(levels, beam, sky, bands, toml_path, has_background=has_background)
    diffuse = np.zeros(bands.n_bands) if levels.diffuse is None else levels.diffuse
    direct = levels.direct
    if direct is None:
        direct = np.divide(diffuse * beam, sky, out=np.zeros_like(diffuse), where=sky > 0)
    for name, expected, modelled in (("diffuse", diffuse, sky), ("direct", direct, beam)):
        _refuse_contradiction(name, expected, modelled, bands)
    total = np.where(is_beam[:, None], beam, sky)
    level = np.where(is_beam[:, None], direct, diffuse)
    irradiance: np.ndarray = (np.divide(share, total, out=np.zeros_like(share), where=total > 0) * level).T
    return irradiance


def _refuse_contradiction(name: str, expected: np.ndarray, modelled: np.ndarray, bands: Wavebands) -> None:
    idle = np.flatnonzero((expected > 0) & ~(modelled > 0))
    if idle.size:
        band = int(idle[0])
        raise SceneError(
            f"sky.toml: {name}_irradiance is {expected[band]:g} W m-2 nm-1 in waveband {band + 1} at "
            f"{bands.wavelength_nm[band]:g} nm, but the scene has no {name} light there; write 0.0 for it"
        )


def _refuse_unknown(
    levels: Levels, beam: np.ndarray, sky: np.ndarray, bands: Wavebands, toml_path: str, *, has_background: bool
) -> None:
    """Raise, with the lines to write, where no file says how bright sun or sky is."""
    missing = []
    if levels.diffuse is None and np.any(sky > 0):
        missing.append("diffuse")
    if levels.direct is None and np.any((beam > 0) & ~(sky > 0)):
        missing.append("direct")
    if not missing:
        return
    at = ", ".join(f"{w:g}" for w in bands.wavelength_nm[:_MAX_SHOWN]) + (", ..." if bands.n_bands > _MAX_SHOWN else "")
    values = ", ".join(["1.0"] * bands.n_bands)
    lines = "".join(f"{name}_irradiance = [{values}]\n" for name in missing)
    what = "the light of a background is in W m-2 nm-1, but no file says how bright sun and sky are"
    if not has_background:
        what = f"[sky] says how bright one of sun and sky is, and nothing says it of the {missing[0]} light"
    raise refuse(
        toml_path,
        what,
        code="E708",
        advice="write their irradiances on a horizontal plane into sky.toml, one value for each waveband "
        f"({at} nm):\n\n[sky]\n{lines}",
    )
