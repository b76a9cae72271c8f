"""How cost grows with photons, patches, wavebands, shards and threads: processor time and peak memory of whole runs.

    python bench/growth.py [--rows photons patches ...] [--small]     # measures: growth.csv, then the picture
    python bench/growth.py --redraw                                   # growth.png from growth.csv

Every point is a process of its own: `aomc-sky run`, all shards in one, and `write_run` of a scene for
wavebands, of which AMC's files hold 500 at most. Files go to memory where there is /dev/shm; the photons of the rows
photons and threads are emitted and dropped. Points are medians of turns, of one turn where a run is long. Peak memory
is what the system says of the ended process. This process imports no numpy before the last run has ended: a child's
peak is at least the memory of the process that started it.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

COLUMNS = ("row", "n", "turns", "processor_s", "wall_s", "peak_mb")
TURNS, LONG_S = 3, 8.0
GRID = 90, 360
_SHARDS = """
import sys
from aomc_sky.cli.main import main
scene, out, n = sys.argv[1:]
for k in range(int(n)):
    assert main(["run", scene, "--out", out, "--iterations", "1e7", "--shard", f"{k + 1}/{n}", "-q"]) == 0
"""
_BANDS = """
import sys
import numpy as np
import aomc_sky as sky
out, n = sys.argv[1], int(sys.argv[2])
bands = np.linspace(400.0, 700.0, n)
values = 1.0 + (np.arange(n)[:, None] + np.arange(360)) % 7
table = sky.TabulatedSky(wavelength_nm=bands, values=values, grid=sky.PatchGrid.regular(10, 36))
sky.write_run(sky.Scene(wavebands=bands, n_photons=1000, components=table), out, seed=1)
"""
_SCENE = """
import sys
sys.path.insert(0, sys.argv[1])
from make_scenes import amc, lambbot
folder, n_zenith, n_azimuth, n_bands = sys.argv[2], *map(int, sys.argv[3:])
bands = [400 + 300 * k / n_bands for k in range(n_bands)]
lines = [f"{z} {a} {1 + (z * a) % 7}" for z in range(1, n_zenith + 1) for a in range(n_azimuth)]
head = f"{n_bands * len(lines)} {n_zenith} {n_azimuth - 1} {n_bands}\\n{' '.join(f'{b:g}' for b in bands)}\\n"
for name, text in (("amc", amc(1000000, flag=1, n_wavebands=n_bands)), ("lambbot", lambbot(bands))):
    open(f"{folder}/{name}.inp", "w").write(text)
with open(f"{folder}/skydist.inp", "w") as file:
    file.write(head)
    for k in range(n_bands):
        file.writelines(f"{k + 1} {line}\\n" for line in lines)
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """One quantity that grows."""

    #: What grows, what one of it is called, and what else the runs are.
    title: str
    unit: str
    rest: str
    #: How many.
    steps: tuple[int, ...]
    #: The command of a run, from a number and a folder for its files; None: standard output is not kept.
    command: Callable[[int, Path], list[str]]
    #: Whether time is that of the clock, as for threads, where work is divided and not added.
    has_wall_time: bool = False


def _run(scene: Path, *options: str) -> list[str]:
    return ["-m", "aomc_sky", "run", str(scene), "--quiet", "--force", *options]


def _dropped(work: Path, *options: str) -> list[str]:
    return _run(scene_of(work, *GRID, 1), "--format", "raw", "--out", "-", *options)


def _stored(work: Path, scene: Path, *options: str) -> list[str]:
    return _run(scene, "--out", str(work / "out"), *options)


