"""Blocks of photons against their leaves and against the plan: which block is damaged, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import OutputError
from aomc_sky.outputs.content_tree import BLOCK, leaf_hash, tree_root
from aomc_sky.outputs.stored_photons import StoredPhotons
from aomc_sky.verify.report import Check
from aomc_sky.verify.run_parts import RunPart

MAX_NAMED = 5
"""Damaged blocks of a waveband that are named; of the others the number is told."""

FOREIGN_SHARE = 0.5
"""Part of the photons of a damaged block that are others than the plan's, from which on it is another run's block."""

Place = tuple[int, int]
"""Waveband [0-based] and block of the whole run."""

Span = tuple[int, int]
"""First photon and end."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StoredLeaves:
    """Leaves of a part as its files of leaves hold them.

    Parameters
    ----------
    of_band : dict of int to ndarray
        uint8 (n_block, 32) of every waveband whose file can be read. [0-based]
    checks : list of Check
        Whether the files can be read and agree with the manifest.
    """

    of_band: dict[int, np.ndarray]
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

    def places(self, part: RunPart) -> dict[bytes, Place]:
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
    wanted = {entry["waveband"]: entry["root"] for entry in content["bands"]}
    checks = [
        Check(name="leaves", waveband=band + 1, passed=False, detail="their root is another than the manifest's")
        for band, root in zip(part.bands, roots, strict=True)
        if wanted.get(band + 1) != root.hex()
    ]
    whole = tree_root(roots).hex()
    is_same = not checks and ("root" not in content or content["root"] == whole)
    detail = (
        f"root {whole[:16]}" if is_same else f"root {whole[:16]}, the manifest says {str(content.get('root'))[:16]}"
    )
    return [*checks, Check(name="content tree", passed=is_same, detail=detail)]


class BlockChecker:
    """Compares blocks of one waveband in the files of one writer, and keeps what it finds.

    Parameters
    ----------
    part : RunPart
        A run or a shard.
    writer : object
        Of a format that holds every bit.
    band : int
        The waveband. [0-based]
    leaves : StoredLeaves
        Of the part.
    places : mapping
        Where each leaf of the run belongs, to tell what stands in a wrong place.
    """

    def __init__(
        self, part: RunPart, writer: Any, band: int, leaves: StoredLeaves, places: Mapping[bytes, Place]
    ) -> None:
        self._part, self._writer, self._band = part, writer, band
        self._wanted, self._places = leaves.of_band.get(band), places
        self._first = part.shard.blocks(part.source.n_photons(band))[0]
        self.n_blocks = self.n_regenerated = self.n_looked = 0
        self.damaged: dict[int, str] = {}
        self.foreign: set[int] = set()

    def compare(self, stored: StoredPhotons, span: Span, *, regenerate: bool) -> tuple[np.ndarray, ...]:
        """Read one block, compare it, and return its rows."""
        block = span[0] // BLOCK
        rows = stored.rows(*span)
        leaf = leaf_hash(*rows)
        agrees = self._wanted is None or self._wanted[block - self._first].tobytes() == leaf
        if regenerate or not agrees:
            self.n_looked += 1
            self._look(block, rows, leaf, span, agrees=agrees)
        self.n_blocks += 1
        self.n_regenerated += regenerate
        return rows

    def _look(self, block: int, rows: tuple[np.ndarray, ...], leaf: bytes, span: Span, *, agrees: bool) -> None:
        made = np.hstack([x.reshape(len(x), -1) for x in made_columns(self._part, self._band, span)])
        found = np.hstack([x.astype(made.dtype, copy=False) for x in rows])
        differs = (made.view(f"u{made.itemsize}") != found.view(f"u{made.itemsize}")).any(axis=1)
        n_wrong = int(np.count_nonzero(differs))
        if n_wrong == 0:
            if not agrees:
                self.damaged[block] = "its leaf is damaged, its photons are not"
            return
        other = self._places.get(leaf)
        if other is not None and other != (self._band, block):
            self.damaged[block] = f"holds block {other[1]} of waveband {other[0] + 1}"
            return
        first = span[0] + int(differs.argmax())
        self.damaged[block] = f"{n_wrong} of {len(differs)} photons differ from the plan, photon {first} is the first"
        if n_wrong > FOREIGN_SHARE * len(differs) and _are_directions(found):
            self.foreign.add(block)

    def checks(self) -> Iterator[Check]:
        """What was found."""
        name = self._writer.names((self._band,))[0]
        waveband = self._band + 1
        if not self.damaged:
            made = f", {self.n_regenerated} of them made again from the plan" if self.n_regenerated else ""
            detail = f"{name}: {self.n_blocks} blocks agree{made}"
            yield Check(name="blocks", waveband=waveband, passed=True, detail=detail)
            return
        if len(self.foreign) == self.n_looked:
            every = (
                "every block"
                if self.n_looked == self.n_blocks
                else f"every block that was made again ({self.n_looked})"
            )
            detail = f"{name}: {every} is another run's (another scene, seed or options)"
            yield Check(name="blocks", waveband=waveband, passed=False, detail=detail, is_foreign=True)
            return
        for block, what in sorted(self.damaged.items())[:MAX_NAMED]:
            yield Check(name="blocks", waveband=waveband, passed=False, detail=f"{name}, block {block}: {what}")
        hidden = len(self.damaged) - MAX_NAMED
        if hidden > 0:
            yield Check(name="blocks", waveband=waveband, passed=False, detail=f"{name}: {hidden} more blocks")


def made_columns(part: RunPart, band: int, span: Span) -> list[np.ndarray]:
    """Photons of a waveband made from the plan: directions, and positions and weights where there are any."""
    batch = part.source.photons(band, *span)
    return [x for x in (batch.directions, batch.positions, batch.weight) if x is not None]


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
