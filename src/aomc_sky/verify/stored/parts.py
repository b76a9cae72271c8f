"""The parts of a run folder that can be verified: the whole run, or its shards while they are not merged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from aomc_sky.outputs.blocks.shard import WHOLE, Shard
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.photons.writer import photon_writer
from aomc_sky.source.photon_source import PhotonSource


@dataclass(frozen=True, kw_only=True, slots=True)
class RunPart:
    """A run, or one shard of it."""

    #: Where its files are.
    folder: RunFolder
    #: From the plan of the run.
    source: PhotonSource
    #: Of the part: what files it has.
    manifest: dict[str, Any]
    #: Wavebands that it holds. [0-based]
    bands: tuple[int, ...]
    #: Which of the photons.
    shard: Shard = WHOLE

    @property
    def formats(self) -> list[str]:
        """Photon formats of the part, without "none"."""
        return [name for name in self.manifest["options"]["formats"] if name != "none"]

    @property
    def row_writers(self) -> list[Any]:
        """Writers of the formats that hold every bit of the photons."""
        writers = [self.writer(name) for name in self.formats]
        return [writer for writer in writers if writer.has_rows]

    def writer(self, name: str) -> Any:
        """What wrote the files of a format."""
        kind = photon_writer(name)
        return kind(self.source, self.shard) if self.shard.is_named else kind(self.source)

    @property
    def leaves(self) -> BlockHashWriter:
        """What wrote the files of leaves."""
        return BlockHashWriter(self.source, self.shard)

    def spans(self, band: int) -> list[tuple[int, int]]:
        """First photon and end of every block of a waveband that the part holds."""
        return list(self.shard.block_spans(self.source.n_photons(band)))

    def is_there(self, writer: Any, band: int) -> bool:
        """Whether the files of a waveband have the length that they ought to have."""
        names, sizes = writer.names((band,)), writer.sizes((band,))
        return all(self.folder.size_of(name) == size for name, size in zip(names, sizes, strict=True))


def missing_shards(parts: Sequence[RunPart]) -> list[Shard]:
    """Shards of a run that are not there."""
    count = parts[0].shard.count
    found = {part.shard.index for part in parts}
    return [Shard(index=k, count=count) for k in range(1, count + 1) if k not in found]
