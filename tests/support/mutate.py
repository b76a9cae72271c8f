"""Mutants of the numerical files, and which tests fail on them: what the suite would not see.

    python -m tests.support.mutate --n 120 --seed 1          # random ones
    python -m tests.support.mutate --at grid.py:71           # all of a line

A numerical file has ten lines or fewer for each operator of arithmetic or order, and is in no room that shows or writes
(`NO_NUMBERS`). A mutation (`mutations.py`) is made in a copy of src, never in the working tree.

The package `coverage` finds out which tests run which line, once for each file of tests, and again where this file or
src has changed. A line that runs at import belongs to the tests that run a line with a name that it defines. Tests run
without the JIT, and only those of kernels take their photons from kernels. Those of the mirrored folder come first, and
those that run little else, for `--seconds` in all.

The map leaves out tests that fail, those that take more than `TEST_SECONDS`, and those of a file after `FILE_SECONDS`.
A mutant that takes longer than `MUTANT_SECONDS` is killed. These are seconds of a processor: other work does no harm.
"""

import argparse
import ast
import contextlib
import hashlib
import importlib.util
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from tests.support.mutations import mutations

REPOSITORY = Path(__file__).resolve().parents[2]
SOURCE = REPOSITORY / "src"
PACKAGE = SOURCE / "aomc_sky"
NO_NUMBERS = {"cli", "engine", "outputs", "pictures"}
TESTS = "ground phase kernels plan skies formats emission source verify conformance golden faults"
TEST_SECONDS, FILE_SECONDS, MUTANT_SECONDS, MEMORY_BYTES = 4, 40, 60, 2**33
_NUMBERS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Mod, ast.FloorDiv, ast.Pow, ast.Lt, ast.LtE, ast.Gt, ast.GtE)
_BLOCKS = (ast.FunctionDef, ast.ClassDef, ast.If, ast.For, ast.While, ast.With, ast.Try)
_WITHOUT = ("-p", "no:randomly", "-p", "no:xdist", "-p", "no:cacheprovider")
_FORK = multiprocessing.get_context("fork")


def room_of(path):
    parts = path.split("/")
    return "ground" if len(parts) == 1 else "/".join(parts[:2] if parts[0] == "skies" and len(parts) > 2 else parts[:1])


def numerical_files():
    for path in sorted(PACKAGE.rglob("*.py")):
        name, text = path.relative_to(PACKAGE).as_posix(), path.read_text()
        n = sum(isinstance(node, _NUMBERS) for node in ast.walk(ast.parse(text)))
        if room_of(name) not in NO_NUMBERS and 10 * n >= text.count("\n"):
            yield name


# Tests run in forked processes, whose parent has loaded what does not change.


class _Watch:
    """A plugin of pytest that notes which tests pass, in how many seconds, and the first that fails."""

    def __init__(self, coverage=None, order=()):
        self.coverage, self.order = coverage, {name: k for k, name in enumerate(order)}
        self.seconds, self.failed = {}, ""

    def pytest_runtest_logreport(self, report):
        if report.when == "call" and report.passed:
            self.seconds[report.nodeid] = time.process_time() - self.began
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_collectreport(self, report):
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_collection_finish(self, session):
        session.items.sort(key=lambda item: self.order.get(item.nodeid, 0))

    def pytest_runtest_setup(self, item):
        self.began = time.process_time()
        if self.coverage:
            self.coverage.switch_context(item.nodeid)
            signal.signal(signal.SIGPROF, _too_long)
            signal.setitimer(signal.ITIMER_PROF, TEST_SECONDS, 1)
            item.session.shouldstop = self.began > FILE_SECONDS and "enough"

    def pytest_runtest_call(self, item):
        if "kernels" not in item.path.parts:  # photons by plain numpy, as with the JIT, unless a test asks for kernels
            importlib.import_module("aomc_sky.kernels.backend")._done = 0

    def pytest_runtest_teardown(self):
        signal.setitimer(signal.ITIMER_PROF, 0)


def _too_long(*_):
    raise TimeoutError


def _pytest(source, words, watch):
    import pytest

    os.environ["PYTHONPATH"] = str(source)
    sys.path.insert(0, str(source))
    with open(os.devnull, "w") as nowhere:
        for stream in (1, 2):
            os.dup2(nowhere.fileno(), stream)
    code = pytest.main(["-q", *_WITHOUT, *words], [watch])
    assert Path(sys.modules["aomc_sky"].__file__).is_relative_to(source)
    return int(code)


