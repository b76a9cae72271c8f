"""What is not in the language is refused at its place; what is written to hurt, in bounded steps, depth and memory."""

import ast
import contextlib
import inspect
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.errors import MAX_PROBLEMS_SHOWN, InputFileError
from aomc_sky.skies.atmosphere.language.expressions import MAX_NESTING, MAX_VARIABLES
from aomc_sky.skies.atmosphere.language.lexer import MAX_BLOCK_BYTES, MAX_NODES
from tests.skies.atmosphere.test_medium import density
from tests.skies.atmosphere.test_medium import read as read_phase
from tests.support.blocks import GIVEN, at, density_block
from tests.support.limits import MOST_CPU_S

_IN_LITTLE_MEMORY = """
import resource, sys
import numpy as np
from tests.support.blocks import GIVEN, density_block
from tests.skies.atmosphere.language.test_refusals import HOSTILE
lanes = np.linspace(0.0, 1e5, 200_001)
full = "".join(f"vec4 a{i} = vec4(altitude);" for i in range(480))
blocks = [*(text for text, _ in HOSTILE.values()), full + "return a7.x;"]
density_block("return altitude;")(lanes, GIVEN)
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 400 * 2**20,) * 2)
from aomc_sky.errors import InputFileError
done = 0
for text in blocks:
    try:
        density_block(text)(lanes[:50_000], GIVEN)
    except InputFileError:
        pass
    done += 1
print(done)
"""


TABLE = Path(__file__).with_name("refusals.txt")
"""The golden page of the language: kind of block, its text => place, code, message and advice of each problem."""


def answer(kind, text):
    with pytest.raises(InputFileError) as caught:
        density(text).kinks() if kind == "density" else read_phase(text)
    assert caught.value.exit_code == 3
    assert {one.field for one in caught.value.problems} == {"number density" if kind == "density" else "phase function"}
    said = (f"{one.line}:{one.column} {one.code} {one.message} | {one.advice}" for one in caught.value.problems)
    return "; ".join(said).rstrip()


def test_every_refusal_is_that_of_the_table():
    """By the reader of blocks, at altitudes that GLSL has no value for, as a density and as a phase function."""
    wanted = dict(line.split(" => ") for line in TABLE.read_text().splitlines())
    found = {row: answer(row.split()[0], ast.literal_eval(row.partition(" ")[2])) for row in wanted}
    assert found == wanted
    assert len(wanted) == 93


def test_problems_are_few():
    with pytest.raises(InputFileError) as caught:
        density_block("x = 1;" * 1000)
    assert len(caught.value.problems) == MAX_PROBLEMS_SHOWN + 1


