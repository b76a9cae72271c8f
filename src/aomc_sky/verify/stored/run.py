"""A finished run, or its shards, verified: files, counts, blocks, directions."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aomc_sky.outputs.shard import Shard
from aomc_sky.outputs.statistics import PhotonSums
from aomc_sky.sampling.allocation import AllocationMethod
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.counts import rings_of
from aomc_sky.verify.counts import FAMILY_LEVEL, CountCheck, check_bands
from aomc_sky.verify.directions import DirectionTests, Tied
from aomc_sky.verify.report import Check, Pulls, VerifyReport, judged
from aomc_sky.verify.stored.manifest import OF_THE_MACHINE, WITHOUT_SCENE, counts_check, manifest_check
from aomc_sky.verify.stored.parts import RunPart, missing_shards
from aomc_sky.verify.stored.photons import BandPhotons, BlockPosition, Resampling, StoredLeaves

Progress = Callable[[int, int], None]

MOST_NUMBERS = 10
"""Missing shards, and wavebands without a file, that stand in a line by number."""


@dataclass(frozen=True, kw_only=True, slots=True)
class VerifyOptions:
    """How a run is verified."""

    #: Part of the blocks of every waveband that is made again from the plan, at least one unless it is 0. [0 to 1]
    resample: float = 0.01
    #: Chance that correct photons fail any test. [above 0, below 1]
    family_level: float = FAMILY_LEVEL
    #: Of the thinning. [0 to 2^64 - 1]
    seed: int = 0
    #: Of the choice of blocks; None draws one, which is reported: one who changes photons and makes all
    #: hashes agree again cannot know which blocks are compared. [0 to 2^64 - 1]
    block_seed: int | None = None
    #: 0 for one per CPU.
    threads: int = 0


def verify_run(
    parts: Sequence[RunPart], bands: Sequence[int], options: VerifyOptions, progress: Progress | None = None
) -> VerifyReport:
    """Verify a run, or its shards, all of one plan; `progress` is called with photons done and photons in all.

    Files against the manifest, counts against masses, blocks against leaves and plan, directions against the sky. An
    OutputError says that the operating system refuses to read a file.
    """
    source = parts[0].source
    files, damaged = _files(parts)
    checks: list[Check] = []
    missing = missing_shards(parts)
    checks += _missing_checks(missing)
    sums: dict[int, PhotonSums] = {}
    counts = count_checks(source, bands)
    leaves = [StoredLeaves.of(part) if part.formats else StoredLeaves.none() for part in parts]
    checks += [*counts, *(check for stored in leaves for check in stored.checks)]
    positions: dict[bytes, BlockPosition] = {}
    for part, stored in zip(parts, leaves, strict=True):
        positions |= stored.positions(part)
    tests = DirectionTests(source, tied=Tied.PLAN, seed=options.seed)
    block_seed = secrets.randbits(64) if options.block_seed is None else options.block_seed
    resampling = Resampling(fraction=options.resample, seed=block_seed, damaged=damaged)
    meter = _Meter(progress, sum(source.n_photons(band) for band in bands))
    pulls: list[Pulls] = []
    untested = []
    for band in bands:
        photons = BandPhotons(parts, leaves, positions, band, resampling)
        if photons.is_whole and not missing:
            directions, found = tests.checks(band, tests.count(band, photons.blocks(meter.add), options.threads))
            pulls += [found] if found is not None else []
        else:
            directions = []
            untested.append(band + 1)
            for _ in photons.blocks(meter.add):
                pass
        checks += [*photons.checks(), *directions]
        of_band = photons.sums()
        sums |= {} if of_band is None else {band: of_band}
    rebuilt = [*(manifest_check(part, sums) for part in parts)]
    rebuilt += [counts_check(part) for part in parts if not part.shard.is_named]
    notes = _untested(untested, len(bands)) + (tests.notes if pulls else [])
    report = judged([*files, *rebuilt, *checks], family_level=options.family_level, notes=notes, pulls=pulls)
    unvouched = (*WITHOUT_SCENE, OF_THE_MACHINE)
    return replace(report, block_seed=block_seed if options.resample else None, unvouched=unvouched)


def _files(parts: Sequence[RunPart]) -> tuple[list[Check], frozenset[str]]:
    checks: list[Check] = []
    damaged: set[str] = set()
    for part in parts:
        of_part, damaged_files = file_checks(part)
        checks += of_part
        damaged |= damaged_files
    return checks, frozenset(damaged)


class _Meter:
    """Photons done, reported as they change."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self._progress, self._done, self._total = progress, 0, total

    def add(self, n_photons: int) -> None:
        self._done += n_photons
        if self._progress:
            self._progress(self._done, self._total)


