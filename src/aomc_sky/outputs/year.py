"""The folder of a year of skies: counts and index grow in step, one block of hours after the other; its manifest."""

from __future__ import annotations

import contextlib
import csv
import errno
import io
import os
import platform
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

import aomc_sky
from aomc_sky.errors import AomcSkyError, OutputError
from aomc_sky.formats.report import quoted
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.folder.run_folder import RunFolder, os_error
from aomc_sky.outputs.manifest import CONVENTIONS, load_manifest
from aomc_sky.outputs.shard import MANIFEST, PART, PLAN, YEAR_FILES
from aomc_sky.regular_file import read_regular, require_one_name
from aomc_sky.sampling.streams import STREAM_VERSION
from aomc_sky.source.year import SCHEMA, HourState, YearPlan, state_text
from aomc_sky.system import EXCLUSIVE, NON_BLOCKING, flock, open_handle, sync_file, sync_folder

BLOCK_HOURS = 100
"""Hours with a sky between two moments at which the files are forced to the disk."""

COUNTS = "counts.npy"
INDEX = "index.csv"


class YearFolder(RunFolder):
    """A folder that holds one year of skies.

    While a year is being made, its counts and its index are in files that end in ``.part``. A block of
    hours goes to the index and then to the counts, each forced to the disk, so that whoever finds n rows of
    counts may trust all blocks before the one that the n-th row is in, whatever ended the writer.
    """

    _what, _another = "a year", "another year of skies (another weather file, seed or options)"
    _load = YearPlan.load

    def _taken(self) -> str | None:
        """A file that a year would replace."""
        return next((name for name in YEAR_FILES if self.size_of(name) is not None), None)

    def require_space_for(self, plan: YearPlan) -> None:
        """Raise before anything is written when the disk cannot hold the counts that are still to come."""
        n_bytes = len(counts_header(plan)) + plan.sky_rows.size * plan.n_cells * counts_dtype(plan).itemsize
        self.require_space(n_bytes - (self.size_of(COUNTS + PART) or 0), "use --bins with fewer patches")

    @property
    def has_files(self) -> bool:
        """Whether counts and index are finished."""
        return self.size_of(COUNTS) is not None and self.size_of(INDEX) is not None

    @contextlib.contextmanager
    def writer(self, plan: YearPlan, index_head: str) -> Iterator[YearWriter]:
        """Open the unfinished files for the next block; a block that was cut short is forgotten.

        The files get their final names when the block of the ``with`` statement ends without an error.
        """
        parts = [self.path / (name + PART) for name in (INDEX, COUNTS)]
        try:
            for name, part in zip((INDEX, COUNTS), parts, strict=True):
                if self.size_of(name) is not None:  # killed between two renames
                    os.replace(self.path / name, part)
            with _opened(parts[0]) as index, _opened(parts[1]) as counts:
                yield YearWriter(plan, index, counts, index_head)
            for name, part in zip((INDEX, COUNTS), parts, strict=True):
                os.replace(part, self.path / name)
            sync_folder(self.path)
        except OSError as error:
            raise os_error("write to", self.path, error) from error


class YearWriter:
    """Appends blocks of hours to the index and the counts, after the blocks that an earlier run completed."""

    def __init__(self, plan: YearPlan, index: BinaryIO, counts: BinaryIO, index_head: str) -> None:
        self._index, self._counts = index, counts
        self._header = counts_header(plan)
        row_bytes = counts_dtype(plan).itemsize * plan.n_cells
        n_stored = max(os.fstat(counts.fileno()).st_size - len(self._header), 0) // row_bytes
        # the last block may have reached the file and not yet the disk when the machine stopped
        blocks, ends = max(n_stored - 1, 0) // BLOCK_HOURS, block_ends(plan)
        lines = index.read().split(b"\n")
        head_fits = lines[0] == index_head.encode() and _starts_with(counts, self._header)
        while blocks and not (head_fits and len(lines) > ends[blocks - 1] + 1):
            blocks -= 1
        self.blocks_done, self.hours_done = blocks, blocks * BLOCK_HOURS
        if blocks:
            kept = b"\n".join(lines[: ends[blocks - 1] + 1]) + b"\n"
            _cut(index, len(kept))
            _cut(counts, len(self._header) + self.hours_done * row_bytes)
            return
        for file, head in ((index, index_head.encode() + b"\n"), (counts, self._header)):
            _cut(file, 0)
            file.write(head)

    def append(self, index_lines: list[str], counts: np.ndarray) -> None:
        """Write one block and force it to the disk."""
        text = "".join(f"{line}\n" for line in index_lines).encode()
        for file, data in ((self._index, text), (self._counts, counts.tobytes())):
            file.write(data)
            file.flush()
            sync_file(file.fileno())


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """A file for reading and appending, created where absent, which nobody else writes."""
    handle = open_handle(path, os.O_RDWR | os.O_CREAT, follow_links=False)
    with os.fdopen(handle, "r+b") as file:
        require_one_name(handle)
        try:
            flock(file, EXCLUSIVE | NON_BLOCKING)
        except OSError as error:
            if error.errno in (errno.EAGAIN, errno.EACCES):
                raise OutputError(f"{path.parent}: another process is writing this year of skies") from error
            # not every network file system knows locks
        yield file