N = 10_000
DEEP = f"more than {MAX_NESTING} deep"
HOSTILE = {
    "open brackets": ("return " + "(" * N, DEEP),
    "indices": ("return " + "wavelengths[" * 4000 + "0" + "]" * 4000 + ";", "an index is a whole number"),
    "components": ("return wavelengths" + ".xyzw" * 6000 + ".x;", "more than 10000"),
    "statements": ("altitude = 1.;" * 4000 + "return 1.;", "more than 10000 numbers, names and operators"),
    "variables": ("".join(f"vec4 a{i} = vec4(altitude);" for i in range(600)), "more than 500 variables"),
    "a long number": ("return " + "9" * 60_000 + ".;", "too large for a double"),
    "a long name": ("return " + "a" * 60_000 + ";", "is not known"),
    "open comments": ("return 1.; " + "/* " * 20_000, "no end"),
    "nul": ("return \0;", "has no meaning"),
    "bytes that are no text": ("return \udcff;", "has no meaning"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_block_is_refused(name):
    text, words = HOSTILE[name]
    began = time.process_time()
    with pytest.raises(InputFileError, match=words) as caught:
        density_block(text)(np.array([0.0, 1e5]), GIVEN)
    assert len(str(caught.value)) < 10_000
    assert time.process_time() - began < MOST_CPU_S


def test_long_blocks_are_worked_out_up_to_the_limits():
    assert at("return " + "+".join(["altitude"] * 5000) + ";", 2.0) == [10_000.0]
    assert at("return " + "true ? 1. : " * 2000 + "2.;", 0.0) == [1.0]
    ladder = "if(altitude < 0.) return 0.; " + "".join(f"else if(altitude < {k}.) return {k}.; " for k in range(1, 999))
    assert at(ladder + "return -1.;", 41.5, 997.5, 2000.0) == [42.0, 998.0, -1.0]
    nested = "(" * (MAX_NESTING - 2) + "altitude" + ")" * (MAX_NESTING - 2)
    assert at(f"return {nested};", 3.0) == [3.0]
    assert at("return wavelengths" + ".wzyx" * 3001 + ".x;", 0.0) == [700.0]
    many = "".join(f"float a{i} = altitude;" for i in range(MAX_VARIABLES - 10))
    assert at(f"{many} return a7;", 5.0) == [5.0]
    fits = "return 1.;".ljust(MAX_BLOCK_BYTES)
    assert at(fits, 0.0) == [1.0]
    for one_more in (fits + " ", "return 1.;//".ljust(MAX_BLOCK_BYTES - 1) + "\xe9"):
        with pytest.raises(InputFileError, match=f"has {MAX_BLOCK_BYTES + 1} bytes"):
            density_block(one_more)
    # return, the terms, and a sign between two
    n_terms = MAX_NODES // 2
    assert at("return " + "+".join(["1."] * n_terms) + ";", 0.0) == [float(n_terms)]
    with pytest.raises(InputFileError, match="more than 10000 numbers, names and operators"):
        at("return " + "+".join(["1."] * n_terms) + "+altitude;", 0.0)


NESTS = {
    "brackets": lambda n: "return " + "(" * n + "altitude" + ")" * n + ";",
    "calls": lambda n: "return " + "min(" * n + "altitude" + ", 1.)" * n + ";",
    "precedences": lambda n: "return " + "float(1. < 2. + 3.*" * n + "1." + " ? 1 : 2)" * n + ";",
    "choices": lambda n: "return " + "true ? " * n + "1." + " : 2." * n + ";",
    "ifs": lambda n: "if(true) " * n + "return 1.; return 2.;",
    "braces": lambda n: "{" * n + "return 1.;" + "}" * n,
    "elses": lambda n: "if(false) ; else { " * n + "return 1.;" + "}" * n + "return 2.;",
    "signs": lambda n: "return " + "- " * n + "1.;",
    "vectors": lambda n: "return " + "vec2(" * n + "1." + ").xy" * n + ".x;",
    "logic": lambda n: "return " + "float(altitude < 1. || 1. < " * n + "1." + ")" * n + ";",
}


@pytest.mark.parametrize("name", NESTS)
def test_at_every_depth_there_is_a_value_or_an_error_of_the_file(name):
    """Also on a stack that is nearly half full already: the deepest block needs less than 600 frames of 1000."""
    accepted = []
    for n in (1, *range(15, 20), *range(30, 36), *range(45, 53), *range(92, MAX_NESTING + 1)):
        with contextlib.suppress(InputFileError):
            density_block(NESTS[name](n))
            accepted.append(n)
    assert accepted
    assert accepted[-1] < MAX_NESTING
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(len(inspect.stack(0)) + 600)
    try:
        with contextlib.suppress(InputFileError):
            density_block(NESTS[name](accepted[-1]))(np.zeros(1), GIVEN)
        with pytest.raises(InputFileError, match=DEEP):
            density_block(NESTS[name](MAX_NESTING + 1))
    finally:
        sys.setrecursionlimit(limit)


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of memory and /proc are Linux's")
@pytest.mark.slow
def test_no_block_needs_much_memory():
    result = subprocess.run([sys.executable, "-c", _IN_LITTLE_MEMORY], capture_output=True, text=True, check=False)
    assert result.stdout.strip() == str(len(HOSTILE) + 1), result.stderr[-2000:]
