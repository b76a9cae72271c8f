"""What is said of a table of an atmosphere."""

from __future__ import annotations

from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.engine.atmosphere.keys import size_report
from aomc_sky.engine.atmosphere.table import AtmosphereTable
from aomc_sky.skies.atmosphere import AtmosphereSky


def table_report(table: AtmosphereTable) -> dict[str, Any]:
    """What a table rests on and how good it is: JSON values.

    Parameters
    ----------
    table : AtmosphereTable
        With or without skies.

    Returns
    -------
    dict
        Species with optical depths and norms of their phase functions, what was dropped; per sun the irradiances,
        the truncation, the estimated errors and the time.
    """
    report, medium = table.report, table.medium
    return {
        "description": table.request.path,
        "version": aomc_sky.__version__,
        "wavelength_nm": medium.wavelength_nm.tolist(),
        "optical_depth": {name: rows.tolist() for name, rows in report.optical_depth.items()},
        "phase_norm": {name: rows.tolist() for name, rows in report.phase_norm.items()},
        "dropped": list(report.dropped),
        "ground_albedo": medium.ground_albedo.tolist(),
        "sun_angular_radius_deg": float(np.rad2deg(medium.sun_angular_radius_rad)),
        "bins": list(table.bins),
        "sizes": size_report(table.sizes),
        "suns": [
            {"sun_zenith_deg": degrees, "method": method}
            for degrees, method in zip(table.sun_zenith_deg, table.methods, strict=True)
        ]
        if not table.skies
        else [_sun_report(sky) for sky in table.skies],
        "seconds": table.seconds,
    }


def _sun_report(sky: AtmosphereSky) -> dict[str, Any]:
    solved = sky.solved
    radiance = sky.patch_mean.sum(axis=1)
    relative = np.divide(sky.patch_error, radiance, out=np.zeros_like(radiance), where=radiance > 0)
    return {
        "sun_zenith_deg": sky.sun_zenith_deg,
        "method": solved.method,
        "reason": solved.reason or None,
        "orders": solved.n_orders,
        "paths": solved.n_paths or None,
        "paths_error": solved.resolution_error if solved.n_paths else None,
        "visible_share": solved.visible_share,
        "direct_irradiance": sky.direct_irradiance.tolist(),
        "diffuse_irradiance": sky.diffuse_irradiance.tolist(),
        "truncation": None if solved.more is None else solved.truncation.tolist(),
        "largest_relative_error": relative.max(axis=1).tolist(),
        "series_error": solved.series_error,
        "patch_change": sky.patch_change,
        "seconds": dict(solved.seconds),
    }
