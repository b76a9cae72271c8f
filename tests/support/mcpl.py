"""libmcpl of the package mcpl as the oracle: it writes files, reads them, and runs its own tool."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.formats.mcpl.header import McplHeader
from aomc_sky.outputs.photons.mcpl import McplWriter
from aomc_sky.source.photon_source import PhotonSource
from bench.mcpl import PARTICLE, LibMcpl, particles_of


class Oracle(LibMcpl):
    """libmcpl with its functions for reading."""

    def __init__(self, library: Path) -> None:
        super().__init__(library)
        self.library = library
        handle = type("File", (ctypes.Structure,), {"_fields_": (("internal", ctypes.c_void_p),)})
        reader = self._reader = ctypes.CDLL(str(library))
        reader.mcpl_open_file.argtypes, reader.mcpl_open_file.restype = [ctypes.c_char_p], handle
        reader.mcpl_read.argtypes, reader.mcpl_read.restype = [handle], ctypes.c_void_p
        reader.mcpl_close_file.argtypes = [handle]

    def read(self, path: Path) -> np.ndarray:
        """All particles of a file, as libmcpl gives them one by one."""
        file = self._reader.mcpl_open_file(str(path).encode())
        pieces = []
        while address := self._reader.mcpl_read(file):
            pieces.append(ctypes.string_at(address, PARTICLE.itemsize))
        self._reader.mcpl_close_file(file)
        return np.frombuffer(b"".join(pieces), PARTICLE)

    def tool(self, *arguments: str | Path) -> str:
        """Standard output of mcpltool."""
        program = self.library.parents[1] / "bin" / "mcpltool"
        command = [str(program), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout


def oracle() -> Oracle:
    """libmcpl, or a skip where the package mcpl is absent."""
    pytest.importorskip("mcpl")
    found = Oracle.find()
    assert isinstance(found, Oracle), "the package mcpl is there, its library is not"
    return found


def random_particles(n: int, seed: int) -> np.ndarray:
    """Particles with every field in use; directions all over the sphere, on its axes and between them."""
    generator = np.random.default_rng(seed)
    particles = np.zeros(n, PARTICLE)
    direction = generator.normal(size=(n, 3))
    axes = [v for v in np.ndindex(3, 3, 3) if v != (1, 1, 1)]
    direction[: len(axes)] = np.array(axes[:n]) - 1
    particles["direction"] = direction / np.sqrt((direction**2).sum(axis=1, keepdims=True))
    particles["ekin"] = generator.exponential(size=n)
    particles["polarisation"] = generator.normal(size=(n, 3))
    particles["position"] = generator.normal(scale=100, size=(n, 3))
    particles["time"] = generator.uniform(size=n)
    particles["weight"] = generator.uniform(0.1, 3, size=n)
    particles["pdgcode"] = generator.choice([22, 2112, -11], size=n)
    particles["userflags"] = generator.integers(0, 2**32, size=n, dtype=np.uint32)
    return particles


def encoded(header: McplHeader, records: np.ndarray | bytes = b"") -> bytes:
    """A whole file."""
    from aomc_sky.formats.mcpl.header import encode_header

    return encode_header(header) + (records if isinstance(records, bytes) else records.tobytes())


def unpacked(packed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Energies and directions of packed triples, through a file."""
    from aomc_sky.formats.mcpl.file import read_mcpl

    header = McplHeader(n_particles=len(packed), pdg_code=22, weight=1.0, is_double=packed.dtype == np.float64)
    records = np.zeros(len(packed), header.record)
    records["packed"] = packed
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.mcpl"
        path.write_bytes(encoded(header, records))
        particles = read_mcpl(path).particles()
    return particles.energy, particles.direction


def written_by_libmcpl(library: LibMcpl, source: PhotonSource, path: Path) -> bytes:
    """The file that libmcpl makes of a source's photons and of the head that our writer gives them."""
    from bench.mcpl import parsed

    header = parsed(McplWriter(source).layouts(tuple(range(source.n_bands)))[0].head)
    library.write(path, header, _particles(source))
    return path.read_bytes()


def _particles(source: PhotonSource) -> Iterable[np.ndarray]:
    def blocks() -> Iterator[np.ndarray]:
        for band in range(source.n_bands):
            for batch in source.batches(band):
                yield particles_of(batch)

    return blocks()
