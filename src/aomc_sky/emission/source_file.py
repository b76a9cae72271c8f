"""A source as one block of bytes, which ``include/aomc_sky.h`` reads: the plan packed for codes without Python.

The layout is on the page docs/formats/source.md. All numbers are little-endian. A head names the plan. The record of a
band has its constants and leads to a directory of sections, the tables of the emission kernels. Equal tables are stored
once, so wavebands of one sky share them.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from aomc_sky.emission.band import Band
from aomc_sky.emission.emitter import Emitter
from aomc_sky.emission.source_witnesses import witnesses
from aomc_sky.plan.options import MAX_REPLICATES, FootprintShape
from aomc_sky.plan.streams import STREAM_VERSION

MAGIC = b"AOMC-SKY"
LAYOUT = 1
"""Changes whenever an older header can no longer read the file."""

FOOTPRINTS = (FootprintShape.POINT, FootprintShape.CIRCLE, FootprintShape.RECTANGLE)
"""Shapes in the order of their numbers in a record."""

_ALIGNMENT = 64
_HEAD_BYTES = 192
_RECORD_WORDS = 40
_CHECKSUM_WORD, _REPLICATES_WORD = 5, 16
_NEEDED = 1
_WEIGHT_KIND = 20
_COARSER = 1
"""A file has half of the guide's entries: `fill` and `at` take as long, and the file is smaller."""
_OPTIONAL = ("stokes", "components")
"""Sections that change no direction: a header that does not know them skips them."""


def tables_of(emitter: Emitter, band: int, packed: Band) -> dict[str, np.ndarray | None]:
    """The sections of a replicate band in the order of their kinds, which count from 1; None for what is not needed.

    The kernels have tables of slots. Here those of cells have an entry for each cell of the plan, so that wavebands of
    one sky share them.
    """
    perez, lobes, words = emitter._perez_tables, emitter._lobe_tables, emitter._packed_cells
    half = np.uint64(16 if words.place.dtype == np.uint32 else 32)
    place = words.place.astype(np.uint64)
    has_laws = packed.law is not None and packed.law.size > 0
    ranges, bins, shapes, envelopes = (None,) * 4 if lobes is None else lobes.tables[:4]
    bin_proposals, bins_per_photon = (None, None) if packed.lobes is None else packed.lobes[3]
    plan = emitter.plan
    stokes = plan.stokes(band % plan.n_bands)
    return {
        "cumulative": packed.cumulative,
        "guide": packed.guide[:: 1 << _COARSER].astype(np.uint32),
        "cell_of_slot": packed.cell_of_slot if packed.cell_of_slot.size else None,
        "place": (place >> half << np.uint64(32)) | (place & ((np.uint64(1) << half) - np.uint64(1))),
        "words": packed.words,
        "law": emitter._start_law if has_laws else None,
        "slopes": emitter._slopes(band),
        "perez_word": None if perez is None else perez.word,
        "perez_bound": None if perez is None else perez.bound,
        "perez_sky": None if perez is None else perez.sky,
        "lobe": None if lobes is None else lobes.lobe,
        "ranges": ranges,
        "bins": bins,
        "shapes": shapes,
        "envelopes": envelopes,
        "bin_proposals": bin_proposals,
        "bins_per_photon": bins_per_photon,
        "witnesses": witnesses(emitter, band),
        "stokes": None if stokes is None else stokes.astype(np.float32),
        "weight": None if (weight := plan.weight(band % plan.n_bands)) is None else weight.astype(emitter.dtype),
        "components": plan.component_start[1:].astype(np.int32),
        "replicates": np.array([plan.replicates], np.int32) if plan.replicates > 1 else None,
    }


def _record(emitter: Emitter, band: int, packed: Band) -> np.ndarray:
    """The words of the band's record but for wavelength, irradiance and directory, uint64 (40,)."""
    stream, lobes = emitter._stream(band), emitter._lobe_tables
    is_net = stream.number_steps is None and not packed.jitter
    words = np.zeros(_RECORD_WORDS, np.uint64)
    words[:3] = emitter.n_photons(band), packed.cumulative.size - 3, emitter.plan.n_cells
    words[7] = int(packed.order.size > 0) | int(packed.jitter) << 1 | is_net << 2
    words[8:11] = packed.order[3:] if packed.order.size else 0
    words[11:13], words[13:15] = packed.shifts, packed.steps
    words[15:19] = packed.key, stream.position_key, packed.number, int(packed.guide_shift) + _COARSER
    words[19:22], words[22:25] = stream.accept, stream.number_shifts[:3]
    if is_net:
        words[25] = stream.number_shifts[3]
    elif stream.number_steps is not None:
        words[25:28] = stream.number_steps
    words[28:30], words[30] = 0 if lobes is None else lobes.tables[4], packed.azimuth_kernel
    return words


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


