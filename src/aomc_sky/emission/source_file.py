"""A source as one block of bytes, which ``include/aomc_sky.h`` reads: the plan packed for codes without Python.

The layout is on the page docs/formats/source.md. All numbers are little-endian. A head names the plan. The record of a
band has its constants and leads to a directory of sections, the tables of the emission kernels. Equal tables are stored
once, so wavebands of one sky share them. `Tables.of` alone knows how the emission holds its tables.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from aomc_sky.emission.emitter import Emitter
from aomc_sky.emission.source_witnesses import witnesses
from aomc_sky.errors import UsageError
from aomc_sky.kernels.arithmetic.constants import NUMBER_STEPS
from aomc_sky.plan.plan import Plan
from aomc_sky.plan.sampling.streams import STREAM_VERSION

MAGIC = b"AOMC-SKY"
LAYOUT = 1
"""Changes whenever an older header can no longer read the file."""

_ALIGNMENT = 64
_HEAD_BYTES = 192
_RECORD_WORDS = 40
_CHECKSUM_WORD = 5
_NEEDED = 1
_OPTIONAL = ("stokes",)
"""Sections that change no direction: a header that does not know them skips them."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tables:
    """Everything that the photons of a band follow from; None where a table is not needed."""

    n: int
    n_cell: int
    is_shuffled: bool
    by_philox: bool
    order_keys: np.ndarray
    shifts: np.ndarray
    steps: np.ndarray
    placement_key: np.uint64
    position_key: np.uint64
    band: np.uint64
    guide_shift: np.uint64
    accept: np.ndarray
    number_shifts: np.ndarray
    number_steps: np.ndarray
    way: np.uint64
    #: The sections follow; those of cells have an entry for each cell of the plan.
    cumulative: np.ndarray
    guide: np.ndarray
    cell_of_slot: np.ndarray | None
    place: np.ndarray
    words: np.ndarray
    law: np.ndarray | None
    slopes: np.ndarray | None
    perez_word: np.ndarray | None
    perez_bound: np.ndarray | None
    perez_sky: np.ndarray | None
    lobe: np.ndarray | None
    ranges: np.ndarray | None
    bins: np.ndarray | None
    shapes: np.ndarray | None
    envelopes: np.ndarray | None
    falls: np.ndarray | None
    paces: np.ndarray | None
    lobe_ends: np.ndarray

    @classmethod
    def of(cls, emitter: Emitter, band: int) -> Tables:
        """The tables of a band with photons, as the emission has them."""
        stream, packed = emitter._stream(band), emitter._packed(band)
        rejection, queue = emitter._rejection, emitter._queue
        n, n_cell = emitter.n_photons(band), emitter.plan.n_cells
        half = np.uint64(16 if emitter._words.place.dtype == np.uint32 else 32)
        place = emitter._words.place.astype(np.uint64)
        head, tail = place >> half, place & ((np.uint64(1) << half) - np.uint64(1))
        falls_and_paces: Any = (None, None) if queue is None else emitter._lobe_steps(band)[1]
        lobes = queue.tables if queue is not None else (None,) * 4
        return cls(
            n=n,
            n_cell=n_cell,
            is_shuffled=stream.order.size > 0,
            by_philox=bool(stream.jitter),
            order_keys=stream.order[3:] if stream.order.size else np.zeros(3, np.uint64),
            shifts=stream.shifts,
            steps=stream.steps,
            placement_key=stream.placement_key,
            position_key=stream.position_key,
            band=stream.band,
            guide_shift=packed.guide_shift,
            accept=stream.accept,
            number_shifts=stream.number_shifts,
            number_steps=NUMBER_STEPS,
            way=packed.main,
            cumulative=packed.cumulative,
            guide=packed.guide.astype(np.uint32),
            cell_of_slot=packed.cell_of_slot if packed.cell_of_slot.size else None,
            place=(head << np.uint64(32)) | tail,
            words=packed.words,
            law=emitter._start_law.astype(np.int8) if packed.law is not None and packed.law.size else None,
            slopes=emitter._slopes(band),
            perez_word=None if rejection is None else rejection.word,
            perez_bound=None if rejection is None else rejection.bound,
            perez_sky=None if rejection is None else rejection.sky,
            lobe=None if queue is None else queue.lobe,
            ranges=lobes[0],
            bins=lobes[1],
            shapes=lobes[2],
            envelopes=lobes[3],
            falls=falls_and_paces[0],
            paces=falls_and_paces[1],
            lobe_ends=np.zeros(2, np.int32) if queue is None else queue.tables[4],
        )

    @property
    def record(self) -> np.ndarray:
        """The words of the band's record but for wavelength, irradiance and directory, uint64 (40,)."""
        n_slot = self.cumulative.size - 3
        flags = int(self.is_shuffled) | int(self.by_philox) << 1
        words = np.zeros(_RECORD_WORDS, np.uint64)
        words[:3], words[7] = (self.n, n_slot, self.n_cell), flags
        words[8:11], words[11:13], words[13:15] = self.order_keys, self.shifts, self.steps
        words[15:19] = self.placement_key, self.position_key, self.band, self.guide_shift
        words[19:22], words[22:25], words[25:28] = self.accept, self.number_shifts, self.number_steps
        words[28:30], words[30] = self.lobe_ends, self.way
        return words


SECTIONS = tuple(field.name for field in fields(Tables))[15:-1]
"""Names of the sections in the order of their kinds, from 1; witnesses and Stokes vectors come after them."""


