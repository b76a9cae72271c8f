"""Blocks written to hurt: refused or worked out in bounded steps, depth and memory, never with a traceback."""

from __future__ import annotations

import contextlib
import inspect
import subprocess
import sys
import time

import numpy as np
import pytest

from aomc_sky.atmosphere.language.block import MAX_STEPS
from aomc_sky.atmosphere.language.expressions import MAX_VARIABLES
from aomc_sky.atmosphere.language.lexer import MAX_BLOCK_BYTES, MAX_NESTING
from aomc_sky.errors import InputFileError
from tests.support.blocks import GIVEN, at, density_block
from tests.support.limits import MOST_CPU_S

N = 10_000
DEEP = f"more than {MAX_NESTING} deep"
HOSTILE = {
    "brackets": ("return " + "(" * N + "1." + ")" * N + ";", DEEP),
    "open brackets": ("return " + "(" * N, DEEP),
    "braces": ("{" * N + "}" * N, DEEP),
    "minus": ("return " + "- " * N + "1.;", DEEP),
    "not": ("return " + "!" * N + "true ? 1. : 2.;", DEEP),
    "ifs": ("if(true) " * 2000 + "return 1.;", DEEP),
    "loops in loops": ("for(;;) " * 2000 + "return 1.;", DEEP),
    "choices in choices": ("return " + "true ? " * 2000 + "2." + ": 1." * 2000 + ";", DEEP),
    "choices in brackets": ("return " + "true ? 1. : (" * 4000 + "2." + ")" * 4000 + ";", DEEP),
    "indices": ("return " + "wavelengths[" * 4000 + "0" + "]" * 4000 + ";", DEEP),
    "components": ("return wavelengths" + ".xyzw" * 3000 + ".x;", DEEP),
    "calls": ("return " + "exp(" * 3000 + "0." + ")" * 3000 + ";", DEEP),
    "constructors": ("return " + "vec4(" * 3000 + "0." + ")" * 3000 + ".x;", DEEP),
    "precedences": ("return " + "false || true && 1. == 1. + 2. * float(" * 1500 + "1" + ")" * 1500 + ";", DEEP),
    "a hundred thousand brackets": ("return " + "(" * 10**5 + "1." + ")" * 10**5 + ";", "more than 65536"),
    "an endless while": ("while(true) {} return 1.;", "steps"),
    "an endless for": ("for(;;) ; return 1.;", "steps"),
    "an endless continue": ("while(true) { continue; } return 1.;", "steps"),
    "loops of loops": ("float s=0.; for(int i=0;i<9999;i++) for(int j=0;j<9999;j++) s+=1.; return s;", "steps"),
    "a loop that grows": ("vec4 v = vec4(1); while(true) { v = v + v; } return v.x;", "steps"),
    "a long condition": ("while(" + "+".join(["1."] * 5000) + " > 0.) {} return 1.;", "steps"),
    "variables": (
        "".join(f"vec4 a{i} = vec4(altitude);" for i in range(600)) + "return 1.;",
        "more than 500 variables",
    ),
    "an array": ("float a[1000000000]; return a[0];", "no arrays"),
    "recursion": ("float f(float x) { return f(x); } return f(1.);", "no functions of its own"),
    "a long number": ("return " + "9" * 60_000 + ".;", "too large for a number"),
    "a long whole number": ("return " + "9" * 60_000 + ";", "beyond 2147483647"),
    "points": ("return 1" + "." * 60_000 + ";", "is not a number"),
    "a long name": ("return " + "a" * 60_000 + ";", "is not known"),
    "open comments": ("return 1.; " + "/* " * 20_000, "no end"),
    "overflow": ("return 1e400;", "too large"),
    "nul": ("return \0;", "has no meaning"),
    "bytes that are no text": ("return \udcff;", "has no meaning"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_block_is_refused(name: str) -> None:
    text, words = HOSTILE[name]
    began = time.process_time()
    with pytest.raises(InputFileError, match=words) as caught:
        density_block(text)(np.array([0.0, 1e5]), GIVEN)
    assert len(str(caught.value)) < 10_000
    assert time.process_time() - began < MOST_CPU_S


def test_what_is_long_and_honest_is_worked_out() -> None:
    assert at("return " + "+".join(["altitude"] * 5000) + ";", 2.0) == [10_000.0]
    assert at("return " + "true ? 1. : " * 3000 + "2.;", 0.0) == [1.0]
    ladder = "if(altitude < 0.) return 0.; " + "".join(f"else if(altitude < {k}.) return {k}.; " for k in range(1, 999))
    assert at(ladder + "return -1.;", 41.5, 997.5, 2000.0) == [42.0, 998.0, -1.0]
    nested = "(" * (MAX_NESTING - 2) + "altitude" + ")" * (MAX_NESTING - 2)
    assert at(f"return {nested};", 3.0) == [3.0]
    assert at("float s = 0.; for(int i = 0; i < 1200; i++) s += 1.; return s;", 0.0) == [1200.0]
    many = "".join(f"float a{i} = altitude;" for i in range(MAX_VARIABLES - 10))
    assert at(f"{many} return a7;", 5.0) == [5.0]


def test_the_limits_are_met_exactly() -> None:
    fits = "return 1.;".ljust(MAX_BLOCK_BYTES)
    assert at(fits, 0.0) == [1.0]
    with pytest.raises(InputFileError, match=f"has {MAX_BLOCK_BYTES + 1} bytes"):
        density_block(fits + " ")
    with pytest.raises(InputFileError, match=f"has {MAX_BLOCK_BYTES + 1} bytes"):
        density_block("return 1.;//".ljust(MAX_BLOCK_BYTES - 1) + "\xe9")
    # body, return, chain, first number, then two steps for each further number
    n_terms = (MAX_STEPS - 4) // 2 + 1
    assert at("return " + "+".join(["1."] * n_terms) + ";", 0.0) == [float(n_terms)]
    with pytest.raises(InputFileError, match="more than 20000 steps"):
        at("return " + "+".join(["1."] * (n_terms + 1)) + ";", 0.0)


NESTS = {
    "brackets": lambda n: "return " + "(" * n + "altitude" + ")" * n + ";",
    "calls": lambda n: "return " + "min(" * n + "altitude" + ", 1.)" * n + ";",
    "precedences": lambda n: "return " + "float(1. < 2. + 3.*" * n + "1." + " ? 1 : 2)" * n + ";",
    "choices": lambda n: "return " + "true ? " * n + "1." + " : 2." * n + ";",
    "ifs": lambda n: "if(true) " * n + "return 1.; return 2.;",
    "braces": lambda n: "{" * n + "return 1.;" + "}" * n,
    "elses": lambda n: "if(false) ; else { " * n + "return 1.;" + "}" * n + "return 2.;",
    "loops": lambda n: "for(;;) " * n + "return 1.; return 1.;",
    "signs": lambda n: "return " + "- " * n + "1.;",
    "vectors": lambda n: "return " + "vec2(" * n + "1." + ").xy" * n + ".x;",
    "indices": lambda n: "return " + "wavelengths[int(" * n + "0." + ")]" * n + ";",
}


@pytest.mark.parametrize("name", NESTS)
def test_at_every_depth_there_is_a_value_or_an_error_of_the_file(name: str) -> None:
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


_IN_LITTLE_MEMORY = """
import resource, sys
import numpy as np
from tests.support.blocks import GIVEN, density_block
from tests.unit.atmosphere.language.test_block_hostile import HOSTILE
lanes = np.linspace(0.0, 1e5, 200_001)
blocks = [text for text, _ in HOSTILE.values()]
full = "".join(f"vec4 a{i} = vec4(altitude);" for i in range(480))
blocks.append(full + "return a7.x;")
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


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of memory and /proc are Linux's")
@pytest.mark.slow
def test_no_block_needs_much_memory() -> None:
    result = subprocess.run([sys.executable, "-c", _IN_LITTLE_MEMORY], capture_output=True, text=True, check=False)
    assert result.stdout.strip() == str(len(HOSTILE) + 1), result.stderr[-2000:]