def _missing_checks(missing: Sequence[Shard]) -> list[Check]:
    if not missing:
        return []
    named = ", ".join(str(shard) for shard in missing[:MOST_NUMBERS])
    more = f" and {len(missing) - MOST_NUMBERS} more" if len(missing) > MOST_NUMBERS else ""
    return [Check(name="shards", passed=False, detail=f"missing: {named}{more}")]


def _untested(wavebands: Sequence[int], n_bands: int) -> list[str]:
    if not wavebands:
        return []
    which = "" if len(wavebands) == n_bands else f" of waveband {', '.join(map(str, wavebands[:MOST_NUMBERS]))}"
    return [f"directions{which} were not tested: no complete file holds every bit of the photons"]


def file_checks(part: RunPart) -> tuple[list[Check], set[str]]:
    """Compare every file with its entry in the manifest.

    One line for all undamaged files and one for each damaged one, whose names are returned too.
    """
    entries = sorted(part.manifest["files"].items())
    damage = {name: _damage(part, name, entry) for name, entry in entries}
    undamaged = [name for name, what in damage.items() if not what]
    checks = [Check(name="files", passed=False, detail=f"{name}: {what}") for name, what in damage.items() if what]
    if undamaged:
        n_bytes = sum(entry["bytes"] for name, entry in entries if not damage[name])
        of_shard = f" of shard {part.shard}" if part.shard.is_named else ""
        detail = f"{len(undamaged)} files{of_shard}, {n_bytes} bytes: length and SHA-256 agree"
        checks.insert(0, Check(name="files", passed=True, detail=detail))
    return checks, {name for name, what in damage.items() if what}


def _damage(part: RunPart, name: str, entry: dict[str, object]) -> str:
    """What is wrong with a file, nothing if it is undamaged."""
    size, expected = part.folder.size_of(name), int(str(entry["bytes"]))
    if size is None:
        return "missing"
    if size != expected:
        how = "truncated" if size < expected else "too long"
        return f"{how}: {size} bytes, the manifest says {expected}"
    if part.folder.sha256_of(name) != entry["sha256"]:
        return "its SHA-256 is not the one in the manifest"
    return ""


_ROUNDING = 1e-6
"""Of the AOMC program, which works in the table's own units: share of a photon."""


def count_checks(source: PhotonSource, bands: Sequence[int]) -> list[Check]:
    """Check the counts of wavebands as `aomc_sky.verify_counts` does, of each replicate on its own; the worst one
    counts.

    Under allocation aomc every cell is what is expected, rounded to a whole number.
    """
    options = source.plan.options
    method = AllocationMethod(options["allocation"])
    checks: list[Check] = []
    for band in bands:
        if method is AllocationMethod.AOMC:
            checks.append(_rounded(source, band))
            continue
        if source.mass(band).max(initial=0.0) > 0:
            checks += _of_band(source, band, method)
    return checks


def _of_band(source: PhotonSource, band: int, method: AllocationMethod) -> list[Check]:
    counts = source.replicate_counts(band)
    each, left = divmod(int(source.plan.arrays["requested"][band]), source.replicates)
    expected = each + (np.arange(source.replicates) < left)
    mass, rings = source.mass(band)[None], rings_of(source.plan.arrays)
    report = check_bands(counts, mass, method, expected, rings)
    found: dict[str, Check] = {}
    for check in (_as_check(c, band, several=source.replicates > 1) for c in report.checks):
        if check.p_value is not None:  # every replicate is a test of its own
            found[f"{check.name}, {check.detail}"] = check
        elif check.name not in found or found[check.name].passed:
            found[check.name] = check
    return list(found.values())


def _as_check(check: CountCheck, band: int, *, several: bool) -> Check:
    where = [f"replicate {check.band}"] if several else []
    is_test = check.name.startswith("chi-square, ")
    if check.cell is not None and not check.passed:
        where.append(f"cell {check.cell}")
    result = Check(
        name=f"counts: {check.name.partition(',')[0] if is_test else check.name}",
        waveband=band + 1,
        passed=check.passed,
        found=check.found,
        allowed=check.allowed,
        detail=", ".join(where),
    )
    if not is_test:
        return result
    detail = ", ".join([check.name.partition(", ")[2], *where])
    return replace(result, found=None, allowed=None, p_value=check.found, detail=detail)


def _rounded(source: PhotonSource, band: int) -> Check:
    expected = source.expected(band)
    off = np.abs(source.counts[band] - expected)
    worst = int(off.argmax())
    allowed = 0.5 + _ROUNDING * max(1.0, float(expected[worst]))
    is_near = bool(off[worst] <= allowed)
    return Check(
        name="counts: each cell rounded",
        waveband=band + 1,
        passed=is_near,
        found=float(off[worst]),
        allowed=allowed,
        detail="" if is_near else f"cell {worst}",
    )
