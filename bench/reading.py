"""Reading a sky file of 641 000 lines against numpy.loadtxt on the same file.

python bench/reading.py [--repeats 5]
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from pathlib import Path

import numpy as np
from harness import in_turns, machine, ratio, verdict

import aomc_sky as sky

BAR = 1.3
N_WAVELENGTHS, N_ZENITH, N_COLUMNS = 20, 89, 360


def write_table(path: Path) -> int:
    """A full table with values of five digits; returns its number of data lines."""
    values = np.random.default_rng(1).lognormal(size=(N_WAVELENGTHS, N_ZENITH, N_COLUMNS))
    indices = np.indices(values.shape).reshape(3, -1).T
    with path.open("w") as file:
        file.write(f"{values.size} {N_ZENITH} {N_COLUMNS - 1} {N_WAVELENGTHS}\n")
        file.write(" ".join(f"{400 + 15 * k}" for k in range(N_WAVELENGTHS)) + "\n")
        rows = zip(indices.tolist(), values.ravel().tolist(), strict=True)
        file.writelines(f"{w + 1} {z + 1} {a} {v:.5g}\n" for (w, z, a), v in rows)
    return values.size


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "skydist.inp"
        n_lines = write_table(path)
        table, plain = sky.read_skydist(path), np.loadtxt(path, skiprows=2)
        if np.any(table.radiance[tuple((plain[:, :3] - [1, 1, 0]).astype(int).T)] != plain[:, 3]):
            raise SystemExit("the two readers disagree")
        contenders = {
            "read_skydist": lambda: sky.read_skydist(path),
            "numpy.loadtxt": lambda: np.loadtxt(path, skiprows=2),
        }
        times = in_turns(contenders, options.repeats)
        print(machine())
        print(f"{n_lines} lines, {path.stat().st_size / 1e6:.1f} MB, median of {options.repeats} turns")
    for name, taken in times.items():
        print(f"  {name:15s} {statistics.median(taken):7.3f} s")
    print(f"  read_skydist / numpy.loadtxt {verdict(ratio(*times.values()), BAR, at_least=False)}")


if __name__ == "__main__":
    main()
