"""The photons of a run as its files hold them; every block is compared with its leaf and with the plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.formats.mcpl.file import read_mcpl
from aomc_sky.outputs.photons.leaves import StoredPhotons, joined_rows, leaf_hash, photon_columns, tree_root
from aomc_sky.outputs.shard import BLOCK
from aomc_sky.outputs.statistics import BlockSums, PhotonSums
from aomc_sky.sampling.streams import stream_key
from aomc_sky.verify.directions import PhotonRows
from aomc_sky.verify.report import MAX_NAMED, Check
from aomc_sky.verify.stored.parts import RunPart

FOREIGN_SHARE = 0.5
"""Part of the photons of a damaged block that are others than the plan's, from which on it is another run's block."""

BlockPosition = tuple[int, int]
"""Waveband [0-based] and block of the whole run."""

Span = tuple[int, int]
"""First photon and end."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredLeaves:
    """Leaves of a part as its files of leaves hold them."""

    #: uint8 (n_block, 32) of every waveband whose file can be read. [0-based]
    of_band: dict[int, np.ndarray]
    #: Whether the files can be read and agree with the manifest.
    checks: list[Check]

    @classmethod
    def of(cls, part: RunPart) -> StoredLeaves:
        """Read the files and compare their roots with the manifest."""
        of_band, checks = {}, []
        for band in part.bands:
            try:
                of_band[band] = part.leaves.read(part.folder, band)
            except OutputError as error:
                checks.append(Check(name="leaves", waveband=band + 1, passed=False, detail=str(error)))
        if len(of_band) == len(part.bands):
            checks += _root_checks(part, of_band)
        return cls(of_band=of_band, checks=checks)

    @classmethod
    def none(cls) -> StoredLeaves:
        """Of a run without photons."""
        return cls(of_band={}, checks=[])

    def positions(self, part: RunPart) -> dict[bytes, BlockPosition]:
        """Where each leaf belongs."""
        return {
            leaf.tobytes(): (band, block)
            for band, leaves in self.of_band.items()
            for block, leaf in enumerate(leaves, part.shard.blocks(part.source.n_photons(band))[0])
        }


def _root_checks(part: RunPart, of_band: dict[int, np.ndarray]) -> list[Check]:
    content = part.manifest.get("content")
    if content is None:
        return []
    roots = [tree_root(of_band[band]) for band in part.bands]
    expected = {entry["waveband"]: entry["root"] for entry in content["bands"]}
    checks = [
        Check(name="leaves", waveband=band + 1, passed=False, detail="their root differs from the root in the manifest")
        for band, root in zip(part.bands, roots, strict=True)
        if expected.get(band + 1) != root.hex()
    ]
    root = tree_root(roots).hex()
    is_same = not checks and ("root" not in content or content["root"] == root)
    detail = f"root {root[:16]}" if is_same else f"root {root[:16]}, the manifest says {str(content.get('root'))[:16]}"
    return [*checks, Check(name="content tree", passed=is_same, detail=detail)]


@dataclass(frozen=True, kw_only=True, slots=True)
class _BlockResult:
    """What the comparison of one block found."""

    #: Of the whole run.
    block: int
    #: Over its photons.
    sums: list[BlockSums]
    #: is_regenerated, is_compared: Whether it was chosen to be made again; whether it was, for that or because its
    #: leaf is another.
    is_regenerated: bool
    is_compared: bool
    #: What is wrong with it, nothing if it is whole.
    damage: str = ""
    #: Whether its photons are another run's.
    is_foreign: bool = False