def source_bytes(emitter: Emitter) -> bytes:
    """The file of the source whose photons an emitter makes."""
    plan = emitter.plan
    records = _HEAD_BYTES + plan.replicates * plan.n_bands * _RECORD_WORDS * 8
    block = _Block(records)
    all_words = []
    photons = plan.cumulative[:, -1].reshape(plan.replicates, plan.n_bands).sum(axis=0).tolist()
    has_mu = int(plan.weight_has_mu.any())
    for replicate, band in itertools.product(range(plan.replicates), range(plan.n_bands)):
        words, directory = np.zeros(_RECORD_WORDS, np.uint64), np.zeros((0, 3), np.uint64)
        number = replicate * plan.n_bands + band
        if emitter.n_photons(number):
            packed = emitter._packed(number)
            words, sections = _record(emitter, number, packed), tables_of(emitter, number, packed)
            entries = enumerate(sections.items(), 1)
            directory = np.array([_entry(block, k, name, v) for k, (name, v) in entries if v is not None])
        absolute = plan.bands[band].irradiance_W_m2_nm
        irradiance = np.nan if absolute is None else np.sum(absolute)
        words[3:5] = np.array([plan.bands[band].wavelength_nm, irradiance], np.float64).view(np.uint64)
        if n := photons[band]:
            words[31] = np.float64(1.0 if absolute is None else irradiance / n).view(np.uint64)
        words[32] = FOOTPRINTS.index(emitter.footprint.shape) | has_mu << 8
        sizes = emitter.footprint.size_x_m, emitter.footprint.size_y_m
        words[33:35] = np.array(sizes, np.float64).view(np.uint64)
        words[35] = replicate
        words[5:7] = block.put(directory.astype("<u8").tobytes()) if directory.size else records, len(directory)
        all_words.append(words.astype("<u8").tobytes())
    block.put(b"")
    data = bytearray(b"".join(block.parts) + b"\0" * (-block.size % _ALIGNMENT))
    data[:_HEAD_BYTES] = _head(emitter, len(data))
    data[_HEAD_BYTES:records] = b"".join(all_words)
    data[8 * _CHECKSUM_WORD : 8 * _CHECKSUM_WORD + 8] = checksum(bytes(data)).to_bytes(8, "little")
    return bytes(data)


def _entry(block: _Block, kind: int, name: str, values: np.ndarray) -> tuple[int, int, int]:
    """Put a section into the block; its entry in the directory: kind, width and need, offset, count."""
    values = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).ravel()
    need = 0 if name in _OPTIONAL else _NEEDED
    return kind | values.itemsize << 32 | need << 48, block.put(values.tobytes()), values.size


def _head(emitter: Emitter, size: int) -> bytes:
    """The first bytes of the file; the checksum is 0."""
    numbers = np.zeros(_HEAD_BYTES // 8, "<u8")
    numbers[4], numbers[6], numbers[7] = size, emitter.plan.n_bands, _HEAD_BYTES
    numbers[_REPLICATES_WORD] = emitter.plan.replicates
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
    n_bands, at, replicates = int(words[6]), int(words[7]) // 8, max(int(words[_REPLICATES_WORD]), 1)
    n_records = n_bands * replicates
    is_whole = words[4] == len(data) and int(words[_CHECKSUM_WORD]) == checksum(data)
    if layout != LAYOUT or not is_whole or replicates > MAX_REPLICATES or at + n_records * _RECORD_WORDS > words.size:
        return None
    records = words[at : at + n_records * _RECORD_WORDS].reshape(replicates, n_bands, _RECORD_WORDS)
    photons = records[..., 0].sum(axis=0).tolist()
    floats = records[0, :, 3:5].copy().view(np.float64)
    is_odd = np.isinf(floats).any() or np.isnan(floats[:, 0]).any()
    if is_odd or np.any(records[..., 35] != np.arange(replicates, dtype=np.uint64)[:, None]):
        return None
    kinds: set[int] = set()
    for begin, n in records[..., 5:7].reshape(-1, 2).tolist():
        kinds |= set((words[begin // 8 : begin // 8 + 3 * n : 3] & np.uint64(0xFFFFFFFF)).tolist())
    return {
        "layout": layout,
        "stream": data[16:32].rstrip(b"\0").decode("ascii", "replace"),
        "precision": f"float{8 * precision}",
        "plan_sha256": data[64:128].decode("ascii", "replace"),
        "bytes": len(data),
        "has_weights": _WEIGHT_KIND in kinds,
        "replicates": replicates,
        "bands": [
            {
                "waveband": band + 1,
                "wavelength_nm": nm,
                "irradiance_W_m2_nm": None if np.isnan(irradiance) else irradiance,
                "photons": photons[band],
            }
            for band, (nm, irradiance) in enumerate(floats.tolist())
        ],
    }
