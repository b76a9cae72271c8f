"""Photons of a small run as variables of a dataset: one long dimension, waveband after waveband."""

from __future__ import annotations

from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.outputs.blocks.chunk_pool import BLOCK
from aomc_sky.outputs.manifest.run import CONVENTIONS
from aomc_sky.source.photon_source import PhotonSource

MOST_PHOTONS = 10_000_000
"""Photons that a dataset holds, since it stands in memory as a whole (about 200 MB)."""

_COLUMNS = {
    "ux": {"long_name": f"x of the {CONVENTIONS['direction']}", "units": "1"},
    "uy": {"long_name": "y of the travel direction", "units": "1"},
    "uz": {"long_name": f"z of the travel direction; {CONVENTIONS['frame']}", "units": "1"},
    "patch": {"long_name": "cell of the photon, from 0: cells of all components, patches zenith by zenith"},
    "x": {"long_name": "x at the surface, origin at the centre of the footprint", "units": "m"},
    "y": {"long_name": "y at the surface, origin at the centre of the footprint", "units": "m"},
    "weight": {"long_name": "statistical weight, mean 1", "units": "1"},
}


def photon_variables(source: PhotonSource) -> dict[str, Any]:
    """Variables of all photons, and how many each waveband has (a contiguous ragged array of the CF conventions).

    Parameters
    ----------
    source : PhotonSource
        The run.

    Returns
    -------
    dict
        `ux`, `uy`, `uz`, `patch`, and `x`, `y`, `weight` where the run has them, over (photon);
        `photon_count` over (waveband).

    Raises
    ------
    UsageError
        More than 1e7 photons.
    """
    if source.total > MOST_PHOTONS:
        raise UsageError(
            f"{source.total} photons are more than the {MOST_PHOTONS} that a dataset holds in memory; take npy or mcpl "
            "for them"
        )
    columns: dict[str, np.ndarray] = {}
    done = 0
    for band in range(source.n_bands):
        for batch in source.batches(band, BLOCK):
            for name in _COLUMNS:
                values = getattr(batch, name)
                if values is not None:
                    columns.setdefault(name, np.empty(source.total, values.dtype))[done : done + len(batch)] = values
            done += len(batch)
    counts = np.array([source.n_photons(band) for band in range(source.n_bands)], dtype=np.int64)
    count_attributes = {"long_name": "photons of the waveband, one after the other", "sample_dimension": "photon"}
    return {
        **{name: ("photon", column, _COLUMNS[name]) for name, column in columns.items()},
        "photon_count": ("waveband", counts, count_attributes),
    }
