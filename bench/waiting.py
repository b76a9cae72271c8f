"""What a person waits for, and photons in memory: one table, each row beside its peers and beside what limits it.

    python bench/waiting.py [--turns 5] [--rows run write-npy ...]
    python bench/waiting.py --before ../other/src               # both trees, turn and turn about

Every measurement is a process of its own (the photons of `bench/waiting_probes.py` share one), and trees and peers take
turns. Seconds are processor time, user and system, which other work on the machine changes least; rows of threads are
wall-clock. Files go to memory where there is /dev/shm. Printed are medians over the turns.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench.harness import machine
from bench.waiting_probes import write_fine_table

HERE = Path(__file__).resolve().parent
INPUTS = HERE.parent / "inputs"
TABLE = str(INPUTS / "clear_day" / "amc.inp")
MEMORY = "/dev/shm"
PROBES = str(HERE / "waiting_probes.py")
N_BANDS = 3
MCPL_BYTES, NPY_BYTES = 36, 12

Values = dict[str, float]
"""By what was measured, in the order of the table."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tree:
    """A version of the package, and where its processes keep what they compile and write."""

    #: The folder that holds the package; None: what every process finds by itself.
    source: Path | None
    work: Path

    def seconds(self, *command: str, **environment: str) -> float:
        """Processor time of a command. [s]"""
        return self._measured(command, environment)[0]

    def run(self, *options: str, out: str, **environment: str) -> float:
        """Processor time of `aomc-sky run` of a table scene. [s]"""
        shutil.rmtree(self.work / out, ignore_errors=True)
        options = ("run", TABLE, *options, "--out", str(self.work / out), "--quiet")
        return self.seconds("-m", "aomc_sky", *options, **environment)

    def probe(self, name: str, *arguments: str, **environment: str) -> Values:
        """What a function of `waiting_probes.py` measures."""
        values: Values = json.loads(self._measured((PROBES, name, *arguments), environment)[1])
        return values

    def fresh(self, name: str) -> str:
        """An empty folder."""
        shutil.rmtree(self.work / name, ignore_errors=True)
        (self.work / name).mkdir()
        return str(self.work / name)

    def _measured(self, command: tuple[str, ...], changes: dict[str, str]) -> tuple[float, str]:
        caches = {"NUMBA_CACHE_DIR": "numba", "XDG_CACHE_HOME": "xdg", "PYTHONPYCACHEPREFIX": "pycache"}
        caches |= {"MPLCONFIGDIR": "matplotlib"}  # its list of fonts: half a second of the first picture on a machine
        environment = {**os.environ, **{name: str(self.work / folder) for name, folder in caches.items()}, **changes}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # where it is set, every start compiles the package's text
        if self.source is not None:
            environment["PYTHONPATH"] = str(self.source)
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            process = subprocess.Popen([sys.executable, *command], env=environment, stdout=out, stderr=err)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            texts = []
            for file in (out, err):
                file.seek(0)
                texts.append(file.read().decode(errors="replace"))
        if process.returncode:
            raise SystemExit(f"{' '.join(command)} ended with {process.returncode}:\n{texts[1]}")
        return usage.ru_utime + usage.ru_stime, texts[0]


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """One line of the table."""

    #: For a person.
    what: str
    #: What the figures are, and the same figures that we want.
    unit: str
    aim: str
    #: Figures of a tree.
    ours: Callable[[Tree], Values]
    #: Figures that depend on no tree: what others take, and what no program can be faster than.
    peers: Callable[[Tree], Values] = field(default=lambda tree: {})
    #: One turn that does not count comes first: it compiles.
    warm_up: bool = True


def _small_run(tree: Tree) -> Values:
    return {"": tree.run("--iterations", "100000", out="small")}


def _imports(tree: Tree) -> Values:
    return {f"import {name}": tree.seconds("-c", f"import {name}") for name in ("numpy", "numba")}


def _first_kernels(tree: Tree, kind: str) -> Values:
    return tree.probe("first_kernels", kind, NUMBA_CACHE_DIR=tree.fresh("empty"))


def _plot(tree: Tree, scene: str) -> Values:
    cache, picture = tree.fresh("xdg-empty"), str(tree.work / "sky.png")
    command = ("-m", "aomc_sky", "plot", str(INPUTS / scene), "--out", picture)
    times: Values = {}
    for turn in ("first", "again"):
        Path(picture).unlink(missing_ok=True)
        times[turn] = tree.seconds(*command, XDG_CACHE_HOME=cache)
    return times


def _written(tree: Tree, form: str) -> Values:
    taken = tree.run("--iterations", "20000000", "--format", form, out="written")
    tree.fresh("written")
    return {"": taken}


def _stored_bytes(tree: Tree, n_bytes: int) -> Values:
    return tree.probe("stored_bytes", str(n_bytes), str(tree.work))


def _shared_out(tree: Tree) -> Values:
    return tree.probe("shared_out", str(_fine_folder(tree)))


def _other_readers(tree: Tree) -> Values:
    return tree.probe("other_readers", str(_fine_folder(tree) / "skydist.inp"))


def _fine_folder(tree: Tree) -> Path:
    folder = tree.work / "fine"
    if not folder.is_dir():
        folder.mkdir()
        write_fine_table(folder)
    return folder


