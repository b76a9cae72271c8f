"""Every program of bench/ runs to its end, small."""

import ast
import importlib.util
import os
import subprocess
import sys

import pytest

from tests.include.test_gpu import gpu
from tests.support.shared import REPOSITORY

FILES = {path.stem: path.read_text() for path in (REPOSITORY / "bench").rglob("*.py")}
PROGRAMS = sorted(f"{name}.py" for name, text in FILES.items() if "__main__" in text)
SMALL = {
    "azimuths.py": "--grids 2 --bands 4",
    "bias.py": "--runs 40 --photons 1000",
    "check.py": "--photons 4096 --replicates 2 --turns 1",
    "clear_sky.py": "literals",
    "cloud_spectrum.py": "",
    "emission.py": "--turns 1",
    "even_numbers.py": "--photons 500 --replicates 4",
    "every_sky.py": "--skies 2 --photons 2000 --seeds 4",
    "gpu.py": "--photons 1e6",
    "growth.py": "--rows threads --small --out growth.csv",
    "measured_skies.py": "--seeds 1",
    "number_modes.py": "--grids uniform --photons 100 --work 400",
    "number_steps.py": "--candidates 20",
    "polarised_field.py": "",
    "published.py": "--gains --photons 500 --replicates 4",
    "report.py": "page.md --skies uniform --photons 1e3 2000 --replicates 2 --turns 1",
    "same_bits.py": "--plain --write bits.json",
    "same_plans.py": "--only cie --write plans.json",
    "source_file.py": "--photons 100000 --repeats 1 --only table",
    "transport.py": "--photons 1000 --repeats 2 --replicates 4 --sample 40000",
    "witnesses.py": "--skies 8",
}
"""Arguments that make each one short. A new program has an entry here, or the first test fails."""

NEEDS = {"clear_sky.py": "pvlib", "cloud_spectrum.py": "PythonicDISORT", "polarised_field.py": "sasktran2"}
"""Packages that are no part of ours or of its tests."""

MAY_MISS = {"check.py", "report.py"}
"""Programs whose bars are out of reach with so few photons: exit code 1."""


def test_every_program_has_its_arguments():
    assert set(SMALL) == set(PROGRAMS)
    assert set(NEEDS) | MAY_MISS <= set(PROGRAMS)


def imported(text):
    """Files of bench/ that this one imports: by `from bench.skies`, `from bench import skies` or `from slab`."""
    lines = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom) and node.module]
    names = {alias.name for node in lines for alias in node.names} | {node.module.split(".")[-1] for node in lines}
    return names & set(FILES)


def test_every_other_file_is_a_part_of_a_program():
    """So each file runs here: none lies beside the programs, like one whose `__main__` is forgotten."""
    reached, last = {name.removesuffix(".py") for name in PROGRAMS}, set()
    while reached != last:
        last, reached = reached, reached.union(*(imported(FILES[name]) for name in reached))
    assert reached == set(FILES)


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS)
def test_a_program_runs_to_its_end(program, tmp_path):
    if program in NEEDS and importlib.util.find_spec(NEEDS[program]) is None:
        pytest.skip(f"it needs {NEEDS[program]}")
    if program == "gpu.py":
        gpu()  # skips where there is none
    paths = [str(REPOSITORY / "src"), str(REPOSITORY), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, REPOSITORY / "bench" / program, *SMALL[program].split()],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in ((0, 1) if program in MAY_MISS else (0,)), done.stderr[-2000:]
    assert "Traceback" not in done.stderr, done.stderr[-2000:]
    assert done.stdout or program.startswith("same_plans")
