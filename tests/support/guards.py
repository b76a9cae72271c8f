"""Guards of the matrix of faults, and a copy of the package in which each is taken out while its test runs."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path

import aomc_sky
from tests.support.forked_programs import ForkServer
from tests.support.shared import REPOSITORY

PACKAGE = Path(aomc_sky.__file__).parent
LIMIT_S = 120
"""What a test may take without its guard; one that `hangs` is given `HANG_S`."""
HANG_S = 12

_PYTEST = """
import sys
from pathlib import Path
import aomc_sky
assert Path(aomc_sky.__file__).parent == Path(sys.argv[1]), f"not the copy: {aomc_sky.__file__}"
import pytest
sys.exit(pytest.main(sys.argv[2:]))
"""
_OPTIONS = (
    "-q",
    "--assert=plain",
    "-p",
    "no:randomly",
    "-p",
    "no:cacheprovider",
    "-p",
    "no:xdist",
    "--no-header",
    "--tb=short",
)
_FAILED = re.compile(r"^1 failed(, \d+ warnings?)? in ", re.MULTILINE)
_BROKEN = re.compile(r"^E +(NameError|UnboundLocalError|SyntaxError|IndentationError|ImportError).*", re.MULTILINE)


@dataclass(frozen=True, kw_only=True, slots=True)
class Guard:
    """A piece of the package that answers one fault, and the test that must fail without it."""

    file: str
    """Below the folder of the package."""
    text: str
    """The guard; it stands in the file exactly once."""
    without: str
    """What stands there when the guard is taken out."""
    test: str
    """Id of a test of a row of the matrix, below ``tests/faults``."""
    hangs: bool
    """Without the guard the test does not fail but goes on without an end, which counts as seen."""

    @property
    def name(self) -> str:
        """Row and fault, from the id of the test."""
        return self.test.partition("[row-")[2].removesuffix("]")

    @property
    def row(self) -> int:
        """Row of the matrix. [1-based]"""
        return int(self.name.partition("-")[0])

    @property
    def place(self) -> str:
        """File and the innermost function or class that holds the first line of the guard."""
        source = (PACKAGE / self.file).read_text()
        line = source.count("\n", 0, source.index(self.text.lstrip())) + 1
        around = [
            node
            for node in ast.walk(ast.parse(source))
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.lineno <= line <= (node.end_lineno or 0)
        ]
        holder = max(around, key=lambda node: node.lineno, default=None)
        return f"{self.file}:{holder.name if holder else line}"


def read_guards(path: Path) -> Iterator[Guard]:
    """The guards of a file; its first paragraph says how they are written."""
    text = path.read_text().partition("\n\n")[2]
    for file, guards in re.findall(r"^([a-z]\S+\.py)\n((?:[ +-].*\n)+)", text, re.MULTILINE):
        for test, hangs, lines in re.findall(r"^  (.+?\])(  \(hangs\))?\n((?:[+-].*\n)+)", guards, re.MULTILINE):
            old, new = ("\n".join(re.findall(rf"^\{sign}(.*)$", lines, re.MULTILINE)) for sign in "-+")
            yield Guard(file=file, text=old, without=new, test=test, hangs=bool(hangs))


@dataclass(frozen=True, kw_only=True, slots=True)
class Seen:
    """What became of a test: whether it failed as a test fails, whether it had to be ended, what it said."""

    failed: bool
    hung: bool
    broken: bool
    said: str


def _cache_of(room: Path) -> Path:
    """Where numba keeps what it compiled of a folder."""
    from numba.core import caching, config

    if not config.CACHE_DIR:
        return room / "__pycache__"
    return Path(config.CACHE_DIR) / caching._CacheLocator.get_suitable_cache_subpath(str(room / "any.py"))


class PackageCopy:
    """The package once more, compiled kernels included, to be imported in the place of the real one.

    Parameters
    ----------
    folder : Path
        Empty; the copy and the temporary files of tests go there.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._server = ForkServer("pytest", "hypothesis", "numpy", "numba")
        self.package = folder / "src" / "aomc_sky"
        # with times, so that what is compiled is that of its source
        shutil.copytree(PACKAGE, self.package, ignore=shutil.ignore_patterns("*.nbi", "*.nbc"))
        self._link_compiled_kernels()

    def test_without(self, guard: Guard) -> Seen:
        """Run the test of a guard while the guard is taken out."""
        with self._replaced(guard):
            return self._test(guard)

    def _link_compiled_kernels(self) -> None:
        """Nothing is compiled twice; and what a kernel stores takes the place of the link, not of its target."""
        for room in {path.parent for path in (PACKAGE / "kernels").rglob("*.py")}:
            here = self.package / room.relative_to(PACKAGE) / "__pycache__"
            here.mkdir(exist_ok=True)
            for path in _cache_of(room).glob("*.nb[ic]"):
                (here / path.name).symlink_to(path.resolve())

    @contextmanager
    def _replaced(self, guard: Guard) -> Iterator[None]:
        path = self.package / guard.file
        text = path.read_text()
        assert text.count(guard.text) == 1, guard
        Path(cache_from_source(str(path))).unlink(missing_ok=True)  # it may be of the same second and size
        path.write_text(text.replace(guard.text, guard.without))
        try:
            yield
        finally:
            path.write_text(text)

    def _test(self, guard: Guard) -> Seen:
        words = [*_OPTIONS, f"--basetemp={self._folder / 'tests'}", f"tests/faults/{guard.test}"]
        paths = [str(self.package.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
        ended = self._server.run(
            _PYTEST,
            self.package,
            *words,
            folder=REPOSITORY,
            limit_s=HANG_S if guard.hangs else LIMIT_S,
            NUMBA_CACHE_DIR=None,
            PYTHONPATH=os.pathsep.join(paths),
            PYTHONDONTWRITEBYTECODE="1",
        )
        said = ended.out + ended.err
        return Seen(
            failed=ended.code == 1 and _FAILED.search(said) is not None,
            hung=ended.hung,
            broken=_BROKEN.search(said) is not None,
            said=said,
        )


@cache
def collected_tests() -> frozenset[str]:
    """Ids of the default tests of the matrix, below ``tests/faults``."""
    options = ["--collect-only", "-q", "--assert=plain", "-p", "no:cacheprovider"]
    words = [sys.executable, "-m", "pytest", *options, "tests/faults"]
    done = subprocess.run(words, cwd=REPOSITORY, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return frozenset(re.findall(r"^tests/faults/(\S.*::.*)$", done.stdout, re.MULTILINE))