def _verified(tree: Tree) -> Values:
    """A run that is made once, and verified."""
    run = tree.work / "verified"
    if not run.is_dir():
        tree.run("--iterations", "33333334", out=run.name)
    return {"": tree.seconds("-m", "aomc_sky", "verify", str(run))}


def _hashed(tree: Tree) -> Values:
    return tree.probe("hashed", str(N_BANDS * 33_333_334 * NPY_BYTES))


def _of(name: str, *arguments: str) -> Callable[[Tree], Values]:
    return lambda tree: tree.probe(name, *arguments)


def _compilation(of: str, aim: str, kind: str) -> Row:
    ours = functools.partial(_first_kernels, kind=kind)
    return Row(what=f"first compilation, {of}", unit="s", aim=aim, ours=ours, warm_up=False)


ROWS = {
    "run": Row(what="`run` of 3 x 1e5 photons of a table scene", unit="s", aim="0.5", ours=_small_run, peers=_imports),
    "compile-table": _compilation("table scene", "2.5", "table"),
    "compile-perez": _compilation("Perez scene", "5", "perez"),
    "compile-host": _compilation("a numba host's first `fill`", "3", "host"),
    "plot-twilight": Row(
        what="`plot inputs/twilight`", unit="s", aim="5, then at once", ours=functools.partial(_plot, scene="twilight")
    ),
    "plot-eclipse": Row(
        what="`plot inputs/eclipse`", unit="s", aim="5, then at once", ours=functools.partial(_plot, scene="eclipse")
    ),
    "write-npy": Row(
        what="`run` of 6e7 photons into memory, npy",
        unit="s",
        aim="4",
        ours=functools.partial(_written, form="npy"),
        peers=functools.partial(_stored_bytes, n_bytes=60_000_000 * NPY_BYTES),
    ),
    "write-mcpl": Row(
        what="`run` of 6e7 photons into memory, mcpl",
        unit="s",
        aim="5",
        ours=functools.partial(_written, form="mcpl"),
        peers=functools.partial(_stored_bytes, n_bytes=60_000_000 * MCPL_BYTES),
    ),
    "read": Row(
        what="reading and sharing out 20 wavelengths x 32 400 patches",
        unit="s",
        aim="half",
        ours=_shared_out,
        peers=_other_readers,
    ),
    "shuffled": Row(
        what="shuffled float32, one thread",
        unit="ns",
        aim="3.5",
        ours=_of("photons", "shuffled"),
        peers=_of("others", "shuffled"),
    ),
    "patch": Row(
        what="patch order float32, one thread",
        unit="ns",
        aim="0.9",
        ours=_of("photons", "patch"),
        peers=_of("others", "patch"),
    ),
    "large": Row(what="shuffled, 1e6 / 4e6 patches", unit="ns", aim="20 / 30", ours=_of("large_tables")),
    "session": Row(
        what="a session that draws 3e6 photons five times, kernels cached",
        unit="ns",
        aim="60, then 10",
        ours=_of("session"),
    ),
    "host": Row(what="one photon per call in a numba loop", unit="ns", aim="13", ours=_of("host")),
    "threads": Row(what="two threads over one, in memory", unit="times", aim="1.85", ours=_of("two_threads")),
    "perez": Row(
        what="exact Perez law, shuffled, over uniform in patch", unit="times", aim="1.3", ours=_of("perez_over_uniform")
    ),
    "verify": Row(what="`verify` of 1e8 photons", unit="s", aim="10", ours=_verified, peers=_hashed),
}
"""The table, by the names that --rows takes."""


def measured(row: Row, trees: list[Tree], turns: int) -> list[Values]:
    """Medians of the figures of each tree, then those of the peers."""
    contenders = [functools.partial(row.ours, tree) for tree in trees] + [functools.partial(row.peers, trees[-1])]
    found: list[list[Values]] = [[] for _ in contenders]
    for turn in range(-1 if row.warm_up else 0, turns):
        for values, contender in zip(found, contenders, strict=True):
            figures = contender()
            if turn >= 0:
                values.append(figures)
    return [{name: statistics.median(turn[name] for turn in of) for name in of[0]} for of in found]


def line(row: Row, figures: list[Values]) -> str:
    """A line of the table."""
    *ours, peers = (", ".join(f"{name} {value:.3g}".strip() for name, value in of.items()) for of in figures)
    return f"| {' | '.join([row.what, row.unit, *ours, row.aim, peers or '-'])} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, help="the folder that holds another tree's package aomc_sky")
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=list(ROWS), metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--turns", type=int, default=5)
    options = parser.parse_args()
    named = (
        {"now": HERE.parent / "src"}
        if options.before is None
        else {
            "before": options.before.resolve(),
            "after": HERE.parent / "src",
        }
    )
    with tempfile.TemporaryDirectory(dir=MEMORY if Path(MEMORY).is_dir() else None) as folder:
        trees = [Tree(source=source, work=Path(folder) / name) for name, source in named.items()]
        for tree in trees:
            tree.work.mkdir()
        print(f"{machine()}; medians of {options.turns} turns\n")
        print(f"| what | unit | {' | '.join(named)} | aim | peers and limits |")
        print(f"| --- | --- |{' --- |' * len(named)} --- | --- |")
        for name in options.rows:
            print(line(ROWS[name], measured(ROWS[name], trees, options.turns)), flush=True)


if __name__ == "__main__":
    main()
