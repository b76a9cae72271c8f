"""Hashes of the photons of every scene in inputs/ by every choice of sampling: did a refactoring keep the bits?

    python bench/same_bits.py --write before.json      # on one commit
    python bench/same_bits.py --compare before.json    # on another one; exit code 1 where anything differs

Stored are SHA-256 of plans, counts and photons (whole bands, a middle range, and photons far beyond 2^32), the latter
by plain numpy and by the compiled kernels, which must agree; and, of each file of tests/data/**/bad and inputs/bad,
code, line, column and width of every problem with the exit code. The wording of the messages is stored apart: it is
reported, and fails with --words alone. Where a scene is solved the bits are those of one machine and one set of
libraries, so compare on the machine that wrote. Public names and the command line alone are used: the script runs on
any commit (copy it to one that has none).

Solved skies are cut down to few patches and paths in a copy of the scene. An empty cache of compiled kernels costs
some minutes more.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import importlib.metadata
import io
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

REPOSITORY = Path(__file__).resolve().parent.parent
INPUTS, DATA = REPOSITORY / "inputs", REPOSITORY / "tests" / "data"
N_PHOTONS = 3000
MIDDLE = (1234, 2345)
MANY = 10**12
SOLVED = {
    "atmosphere_sky": "zenith_bins = 9\nazimuth_bins = 12\n",
    "twilight": "zenith_bins = 4\nazimuth_bins = 8\npaths = 64\n",
    "eclipse": "zenith_bins = 4\nazimuth_bins = 8\npaths = 64\n",
    "light_polluted": "zenith_bins = 4\nazimuth_bins = 8\npaths = 64\n",
}
"""What a solved sky is cut down to."""
BACKGROUND = '\n[[background]]\nfile = "night.h5"\ntime = 2026-02-14T21:30:00Z\nutc_offset = 1\n'
IRRADIANCE = "\n[sky]\ndiffuse_irradiance = [0.2, 0.3, 0.3, 0.2]\ndirect_irradiance = [0.5, 0.7, 0.8, 0.7]\n"
READ: dict[str, tuple[str, dict[str, Any]]] = {
    **{path.parent.name: (path.parent.name, {}) for path in sorted(INPUTS.glob("*/amc.inp"))},
    "sparse_sky, degrees": ("sparse_sky", {"bins": "degrees"}),
    "document_example, weights": ("document_example", {"bins": "degrees", "weighting": "aomc"}),
    "clear_day, solid angle": ("clear_day", {"weighting": "solid-angle"}),
    "overcast, projected": ("overcast", {"weighting": "projected"}),
    "overcast, perez": ("overcast", {"sky": "perez", "perez": {"epsilon": 2.5, "delta": 0.2}}),
    "sparse_sky, compat": ("sparse_sky", {"compat": "aomc"}),
    "sun_and_sky, compat": ("sun_and_sky", {"compat": "aomc"}),
    "sun_and_sky, uniform": ("sun_and_sky", {"sky": "uniform"}),
    "sun_and_sky, cells": ("sun_and_sky", {"within": "uniform", "sun": {"zenith_deg": 71.5}}),
    "perez_sky, parallel": ("perez_sky", {"sun": {"disc": False}}),
    "perez and lobes": ("perez_lobes", {}),
    "atmosphere and lobes": ("atmosphere_lobes", {}),
    "clear_day, many": ("clear_day", {"iterations": MANY}),
    "perez_sky, many": ("perez_sky", {"iterations": MANY}),
    "night_sky, many": ("night_sky", {"iterations": MANY}),
}
"""Scenes: the folder, and how it is read."""
PLACES = ({"placement": "r2"}, {"placement": "philox"}, {"placement": "centre"}, {"method": "iid"})
OPTIONS: list[dict[str, Any]] = [
    *({**place, "order": order} for place, order in itertools.product(PLACES, ("shuffled", "patch"))),
    {"allocation": "largest-remainder"},
    {"weights": True},
    {"replicates": 3},
    {"seed": 2**63 + 11, "replicates": 2, "method": "iid"},
]
RARE = {
    "float32": ("placement centre, order patch", "placement philox, order patch", "method iid, order patch"),
    "float64": ("placement centre, order shuffled", "placement philox, order shuffled", "method iid, order shuffled"),
}
"""What the kernels are not compiled for, unless --all asks for it."""
COMPAT_OPTIONS: list[dict[str, Any]] = [{}, {"weights": True}]
"""How a scene is sampled, each in both precisions."""
PLACE = re.compile(r"(?P<path>[^\s:]+)(?::(?P<line>\d+):(?P<column>\d+))?: (?P<kind>error|warning)\[(?P<code>E\d+)\]")

Found = dict[str, dict[str, str]]


def made_scenes(folder: Path) -> None:
    """Copy the scenes; solved skies are cut down, and two get the light of lobes besides."""
    for path in sorted(INPUTS.glob("*/amc.inp")):
        shutil.copytree(path.parent, folder / path.parent.name)
    for name, keys in SOLVED.items():
        toml = folder / name / "sky.toml"
        kept = [line for line in toml.read_text().splitlines() if not line.startswith(("zenith_bins", "azimuth_bins"))]
        toml.write_text("\n".join(kept).replace("[atmosphere]\n", f"[atmosphere]\n{keys}") + "\n")
    for name, base in (("perez_lobes", "perez_sky"), ("atmosphere_lobes", "atmosphere_sky")):
        shutil.copytree(folder / base, folder / name)
        shutil.copy(INPUTS / "night_sky" / "night.h5", folder / name)
        units = "" if name == "atmosphere_lobes" else IRRADIANCE
        with (folder / name / "sky.toml").open("a") as file:
            file.write(units + BACKGROUND)


def make_plans(folder: Path) -> Found:
    """Settle every plan, store it for the other processes, and hash it."""
    import aomc_sky as sky

    plans, counts, files = {}, {}, {}
    made_scenes(folder / "scenes")
    for scene_name, (scene_folder, reading) in READ.items():
        scene = sky.read_scene(folder / "scenes" / scene_folder, **{"iterations": N_PHOTONS, **reading})
        many = COMPAT_OPTIONS if "compat" in reading else OPTIONS[: 2 if "iterations" in reading else None]
        for options, precision in itertools.product(many, ("float32", "float64")):
            name = f"{scene_name}: {', '.join([precision, *(f'{key} {value}' for key, value in options.items())])}"
            try:
                source = scene.source(**{"seed": 5, **options}, precision=precision)
            except sky.AomcSkyError as refusal:  # a lobe has no centre
                plans[name] = type(refusal).__name__
                continue
            files[name] = f"{len(plans)}.npz"
            source.plan.save(folder / files[name])
            plans[name] = source.plan.sha256
            counts[name] = hashlib.sha256(source.counts.tobytes()).hexdigest()
    (folder / "files.json").write_text(json.dumps(files))
    return {"plans": plans, "counts": counts}


def _ranges(n: int) -> Iterator[tuple[int, int]]:
    if n > 10 * N_PHOTONS:
        yield from ((0, 1000), (n // 2 - 100, n // 2 + 2500), (n - 500, n))
    else:
        yield from ((0, n), (min(MIDDLE[0], n), min(MIDDLE[1], n)), (n // 2, min(n // 2 + 1, n)))


def photons_of(plan_path: Path) -> str:
    """One hash of the photons of all bands of a stored plan."""
    import aomc_sky as sky

    source = sky.PhotonSource.from_plan(sky.Plan.load(plan_path))
    digest = hashlib.sha256()
    for band in range(source.n_bands):
        for start, stop in _ranges(source.n_photons(band)):
            batch = source.photons(band, start, stop)
            for name in ("ux", "uy", "uz", "patch", "x", "y", "weight"):
                array = getattr(batch, name)
                digest.update(f"{name} {None if array is None else array.dtype.str} {len(batch)}".encode())
                if array is not None:
                    digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def load_kernels() -> None:
    """Ask for more photons than a process makes in plain numpy."""
    import aomc_sky as sky

    source = sky.read_scene(INPUTS / "clear_day", iterations=30_000_000).source()
    for _ in range(3):
        source.photons(0, 0, 10_100_000)
    assert "llvmlite" in sys.modules, "so many photons no longer come from the kernels"


def make_photons(folder: Path, precision: str, *, compiled: bool, every: bool = True) -> Found:
    """Hash the photons of the stored plans, by one of the two ways; so few come from plain numpy by themselves."""
    if compiled:
        load_kernels()
    files = json.loads((folder / "files.json").read_text())
    chosen = [name for name in files if f": {precision}" in name and (every or not name.endswith(RARE[precision]))]
    hashes = {name: photons_of(folder / files[name]) for name in chosen}
    return {"compiled" if compiled else "plain": hashes}


def _commands(folder: Path) -> Iterator[tuple[str, Path, list[str]]]:
    """Each bad file: its name, the folder to stand in, and the command that reads it."""
    for number, path in enumerate(sorted([*DATA.glob("*/bad/*"), *(INPUTS / "bad").iterdir()])):
        kind = path.parents[1].name
        if path.suffix in (".expected", ".md") or path.is_dir():
            continue
        name = path.relative_to(REPOSITORY).as_posix()
        if kind in ("amc", "lambbot", "difcol", "skydist", "sky_toml"):
            beside = folder / str(number)
            beside.mkdir()
            if kind not in ("amc", "skydist"):
                shutil.copy(INPUTS / "beam_only" / "amc.inp", beside)  # two wavebands
            copy = beside / (f"{kind}.inp" if path.suffix == ".inp" else "sky.toml")
            shutil.copy(path, copy)
            yield name, beside, ["validate", copy.name]
            yield f"{name} --lenient", beside, ["validate", "--lenient", copy.name]
        elif kind == "weather":
            weather = f"--{path.name.partition('_')[0]}"
            yield name, path.parent, ["perez", weather, path.name, "--row", "12"]
        elif kind == "photons_npy":
            yield (
                name,
                path.parent,
                ["verify", path.name, "--scene", str(INPUTS / "beam_only"), "--waveband", "1", "--seed", "1"],
            )
        else:
            yield name, path.parent, ["validate", path.name]


def _spans(text: str) -> str:
    """Code, line, column and width of each problem of an output."""
    found, lines = [], text.splitlines()
    for number, line in enumerate(lines):
        place = PLACE.match(line)
        if place is None:
            continue
        caret = lines[number + 2].count("^", 8) if number + 2 < len(lines) and "| " in lines[number + 2] else 0
        found.append(f"{place['kind']} {place['code']} {place['line'] or 0}:{place['column'] or 0} +{caret}")
    return "; ".join(found)


def make_errors(folder: Path) -> Found:
    """Read every bad file by the command line, in this process."""
    (program,) = importlib.metadata.entry_points(group="console_scripts", name="aomc-sky")
    main, errors, words = program.load(), {}, {}
    for name, where, command in _commands(folder):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.chdir(where), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = main(command)
            except SystemExit as left:
                code = left.code
        text = (out.getvalue() + err.getvalue()).replace(f"{REPOSITORY}/", "")
        errors[name] = f"exit {code}: {_spans(text)}"
        words[name] = text
    return {"errors": errors, "words": words}


LEGS = {
    "plans": make_plans,
    "errors": make_errors,
    **{f"plain {p}": partial(make_photons, precision=p, compiled=False) for p in RARE},
    **{f"compiled {p}": partial(make_photons, precision=p, compiled=True, every=False) for p in RARE},
    **{f"compiled {p}, every one": partial(make_photons, precision=p, compiled=True) for p in RARE},
}


def _legs(way: str, *, every: bool) -> tuple[str, ...]:
    ending = ", every one" if way == "compiled" and every else ""
    return tuple(f"{way} {precision}{ending}" for precision in RARE)


def measured(ways: list[str], *, every: bool) -> Found:
    """Everything that is compared, each part made in a process of its own."""
    result: Found = {}
    turns = [("plans", "errors"), *(_legs(way, every=every) for way in ways)]
    with tempfile.TemporaryDirectory() as name:
        for turn in turns:
            began = time.perf_counter()
            running = {}
            for leg in turn:
                (folder := Path(name) / "errors" if leg == "errors" else Path(name)).mkdir(exist_ok=True)
                command = [sys.executable, __file__, "--leg", leg, str(folder), f"{name}/{leg}.json"]
                running[leg] = subprocess.Popen(command, env={**os.environ, "PYTHONHASHSEED": "0"})
            for leg, process in running.items():
                if process.wait() != 0:
                    raise SystemExit(f"{leg}: failed")
                for group, found in json.loads(Path(f"{name}/{leg}.json").read_text()).items():
                    result.setdefault(group, {}).update(found)
            print(f"{' and '.join(turn)}: {time.perf_counter() - began:.0f} s", file=sys.stderr)
    return result


def differences(group: str, before: dict[str, str], after: dict[str, str]) -> int:
    """Print and count the names that were measured now and whose values are not the same, or were absent."""
    names = [name for name in after if before.get(name) != after[name]]
    for name in names:
        width = None if group in ("errors", "words") else 16
        print(f"{group}: {name}\n  - {before.get(name, 'absent')[:width]}\n  + {after[name][:width]}")
    gone = [name for name in before if name not in after] if group != "compiled" else []
    print(*(f"{group}: {name} is gone" for name in gone), sep="\n", end="\n" if gone else "")
    print(f"{group}: {len(after)} compared, {len(names)} differ, {len(gone)} gone")
    return len(names) + len(gone)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", type=Path, metavar="FILE.json", help="store what was found")
    parser.add_argument("--compare", type=Path, metavar="FILE.json", help="compare with what was stored")
    parser.add_argument("--words", action="store_true", help="other words of a message fail too")
    parser.add_argument("--plain", action="store_true", help="leave the compiled kernels out: a minute less or ten")
    parser.add_argument("--all", action="store_true", help="compile the kernels for every choice, not for most")
    parser.add_argument("--leg", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.leg:
        leg, folder, path = arguments.leg
        warnings.simplefilter("ignore")
        Path(path).write_text(json.dumps(LEGS[leg](Path(folder))))  # type: ignore[operator]
        return 0
    ways = ["plain", *([] if arguments.plain else ["compiled"])]
    found = measured(ways, every=arguments.all)
    for group, hashes in found.items():
        whole = hashlib.sha256(json.dumps(hashes, sort_keys=True).encode()).hexdigest()
        print(f"{group}: {len(hashes)}, together {whole[:16]}")
    failed = 0
    if "compiled" in found:
        plain = {name: found["plain"][name] for name in found["compiled"]}
        failed += differences("plain numpy and compiled", plain, found["compiled"])
    if arguments.write:
        arguments.write.write_text(json.dumps(found, indent=1, sort_keys=True))
    if arguments.compare:
        before = json.loads(arguments.compare.read_text())
        differ = {group: differences(group, before.get(group, {}), hashes) for group, hashes in found.items()}
        failed += sum(differ.values()) - (0 if arguments.words else differ["words"])
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