def _cut(file: BinaryIO, size: int) -> None:
    file.truncate(size)
    file.seek(size)


def _starts_with(file: BinaryIO, head: bytes) -> bool:
    file.seek(0)
    return file.read(len(head)) == head


def block_ends(plan: YearPlan) -> list[int]:
    """Row after the last one of each block; hours without a sky belong to the block before them."""
    starts = plan.sky_rows[BLOCK_HOURS::BLOCK_HOURS].tolist()
    return [*starts, plan.n_rows]


def counts_dtype(plan: YearPlan) -> np.dtype:
    """The smallest of int32 and int64 that holds every count."""
    return np.dtype("<i4" if plan.iterations < 2**31 else "<i8")


def counts_header(plan: YearPlan) -> bytes:
    """Head of counts.npy, whose size is known before its first row."""
    buffer = io.BytesIO()
    shape = (int(plan.sky_rows.size), plan.n_cells)
    head = {"descr": counts_dtype(plan).str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, head)
    return buffer.getvalue()


def read_counts(folder: RunFolder, plan: YearPlan) -> np.ndarray:
    """Counts of all hours with a sky, (n_sky_row, n_cell), mapped from the disk.

    AomcSkyError where the file is missing, or not the one that the plan describes.
    """
    path = folder.path / COUNTS
    try:
        with folder.reading(COUNTS) as file:
            np.lib.format.read_magic(file)
            head = np.lib.format.read_array_header_1_0(file)
            if head != ((plan.sky_rows.size, plan.n_cells), False, counts_dtype(plan)):
                raise AomcSkyError(f"{path} does not belong to the plan beside it")
            if not plan.sky_rows.size:  # nothing to map in a year of nights
                return np.zeros(head[0], dtype=head[2])
            return np.memmap(file, dtype=head[2], mode="r", offset=file.tell(), shape=head[0])
    except (OSError, ValueError, OutputError) as error:
        raise AomcSkyError(
            f"{path} cannot be read; if the year was cut short, run its command again ({error})"
        ) from error


INDEX_COLUMNS = (
    "row,line,start_utc,state,sun_zenith_deg,sun_azimuth_deg,extraterrestrial_normal,dni,dhi,"
    "epsilon,delta,counts_row,photons,note"
)
NO_LIGHT = "no-light"
MAX_INDEX_BYTES = 1 << 28
_STATES = {NO_LIGHT, *map(state_text, HourState)}
_WHOLE_NUMBER = re.compile("[0-9]{1,18}")


def index_line(plan: YearPlan, row: int, *, sky: tuple[float, float, int, int] | None = None, note: str = "") -> str:
    """One line of index.csv."""
    arrays = plan.arrays
    start = np.datetime_as_string(arrays["start_s"][row].astype("M8[s]"), timezone="UTC")
    state = state_text(HourState(int(arrays["state"][row])))
    if note.startswith(NO_LIGHT):
        state, note = NO_LIGHT, note.partition(": ")[2]
    names = ("sun_zenith_deg", "sun_azimuth_deg", "extraterrestrial_normal", "dni", "dhi")
    fields = [row + 1, int(arrays["line"][row]), start, state, *(repr(float(arrays[name][row])) for name in names)]
    if sky is None:
        fields += ["", "", "", 0]
    else:
        epsilon, delta, counts_row, photons = sky
        fields += [repr(epsilon), repr(delta), counts_row, photons]
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="").writerow([*fields, " ".join(note.split())])
    return buffer.getvalue()


def read_index(folder: str | Path) -> list[dict[str, str]]:
    """Read index.csv of a year: one entry per row of the weather file, texts by column name.

    AomcSkyError where the folder holds no finished year, or its index is not one that we write (E963).
    """
    path = Path(folder) / INDEX
    try:
        text = read_regular(path, MAX_INDEX_BYTES, follow_links=False).decode("utf-8")
        rows = list(csv.DictReader(io.StringIO(text, newline="")))
    except (OSError, ValueError, csv.Error) as error:
        raise AomcSkyError(
            f"{path} cannot be read; if the year was cut short, run its command again ({error})"
        ) from error
    if not rows or ",".join(map(str, rows[0])) != INDEX_COLUMNS:
        raise AomcSkyError(f"{path} is not the index of a year of skies")
    for line, row in enumerate(rows, 2):
        _check_row(path, line, row)
    return rows


def _check_row(path: Path, line: int, row: dict[str, str]) -> None:
    """Raise for a row that no year of ours has: other columns, another state, no number where one is wanted."""
    numbers = ("row", "line", "photons", *(("counts_row",) if row.get("counts_row") else ()))
    if len(row) != INDEX_COLUMNS.count(",") + 1 or None in row.values():
        fault = "not as many columns as the first line"
    elif row["state"] not in _STATES:
        fault = f"state {quoted(row['state'])}"
    elif wrong := [name for name in numbers if not _WHOLE_NUMBER.fullmatch(row[name])]:
        fault = f"{wrong[0]} {quoted(row[wrong[0]])}"
    else:
        return
    advice = "remove manifest.json, index.csv and counts.npy; the command of the year makes them again"
    raise refuse(path, f"not an index of aomc-sky: {fault}", code="E963", line=line, column=1, advice=advice)


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
        "files": {name: folder.entry_of(name) for name in sorted(names)},
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
