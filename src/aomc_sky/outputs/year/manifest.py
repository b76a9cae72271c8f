"""manifest.json of a year of skies, written last. Everything about time and machine stands under ``run``."""

from __future__ import annotations

import platform
import time
from pathlib import Path
from typing import Any

import numpy as np

import aomc_sky
from aomc_sky.outputs.folder.run_folder import MANIFEST, PLAN
from aomc_sky.outputs.manifest.file import load_manifest
from aomc_sky.outputs.manifest.run import CONVENTIONS
from aomc_sky.outputs.year.folder import COUNTS, INDEX, YearFolder
from aomc_sky.outputs.year.index import read_index
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.year import SCHEMA, YearPlan


def build_year_manifest(
    folder: YearFolder, plan: YearPlan, inputs: dict[str, Any], hours: int, seconds: float
) -> dict[str, Any]:
    """Put the manifest together; equal weather, seed and options give equal text aside from ``run``."""
    index = read_index(folder.path)
    states = [entry["state"] for entry in index]
    limited = sum(1 for entry in index if entry["state"] == "sky" and entry["note"])
    names = (PLAN, COUNTS, INDEX)
    return {
        "schema": SCHEMA,
        "version": aomc_sky.__version__,
        "stream": STREAM_VERSION,
        "seed": plan.options["seed"],
        "plan_sha256": plan.sha256,
        "inputs": inputs,
        "conventions": CONVENTIONS,
        "options": {k: v for k, v in plan.options.items() if k not in ("schema", "stream", "seed")},
        "hours": {state: states.count(state) for state in sorted(set(states))},
        "hours_limited": limited,
        "total": sum(int(entry["photons"]) for entry in index),
        "files": {name: {"bytes": folder.size_of(name), "sha256": folder.sha256_of(name)} for name in sorted(names)},
        "run": {
            "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            "seconds": round(seconds, 6),
            "hours": hours,
            "hours_per_second": round(hours / seconds, 1) if hours and seconds > 0 else None,
            "python": platform.python_version(),
            "numpy": np.__version__,
            "machine": platform.machine(),
        },
    }


def read_year_manifest(folder: str | Path) -> dict[str, Any]:
    """Read the manifest of a finished year, as `load_manifest` does."""
    return load_manifest(Path(folder) / MANIFEST, "year_manifest.schema.json")
