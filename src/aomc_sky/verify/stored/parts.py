"""From a run folder to the parts that are verified: the whole run, or its finished shards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from aomc_sky.errors import AomcSkyError, ForeignOutputError, InputFileError
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import read_manifest, read_shard_manifest, require_wavebands
from aomc_sky.outputs.photons.files import photon_writer
from aomc_sky.outputs.photons.leaves import BlockHashWriter
from aomc_sky.outputs.shard import MANIFEST, PLAN, WHOLE_RUN, Shard, shard_of_manifest
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.plan import Plan


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
    shard: Shard = WHOLE_RUN

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
        return all(self.folder.size_of(layout.name) == layout.size for layout in writer.layouts((band,)))


def missing_shards(parts: Sequence[RunPart]) -> list[Shard]:
    """Shards of a run that are not there."""
    count = parts[0].shard.count
    found = {part.shard.index for part in parts}
    return [Shard(index=k, count=count) for k in range(1, count + 1) if k not in found]


def refuse_another_plan(folder: RunFolder) -> None:
    """Raise where the manifest, or that of a shard, belongs to another plan than the one in the folder."""
    folder.require_regular_files()
    try:
        plan = Plan.load(folder.path / PLAN).sha256
        expected = {MANIFEST: read_manifest(folder.path / MANIFEST)["plan_sha256"]} if _is_there(folder) else {}
    except AomcSkyError:
        return  # the one who opens the run says what is damaged
    for shard, name in _shards(folder):
        expected[name] = _read(folder, shard, name)["plan_sha256"]
    for name, of_manifest in expected.items():
        if of_manifest != plan:
            raise ForeignOutputError(
                f"{folder.path / name} belongs to another run (another scene, seed or options) than {PLAN}: plan "
                f"{str(of_manifest)[:16]}, not {plan[:16]}"
            )


def _is_there(folder: RunFolder) -> bool:
    return folder.size_of(MANIFEST) is not None


def _shards(folder: RunFolder) -> list[tuple[Shard, str]]:
    """Finished shards in the folder, in order; none where the run itself is finished."""
    if _is_there(folder):
        return []
    found = ((shard_of_manifest(name), name) for name in folder.names("manifest."))
    return sorted(((s, name) for s, name in found if s is not None), key=lambda item: (item[0].count, item[0].index))


def _read(folder: RunFolder, shard: Shard, name: str) -> dict[str, object]:
    try:
        return read_shard_manifest(folder.path / name, shard)
    except InputFileError:
        raise
    except AomcSkyError as error:
        raise refuse(folder.path / name, str(error), advice="make the shard again") from error


def open_parts(folder: RunFolder, source: PhotonSource) -> list[RunPart]:
    """The run, or its finished shards; none where nothing is finished. Damaged manifests and shards of different cuts
    raise.
    """
    if _is_there(folder):
        manifest = read_manifest(folder.path / MANIFEST)
        require_wavebands(folder.path / MANIFEST, manifest, source.n_bands)
        return [RunPart(folder=folder, source=source, manifest=manifest, bands=_bands(manifest["bands"]))]
    shards = _shards(folder)
    counts = sorted({shard.count for shard, _ in shards})
    if len(counts) > 1:
        named = " and ".join(str(count) for count in counts)
        raise refuse(folder.path, f"holds shards of runs in {named} parts", advice="keep the shards of one run")
    parts = []
    for shard, name in shards:
        manifest = _read(folder, shard, name)
        require_wavebands(folder.path / name, manifest, source.n_bands)
        bands = _bands(manifest["bands"])  # type: ignore[arg-type]
        parts.append(RunPart(folder=folder, source=source, manifest=manifest, bands=bands, shard=shard))
    return parts


def _bands(entries: Sequence[dict[str, int]]) -> tuple[int, ...]:
    return tuple(int(entry["waveband"]) - 1 for entry in entries)
