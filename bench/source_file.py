"""The source in a file beside our own batches and numba's `sample(i)`: time, size, time to load, resident memory.

    python bench/source_file.py [--photons 2000000] [--repeats 7] [--flags "-O3 -march=native"] [--compiler cc]

Each line is a law in an order and a precision. All of a line is timed in turn, and the best of the repeats counts. The
C program is compiled with the flags given; every photon of `fill` is compared with ours. The last column is
`fill_weighted` with patches and weights over `fill`, for photons of which each patch has another weight.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numba
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.kernels.backend import announce_photons
from tests.support.fairness import LOBES, component
from tests.support.host_scenes import WAVEBANDS, disc, perez, table

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = r"""
#include "aomc_sky.h"
static aomc_sky_source source, weighted;
static aomc_sky_stream stream;
static int32_t patch[65536];
int open_bytes(const void *bytes, uint64_t size, const void *others, uint64_t others_size) {
    aomc_sky_file file, other;
    int code = aomc_sky_view(bytes, size, &file);
    if (code == 0) code = aomc_sky_view(others, others_size, &other);
    if (code == 0) code = aomc_sky_band(&file, 0, &source);
    return code ? code : aomc_sky_weighted_band(&other, 0, &weighted);
}
int64_t plain_f32(int64_t start, int64_t n, float *x, float *y, float *z, float *w) {
    (void)w;
    return aomc_sky_fill(&weighted, start, n, x, y, z);
}
int64_t plain_f64(int64_t start, int64_t n, double *x, double *y, double *z, double *w) {
    (void)w;
    return aomc_sky_fill_double(&weighted, start, n, x, y, z);
}
int64_t weighted_f32(int64_t start, int64_t n, float *x, float *y, float *z, float *w) {
    return aomc_sky_fill_weighted(&weighted, start, n, x, y, z, patch, w);
}
int64_t weighted_f64(int64_t start, int64_t n, double *x, double *y, double *z, double *w) {
    return aomc_sky_fill_weighted_double(&weighted, start, n, x, y, z, patch, w);
}
double next_one(int64_t n) {
    double sum = 0;
    aomc_sky_particle p;
    if (aomc_sky_particles(&stream, &source, 1, 0, n) != 0) return NAN;
    while (aomc_sky_next(&stream, &p) > 0) sum += p.ux + p.uy * p.uz;
    return sum;
}
int64_t fill_f32(int64_t start, int64_t n, float *x, float *y, float *z) {
    return aomc_sky_fill(&source, start, n, x, y, z);
}
int64_t fill_f64(int64_t start, int64_t n, double *x, double *y, double *z) {
    return aomc_sky_fill_double(&source, start, n, x, y, z);
}
double sum_f32(int64_t n) {
    double sum = 0;
    for (int64_t i = 0; i < n; i++) { aomc_sky_photon p = aomc_sky_at(&source, i); sum += p.ux + p.uy * p.uz; }
    return sum;
}
double sum_f64(int64_t n) {
    double sum = 0;
    for (int64_t i = 0; i < n; i++) {
        aomc_sky_photon_double p = aomc_sky_at_double(&source, i);
        sum += p.ux + p.uy * p.uz;
    }
    return sum;
}
"""
LOAD = r"""
#include "aomc_sky.h"
#include <time.h>
int main(int count, char **arguments) {
    aomc_sky_file file;
    struct timespec a, b;
    char line[256];
    FILE *status;
    int code;
    (void)count;
    clock_gettime(CLOCK_MONOTONIC, &a);
    code = aomc_sky_load(arguments[1], &file);
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%d %g", code, (b.tv_sec - a.tv_sec) * 1e3 + (b.tv_nsec - a.tv_nsec) * 1e-6);
    status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status)) if (strncmp(line, "VmRSS", 5) == 0) printf(" %s", line + 6);
    return code;
}
"""


def compiled(text: str, compiler: str, flags: list[str], folder: Path, name: str) -> Path:
    """A program or, with -shared, a library."""
    (folder / f"{name}.c").write_text(text)
    target = folder / name
    subprocess.run([compiler, *flags, f"-I{include_dir()}", "-o", target, folder / f"{name}.c", "-lm"], check=True)
    return target


def scenes() -> dict[str, Any]:
    """Components by name."""
    clear = sky.read_scene(ROOT / "inputs" / "clear_day")
    return {
        "clear_day": clear.components,
        "table 6 x 9": (table(sky.component.Law.CELL_MU2, 6, 9),),
        "disc and table": (*disc(20), table(sky.component.Law.CELL_MU2, 90, 360)),
        "perez 90 x 360": perez(90, 360),
        "perez 6 x 12": perez(6, 12),
        "lobe hg": (component(LOBES["cloud edge"]),),
        "lobe ggx": (component(LOBES["glow"]),),
        "lobe beckmann": (component(LOBES["band"]),),
    }


def aligned(data: bytes) -> np.ndarray:
    """The bytes at an address that the header takes."""
    memory = np.zeros(len(data) + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    memory[begin : begin + len(data)] = np.frombuffer(data, np.uint8)
    return memory[begin : begin + len(data)]


def best(functions: dict[str, Any], repeats: int) -> dict[str, float]:
    """Best time of each, all of them in turn, on this thread: other programs take time, too."""
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(repeats):
        for name, function in functions.items():
            begin = time.thread_time()
            function()
            times[name].append(time.thread_time() - begin)
    return {name: min(values) for name, values in times.items()}


def sampled(source: sky.PhotonSource) -> Any:
    """A numba loop over `sample(i)`."""
    sample = source.numba_sampler(0).sample

    @numba.njit
    def loop(n: int) -> float:
        total = 0.0
        for i in range(n):
            x, y, z = sample(i)
            total += x + y * z
        return total

    return loop


def weighted(scene: sky.Scene, **way: Any) -> sky.PhotonSource:
    """Photons with another weight in each patch of the grids."""
    rng = np.random.default_rng(1)
    importance = {one.name: rng.lognormal(0, 1, one.n_cells) for one in scene.components if one.grid is not None}
    return scene.source(seed=1, importance=importance or None, **way)


def measure(
    source: sky.PhotonSource, other: sky.PhotonSource, library: ctypes.CDLL, repeats: int, block: int = 65_536
) -> dict[str, float]:
    """Nanoseconds a photon of batches, `fill`, `next`, `sample(i)` and `at`; of `other` without and with weights."""
    data, others = aligned(source.to_bytes()), aligned(other.to_bytes())
    n, kind = source.n_photons(0), "f32" if source.dtype == np.float32 else "f64"
    files = [(ctypes.c_void_p(one.ctypes.data), ctypes.c_uint64(one.size)) for one in (data, others)]
    assert library.open_bytes(*files[0], *files[1]) == 0
    fill, total = getattr(library, f"fill_{kind}"), getattr(library, f"sum_{kind}")
    total.restype, fill.restype, library.next_one.restype = ctypes.c_double, ctypes.c_int64, ctypes.c_double
    out, mine = source.photons(0, 0, block), np.empty((4, block), source.dtype)
    *at, weight = [ctypes.c_void_p(row.ctypes.data) for row in mine]

    def batches() -> None:
        for _ in source.batches(0, block, out):
            pass

    def filled() -> None:
        for start in range(0, n, block):
            fill(ctypes.c_int64(start), ctypes.c_int64(block), *at)

    def others_by(name: str) -> Any:
        function = getattr(library, f"{name}_{kind}")

        def filled() -> None:
            for start in range(0, n, block):
                function(ctypes.c_int64(start), ctypes.c_int64(block), *at, weight)

        return filled

    for start in range(0, n, block):
        batch = source.photons(0, start, min(start + block, n), out=out)
        fill(ctypes.c_int64(start), ctypes.c_int64(block), *at)
        for own, row in zip((batch.ux, batch.uy, batch.uz), mine[:3], strict=True):
            assert own.tobytes() == row[: own.size].tobytes()
    loop = sampled(source)
    assert abs(loop(n) - total(ctypes.c_int64(n))) <= 1e-6 * n
    one_by_one = {"sample": lambda: loop(n), "at": lambda: total(ctypes.c_int64(n))}
    one_by_one["next"] = lambda: library.next_one(ctypes.c_int64(n))
    functions = {"batches": batches, "fill": filled, **one_by_one}
    functions |= {name: others_by(name) for name in ("plain", "weighted")}
    return {name: seconds / n * 1e9 for name, seconds in best(functions, repeats).items()}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=int, default=2_000_000)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--compiler", default="cc")
    parser.add_argument("--flags", default="-O3 -march=native")
    parser.add_argument("--only", default="", help="lines whose scene begins so")
    arguments = parser.parse_args()
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")
    announce_photons(2**40)  # all batches by the compiled kernels
    flags = arguments.flags.split()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        library = ctypes.CDLL(
            str(compiled(PROGRAM, arguments.compiler, [*flags, "-shared", "-fPIC"], folder, "program.so"))
        )
        heads = (
            "batches",
            "fill",
            "sample",
            "at",
            "next",
            "fill/bat.",
            "at/sam.",
            "next/fill",
            "next/sam.",
            "weighted",
        )
        print(f"{'ns a photon':16} {'':17}", *(f"{head:>9}" for head in heads))
        for scene_name, components in scenes().items():
            if not scene_name.startswith(arguments.only):
                continue
            wavebands = 550.0 if scene_name.startswith("lobe") else WAVEBANDS
            scene = sky.Scene(
                wavebands=[wavebands] if isinstance(wavebands, float) else _wavebands(scene_name, wavebands),
                n_photons=arguments.photons,
                components=components,
            )
            ways = [{}, {"order": "patch"}, {"precision": "float64"}, {"placement": "philox"}]
            for way in ways:
                ns = measure(scene.source(seed=1, **way), weighted(scene, **way), library, arguments.repeats)
                ratios = [("fill", "batches"), ("at", "sample"), ("next", "fill"), ("next", "sample")]
                shown = [ns[name] for name in ("batches", "fill", "sample", "at", "next")]
                shown += [ns[one] / ns[other] for one, other in (*ratios, ("weighted", "plain"))]
                label = " ".join(way.values()) or "shuffled"
                print(f"{scene_name:16} {label:17}", *(f"{value:9.2f}" for value in shown), flush=True)
        load = compiled(LOAD, arguments.compiler, ["-O2", "-std=gnu11"], folder, "load")
        for scene_name in ("clear_day", "night_sky"):
            source = sky.read_scene(ROOT / "inputs" / scene_name).source(seed=1)
            path = folder / f"{scene_name}.sky"
            sky.write_source(source, path)
            done = subprocess.run([load, path], capture_output=True, text=True, check=True).stdout.split()
            size = path.stat().st_size
            print(
                f"{scene_name}: {size / 1e6:.2f} MB, {size / source.n_bands / 1e6:.2f} a band; loaded in "
                f"{float(done[1]):.2f} ms, {float(done[1]) / size * 1e6:.2f} a MB; {int(done[2]) / 1e3:.1f} MB resident"
            )


def _wavebands(scene_name: str, wavebands: Any) -> Any:
    return sky.read_scene(ROOT / "inputs" / scene_name).wavebands if scene_name == "clear_day" else wavebands


if __name__ == "__main__":
    main()
