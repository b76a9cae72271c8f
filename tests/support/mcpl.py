"""libmcpl of the package mcpl as the oracle: it writes files, reads them, and runs its own tool."""

import ctypes
import importlib.util
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.formats.mcpl.file import read_mcpl
from aomc_sky.outputs.photons.mcpl import MAX_CELLS, MEV_NM, PHOTON, McplWriter

COUNT_OFFSET = 8
"""Where the head of a file has the number of particles. [bytes]"""
_VECTORS = [(name, "f8", (3,)) for name in ("polarisation", "position", "direction")]
_LAST = [("time", "f8"), ("weight", "f8"), ("pdgcode", "i4"), ("userflags", "u4")]
PARTICLE = np.dtype([("ekin", "f8"), *_VECTORS, *_LAST])
"""`mcpl_particle_t`."""


class _File(ctypes.Structure):
    _fields_ = (("internal", ctypes.c_void_p),)


class Oracle:
    """The functions of libmcpl that write and read a file; errors of the library end the process."""

    def __init__(self, library):
        self.library, self._lib = library, ctypes.CDLL(str(library))
        self._lib.mcpl_create_outfile.restype = self._lib.mcpl_open_file.restype = _File
        self._lib.mcpl_read.restype = ctypes.c_void_p
        text, number = ctypes.c_char_p, ctypes.c_void_p
        types = {
            "create_outfile": [text], "hdr_set_srcname": [_File, text], "hdr_add_comment": [_File, text],
            "hdr_add_data": [_File, text, ctypes.c_uint32, text], "hdr_add_stat_sum": [_File, text, ctypes.c_double],
            "enable_userflags": [_File], "enable_polarisation": [_File], "enable_doubleprec": [_File],
            "enable_universal_pdgcode": [_File, ctypes.c_int32], "enable_universal_weight": [_File, ctypes.c_double],
            "add_particle": [_File, number], "close_outfile": [_File],
            "open_file": [text], "read": [_File], "close_file": [_File],
        }  # fmt: skip
        for name, arguments in types.items():
            getattr(self._lib, f"mcpl_{name}").argtypes = arguments

    def write(self, path, header, blocks):
        """Write a .mcpl file from arrays of `PARTICLE`, one by one; the head's number of particles is counted anew."""
        lib = self._lib
        file = lib.mcpl_create_outfile(str(path).encode())
        lib.mcpl_hdr_set_srcname(file, header.source.encode())
        for comment in header.comments:
            self._comment(file, comment)
        for key, data in header.blobs:
            lib.mcpl_hdr_add_data(file, key.encode(), len(data), data)
        switches = {"userflags": "has_user_flags", "polarisation": "has_polarisation", "doubleprec": "is_double"}
        for name, field in switches.items():
            if getattr(header, field):
                getattr(lib, f"mcpl_enable_{name}")(file)
        if header.pdg_code:
            lib.mcpl_enable_universal_pdgcode(file, header.pdg_code)
        if header.weight:
            lib.mcpl_enable_universal_weight(file, header.weight)
        add, size = lib.mcpl_add_particle, PARTICLE.itemsize
        for block in blocks:
            # addresses into one array: the fastest loop that Python has for this interface
            for address in range(block.ctypes.data, block.ctypes.data + block.size * size, size):
                add(file, address)
        lib.mcpl_close_outfile(file)

    def _comment(self, file, comment):
        kind, _, rest = comment.partition(":sum:")
        if kind == "stat" and rest:
            key, _, value = rest.partition(":")
            self._lib.mcpl_hdr_add_stat_sum(file, key.encode(), float(value))
        else:
            self._lib.mcpl_hdr_add_comment(file, comment.encode())

    def read(self, path):
        file = self._lib.mcpl_open_file(str(path).encode())
        pieces = []
        while address := self._lib.mcpl_read(file):
            pieces.append(ctypes.string_at(address, PARTICLE.itemsize))
        self._lib.mcpl_close_file(file)
        return np.frombuffer(b"".join(pieces), PARTICLE)

    def tool(self, *arguments):
        program = self.library.parents[1] / "bin" / "mcpltool"
        command = [str(program), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout


def particles_of(batch):
    """Photons as an array of `mcpl_particle_t`, in the conventions of docs/formats/mcpl.md."""
    particles = np.zeros(len(batch), PARTICLE)
    particles["ekin"] = MEV_NM / batch.wavelength_nm
    particles["direction"] = batch.directions
    if batch.x is not None:
        particles["position"][:, :2] = 100 * np.stack([batch.x, batch.y], axis=1).astype(np.float64)
    particles["weight"] = 1.0 if batch.weight is None else batch.weight
    particles["pdgcode"] = PHOTON
    particles["userflags"] = (batch.band + 1) * MAX_CELLS + batch.patch
    return particles


def parsed(head):
    """A head from its bytes, whatever number of particles it announces."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "head.mcpl")
        path.write_bytes(head[:COUNT_OFFSET] + bytes(8) + head[COUNT_OFFSET + 8 :])
        return read_mcpl(path).header


def oracle():
    """libmcpl of the package mcpl, or a skip where that is absent."""
    pytest.importorskip("mcpl")
    package = importlib.util.find_spec("_mcpl_core")
    assert package is not None, "the package mcpl is there, its library is not"
    folders = [Path(folder, "data") for folder in package.submodule_search_locations or ()]
    return Oracle(next(library for folder in folders for library in sorted(folder.rglob("libmcpl.[sd]*"))))


def random_particles(n, seed):
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


def encoded(header, records=b""):
    from aomc_sky.formats.mcpl.header import encode_header

    return encode_header(header) + (records if isinstance(records, bytes) else records.tobytes())


def written_by_libmcpl(library, source, path):
    """The file that libmcpl makes of a source's photons and of the head that our writer gives them."""
    header = parsed(McplWriter(source).layouts(tuple(range(source.n_bands)))[0].head)
    library.write(path, header, _particles(source))
    return path.read_bytes()


def _particles(source):
    return (particles_of(batch) for band in range(source.n_bands) for batch in source.batches(band))