class BlockChecker:
    """Compares blocks of one waveband in the files of one writer, on any threads, and keeps what it finds.

    The writer is of a format that holds every bit; `positions` says where each leaf of the run belongs, to name what
    stands at a wrong position.
    """

    def __init__(
        self, part: RunPart, writer: Any, band: int, leaves: StoredLeaves, positions: Mapping[bytes, BlockPosition]
    ) -> None:
        self._part, self._writer, self._band = part, writer, band
        self._expected, self._positions = leaves.of_band.get(band), positions
        self._first = part.shard.blocks(part.source.n_photons(band))[0]
        self._results: list[_BlockResult] = []  # threads append, which needs no lock

    def compare(self, span: Span, *, regenerate: bool) -> tuple[np.ndarray, ...]:
        """Read one block, compare it, and return its rows."""
        part, block = self._part, span[0] // BLOCK
        quiet = np.errstate(divide="ignore", over="ignore", invalid="ignore")  # sums of damaged photons
        with quiet, StoredPhotons(part.folder, self._writer, self._band) as stored:
            read = stored.block(span)
        rows, leaf = read.rows, read.leaf
        agrees = self._expected is None or self._expected[block - self._first].tobytes() == leaf
        damage, is_foreign, is_compared = "", False, regenerate or not agrees
        if is_compared:
            damage, is_foreign = self._damage(rows, leaf, span, agrees=agrees)
        result = _BlockResult(
            block=block,
            sums=read.sums,
            is_regenerated=regenerate,
            is_compared=is_compared,
            damage=damage,
            is_foreign=is_foreign,
        )
        self._results.append(result)
        return rows

    def sums(self) -> PhotonSums | None:
        """Sums over all photons that were read; None if a block is damaged."""
        if any(result.damage for result in self._results):
            return None
        total = PhotonSums(self._part.source.replicates)
        for result in self._results:
            total.add(result.sums)
        return total

    def _damage(self, rows: tuple[np.ndarray, ...], leaf: bytes, span: Span, *, agrees: bool) -> tuple[str, bool]:
        """What is wrong with a block, nothing if it is whole, and whether it is another run's."""
        made = joined_rows(photon_columns(self._part.source.photons(self._band, *span)))
        found = joined_rows(rows).astype(made.dtype, copy=False)
        differs = made.view(f"u{made.itemsize}") != found.view(f"u{made.itemsize}")
        if not differs.any():
            return ("" if agrees else "its leaf is damaged, its photons are not"), False
        block, other = span[0] // BLOCK, self._positions.get(leaf)
        if other is not None and other != (self._band, block):
            return f"holds block {other[1]} of waveband {other[0] + 1}", False
        is_wrong = differs.any(axis=1)
        n_wrong, first = int(np.count_nonzero(is_wrong)), span[0] + int(is_wrong.argmax())
        what = f"{n_wrong} of {len(is_wrong)} photons differ from the plan, photon {first} is the first"
        return what, n_wrong > FOREIGN_SHARE * len(is_wrong) and _are_directions(found)

    def checks(self) -> Iterator[Check]:
        """What was found."""
        name = self._writer.names((self._band,))[0]
        waveband = self._band + 1
        results = sorted(self._results, key=lambda result: result.block)
        damaged = [result for result in results if result.damage]
        if not damaged:
            n_made = sum(result.is_regenerated for result in results)
            made = f", {n_made} of them made again from the plan" if n_made else ""
            detail = f"{name}: {len(results)} blocks agree{made}"
            yield Check(name="blocks", waveband=waveband, passed=True, detail=detail)
            return
        n_compared = sum(result.is_compared for result in results)
        if sum(result.is_foreign for result in damaged) == n_compared:
            every = "every block" if n_compared == len(results) else f"every block that was made again ({n_compared})"
            detail = f"{name}: {every} belongs to another run (another scene, seed or options)"
            yield Check(name="blocks", waveband=waveband, passed=False, detail=detail, is_foreign=True)
            return
        for result in damaged[:MAX_NAMED]:
            detail = f"{name}, block {result.block}: {result.damage}"
            yield Check(name="blocks", waveband=waveband, passed=False, detail=detail)
        hidden = len(damaged) - MAX_NAMED
        if hidden > 0:
            yield Check(name="blocks", waveband=waveband, passed=False, detail=f"{name}: {hidden} more damaged blocks")


def leaves_of_plan(part: RunPart, band: int, blocks: Sequence[int], leaves: StoredLeaves) -> Check:
    """Compare leaves with blocks made from the plan, for a run whose photons stand in no file that holds every bit."""
    n = part.source.n_photons(band)
    stored = leaves.of_band[band]
    wrong = []
    for block in blocks:
        batch = part.source.photons(band, block * BLOCK, min((block + 1) * BLOCK, n))
        if leaf_hash(*photon_columns(batch)) != stored[block - part.shard.blocks(n)[0]].tobytes():
            wrong.append(block)
    detail = f"leaves of {len(blocks)} blocks agree with the plan"
    if wrong:
        detail = f"leaves of blocks {', '.join(map(str, wrong[:MAX_NAMED]))} differ from the plan"
    return Check(name="blocks", waveband=band + 1, passed=not wrong, detail=detail)


def _are_directions(rows: np.ndarray) -> bool:
    """Whether most rows begin with a unit vector: photons of another run do, zeros and noise of a disk do not."""
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.sqrt((rows[:, :3].astype(np.float64) ** 2).sum(axis=1))
        return int(np.count_nonzero(np.abs(length - 1.0) < 1e-3)) > FOREIGN_SHARE * len(rows)


CHOICE = "verify-blocks"
"""Name of the stream that chooses blocks; no photon is made from it."""


def chosen_blocks(seed: int, band: int, n_blocks: int, fraction: float) -> np.ndarray:
    """Blocks of a band that a resampling results at: ceil(fraction x n_blocks) different ones in rising order."""
    n = min(n_blocks, int(np.ceil(fraction * n_blocks)))
    generator = np.random.Generator(np.random.Philox(key=[stream_key(seed, CHOICE), band]))
    return np.sort(generator.choice(n_blocks, size=n, replace=False)) if n else np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, kw_only=True, slots=True)