def _in_child(target, arguments, seconds):
    """Run a function in a forked process, for so many seconds of a processor; its exit code."""
    child = _FORK.Process(target=_begin, args=(target, arguments, seconds))
    child.start()
    child.join(10 * seconds)  # one that waits for what never comes uses no processor
    code = child.exitcode
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    child.join()
    return code


def _begin(target, arguments, seconds):
    os.setsid()
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    target(*arguments)


def _map_file(test_file, out):
    """Seconds of each test of a file, and the tests of each line of the package, as JSON."""
    import coverage

    cov = coverage.Coverage(data_file=None, source=[str(PACKAGE)], config_file=False)
    watch = _Watch(cov)
    cov.start()
    _pytest(SOURCE, [str(test_file)], watch)
    cov.stop()
    data, lines, index = cov.get_data(), {}, {name: k for k, name in enumerate(watch.seconds)}
    for path in data.measured_files():
        by_line = {n: [index[c] for c in found if c in index] for n, found in data.contexts_by_lineno(path).items()}
        lines[Path(path).relative_to(PACKAGE).as_posix()] = {n: tests for n, tests in by_line.items() if tests}
    part = out.with_suffix(".part")
    part.write_text(json.dumps({"seconds": watch.seconds, "lines": lines}))
    part.replace(out)


def _load_package():
    """For all maps: what runs at import is in none of them."""
    sys.path.insert(0, str(SOURCE))
    for path in PACKAGE.rglob("*.py"):
        if path.stem != "__main__":
            with contextlib.suppress(ImportError):  # of an extra
                importlib.import_module(
                    ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")
                )


def _map_in_child(pair):
    _in_child(_map_file, pair, 4 * FILE_SECONDS)
    print(f"# map of {pair[0].relative_to(REPOSITORY)}", file=sys.stderr, flush=True)


class Lines:
    """Which tests run a line, by one map for each file of tests."""

    def __init__(self, folder, test_files, jobs):
        folder.mkdir(parents=True, exist_ok=True)
        self.seconds, self.width, self.tests = {}, Counter(), defaultdict(lambda: defaultdict(list))
        self.texts = {path.relative_to(PACKAGE).as_posix(): path.read_text() for path in sorted(PACKAGE.rglob("*.py"))}
        source = hashlib.sha256("".join(self.texts.values()).encode()).digest()
        maps = {}
        for path in test_files:
            key = hashlib.sha256(
                source + path.relative_to(REPOSITORY).as_posix().encode() + path.read_bytes()
            ).hexdigest()
            maps[path] = folder / f"{key[:16]}.json"
        with ProcessPoolExecutor(jobs, _FORK, _load_package) as pool:
            list(pool.map(_map_in_child, [pair for pair in maps.items() if not pair[1].exists()]))
        for out in maps.values():
            self._add(**json.loads(out.read_text() if out.exists() else '{"seconds": {}, "lines": {}}'))

    def _add(self, seconds, lines):
        names = list(seconds)
        self.seconds |= seconds
        for path, by_line in lines.items():
            for line, tests in by_line.items():
                self.width.update(names[k] for k in tests)
                self.tests[path][int(line)].extend(names[k] for k in tests)

    def of(self, mutation, limit_s):
        """The tests for a mutation, as many as the limit of time allows, and how many run its line."""
        by_line, (statement, is_import) = (
            self.tests[mutation.path],
            _statement(self.texts[mutation.path], mutation.line),
        )
        found = {test for line in range(mutation.line, mutation.end_line + 1) for test in by_line[line]}
        if not found and not isinstance(statement, _BLOCKS):
            found = {test for k in range(statement.lineno, statement.end_lineno + 1) for test in by_line[k]}
        names = {n.id for n in ast.walk(statement) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        names |= {getattr(statement, "name", "")} - {""}
        if names and is_import:
            word = re.compile(rf"\b({'|'.join(names)})\b")
            for path, text in self.texts.items():
                at = [k for k, words in enumerate(text.split("\n"), 1) if word.search(words)]
                found.update(test for k in at for test in self.tests[path][k])
        room = "tests/" + os.path.dirname(mutation.path)
        order = sorted(found, key=lambda t: (not t.startswith(room), self.width[t] * (0.05 + self.seconds[t]), t))
        chosen, files, total = [], set(), 0.0
        for test in order:
            file = test.partition("::")[0]
            total += self.seconds[test] + (file not in files)  # a file is loaded, for about a second
            if total > limit_s and chosen:
                break
            files.add(file)
            chosen.append(test)
        return chosen, len(order)


def _statement(text, line):
    """The smallest statement around a line, and whether it runs at import."""
    around = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.stmt) and n.lineno <= line <= n.end_lineno]
    is_import = not any(isinstance(n, ast.FunctionDef) and n.body[0].lineno <= line for n in around)
    return min(around, key=lambda n: n.end_lineno - n.lineno), is_import


