"""Makes the counts, photons and manifest of a run again from its plan, or the plan from its scene, and compares."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

import aomc_sky
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import InputFileError, OutputError
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.outputs.counts import COUNTS_FILES, counts_file, in_columns_of, table_version
from aomc_sky.outputs.manifest import differences, manifest_again, part_of_scene, scene_part, stated_of
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, SOURCE, SOURCE_FILE, formats_of
from aomc_sky.outputs.photons.files import (
    BLOCK,
    ChunkPool,
    FileLayout,
    Meter,
    PhotonFiles,
    PhotonRows,
    Progress,
    RunFiles,
    Target,
    block_spans,
)
from aomc_sky.outputs.run_folder import MANIFEST, PLAN, RunFolder, os_error
from aomc_sky.outputs.statistics import PhotonSums
from aomc_sky.plan.allocation import AllocationMethod, cumulative_counts
from aomc_sky.plan.plan import Plan, differing, read_stated
from aomc_sky.source.scene import Scene
from aomc_sky.system import read_at
from aomc_sky.verify.counts import FAMILY_LEVEL
from aomc_sky.verify.directions import verify_directions
from aomc_sky.verify.report import Check, VerifyReport, judged, named


def verify_run(
    path: Path,
    source: PhotonSource,
    manifest: dict[str, Any],
    bands: Sequence[int],
    *,
    resample: float = 1.0,
    seed: int = 0,
    threads: int = 0,
    progress: Progress | None = None,
) -> VerifyReport:
    """Make the counts, the photons and the manifest of a run again and compare them with its files.

    Photons are made for `bands` [0-based] that are in a file. The part of their blocks that is made is `resample`,
    0 to 1. These blocks are drawn by `seed`, at least one of each waveband unless `resample` is 0. The function
    `progress` is called with photons done and photons in all.
    """
    files = RunFiles(source, RunFolder(path))
    folder, stored = files.folder, files.stored_formats()
    formats = [name for name in PHOTON_FORMATS if name in manifest["options"]["formats"]]
    listed = [*formats, *(name for name in manifest["options"]["formats"] if name == SOURCE)]
    sums: dict[int, PhotonSums] = {}
    compared = [
        _ComparedFiles(folder, part, is_listed=name in formats)
        for name in PHOTON_FORMATS
        if name in {*formats, *stored}
        for part in files.of(name)
        if not {*part.bands}.isdisjoint(bands)
    ]
    with ExitStack() as stack, ChunkPool(source, threads) as pool:
        shared = [stack.enter_context(one.opened()) for one in compared if len(one.part.bands) > 1]
        spans = {band: _chosen_blocks(source, band, resample, seed) for band in bands if compared}
        meter = Meter(progress, sum(stop - start for band_spans in spans.values() for start, stop in band_spans))
        announce_photons(meter.total)
        for band, band_spans in spans.items():
            with ExitStack() as opened:
                own = [opened.enter_context(one.opened()) for one in compared if one.part.bands == (band,)]
                sums[band] = pool.emit(band, [*own, *shared], meter.add, band_spans)
    checks = [
        _counts_file_check(folder, source),
        *_source_file_checks(folder, source, is_listed=SOURCE in manifest["options"]["formats"]),
        *_counts_checks(source, bands),
        *(check for one in compared for check in one.checks),
        *_stray_checks(files, {*formats, *stored}),
        _manifest_check(files, manifest, sums if resample == 1 else {}, listed),
    ]
    notes = [f"blocks to make again were drawn with --seed {seed}"] if compared and 0 < resample < 1 else []
    return judged(checks, family_level=FAMILY_LEVEL, notes=notes)


def _chosen_blocks(source: PhotonSource, band: int, resample: float, seed: int) -> list[tuple[int, int]]:
    """Blocks of a waveband to make again, in order; some are drawn at random unless all are asked for."""
    spans = list(block_spans(0, source.n_photons(band)))
    if resample == 1:
        return spans
    n = min(len(spans), math.ceil(resample * len(spans)))
    chosen = np.random.default_rng((seed, band)).choice(len(spans), n, replace=False)
    return [spans[k] for k in sorted(chosen.tolist())]


class _ComparedFiles:
    """Photon files that belong together, compared with the bytes that the plan makes of their photons."""

    def __init__(self, folder: RunFolder, part: PhotonFiles, *, is_listed: bool) -> None:
        self.part, self._folder, self._is_listed = part, folder, is_listed
        self.checks: list[Check] = []  #: what was found of each file, after its block
        n = len(part.layouts)
        self._files: list[BinaryIO | None] = [None] * n
        self._n_wrong, self._first_wrong, self._n_compared = [0] * n, [""] * n, 0
        self._room = bytearray()

    @contextmanager
    def opened(self) -> Iterator[Target]:
        """The target to which `ChunkPool.emit` gives its blocks."""
        with ExitStack() as stack:
            for k, layout in enumerate(self.part.layouts):
                if self._folder.size_of(layout.name) is not None:
                    self._files[k] = stack.enter_context(self._folder.reading(layout.name))
            yield self.part.writer, self._compare
            self.checks = list(self._checks())

    def _compare(self, band: int, start: int, chunks: tuple[memoryview, ...]) -> None:
        for k, (layout, file, chunk) in enumerate(zip(self.part.layouts, self._files, chunks, strict=True)):
            if file is None:
                continue
            if len(self._room) != len(chunk):  # memory that is used again: fresh one costs as much as reading
                self._room = _aligned(len(chunk))
            found = self._room
            n_read = self._read(file, layout, found, self.part.offset(layout, band, start))
            if found == chunk and n_read == len(chunk):
                continue
            rows = (np.frombuffer(data, np.uint8).reshape(-1, layout.row_bytes) for data in (found, chunk))
            is_wrong = np.any(np.not_equal(*rows), axis=1)
            is_wrong[n_read // layout.row_bytes :] = True
            if not self._n_wrong[k]:
                band_spans = f" of waveband {band + 1}" if len(self.part.bands) > 1 else ""
                self._first_wrong[k] = f"photon {start + int(np.argmax(is_wrong))}{band_spans}"
            self._n_wrong[k] += int(np.count_nonzero(is_wrong))
        self._n_compared += len(chunks[0]) // self.part.layouts[0].row_bytes

    def _read(self, file: BinaryIO, layout: FileLayout, room: bytearray, offset: int) -> int:
        try:
            return read_at(file.fileno(), room, offset)
        except OSError as error:
            raise os_error("read", self._folder.path / layout.name, error) from error

    def _checks(self) -> Iterator[Check]:
        waveband = self.part.bands[0] + 1 if len(self.part.bands) == 1 else None
        for k, (layout, file) in enumerate(zip(self.part.layouts, self._files, strict=True)):
            if file is None and not self._is_listed:
                continue
            faults = [] if file is None else list(self._faults(layout, file))
            if self._n_wrong[k]:
                faults.append(
                    f"{self._n_wrong[k]} of {self._n_compared} photons differ from the plan, the first is "
                    f"{self._first_wrong[k]}"
                )
            detail = "missing" if file is None else "; ".join(faults)
            has_size = self._folder.size_of(layout.name) == layout.size
            yield Check(
                name="photons",
                waveband=waveband,
                passed=not detail,
                detail=f"{layout.name}: {detail or f'{self._n_compared} photons made again, no bit differs'}",
                is_foreign=has_size and 2 * self._n_wrong[k] > self._n_compared,  # those of another run
            )

    def _faults(self, layout: FileLayout, file: BinaryIO) -> Iterator[str]:
        """Faults of the length and the head of a file."""
        size = self._folder.size_of(layout.name)
        if size != layout.size:
            yield f"{size} bytes in place of {layout.size}"
        head = bytearray(len(layout.head))
        if self._read(file, layout, head, 0) < len(head) or head != layout.head:
            yield f"the first {len(head)} bytes are not those of this run"


def _aligned(n_bytes: int) -> bytearray:
    """Memory that begins at a multiple of 32 bytes: some processors read files five times as slowly into other."""
    room = bytearray(n_bytes + 31)
    del room[: -np.frombuffer(room, np.uint8).ctypes.data % 32]
    del room[n_bytes:]
    return room


def _counts_file_check(folder: RunFolder, source: PhotonSource) -> Check:
    """Make the file of counts again, compare it byte for byte and name the first line that differs."""
    name, expected = counts_file(source)
    try:
        with folder.reading(name) as file:
            found = file.read(len(expected) + 1)
    except OutputError:
        return Check(name="counts file", passed=False, detail=f"{name} is missing")
    made, expected = expected, in_columns_of(found, expected)
    if found == expected:
        older = "" if expected is made else f", an older table (version {table_version(found)}),"
        return Check(name="counts file", passed=True, detail=f"{name}{older} agrees with the plan, byte for byte")
    if name != COUNTS_FILES[0]:
        return Check(name="counts file", passed=False, detail=f"{name} differs from the plan")
    lines = zip([*found.split(b"\n"), b""], [*expected.split(b"\n"), b""], strict=False)
    line = next((k for k, (one, other) in enumerate(lines, 1) if one != other), 0)
    return Check(name="counts file", passed=False, detail=f"{name} differs from the plan, from line {line} on")


def _stray_checks(files: RunFiles, formats: Iterable[str]) -> Iterator[Check]:
    """A photon file that the plan does not make is left from another run."""
    own = {layout.name for name in formats for part in files.of(name) for layout in part.layouts}
    for name in sorted(formats_of({*files.folder.photon_names()} - own)):
        yield Check(name="photons", passed=False, is_foreign=True, detail=f"{name}: this run makes no such file")


def _source_file_checks(folder: RunFolder, source: PhotonSource, *, is_listed: bool) -> Iterator[Check]:
    """Make the source file again and compare it byte for byte."""
    size = folder.size_of(SOURCE_FILE)
    if size is None and not is_listed:
        return
    detail = f"{SOURCE_FILE} is missing"
    if size is not None:
        expected = source.to_bytes()
        with folder.reading(SOURCE_FILE) as file:
            is_same = file.read(len(expected) + 1) == expected
        detail = f"{SOURCE_FILE} {'agrees with the plan, byte for byte' if is_same else 'differs from the plan'}"
    yield Check(name="source file", passed=size is not None and is_same, detail=detail)


def _manifest_check(
    files: RunFiles, found: dict[str, Any], sums: Mapping[int, PhotonSums], formats: Sequence[str]
) -> Check:
    """Build the manifest again from the plan and compare it; the part of the scene with what plan.npz states.

    Means over photons that were not all made again are taken from the manifest.
    """
    wrong = list(differences(found, manifest_again(files.source, found, sums, formats, files.stored()[1])))
    same, made = f"{MANIFEST} agrees with the plan and the files", stated_of(part_of_scene(found), found["version"])
    try:
        stated = read_stated(files.folder.path / PLAN)
    except InputFileError as error:
        wrong.append(f"{PLAN} {error.problems[0].message}")
    else:
        if stated is None:
            same += f"; not checked, for this {PLAN} does not state them: inputs, options.scene, notes and version"
        else:
            names = [name for name in {**stated, **made} if stated.get(name) != made.get(name)]
            wrong += [f"{name} is not what {PLAN} states" for name in names]
    return Check(name="manifest", passed=not wrong, detail=named(wrong) if wrong else same)


def _counts_checks(source: PhotonSource, bands: Sequence[int]) -> Iterator[Check]:
    """Share the photons out again and compare the counts; those of allocation aomc need the table of the scene."""
    plan = source.plan
    if plan.options["allocation"] == AllocationMethod.AOMC.value:
        return
    found, made = plan.cumulative, cumulative_counts(plan.bands, plan.components, plan.options, plan.bias)
    for band in bands:
        rows = slice(band, None, source.n_bands)  # of all replicates
        differs = np.flatnonzero(np.any(np.diff(found[rows], axis=1) != np.diff(made[rows], axis=1), axis=0))
        detail = f"{differs.size} cells differ, the first is cell {differs[0]}" if differs.size else "shared out again"
        yield Check(name="counts", waveband=band + 1, passed=not differs.size, detail=detail)


def scene_checks(plan: Plan, manifest: Mapping[str, Any], scene: Scene) -> list[Check]:
    """Make the plan of a run, and the part of its manifest on the scene, again from the scene, and compare."""
    names = ("method", "allocation", "placement", "order", "precision", "weights", "replicates")
    how = {name: plan.options[name] for name in names} | {"bias": plan.options.get("bias") or {}}
    if plan.options.get("importance"):
        detail = "not made again: the importance of its patches was given in Python"
        return [Check(name="scene: plan", passed=False, detail=detail)]
    made = scene.source(plan.seed, **how).plan
    wrong = []
    if plan.sha256 != made.sha256:
        wrong = _of_another_scene(plan, made) or [
            *differences(plan.options, made.options, source="the scene gives"),
            *_array_differences(plan.members(), made.members()),
        ]
    same = f"made again from the scene with seed {plan.seed}: {plan.sha256[:16]}"
    checks = [Check(name="scene: plan", passed=not wrong, is_foreign=bool(wrong), detail=named(wrong) or same)]
    found, part = part_of_scene(manifest), scene_part(scene)
    same = "names and hashes of its files, how they were read, and notes agree with the manifest"
    if manifest["version"] != aomc_sky.__version__:  # which may say the same in other words
        part["notes"] = found["notes"]
        same = "names and hashes of its files, and how they were read, agree with the manifest; notes are not compared"
    wrong = _other_files(found.pop("inputs"), part.pop("inputs"))
    wrong += differences(found, json.loads(json.dumps(part)), source="the scene gives")
    return [*checks, Check(name="scene: manifest", passed=not wrong, detail=named(wrong) or same)]


def _of_another_scene(plan: Plan, made: Plan) -> list[str]:
    """What shows at once that a run is of another scene; empty for one that has changed."""

    def facts(of: Plan) -> dict[str, str]:
        nm = of.wavelength_nm.tolist()
        return {
            "wavebands": f"{len(nm)} ({nm[0]:g} to {nm[-1]:g} nm)" if len(nm) > 1 else f"1 ({nm[0]:g} nm)",
            "components": ", ".join(of.component_names),
            "patches": str(of.n_cells),
        }

    one, other = facts(plan), facts(made)
    wrong = [f"{name} {one[name]}, the scene gives {other[name]}" for name in one if one[name] != other[name]]
    return [f"another scene: {'; '.join(wrong)}"] if wrong else []


def _other_files(found: Mapping[str, Any], expected: Mapping[str, Any]) -> list[str]:
    """Files of the scene that are not those of the run."""
    said = {
        "other contents of": [role for role in found if role in expected and found[role] != expected[role]],
        "the scene has no": [role for role in found if role not in expected],
        "the run had no": [role for role in expected if role not in found],
    }
    return [f"{what} {', '.join(roles)}" for what, roles in said.items() if roles]


def _array_differences(found: Mapping[str, np.ndarray], expected: Mapping[str, np.ndarray]) -> Iterator[str]:
    for name in sorted({*found, *expected}):
        one, other = found.get(name), expected.get(name)
        if one is None or other is None or one.shape != other.shape:
            shapes = ["none" if array is None else str(array.shape) for array in (one, other)]
            yield f"{name} has shape {shapes[0]}, the scene gives {shapes[1]}"
            continue
        differs = differing(one, other)
        if differs.any():
            at = np.unravel_index(int(np.argmax(differs)), differs.shape)
            hint = " (for a run made with --iterations, give it here too)" if name == "requested" else ""
            yield (
                f"{name}[{', '.join(map(str, at))}] is {one[at]}, the scene gives {other[at]}, "
                f"{int(differs.sum())} of {differs.size} differ{hint}"
            )


def statistics_of_run(
    path: Path,
    source: PhotonSource,
    bands: Sequence[int],
    *,
    family_level: float = FAMILY_LEVEL,
    seed: int = 0,
    threads: int = 0,
) -> VerifyReport:
    """Test the directions of a run with stored photons; they are made from the plan, as `verify_run` compares files."""
    if not RunFiles(source, RunFolder(path), bands).stored_formats():
        notes = ["directions were not tested: the run stores no photons"]
        return judged([], family_level=family_level, notes=notes)
    announce_photons(sum(source.n_photons(band) for band in bands))
    photons = {band: _made(source, band) for band in bands}
    return verify_directions(source, photons, family_level=family_level, seed=seed, threads=threads)


def _made(source: PhotonSource, band: int) -> Iterator[PhotonRows]:
    for batch in source.batches(band, BLOCK):
        yield PhotonRows(start=batch.start, direction=batch.directions)
