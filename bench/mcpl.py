"""Our MCPL writer against a ctypes loop over libmcpl's mcpl_add_particle: the same photons, the same bytes.

    python bench/mcpl.py [--photons 1000000] [--repeats 7]

Both start from photons in memory and end with a file; the loop gets its particles ready made and
only calls, which is the fastest form that Python has for it. Besides: `write_mcpl` with emission.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import statistics
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from aomc_sky.errors import OutputError
from aomc_sky.formats.mcpl.file import read_mcpl
from aomc_sky.formats.mcpl.header import COUNT_OFFSET, McplHeader
from aomc_sky.kernels.backend import PLAIN_PHOTONS, announce_photons
from aomc_sky.outputs.photons.mcpl import MAX_CELLS, MEV_NM, PHOTON, McplWriter, write_mcpl
from aomc_sky.skies.uniform import UniformSky
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.photons import PhotonBatch
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands
from bench.harness import machine, ratio, seconds, verdict

BAR = 15.0

PARTICLE = np.dtype(
    [
        ("ekin", "f8"),
        ("polarisation", "f8", (3,)),
        ("position", "f8", (3,)),
        ("direction", "f8", (3,)),
        ("time", "f8"),
        ("weight", "f8"),
        ("pdgcode", "i4"),
        ("userflags", "u4"),
    ]
)
"""`mcpl_particle_t`."""

BLOCK = 65_536


class _File(ctypes.Structure):
    _fields_ = (("internal", ctypes.c_void_p),)


class LibMcpl:
    """The functions of libmcpl that write a file; errors of the library end the process."""

    def __init__(self, library: Path) -> None:
        self._lib = ctypes.CDLL(str(library))
        self._lib.mcpl_create_outfile.restype = _File
        text, number = ctypes.c_char_p, ctypes.c_void_p
        types: dict[str, list[Any]] = {
            "mcpl_create_outfile": [text],
            "mcpl_hdr_set_srcname": [_File, text],
            "mcpl_hdr_add_comment": [_File, text],
            "mcpl_hdr_add_data": [_File, text, ctypes.c_uint32, text],
            "mcpl_hdr_add_stat_sum": [_File, text, ctypes.c_double],
            "mcpl_enable_userflags": [_File],
            "mcpl_enable_polarisation": [_File],
            "mcpl_enable_doubleprec": [_File],
            "mcpl_enable_universal_pdgcode": [_File, ctypes.c_int32],
            "mcpl_enable_universal_weight": [_File, ctypes.c_double],
            "mcpl_add_particle": [_File, number],
            "mcpl_close_outfile": [_File],
        }
        for name, arguments in types.items():
            getattr(self._lib, name).argtypes = arguments

    @classmethod
    def find(cls) -> LibMcpl | None:
        """The library of the installed package mcpl, None where there is none."""
        package = importlib.util.find_spec("_mcpl_core")
        for folder in (package.submodule_search_locations if package else None) or ():
            for library in sorted(Path(folder, "data").rglob("libmcpl.[sd]*")):
                return cls(library)
        return None

    def write(self, path: Path, header: McplHeader, blocks: Iterable[np.ndarray]) -> None:
        """Write a .mcpl file from arrays of `PARTICLE`, one by one; the head's number of particles is counted anew."""
        lib = self._lib
        file = lib.mcpl_create_outfile(str(path).encode())
        lib.mcpl_hdr_set_srcname(file, header.source.encode())
        for comment in header.comments:
            self._comment(file, comment)
        for key, data in header.blobs:
            lib.mcpl_hdr_add_data(file, key.encode(), len(data), data)
        if header.has_user_flags:
            lib.mcpl_enable_userflags(file)
        if header.has_polarisation:
            lib.mcpl_enable_polarisation(file)
        if header.is_double:
            lib.mcpl_enable_doubleprec(file)
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

    def _comment(self, file: _File, comment: str) -> None:
        kind, _, rest = comment.partition(":sum:")
        if kind == "stat" and rest:
            key, _, value = rest.partition(":")
            self._lib.mcpl_hdr_add_stat_sum(file, key.encode(), float(value))
        else:
            self._lib.mcpl_hdr_add_comment(file, comment.encode())


