"""A job: the photon files of a run or shard, made where they are missing or damaged."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aomc_sky.errors import AomcSkyError
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.blocks import ChunkPool
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import ForgedManifestError, hash_matches, require_wavebands
from aomc_sky.outputs.names import PLAN
from aomc_sky.outputs.photons.files import PhotonFiles, PhotonWriter, photon_files
from aomc_sky.outputs.photons.leaves import BlockHashWriter, compared_blocks
from aomc_sky.outputs.statistics import PhotonSums

Progress = Callable[[int, int], None]
"""Called with photons done and photons in all."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MadePhotons:
    """Photon files that are in the folder now."""

    files: dict[str, dict[str, Any]]  #: bytes and SHA-256 of every photon file and every file of leaves by its name
    sums: dict[int, PhotonSums]  #: sums over the photons of every waveband [0-based]
    emitted: int  #: photons that had to be made


class Meter:
    """Photons done and photons in all, reported as they change."""

    def __init__(self, progress: Progress | None, total: int = 0) -> None:
        self._progress = progress
        self.done, self.total = 0, total

    def add(self, n_photons: int) -> None:
        """So many more are done."""
        self.done += n_photons
        if self._progress:
            self._progress(self.done, self.total)


class PhotonJob:
    """The photon files of a run or shard and their leaves: made by the threads of this process.

    Leaves get their name before the photons that they are of, so photons without leaves are not of a run that
    was killed. Photons that do not agree with their leaves are made again together with these, for nobody
    knows which of the two is damaged. Making the job raises where the disk is too small.
    """

    def __init__(
        self, pool: ChunkPool, folder: RunFolder, writers: Sequence[PhotonWriter], bands: Sequence[int]
    ) -> None:
        self.pool, self.folder, self.bands = pool, folder, tuple(bands)
        self.files = photon_files(folder, writers, bands)
        leaves = BlockHashWriter(pool.source, pool.shard)
        self.leaves = {band: PhotonFiles(folder, leaves, (band,)) for band in bands}
        folder.require_space(self.n_bytes_missing())

    def n_bytes_missing(self) -> int:
        """What the files will take beyond what they take now. [bytes]"""
        return sum(files.n_bytes_missing for files in (*self.files, *self.leaves.values()))

    def own_files(self, band: int) -> list[PhotonFiles]:
        """Files that hold one waveband alone, without its leaves."""
        return [files for files in self.files if files.bands == (band,)]

    def make(self, progress: Progress | None = None) -> MadePhotons:
        """Make what is missing or damaged, and the sums of all wavebands; photons that are only read are counted too.

        Nothing half is left where the operating system refuses.
        """
        shared = [files for files in self.files if len(files.bands) > 1 and not files.is_finished]
        finished = {band: self._finished_files(band) for band in self.bands}
        n_photons = {band: self.pool.shard.n_photons(self.pool.source.n_photons(band)) for band in self.bands}
        announce_photons(sum(n_photons.values()))
        meter = Meter(progress)
        for band in self.bands:
            n_readings = sum(files.writer.has_rows for files in finished[band])
            meter.total += (n_readings + bool(shared or not n_readings)) * n_photons[band]
        known = {band: self._compare(band, finished[band], meter) for band in self.bands}
        made: dict[int, PhotonSums] = {}
        emitted = 0
        with contextlib.ExitStack() as stack:
            for files in shared:
                stack.enter_context(files)
            for band, (sums, missing) in known.items():
                if sums is None or missing or shared:
                    made[band] = self._emit(band, missing, shared, meter)
                    emitted += n_photons[band]
                else:
                    made[band] = sums
        entries: dict[str, dict[str, Any]] = {}
        for of_files in self.pool.in_order(PhotonFiles.entries, [*self.files, *self.leaves.values()]):
            entries |= of_files
        return MadePhotons(files=entries, sums=made, emitted=emitted)

    def _finished_files(self, band: int) -> list[PhotonFiles]:
        """Files of one waveband that an earlier run finished; none where there are no leaves to compare them with."""
        return [files for files in self.own_files(band) if files.is_finished] if self.leaves[band].is_finished else []

    def _compare(
        self, band: int, finished: list[PhotonFiles], meter: Meter
    ) -> tuple[PhotonSums | None, list[PhotonFiles]]:
        """Sums over photons that agree with their leaves, and the files to make: leaves last, to be closed first."""
        sums = None
        for files in (files for files in finished if files.writer.has_rows):
            sums = self._stored_sums(band, files.writer, meter)
            if sums is None:
                finished = []
                break
        missing = [files for files in self.own_files(band) if files not in finished]
        return sums, missing if sums is not None else [*missing, self.leaves[band]]

    def _stored_sums(self, band: int, writer: PhotonWriter, meter: Meter) -> PhotonSums | None:
        """Sums over the photons of finished files, None where a block does not agree with its leaf."""
        sums = PhotonSums(self.pool.source.replicates)
        leaves = BlockHashWriter(self.pool.source, self.pool.shard).read(self.folder, band)
        compared = compared_blocks(self.pool, self.folder, writer, band, self.pool.shard, leaves)
        with contextlib.closing(compared) as blocks:
            for block, agrees in blocks:
                if not agrees:
                    meter.total += sums.n_photons  # read in vain
                    return None
                sums.add(block.sums)
                meter.add(block.n_photons)
        return sums

    def _emit(self, band: int, missing: list[PhotonFiles], shared: list[PhotonFiles], meter: Meter) -> PhotonSums:
        sums = PhotonSums(self.pool.source.replicates)
        with contextlib.ExitStack() as stack:
            targets = [*(stack.enter_context(files) for files in missing), *shared]
            for chunks, blocks, n in self.pool.chunks(band, [files.writer for files in targets]):
                for files, chunk in zip(targets, chunks, strict=True):
                    files.write(chunk)
                sums.add(blocks)
                meter.add(n)
        return sums