def checksum(block: bytes | np.ndarray) -> int:
    """The checksum of a file of whole words, without the word in which it stands; `aomc_sky_checksum` of the header."""
    words = np.frombuffer(block, "<u8").copy()
    words[_CHECKSUM_WORD] = 0
    words ^= np.arange(words.size, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    words *= np.uint64(0xD1342543DE82EF95)
    words ^= words >> np.uint64(32)
    words *= np.uint64(0xAF251AF3B0F025B5)
    return int(np.add.reduce(words, dtype=np.uint64))


class _Block:
    """The bytes of a file while it grows."""

    def __init__(self, size: int) -> None:
        self.parts = [b"\0" * size]
        self.size = size
        self._known: dict[bytes, int] = {}

    def put(self, data: bytes) -> int:
        """Append bytes at the next aligned place and return its offset; equal ones are there once."""
        if data not in self._known:
            offset = -(-self.size // _ALIGNMENT) * _ALIGNMENT
            self.parts += [b"\0" * (offset - self.size), data]
            self.size = offset + len(data)
            self._known[data] = offset
        return self._known[data]


def require_packable(plan: Plan) -> None:
    """UsageError for plans that the file cannot hold: with weights or replicates."""
    for is_there, what, advice in (
        (any(c.weight is not None for c in plan.components), "weights of photons", "make it without weights"),
        (plan.replicates > 1, f"{plan.replicates} replicates", "make one source per seed with replicates=1"),
    ):
        if is_there:
            raise UsageError(f"a source file holds directions alone, and this source has {what}: {advice}")


def source_bytes(emitter: Emitter) -> bytes:
    """The file of the source whose photons an emitter makes."""
    plan = emitter.plan
    require_packable(plan)
    records = _HEAD_BYTES + plan.n_bands * _RECORD_WORDS * 8
    block = _Block(records)
    all_words = []
    for band in range(plan.n_bands):
        words, directory = np.zeros(_RECORD_WORDS, np.uint64), np.zeros((0, 3), np.uint64)
        if emitter.n_photons(band):
            tables = Tables.of(emitter, band)
            words, sections = tables.record, {name: getattr(tables, name) for name in SECTIONS}
            sections["witnesses"] = witnesses(emitter, band, tables)
            stokes = plan.stokes(band)
            sections["stokes"] = None if stokes is None else stokes.astype(np.float32)
            directory = np.array([_entry(block, k, v) for k, v in enumerate(sections.items(), 1) if v[1] is not None])
        absolute = plan.bands[band].irradiance_W_m2_nm
        irradiance = np.nan if absolute is None else np.sum(absolute)
        words[3:5] = np.array([plan.bands[band].wavelength_nm, irradiance], np.float64).view(np.uint64)
        words[5:7] = block.put(directory.astype("<u8").tobytes()) if directory.size else records, len(directory)
        all_words.append(words.astype("<u8").tobytes())
    block.put(b"")
    data = bytearray(b"".join(block.parts) + b"\0" * (-block.size % _ALIGNMENT))
    data[:_HEAD_BYTES] = _head(emitter, len(data))
    data[_HEAD_BYTES:records] = b"".join(all_words)
    data[8 * _CHECKSUM_WORD : 8 * _CHECKSUM_WORD + 8] = checksum(bytes(data)).to_bytes(8, "little")
    return bytes(data)


def _entry(block: _Block, kind: int, section: tuple[str, np.ndarray]) -> tuple[int, int, int]:
    """Put a section into the block; its entry in the directory: kind, width and need, offset, count."""
    name, values = section
    values = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).ravel()
    need = 0 if name in _OPTIONAL else _NEEDED
    return kind | values.itemsize << 32 | need << 48, block.put(values.tobytes()), values.size


def _head(emitter: Emitter, size: int) -> bytes:
    """The first bytes of the file; the checksum is 0."""
    numbers = np.zeros(_HEAD_BYTES // 8, "<u8")
    numbers[4], numbers[6], numbers[7] = size, emitter.plan.n_bands, _HEAD_BYTES
    head = bytearray(numbers.tobytes())
    head[:8] = MAGIC
    head[8:16] = np.array([LAYOUT, emitter.dtype.itemsize], "<u4").tobytes()
    head[16:32] = STREAM_VERSION.encode().ljust(16, b"\0")
    head[64:128] = emitter.plan.sha256.encode()
    return bytes(head)


def head_of(data: bytes) -> dict[str, Any] | None:
    """What the head of a file and the records of its bands say, as JSON values; None where it is damaged."""
    if len(data) < _HEAD_BYTES or len(data) % 8 or data[:8] != MAGIC:
        return None
    words = np.frombuffer(data, "<u8")
    layout, precision = np.frombuffer(data[8:16], "<u4").tolist()
    n_bands, at = int(words[6]), int(words[7]) // 8
    is_whole = words[4] == len(data) and int(words[_CHECKSUM_WORD]) == checksum(data)
    if layout != LAYOUT or not is_whole or at + n_bands * _RECORD_WORDS > words.size:
        return None
    records = words[at : at + n_bands * _RECORD_WORDS].reshape(n_bands, _RECORD_WORDS)
    floats = records[:, 3:5].copy().view(np.float64)
    return {
        "layout": layout,
        "stream": data[16:32].rstrip(b"\0").decode("ascii", "replace"),
        "precision": f"float{8 * precision}",
        "plan_sha256": data[64:128].decode("ascii", "replace"),
        "bytes": len(data),
        "bands": [
            {
                "waveband": band + 1,
                "wavelength_nm": nm,
                "irradiance_W_m2_nm": None if np.isnan(irradiance) else irradiance,
                "photons": int(records[band, 0]),
            }
            for band, (nm, irradiance) in enumerate(floats.tolist())
        ],
    }
