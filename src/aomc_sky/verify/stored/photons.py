"""The photons of one waveband of a run as its files hold them: every block compared while it is read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from aomc_sky.formats.mcpl.file import read_mcpl
from aomc_sky.outputs.blocks.content_tree import BLOCK
from aomc_sky.outputs.blocks.statistics import PhotonSums
from aomc_sky.verify.report import Check
from aomc_sky.verify.sky.direction_counts import PhotonBlock, PhotonRows
from aomc_sky.verify.stored.blocks import BlockChecker, BlockPosition, Span, StoredLeaves, leaves_of_plan
from aomc_sky.verify.stored.parts import RunPart
from aomc_sky.verify.thinning import chosen_blocks


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

    def blocks(self, progress: Callable[[int], None]) -> Iterator[PhotonBlock]:
        """Photons of all parts, once each, to be read on threads, which compares them.

        Files that hold them a second time are compared as well; their blocks come back empty.
        """
        if self._packed is not None:
            for rows in _packed_rows(self._packed, self._band):
                progress(len(rows.direction))
                yield rows
        given: set[int] = set()
        for part, writer, checker in self._readable:
            is_new = part.shard.index not in given
            given.add(part.shard.index)
            is_damaged = not self._damaged.isdisjoint(writer.names((self._band,)))
            for start, stop in part.spans(self._band):
                progress((stop - start) * is_new)
                again = is_damaged or start // BLOCK in self._again
                yield partial(_compared, checker, (start, stop), regenerate=again, is_new=is_new)

    def sums(self) -> PhotonSums | None:
        """Sums over the photons of a whole run, after all `blocks` were read; None where they are not known."""
        whole = [checker for part, _, checker in self._readable if not part.shard.is_named]
        return whole[0].sums() if whole else None

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
    heads = writer.headers((band,))
    for k, (name, size) in enumerate(zip(writer.names((band,)), writer.sizes((band,)), strict=True)):
        found = part.folder.size_of(name)
        if found is None:
            wrong.append(f"{name} is missing")
        elif found > size:
            wrong.append(f"{name} has {found - size} bytes after its last block")
        elif found < size:
            row = writer.widths[k] * writer.row_dtype.itemsize
            whole = first + max(found - len(heads[k]), 0) // (row * BLOCK)
            wrong.append(f"{name} ends in block {whole}; blocks {whole} to {end - 1} are not whole")
    return Check(name="blocks", waveband=band + 1, passed=False, detail="; ".join(wrong))