_stamp = 1_000_000_000


def _fate(folder, mutation, tests):
    """What killed a mutant; "" where it survived."""
    global _stamp
    copy = folder / f"copy_{os.getpid()}"
    if not copy.exists():
        shutil.copytree(SOURCE, copy)
    target, report = copy / "aomc_sky" / mutation.path, folder / f"report_{os.getpid()}"
    text = target.read_text()
    report.unlink(missing_ok=True)
    for content in (mutation.applied(text), text):  # each with its own time: no .pyc of the other is taken for it
        target.write_text(content)
        os.utime(target, (_stamp := _stamp + 2, _stamp))
        if content is not text:
            code = _in_child(_test, (copy, tests, report), MUTANT_SECONDS)
    return (
        report.read_text()
        if report.exists()
        else "time"
        if code in (None, -signal.SIGXCPU, -signal.SIGKILL)
        else f"a crash ({code})"
    )


def _test(source, tests, report):
    watch = _Watch(order=tests)
    code = _pytest(source, ["-x", *tests], watch)
    report.write_text(watch.failed or (f"no start ({code})" if code else ""))


def chosen_mutations(files, n, seed):
    """Random places of the files, each as likely as another, and one of the mutations of each."""
    places = defaultdict(list)
    for name in files:
        for m in mutations(name, (PACKAGE / name).read_text()):
            places[m.path, m.start, m.end].append(m)
    rng = random.Random(seed)
    return [rng.choice(places[place]) for place in rng.sample(list(places), min(n, len(places)))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=120, help="number of mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", default="", help="how paths of files begin: grid, skies/lobes, formats/aomc/amc.py")
    parser.add_argument("--at", nargs="+", default=[], help="all mutations of lines, FILE:LINE below src/aomc_sky")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=20.0, help="time of the tests of a mutant")
    parser.add_argument(
        "--tests", nargs="+", default=[f"tests/{room}" for room in TESTS.split()], help="files and folders"
    )
    parser.add_argument("--map", type=Path, default=Path(tempfile.gettempdir()) / "aomc-sky-lines", help="a folder")
    given = parser.parse_args()
    if importlib.util.find_spec("coverage") is None:
        sys.exit("this needs coverage: pip install coverage")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    for name in ("numpy", "scipy.special", "numba", "mpmath", "pytest"):
        importlib.import_module(name)
    found = [[path] if path.is_file() else path.rglob("test_*.py") for path in map(Path, given.tests)]
    lines = Lines(given.map, sorted({path.resolve() for paths in found for path in paths}), given.jobs)
    chosen = chosen_mutations([f for f in numerical_files() if f.startswith(given.room)], given.n, given.seed)
    if given.at:
        names = {at.partition(":")[0] for at in given.at}
        every = [m for name in sorted(names) for m in mutations(name, (PACKAGE / name).read_text())]
        chosen = [m for m in every if {m.path, f"{m.path}:{m.line}"} & set(given.at)]
    table = defaultdict(Counter)
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(given.jobs, _FORK) as pool:
        begun = []
        for m in chosen:
            tests, n_all = lines.of(m, given.seconds)
            begun.append((m, len(tests), n_all, pool.submit(_fate, Path(folder), m, tests) if tests else None))
        for m, n_tests, n_all, result in begun:
            killer = result.result() if result else ""
            fate = "killed" if killer else "survived" if result else "not reached"
            print(f"{m}\n    {fate}", f"by {killer}" if killer else f"by {n_tests} of {n_all} tests", flush=True)
            table[room_of(m.path)][fate] += 1
    for room, fates in [*sorted(table.items()), ("all", sum(table.values(), Counter()))]:
        print(f"{room:20}", *(f"{fate} {fates[fate]:3}" for fate in ("killed", "survived", "not reached")), sep="  ")


if __name__ == "__main__":
    main()
