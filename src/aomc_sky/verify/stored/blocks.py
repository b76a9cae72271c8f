"""Blocks of photons against their leaves and against the plan: which block is damaged, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.outputs.blocks.content_tree import BLOCK, leaf_hash, tree_root
from aomc_sky.outputs.blocks.statistics import BlockSums, PhotonSums
from aomc_sky.outputs.photons.leaves import StoredPhotons
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
    roots = [tree_root(leaf.tobytes() for leaf in of_band[band]) for band in part.bands]
    expected = {entry["waveband"]: entry["root"] for entry in content["bands"]}
    checks = [
        Check(name="leaves", waveband=band + 1, passed=False, detail="their root is another than the manifest's")
        for band, root in zip(part.bands, roots, strict=True)
        if expected.get(band + 1) != root.hex()
    ]
    whole = tree_root(roots).hex()
    is_same = not checks and ("root" not in content or content["root"] == whole)
    detail = (
        f"root {whole[:16]}" if is_same else f"root {whole[:16]}, the manifest says {str(content.get('root'))[:16]}"
    )
    return [*checks, Check(name="content tree", passed=is_same, detail=detail)]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Look:
    """What a comparison of one block found."""

    #: Of the whole run.
    block: int
    #: Over its photons.
    sums: list[BlockSums]
    #: is_regenerated, is_looked_into: Whether it was chosen to be made again; whether it was, for that or because its
    #: leaf is another.
    is_regenerated: bool
    is_looked_into: bool
    #: What is wrong with it, nothing if it is whole.
    damage: str = ""
    #: Whether its photons are another run's.
    is_foreign: bool = False


class BlockChecker:
    """Compares blocks of one waveband in the files of one writer, on any threads, and keeps what it finds.

    The writer is of a format that holds every bit; `positions` says where each leaf of the run belongs, to name what
    stands in a wrong place.
    """

    def __init__(
        self, part: RunPart, writer: Any, band: int, leaves: StoredLeaves, positions: Mapping[bytes, BlockPosition]
    ) -> None:
        self._part, self._writer, self._band = part, writer, band
        self._expected, self._positions = leaves.of_band.get(band), positions
        self._first = part.shard.blocks(part.source.n_photons(band))[0]
        self._looks: list[_Look] = []  # threads append, which needs no lock

    def compare(self, span: Span, *, regenerate: bool) -> tuple[np.ndarray, ...]:
        """Read one block, compare it, and return its rows."""
        part, block = self._part, span[0] // BLOCK
        quiet = np.errstate(divide="ignore", over="ignore", invalid="ignore")  # sums of damaged photons
        with quiet, StoredPhotons(part.folder, part.source, self._writer, self._band) as stored:
            read = stored.block(span)
        rows, leaf = read.rows, read.leaf
        agrees = self._expected is None or self._expected[block - self._first].tobytes() == leaf
        damage, is_foreign, looks_into = "", False, regenerate or not agrees
        if looks_into:
            damage, is_foreign = self._damage(rows, leaf, span, agrees=agrees)
        look = _Look(
            block=block,
            sums=read.sums,
            is_regenerated=regenerate,
            is_looked_into=looks_into,
            damage=damage,
            is_foreign=is_foreign,
        )
        self._looks.append(look)
        return rows

    def sums(self) -> PhotonSums | None:
        """Sums over all photons that were read; None if a block is damaged."""
        if any(look.damage for look in self._looks):
            return None
        total = PhotonSums(self._part.source.replicates)
        for look in self._looks:
            total.add(look.sums)
        return total

    def _damage(self, rows: tuple[np.ndarray, ...], leaf: bytes, span: Span, *, agrees: bool) -> tuple[str, bool]:
        """What is wrong with a block, nothing if it is whole, and whether it is another run's."""
        made = _joined(made_columns(self._part, self._band, span))
        found = _joined(rows).astype(made.dtype, copy=False)
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
        looks = sorted(self._looks, key=lambda look: look.block)
        damaged = [look for look in looks if look.damage]
        if not damaged:
            n_made = sum(look.is_regenerated for look in looks)
            made = f", {n_made} of them made again from the plan" if n_made else ""
            detail = f"{name}: {len(looks)} blocks agree{made}"
            yield Check(name="blocks", waveband=waveband, passed=True, detail=detail)
            return
        n_looked = sum(look.is_looked_into for look in looks)
        if sum(look.is_foreign for look in damaged) == n_looked:
            every = "every block" if n_looked == len(looks) else f"every block that was made again ({n_looked})"
            detail = f"{name}: {every} is another run's (another scene, seed or options)"
            yield Check(name="blocks", waveband=waveband, passed=False, detail=detail, is_foreign=True)
            return
        for look in damaged[:MAX_NAMED]:
            detail = f"{name}, block {look.block}: {look.damage}"
            yield Check(name="blocks", waveband=waveband, passed=False, detail=detail)
        hidden = len(damaged) - MAX_NAMED
        if hidden > 0:
            yield Check(name="blocks", waveband=waveband, passed=False, detail=f"{name}: {hidden} more blocks")


def made_columns(part: RunPart, band: int, span: Span) -> list[np.ndarray]:
    """Photons of a waveband made from the plan: directions, and positions and weights where there are any."""
    batch = part.source.photons(band, *span)
    return [x for x in (batch.directions, batch.positions, batch.weight) if x is not None]


def _joined(columns: Sequence[np.ndarray]) -> np.ndarray:
    """All numbers of a photon in one row."""
    first = columns[0]
    return first if len(columns) == 1 and first.ndim == 2 else np.hstack([x.reshape(len(x), -1) for x in columns])


def leaves_of_plan(part: RunPart, band: int, blocks: Sequence[int], leaves: StoredLeaves) -> Check:
    """Compare leaves with blocks made from the plan, for a run whose photons stand in no file that holds every bit."""
    n = part.source.n_photons(band)
    stored = leaves.of_band[band]
    wrong = []
    for block in blocks:
        columns = made_columns(part, band, (block * BLOCK, min((block + 1) * BLOCK, n)))
        if leaf_hash(*columns) != stored[block - part.shard.blocks(n)[0]].tobytes():
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