def particles_of(batch: PhotonBatch) -> np.ndarray:
    """Photons as an array of `mcpl_particle_t`, in the conventions of docs/formats/mcpl.md."""
    particles = np.zeros(len(batch), PARTICLE)
    particles["ekin"] = MEV_NM / batch.wavelength_nm
    particles["direction"] = np.stack([batch.ux, batch.uy, batch.uz], axis=-1)
    if batch.x is not None and batch.y is not None:
        particles["position"][:, 0] = 100 * batch.x.astype(np.float64)
        particles["position"][:, 1] = 100 * batch.y.astype(np.float64)
    particles["weight"] = 1.0 if batch.weight is None else batch.weight
    particles["pdgcode"] = PHOTON
    particles["userflags"] = (batch.band + 1) * MAX_CELLS + batch.patch
    return particles


def mcpl_times(n_photons: int, repeats: int, precision: str = "float32") -> dict[str, list[float]] | None:
    """Seconds of each turn, turn and turn about; None without the package mcpl.

    ``packed``: our writer from photons in memory to the file, one thread; ``libmcpl``: the loop, from particles in
    memory to the file; ``emitted``: `write_mcpl` with one thread, emission and the wait for the disk included.
    """
    library = LibMcpl.find()
    if library is None:
        return None
    announce_photons(PLAIN_PHOTONS + 1)  # compiled from the first photon on
    source = uniform_source(n_photons, precision)
    writer = McplWriter(source)
    header = parsed(writer.layouts((0,))[0].head)
    batches = list(source.batches(0, BLOCK))
    particles = [particles_of(batch) for batch in batches]
    contenders: dict[str, Callable[[Path], None]] = {
        "packed": lambda path: _write_packed(path, writer, batches),
        "libmcpl": lambda path: library.write(path, header, particles),
        "emitted": lambda path: write_mcpl(source, path, threads=1),
    }
    with tempfile.TemporaryDirectory() as folder:
        times = _in_turns(contenders, repeats, Path(folder))
        first, *others = (Path(folder, f"{name}.mcpl").read_bytes() for name in contenders)
    if any(data != first for data in others):
        raise OutputError("our MCPL file differs from that of libmcpl; report this with the version of mcpl")
    return times


def _in_turns(contenders: dict[str, Callable[[Path], None]], repeats: int, folder: Path) -> dict[str, list[float]]:
    """`timing.in_turns` for contenders that write a file each; removing that of the last turn is not timed."""
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(-1, repeats):
        for name, work in contenders.items():
            path = folder / f"{name}.mcpl"
            path.unlink(missing_ok=True)
            taken = seconds(partial(work, path))
            if turn >= 0:
                times[name].append(taken)
    return times


def _write_packed(path: Path, writer: McplWriter, batches: list[PhotonBatch]) -> None:
    with open(path, "wb") as file:
        file.write(writer.layouts((0,))[0].head)
        for batch in batches:
            chunks = writer.chunks(batch)
            file.write(chunks[0])
            writer.recycle(chunks)


def uniform_source(n_photons: int, precision: str) -> PhotonSource:
    """One waveband of a uniform sky."""
    bands = Wavebands(wavelength_nm=np.array([500.0]))
    scene = Scene(wavebands=bands, n_photons=np.array([n_photons]), components=UniformSky().lower([500.0]))
    return scene.source(seed=1, precision=precision)


def parsed(head: bytes) -> McplHeader:
    """A head from its bytes, whatever number of particles it announces."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "head.mcpl"
        path.write_bytes(head[:COUNT_OFFSET] + bytes(8) + head[COUNT_OFFSET + 8 :])
        return read_mcpl(path).header


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photons", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    print(f"{machine()}\n{options.photons} photons, median of {options.repeats} turns, one thread")
    for precision in ("float32", "float64"):
        times = mcpl_times(options.photons, options.repeats, precision)
        if times is None:
            raise SystemExit("the package mcpl is not installed: pip install mcpl")
        print(precision)
        for name, taken in times.items():
            median = statistics.median(taken)
            print(
                f"  {name:10s} {median / options.photons * 1e9:8.1f} ns per photon "
                f"{options.photons / median / 1e6:8.2f} million per second"
            )
        print(f"  libmcpl / packed   {verdict(ratio(times['libmcpl'], times['packed']), BAR, at_least=True)}")
        print(f"  libmcpl / emitted  {ratio(times['libmcpl'], times['emitted']):8.2f}")


if __name__ == "__main__":
    main()