class Resampling:
    """Which blocks are made again from the plan."""

    #: Part of the blocks of every waveband, at least one unless it is 0. [0 to 1]
    fraction: float
    #: Of the choice. [0 to 2^64 - 1]
    seed: int
    #: Files that are known to be damaged: all their blocks are made again, to say what is wrong.
    damaged: frozenset[str]


class BandPhotons:
    """Files of one waveband that can be read, and what is wrong with the others.

    `leaves` are those of each part; `positions` says where each leaf of the run belongs.
    """

    def __init__(
        self,
        parts: Sequence[RunPart],
        leaves: Sequence[StoredLeaves],
        positions: Mapping[bytes, BlockPosition],
        band: int,
        resampling: Resampling,
    ) -> None:
        self._band = band
        n_blocks = -(-parts[0].source.n_photons(band) // BLOCK)
        self._damaged = resampling.damaged
        self._again = frozenset(chosen_blocks(resampling.seed, band, n_blocks, resampling.fraction).tolist())
        self._damage: list[Check] = []
        self._readable: list[tuple[RunPart, Any, BlockChecker]] = []
        self._with_rows = 0
        self._packed: RunPart | None = None
        for part, stored in zip(parts, leaves, strict=True):
            self._sort(part, stored, positions)
        self.is_whole = self._with_rows == len(parts)

    def _sort(self, part: RunPart, stored: StoredLeaves, positions: Mapping[bytes, BlockPosition]) -> None:
        """Readable files of a part, and a line for each other one."""
        writers = part.row_writers
        there = [writer for writer in writers if part.is_there(writer, self._band)]
        self._damage += [_of_another_length(part, w, self._band) for w in writers if w not in there]
        self._readable += [(part, w, BlockChecker(part, w, self._band, stored, positions)) for w in there]
        self._with_rows += bool(there)
        if not writers and "mcpl" in part.formats:
            self._packed, self._with_rows = part, self._with_rows + 1
        if not writers and self._band in stored.of_band:
            first, end = part.shard.blocks(part.source.n_photons(self._band))
            blocks = [block for block in range(first, end) if block in self._again]
            self._damage.append(leaves_of_plan(part, self._band, blocks, stored))

    def blocks(self, progress: Callable[[int], None]) -> Iterator[PhotonRows]:
        """Photons of all parts, once each, compared on the way.

        Files that hold them a second time are compared as well; their blocks come back empty.
        """
        if self._packed is not None:
            for rows in _packed_rows(self._packed, self._band):
                progress(len(rows.direction))
                yield rows
        counted: set[int] = set()
        for part, writer, checker in self._readable:
            is_new = part.shard.index not in counted
            counted.add(part.shard.index)
            is_damaged = not self._damaged.isdisjoint(writer.names((self._band,)))
            for start, stop in part.spans(self._band):
                progress((stop - start) * is_new)
                again = is_damaged or start // BLOCK in self._again
                yield _compared(checker, (start, stop), regenerate=again, is_new=is_new)

    def sums(self) -> PhotonSums | None:
        """Sums over the photons of a whole run, after all `blocks` were read; None where they are not known."""
        of_run = [checker for part, _, checker in self._readable if not part.shard.is_named]
        return of_run[0].sums() if of_run else None

    def checks(self) -> list[Check]:
        """What was found, after all `blocks` were read."""
        return [*self._damage, *(check for _, _, checker in self._readable for check in checker.checks())]


def _compared(checker: BlockChecker, span: Span, *, regenerate: bool, is_new: bool) -> PhotonRows:
    """One block of a file, read and compared."""
    rows = checker.compare(span, regenerate=regenerate)
    return PhotonRows(start=span[0], direction=rows[0][: None if is_new else 0, :3])


def _packed_rows(part: RunPart, band: int) -> Iterator[PhotonRows]:
    """Directions of a waveband from the MCPL file of a run, which holds all of them one after the other."""
    writer = part.writer("mcpl")
    file = read_mcpl(part.folder.path / writer.names(part.bands)[0])
    first = sum(part.source.n_photons(b) for b in part.bands[: part.bands.index(band)])
    for block in file.blocks(BLOCK, first, first + part.source.n_photons(band)):
        yield PhotonRows(start=block.start - first, direction=block.direction)


def _of_another_length(part: RunPart, writer: Any, band: int) -> Check:
    """The line of files that are missing, truncated or too long: the blocks that are not there."""
    first, end = part.shard.blocks(part.source.n_photons(band))
    wrong = []
    for layout, width in zip(writer.layouts((band,)), writer.widths, strict=True):
        name, size = layout.name, layout.size
        found = part.folder.size_of(name)
        if found is None:
            wrong.append(f"{name} is missing")
        elif found > size:
            wrong.append(f"{name} has {found - size} bytes after its last block")
        elif found < size:
            row = width * writer.row_dtype.itemsize
            last = first + max(found - len(layout.head), 0) // (row * BLOCK)
            wrong.append(f"{name} ends in block {last}; blocks {last} to {end - 1} are not complete")
    return Check(name="blocks", waveband=band + 1, passed=False, detail="; ".join(wrong))
