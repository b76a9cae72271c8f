"""Our MCPL writer against a ctypes loop over libmcpl's mcpl_add_particle: the same photons, the same bytes.

    python bench/mcpl.py [--photons 1000000] [--repeats 7]

Both start from photons in memory and end with a file; the loop gets its particles ready made and
only calls, which is the fastest form that Python has for it. Besides: `write_mcpl` with emission.
"""

from __future__ import annotations

import argparse
import statistics

from harness import machine, ratio, verdict

from bench.libmcpl import mcpl_times

BAR = 15.0


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
