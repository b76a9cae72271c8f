"""The lobes of background skies by themselves: density, sampler, masses above the horizon and over patches.

Kinds: "hg" (Henyey-Greenstein), "ggx" and "beckmann" (VNDF). Local frame: the axis of a lobe is +z. A
quaternion (w, x, y, z) turns local into world (x east, y north, z up); directions point from the scene to the sky.
"""

from __future__ import annotations

from aomc_sky.skies.lobes.horizon import mass_above_horizon
from aomc_sky.skies.lobes.lobe import KINDS, pdf, rotation_matrix, sample, to_local, to_world
from aomc_sky.skies.lobes.patches import patch_mass

__all__ = ["KINDS", "mass_above_horizon", "patch_mass", "pdf", "rotation_matrix", "sample", "to_local", "to_world"]
