"""What ``aomc-sky lobes`` prints of background skies at one time."""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.cli.commands.run_report import MAX_COMPONENTS, MAX_ROWS
from aomc_sky.cli.table import table
from aomc_sky.formats.sky_toml.rules import moment_text
from aomc_sky.source.backgrounds.scene import LobeScene, axis_of

MAX_LOBES = 100


def as_json(scene: LobeScene) -> dict[str, Any]:
    """Lobes and irradiances as JSON values. [W m-2 nm-1, nm, deg]"""
    first = scene.sections[0]
    sphere, above, plane = (scene.irradiance(above=kind) for kind in ("sphere", "plain", "projected"))
    loss = _loss(sphere.sum(axis=0), above.sum(axis=0))
    return {
        "files": [section.file for section in scene.sections],
        "time": moment_text(first.time),
        "unix_time_s": first.time,
        "utc_offset_h": first.utc_offset,
        "interpolation": first.interpolation,
        "wavelength_nm": scene.wavelength_nm.tolist(),
        "sphere_W_m2_nm": sphere.sum(axis=0).tolist(),
        "irradiance_W_m2_nm": plane.sum(axis=0).tolist(),
        "horizon_loss": loss.tolist(),
        "lobes": [
            {
                "name": name,
                "kind": lobe.kind,
                "param0": lobe.param0,
                "param1": lobe.param1,
                "quaternion": lobe.quaternion.tolist(),
                "zenith_deg": axis_of(lobe)[0],
                "azimuth_deg": axis_of(lobe)[1],
                "share_above_horizon": scene.share(lobe, "plain"),
                "share_on_horizontal": scene.share(lobe, "projected"),
                "sphere_W_m2_nm": sphere[k].tolist(),
                "irradiance_W_m2_nm": plane[k].tolist(),
            }
            for k, (name, lobe) in enumerate(scene.lobes)
        ],
    }


def _loss(sphere: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Share of the light that comes from below the horizon; 0 without light."""
    share = np.divide(sphere - above, sphere, out=np.zeros_like(sphere), where=sphere > 0)
    return np.clip(share, 0.0, 1.0)


def as_text(scene: LobeScene, written: dict[str, str]) -> str:
    """Background skies for a person."""
    values = as_json(scene)
    lines = [
        f"{', '.join(values['files'])} at {values['time']}, local midnight {values['utc_offset_h']:+g} h from UTC, "
        f"{values['interpolation']} between keys",
        "",
    ]
    if not values["lobes"]:
        lines.append("no lobe has light at this time")
    else:
        lines += [*_lobe_lines(values), "", *_irradiance_lines(values)]
    lines += ["", *(f"{what}: {where}" for what, where in written.items())]
    return "\n".join(lines).rstrip()


def _lobe_lines(values: dict[str, Any]) -> list[str]:
    rows = [
        (
            lobe["name"],
            lobe["kind"],
            f"{lobe['param0']:g}",
            "-" if lobe["kind"] == "hg" else f"{lobe['param1']:g}",
            f"{lobe['zenith_deg']:.3f}",
            f"{lobe['azimuth_deg']:.3f}",
            f"{lobe['share_above_horizon']:.6f}",
            f"{lobe['share_on_horizontal']:.6f}",
        )
        for lobe in values["lobes"][:MAX_LOBES]
    ]
    head = ("lobe", "kind", "g, alpha x", "alpha y", "zenith", "azimuth", "above", "on plane")
    lines = [
        "shares of each lobe above the horizon and on a horizontal plane; azimuth from +x (east) towards +y (north)",
        table(rows, head),
    ]
    hidden = len(values["lobes"]) - len(rows)
    return lines if hidden <= 0 else [*lines, f"... and {hidden} more lobes (--json has all)"]


def _irradiance_lines(values: dict[str, Any]) -> list[str]:
    by_light = sorted(values["lobes"], key=lambda lobe: -max(lobe["irradiance_W_m2_nm"]))
    shown = by_light[:MAX_COMPONENTS]
    rows = [
        (
            f"{wavelength:g}",
            f"{values['sphere_W_m2_nm'][k]:.5g}",
            f"{values['irradiance_W_m2_nm'][k]:.5g}",
            f"{values['horizon_loss'][k]:.6f}",
            *(f"{lobe['irradiance_W_m2_nm'][k]:.4g}" for lobe in shown),
        )
        for k, wavelength in enumerate(values["wavelength_nm"][:MAX_ROWS])
    ]
    lines = [
        "irradiance over the sphere, and Ed on a horizontal plane, of all lobes and of each [W m-2 nm-1]; "
        "below: share from below the horizon",
        table(rows, ("nm", "sphere", "Ed", "below", *(lobe["name"] for lobe in shown))),
    ]
    if len(values["wavelength_nm"]) > MAX_ROWS or len(by_light) > len(shown):
        lines.append(f"... {len(values['wavelength_nm'])} wavelengths, {len(by_light)} lobes (--json has all)")
    return lines
