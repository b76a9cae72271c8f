"""Seed policy and profiles of the suite.

Tests make their generators from numbers written in the test, never from the clock, so a failure comes back when the
test runs again; only their order is random (pytest-randomly prints its seed). Hypothesis draws the same examples every
time in the profiles `quick` (the default) and `ci` (where CI is set); `AOMC_SKY_HYPOTHESIS=nightly` looks for new ones.
Nothing may reach for the network.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import gettext
import importlib
import os
import shutil
import socket
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import pytest
from hypothesis import HealthCheck, settings

from aomc_sky.outputs.photon_formats import PHOTON_FORMATS
from aomc_sky.system import n_cpus
from tests.support.backend import begin_process
from tests.support.builds import FOLDER
from tests.support.fault_rows import command
from tests.support.packages import pip_install
from tests.support.scenes import copy_scene
from tests.support.shared import REPOSITORY

# waiting threads of OpenBLAS go round in a loop: on two cores they took a third of the time of the tests of skies.
# It reads this when it is loaded; workers of pytest-xdist have it from here.
os.environ.setdefault(ONE_THREAD := "OPENBLAS_NUM_THREADS", "1")

settings.register_profile(
    "quick", max_examples=25, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("ci", settings.get_profile("quick"), max_examples=100)
settings.register_profile("nightly", settings.get_profile("quick"), max_examples=2000, derandomize=False)
settings.load_profile(os.environ.get("AOMC_SKY_HYPOTHESIS", "ci" if os.environ.get("CI") else "quick"))


_LONG = """
    bits emit pages hosts damage numbers measured replicates field_axes polarisation plot backward cli_verify_scene
    commands patch_integrals light_matrix machine_faults interrupts two_runs jit slab verify readers_fuzz spectral_split
    cli_measured cli_tables mcpl aomc_light sky_plugin lobe_cells perez_emission cli_plot radiance_field cli_polarised
    patches cli_dask cli_shards output_targets function_sky spoilt_files
"""
FIRST = tuple(f"test_{name}.py" for name in _LONG.split())
"""Files that take a worker five seconds or more: they come first, so that none is left with one of them at the end."""


def pytest_configure(config: pytest.Config) -> None:
    # children of tests, and there are hundreds, keep what Python compiles of the package; else each compiles it anew
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    gc.set_threshold(50_000, 20, 100)  # looking for garbage after every 700 objects was 7 % of the suite
    if getattr(config.option, "loadscopereorder", False):  # xdist would begin with files of many tests
        config.option.loadscopereorder = False
    if FOLDER not in os.environ:  # a worker of pytest-xdist has it
        os.environ[FOLDER] = tempfile.mkdtemp(prefix="aomc-sky-builds-")
        config.add_cleanup(lambda: shutil.rmtree(os.environ.pop(FOLDER)))


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_auto_num_workers() -> int:
    """Workers of ``-n auto``: a container may have two CPUs of a machine with a hundred, and each worker takes a GB."""
    n_workers = min(n_cpus(), 8)
    with contextlib.suppress(OSError, ValueError):  # no control group of version 2, or no limit ("max")
        quota, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        n_workers = min(n_workers, max(1, round(int(quota) / int(period))))
    return n_workers


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Tests live as long as the process: the collector of garbage does not look through ten thousand of them again."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    turn = {name: k for k, name in enumerate(FIRST)}
    items.sort(key=lambda item: turn.get(item.path.name, len(turn)))


def pytest_sessionstart() -> None:
    _note_skipped("")  # the file is there, whether or not anything is skipped


def _note_skipped(text: str) -> None:
    """Where `AOMC_SKY_SKIPPED` names a file, as the gate does: a line for each test that is skipped, and why."""
    path = os.environ.get("AOMC_SKY_SKIPPED")
    if path and "PYTEST_XDIST_WORKER" not in os.environ:
        with open(path, "a") as file:
            file.write(text)


def pytest_runtest_logreport(report: pytest.TestReport | pytest.CollectReport) -> None:
    if report.skipped:
        where = report.longrepr
        reason = " ".join(str(where[-1] if isinstance(where, tuple | list) else where).split())
        _note_skipped(f"{report.nodeid}\t{reason.removeprefix('Skipped: ')}\n")


def pytest_collectreport(report: pytest.CollectReport) -> None:
    pytest_runtest_logreport(report)


@pytest.fixture
def amc(tmp_path: Path) -> Path:
    """amc.inp of the small scene that most commands are tested on, in a folder of its own."""
    return copy_scene("document_example", tmp_path)


@pytest.fixture
def scene(amc: Path) -> Path:
    """The folder of that scene."""
    return amc.parent


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Run the command with these words, expect its exit code, and give what it printed: `told("info", path).out`."""

    def call(*words: object, code: int = 0) -> Any:
        capsys.readouterr()
        found = command(*words)
        said = capsys.readouterr()
        assert found == code, (words, found, said)
        return said

    return call


@pytest.fixture
def double(monkeypatch: pytest.MonkeyPatch) -> None:
    """A photon format in the table that the package does not have; its files do not end in its name."""
    monkeypatch.setitem(PHOTON_FORMATS, "double", "tests.support.double_format:DoubleWriter")


@pytest.fixture(scope="session")
def skies_site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for the module path in which pip has installed the package of examples/sky_plugin."""
    site = tmp_path_factory.mktemp("site")
    pip_install(REPOSITORY / "examples" / "sky_plugin", site)
    return site


@pytest.fixture(autouse=True, scope="session")
def _no_network() -> Iterator[None]:
    connect = socket.socket.connect

    def guarded(self: socket.socket, address: Any) -> None:
        inside = address[0] in ("127.0.0.1", "::1") if isinstance(address, tuple) else False  # a Dask cluster here
        if self.family in (socket.AF_INET, socket.AF_INET6) and not inside:
            _refuse(address)
        connect(self, address)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "connect", guarded)
        yield


@pytest.fixture(autouse=True, scope="session")
def _one_thread_of_openblas() -> Iterator[None]:
    """For this process alone: what a test starts has as many as a user's."""
    importlib.import_module("scipy.linalg")  # it has a library of its own beside numpy's
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv(ONE_THREAD)
        yield


@pytest.fixture(autouse=True, scope="session")
def _no_wait_for_the_disk() -> Iterator[None]:
    """No test outlives a power cut: `os.fsync`, some ms for each of thousands of files, asks for an open file alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda handle: os.fstat(handle) and None)
        yield


@pytest.fixture(autouse=True, scope="session")
def _one_look_for_translations() -> Iterator[None]:
    """argparse asks for the translation of each text, and `gettext` looks at the disk each time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gettext, "find", functools.cache(gettext.find))
        yield


@pytest.fixture(autouse=True, scope="session")
def _begins_in_plain_numpy() -> None:
    begin_process()


@pytest.fixture(autouse=True)
def _as_in_a_fresh_process() -> None:
    begin_process()


def _refuse(address: object) -> NoReturn:
    raise RuntimeError(f"a test reached for the network: {address}")