def _patches(n: int, work: Path) -> list[str]:
    n_zenith = {100: 10, 1000: 20, 10_000: 100, 100_000: 250, 1_000_000: 1000}[n]
    return _stored(work, scene_of(work, n_zenith, n // n_zenith, 1), "--iterations", "100000")


ROWS = {
    "photons": Row(
        title="photons",
        unit="photon",
        rest="one waveband, 32 400 patches",
        steps=(10**5, 10**6, 10**7, 10**8, 10**9, 10**10),
        command=lambda n, work: _dropped(work, "--iterations", str(n)),
    ),
    "patches": Row(
        title="patches of a table",
        unit="patch",
        rest="one waveband, 1e5 photons",
        steps=(10**2, 10**3, 10**4, 10**5, 10**6),
        command=_patches,
    ),
    "wavebands": Row(
        title="wavebands, each with its table",
        unit="waveband",
        rest="360 patches, 1000 photons each",
        steps=(1, 10, 100, 500, 2000),
        command=lambda n, work: ["-c", _BANDS, str(work / "out"), str(n)],
    ),
    "shards": Row(
        title="shards",
        unit="shard",
        rest="1e7 photons, 32 400 patches",
        steps=(1, 10, 100, 1000),
        command=lambda n, work: ["-c", _SHARDS, str(scene_of(work, *GRID, 1)), str(work / "out"), str(n)],
    ),
    "threads": Row(
        title="threads",
        unit="thread",
        rest="3e8 photons, time by the clock",
        steps=tuple(n for n in (1, 2, 4, 8, 16, 32, 64) if n <= (os.cpu_count() or 1)),
        command=lambda n, work: _dropped(work, "--iterations", "300000000", "--threads", str(n)),
        has_wall_time=True,
    ),
}


def scene_of(work: Path, n_zenith: int, n_azimuth: int, n_bands: int) -> Path:
    """The folder of a scene with a table of so many patches for each waveband; a process of its own writes it once."""
    folder = work / f"scene-{n_zenith}-{n_azimuth}-{n_bands}"
    if not folder.is_dir():
        folder.mkdir()
        words = [str(ROOT / "inputs"), str(folder), *map(str, (n_zenith, n_azimuth, n_bands))]
        subprocess.run([sys.executable, "-c", _SCENE, *words], check=True)
    return folder


@dataclass(frozen=True, kw_only=True, slots=True)
class Cost:
    """What a process took."""

    processor_s: float
    wall_s: float
    peak_mb: float


def cost_of(command: list[str], work: Path) -> Cost:
    """Run a command of this Python; standard output is dropped."""
    shutil.rmtree(work / "out", ignore_errors=True)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(work / "numba"), "PYTHONPYCACHEPREFIX": str(work / "pycache")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile() as err:
        start = time.perf_counter()
        process = subprocess.Popen([sys.executable, *command], env=environment, stdout=subprocess.DEVNULL, stderr=err)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        err.seek(0)
        if process.returncode:
            raise SystemExit(f"{command} ended with {process.returncode}:\n{err.read().decode(errors='replace')}")
    kilobytes = usage.ru_maxrss / (1024 if sys.platform == "darwin" else 1)
    return Cost(processor_s=usage.ru_utime + usage.ru_stime, wall_s=wall, peak_mb=kilobytes / 1024)


def measured(names: list[str], work: Path, *, is_small: bool) -> Iterator[dict[str, str]]:
    """Lines of the table; a turn that does not count comes first and compiles."""
    for name in names:
        row = ROWS[name]
        cost_of(row.command(row.steps[min(2, len(row.steps) - 1)], work), work)
        for n in row.steps[: 3 if is_small else None]:
            costs = [cost_of(row.command(n, work), work)]
            while len(costs) < TURNS and costs[0].processor_s < LONG_S:
                costs.append(cost_of(row.command(n, work), work))
            middle = {part: statistics.median(getattr(c, part) for c in costs) for part in COLUMNS[3:]}
            line = {"row": name, "n": str(n), "turns": str(len(costs)), **{k: f"{v:.4g}" for k, v in middle.items()}}
            print(*(f"{line[column]:>12}" for column in COLUMNS), flush=True)
            yield line


def draw(lines: list[dict[str, str]], path: Path) -> None:
    """A column for what grows: time for each above, peak memory below; grey is linear growth."""
    from matplotlib.figure import Figure

    from aomc_sky.outputs.picture import picture_path, save_picture

    names = [name for name in ROWS if any(line["row"] == name for line in lines)]
    figure = Figure(figsize=(2.35 * len(names) + 0.3, 4.9), layout="constrained")
    panels = figure.subplots(2, len(names), squeeze=False, sharex="col")
    for column, name in zip(panels.T, names, strict=True):
        own = [line for line in lines if line["row"] == name]
        n = [int(line["n"]) for line in own]
        taken = [float(line["wall_s" if ROWS[name].has_wall_time else "processor_s"]) for line in own]
        _draw_time(column[0], ROWS[name], n, taken)
        _draw_memory(column[1], ROWS[name], n, [float(line["peak_mb"]) for line in own])
    panels[0, 0].set_ylabel("time for each")
    panels[1, 0].set_ylabel("peak memory of the process [MB]")
    save_picture(figure, picture_path(path), dpi=130)


def _draw_time(panel, row: Row, n: list[int], taken: list[float]) -> None:  # type: ignore[no-untyped-def]
    """Time for each; of threads the product of time and threads, which is constant where they do not wait."""
    each = [t * k if row.has_wall_time else t / k for t, k in zip(taken, n, strict=True)]
    panel.set_title(f"{row.title}\n", fontsize=9, loc="left")
    panel.text(0, 1.03, row.rest, transform=panel.transAxes, fontsize=7, color="#777777")
    panel.axhline(min(each), color="#aaaaaa", linewidth=1.0, linestyle="--", zorder=0)
    panel.plot(n, each, "o-", color="#0072B2", markersize=4, linewidth=1.5)
    panel.set(xscale="log", yscale="log")
    low, high = min(each), max(each)
    panel.set_ylim(low / (high / low) ** 0.25 / 1.3, high * (high / low) ** 0.15 * 1.3)
    for k, side in ((0, "left"), (-1, "right")):
        words = "threads x time" if row.has_wall_time else f"a {row.unit}"
        text = f"{_seconds(each[k])}" + (f"\n{words}" if k else "")
        above = each[k] >= low * 1.02
        panel.annotate(
            text,
            (n[k], each[k]),
            (0, 6 if above else -6),
            textcoords="offset points",
            fontsize=7,
            color="#0072B2",
            ha=side,
            va="bottom" if above else "top",
        )
    _clean(panel)


def _draw_memory(panel, row: Row, n: list[int], peak: list[float]) -> None:  # type: ignore[no-untyped-def]
    """Peak memory, and what each further one takes at the end."""
    panel.plot(n, peak, "s-", color="#D55E00", markersize=4, linewidth=1.5)
    byte = 2**20 * (peak[-1] - peak[0]) / max(n[-1] - n[0], 1)
    grows = byte * (n[-1] - n[0]) > 2**20 * 0.05 * peak[0]
    if len(n) > 2 and grows and byte > 1:  # linear growth up to the point before the last, and on
        slope = max((peak[-2] - peak[0]) / (n[-2] - n[0]), 0.0)
        panel.plot(n, [peak[0] + slope * (k - n[0]) for k in n], "--", color="#aaaaaa", linewidth=1.0, zorder=0)
    panel.set(xscale="log", yscale="log", ylim=(20, 2000))
    each = f"{_bytes(byte)} a {row.unit}" if grows else "does not grow"
    panel.annotate(
        f"{peak[-1]:.0f} MB\n{each}",
        (n[-1], peak[-1]),
        (0, 6),
        textcoords="offset points",
        fontsize=7,
        color="#D55E00",
        ha="right",
        va="bottom",
    )
    panel.set_xlabel(f"{row.title.split(',')[0].split(' of ')[0]}", fontsize=8)
    _clean(panel)


def _clean(panel) -> None:  # type: ignore[no-untyped-def]
    panel.minorticks_off()
    panel.tick_params(labelsize=7, colors="#666666")
    panel.spines[["top", "right"]].set_visible(False)
    panel.spines[["left", "bottom"]].set_color("#999999")
    panel.margins(x=0.08)
    if panel.lines[-1].get_xdata()[-1] <= _FEW:  # threads
        panel.set_xticks([2**k for k in range(7)], [f"{2**k}" for k in range(7)])
        panel.set_xlim(0.85, 1.2 * panel.lines[-1].get_xdata()[-1])


_FEW = 64


def _scaled(value: float, steps: tuple[tuple[float, str], ...]) -> str:
    size, unit = next((s for s in steps if value >= s[0]), steps[-1])
    return f"{value / size:.2g} {unit}" if value / size < 10 else f"{value / size:.0f} {unit}"


def _seconds(value: float) -> str:
    return _scaled(value, ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")))


def _bytes(value: float) -> str:
    return _scaled(value, ((2.0**20, "MB"), (2.0**10, "kB"), (1.0, "B")))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=list(ROWS), metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--small", action="store_true", help="the first three points of each row")
    parser.add_argument("--redraw", action="store_true", help="the picture from the numbers that are there")
    parser.add_argument(
        "--out", type=Path, default=Path("growth.csv"), metavar="FILE", help="the numbers; the picture ends in .png"
    )
    arguments = parser.parse_args()
    if not arguments.redraw:
        work = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
        try:
            lines = list(measured(arguments.rows, work, is_small=arguments.small))
        finally:
            shutil.rmtree(work)
        with arguments.out.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(lines)
    with arguments.out.open() as file:
        draw(list(csv.DictReader(file)), arguments.out.with_suffix(".png"))


if __name__ == "__main__":
    main()