def finished_manifest(
    pool: ChunkPool,
    folder: RunFolder,
    name: str,
    read: Callable[[Path], dict[str, Any]],
    formats: tuple[str, ...],
    progress: Progress | None = None,
) -> dict[str, Any] | None:
    """Return the manifest of a finished run or shard, None where there is work left.

    The manifest is compared with the hash that it holds of itself, and every file that it lists with its SHA-256.
    Where that fails the manifest is removed, so that the folder is unfinished, and then the damaged files, so that they
    are made again. A manifest that agrees with its own hash and yet is none that we write is a ForgedManifestError: no
    damage made it so, and nothing is done. `progress` is called in proportion to the bytes of the files.
    """
    if folder.size_of(name) is None:
        return None
    manifest = None
    try:
        manifest = read(folder.path / name)
        require_wavebands(folder.path / name, manifest, pool.source.n_bands)
        is_of_plan = manifest["plan_sha256"] == pool.source.plan.sha256
        if not is_of_plan or manifest["options"]["formats"] != list(formats) or not hash_matches(manifest):
            manifest = None
    except ForgedManifestError:
        raise
    except AomcSkyError:  # a damaged manifest finishes nothing
        manifest = None
    damaged = [] if manifest is None else _damaged(pool, folder, manifest["files"], progress)
    if manifest is not None and not damaged:
        return manifest
    folder.remove(name)
    for file in damaged:
        if file == PLAN:  # never away: a folder without a plan belongs to nobody
            folder.write(PLAN, pool.source.plan.to_bytes())
        else:
            folder.remove(file)
    return None


def _damaged(
    pool: ChunkPool, folder: RunFolder, files: dict[str, dict[str, Any]], progress: Progress | None
) -> list[str]:
    def is_complete(name: str) -> bool:
        return folder.size_of(name) == files[name]["bytes"] and folder.sha256_of(name) == files[name]["sha256"]

    damaged, n_read = [], 0
    n_photons = sum(pool.shard.n_photons(pool.source.n_photons(band)) for band in range(pool.source.n_bands))
    n_bytes = sum(entry["bytes"] for entry in files.values())
    for name, complete in zip(files, pool.in_order(is_complete, files), strict=True):
        damaged += [] if complete else [name]
        n_read += files[name]["bytes"]
        if progress:
            progress(n_photons * n_read // max(n_bytes, 1), n_photons)
    return damaged
