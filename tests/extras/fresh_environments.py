"""Install the package with each extra alone, and with all, in fresh environments, and run what each must do.

    python tests/extras/fresh_environments.py [EXTRA ...]

By hand, for every environment is hundreds of megabytes and some minutes; each is removed after its turn. In
the environment of a user's extra its own commands must end with exit code 0, those of every other extra with 2 and
the one line that names it. The same without environments: tests/cli/test_cli_extras.py.
"""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
support = importlib.import_module("tests.support.extras")

TOOLS = {
    "test": ["-m", "pytest", "--version"],
    "dev": ["-m", "mypy", "--version"],
    "docs": ["-m", "sphinx", "--version"],
}
"""Extras of those who work on the package -> what must run."""

PROBES = {
    "dask": "from distributed import LocalCluster",
    "bench": "import mitsuba, matplotlib, PythonicDISORT",
}
"""Extras that no command refuses to work without -> what must be importable."""


def pip(python: Path, *words: str | Path) -> None:
    """Run pip; bytecode is left out, for most of it would never be run."""
    quiet = ["--quiet", "--disable-pip-version-check"]
    subprocess.run([python, "-m", "pip", *words, *quiet], check=True, stderr=subprocess.DEVNULL)


def base_environment(made: Path) -> tuple[Path, Path]:
    """A fresh environment with the package alone, and the wheel that it came from."""
    folder = made / "base"
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    pip(python, "wheel", "--no-deps", "--wheel-dir", made, support.ROOT)
    wheel = next(made.glob("*.whl"))
    pip(python, "install", "--no-compile", wheel)
    return folder, wheel


def installed(base: Path, folder: Path, wheel: Path, extra: str) -> Path:
    """A copy of the base environment with one extra; its Python."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(base, folder, symlinks=True)
    pip(folder / "bin" / "python", "install", "--no-compile", f"{wheel}[{extra}]")
    return folder / "bin" / "python"


def extras_in(python: Path) -> set[str]:
    """Extras whose packages an environment holds, also such as another extra's packages bring: pvlib brings h5py."""
    found = f"[name for name, packages in {support.PACKAGES}.items() if all(map(find_spec, packages))]"
    asked = f"from importlib.util import find_spec; print(*{found})"
    return set(subprocess.run([python, "-c", asked], capture_output=True, text=True, check=True).stdout.split())


def faults_of(python: Path, folder: Path, extra: str) -> Iterator[str]:
    """What went otherwise than it must."""
    there = extras_in(python)
    wanted = set(support.PACKAGES) if extra == "all" else {extra} - set(TOOLS)
    if not wanted <= there:
        yield f"not installed: {wanted - there}"
    probes = [TOOLS[extra]] if extra in TOOLS else [["-c", PROBES[name]] for name in there if name in PROBES]
    for probe in probes:
        if subprocess.run([python, *probe], capture_output=True, check=False).returncode:
            yield f"{probe} fails"
    if extra not in TOOLS:
        yield from faults_of_commands(python, folder, there)


def faults_of_commands(python: Path, folder: Path, there: set[str]) -> Iterator[str]:
    """Commands that do not what they must where some extras are there."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder.parent / "numba")}

    def run(*words: str) -> tuple[int, str]:
        command = [python, "-m", "aomc_sky", *words]
        done = subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)
        return done.returncode, done.stderr

    for words in support.commands_of_core(folder):
        if (answer := run(*words)) != (0, ""):
            yield f"{words}: {answer}"
    wanting = {(name,): commands for name, commands in support.commands_wanting(folder).items()}
    for needs, commands in {**wanting, **support.commands_wanting_two(folder)}.items():
        missing = [name for name in needs if name not in there]
        for words in commands:
            code, said = run(*words)
            if missing and not (code == 2 and any(said.endswith(support.hint(name)) for name in missing)):
                yield f"{words} without {missing}: {code} {said}"
            if not missing and code != 0:
                yield f"{words}: {code} {said}"


def main(names: list[str]) -> int:
    """Take the extras in turn; the number of those that fail."""
    n_bad = 0
    with tempfile.TemporaryDirectory(prefix="aomc-sky-extras-") as made:
        base, wheel = base_environment(Path(made))
        for extra in names or support.extras_of_project():
            # one place for all environments: compiled kernels are kept by the path of their source
            python = installed(base, Path(made) / "environment", wheel, extra)
            work = Path(made) / extra
            work.mkdir()
            faults = list(faults_of(python, work, extra))
            n_bad += bool(faults)
            print("\n  ".join([f"{extra}: {'failed' if faults else 'ok'}", *faults]), flush=True)
    return n_bad


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
