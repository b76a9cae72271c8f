"""Background-sky files (DIRSIG BackgroundSkyData, HDF5): reader and writer."""

from __future__ import annotations

from aomc_sky.formats.background_data import (
    Animation,
    BackgroundFile,
    BackgroundInfo,
    Lobe,
    LobeType,
    ReferenceType,
    animation_of_lobes,
)

__all__ = [
    "Animation",
    "BackgroundFile",
    "BackgroundInfo",
    "Lobe",
    "LobeType",
    "ReferenceType",
    "animation_of_lobes",
]
