"""What is not in the language is refused at its place; what is written to hurt, in bounded steps, depth and memory."""

import contextlib
import inspect
import subprocess
import sys
import time

import numpy as np
import pytest

from aomc_sky.errors import MAX_PROBLEMS_SHOWN, InputFileError
from aomc_sky.skies.atmosphere.language.expressions import MAX_NESTING, MAX_VARIABLES
from aomc_sky.skies.atmosphere.language.lexer import MAX_BLOCK_BYTES, MAX_NODES
from tests.support.blocks import GIVEN, at, density_block, phase_block
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


def problems_of(text):
    with pytest.raises(InputFileError) as caught:
        density_block(text)
    assert all(problem.code == "E403" for problem in caught.value.problems)
    assert all(problem.field == "number density" for problem in caught.value.problems)
    assert caught.value.exit_code == 3
    return tuple(f"{one.line}:{one.column}: {one.message} | {one.advice}" for one in caught.value.problems)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        # not in the language
        ('return "a";', "10:8: the character '\"' has no meaning in a code block"),
        ("/* open", "10:1: this comment has no end | close it with */"),
        ("struct A { float x; }; return 1.;", "10:1: a type is not known"),
        ("return float(1 << 3);", "10:16: the operator << is not part of this language"),
        ("int i = 5; i <<= 2; return i;", "10:14: the operator <<= is not part of this language"),
        ("float a; float b = a = 1.; return b;", "10:22: an assignment is not a value here"),
        ("int i = 1; return --i;", "10:19: a value is missing; found --"),
        ("float a = (1., 2.); return a;", "10:14: there are two values in one pair of brackets"),
        # numbers
        ("return float(0x10);", "10:14: 0x10 is not a number"),
        ("return 3000000000;", "10:8: the whole number 3000000000 is beyond 2147483647"),
        ("return 1e400;", "10:8: 1e400 is too large for a double-precision number"),
        ("return 1e-400;", "10:8: 1e-400 is too small for a double-precision number"),
        # shape of statements
        ("float a = 1.\nreturn a;", "10:13: ; is missing at the end of the statement; found return | write ;"),
        ("return exp(1.;", "10:14: ) is missing after the arguments of exp"),
        ("return;", "10:7: return has no value"),
        ("return altitude > 1. ? 2.;", "10:26: : is missing between the two values of ?:"),
        ("if altitude > 1. return 2.;", "10:3: ( is missing after if"),
        ("if(altitude > 1.) { return 2.;", "10:19: this { is not closed in the block"),
        ("else return 1.;", "10:1: else cannot stand here | it has no if before it"),
        ("altitude; return 1.;", "10:1: this statement does nothing"),
        ("float; return 1.;", "10:6: a name is missing after the type"),
        ("const x = 1.; return 1.;", "10:7: a type is missing"),
        ("", "10:1: the block can end without a value; it must return a float | write return and a value at its end"),
        # types
        ("return true;", "10:8: the value that is returned is a bool, not a float | write float(...) around it"),
        ("vec2 v = vec3(1); return 1.;", "10:10: the value of v is a vec3, not a vec2 | take a component"),
        ("return true ? 2. : vec2(1).xy;", "10:8: the values of ?: have different types: float and vec2"),
        ("return 1. + (altitude < 5.);", "10:8: + cannot combine float and bool | write cond ? a : b"),
        ("return 5. % 2.;", "10:11: the operator % is not part of this language | write mod(x, y)"),
        ("return 1. < altitude < 5. ? 1. : 0.;", "10:8: < compares two numbers, not bool and float | join two"),
        ("return true == 1 ? 1. : 0.;", "10:8: == compares two values of one type, not bool and int"),
        ("return 1 && true ? 1. : 0.;", "10:8: && takes bools, not an int"),
        ("return -true ? 1. : 0.;", "10:8: - takes a number, not a bool"),
        ("int i = 1; i += 0.5; return i;", "10:12: += gives a float, and the variable is an int"),
        # functions
        ("return pow(wavelengths, 1.5).x;", "10:8: pow does not take vec4, float: its values have one type"),
        ("return exp();", "10:8: exp takes 1 values, not 0"),
        ("return expp(1.);", "10:8: there is no function expp | is exp meant?"),
        ("return vec2(1, 2, 3).x;", "10:8: there are more values than components of vec2"),
        ("return vec4(1, 2).x;", "10:8: vec4 has 4 components, 2 are given"),
        ("return float(1, 2);", "10:8: float() takes one value, not 2"),
        # names
        ("return altitud;", "10:8: the name altitud is not known | is altitude meant?"),
        ("return exp;", "10:8: the name exp is not known | exp is a function: write exp(...)"),
        ("float x = x; return x;", "10:11: the name x is not known"),
        ("float x = 1.; float x = 2.; return x;", "10:21: x is declared twice"),
        ("const float a; return 1.;", "10:13: a is const and has no value"),
        ("wavelengths.x = 2.; return 1.;", "10:1: wavelengths is given to the block and cannot be changed"),
        ("1. = 2.; return 1.;", "10:1: only a variable or its components can get a value"),
        # components
        ("return altitude.x;", "10:17: a float has no components"),
        ("return wavelengths.xg;", "10:20: xg names no components of a vec4"),
        ("return wavelengths[4];", "10:20: 4 names no components of a vec4 | write an index of 0 to 3"),
        ("return wavelengths[1.];", "10:20: an index is a whole number that stands there; found 1."),
        ("vec2 v = vec2(1); v.xx = vec2(2); return 1.;", "10:19: a component is named twice on the left of ="),
    ],
)
def test_one_problem(text, wanted):
    found = problems_of(text)
    assert len(found) == 1, found
    assert found[0].startswith(wanted), found[0]


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("float a = 1. * true;\nvec2 b = a;\nif(a) b = 2.;\nreturn b + c;", "10:11: 11:10: 12:4: 13:12:"),
        ("float f(float x) { return x; }\nfloat a[2];\nstruct B { int i; };\nreturn 1.;", "10:7: 11:7: 12:1:"),
        ("flot @ = 1.;\n#define x\nreturn 010;", "10:6: 11:1: 12:8:"),  # characters before statements
    ],
)
def test_a_block_tells_all_its_problems_in_their_order(text, places):
    assert [one.split(" ")[0] for one in problems_of(text)] == places.split()


def test_problems_are_few_and_name_what_is_wrong():
    assert len(problems_of("x = 1;" * 1000)) == MAX_PROBLEMS_SHOWN + 1
    with pytest.raises(InputFileError) as caught:
        density_block("float h = altitude/km;\n  return exp(-hh);")
    assert str(caught.value) == (
        "a.atmo:11:15: error[E403]: number density: the name hh is not known\n"
        "   11 |   return exp(-hh);\n"
        "      |               ^^ is h meant?"
    )
    with pytest.raises(InputFileError, match=r"is a float, not a vec4\n.*\n.*write vec4\(\.\.\.\) around it"):
        phase_block("return 1.;")
    with pytest.raises(InputFileError, match="the name altitude is not known"):
        phase_block("return vec4(altitude);")
    for text in ("__import__('os').system('true')", "().__class__", "open('x')", "exec(1)", "[0 for x in y]"):
        assert problems_of(f"return {text};")


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


def test_nothing_of_a_block_reaches_python():
    for text in (
        "__import__('os').system('true')",
        "().__class__",
        "open('x')",
        "exec(1)",
        "lambda: 1",
        "[0 for x in y]",
    ):
        assert problems_of(f"return {text};")


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of memory and /proc are Linux's")
@pytest.mark.slow
def test_no_block_needs_much_memory():
    result = subprocess.run([sys.executable, "-c", _IN_LITTLE_MEMORY], capture_output=True, text=True, check=False)
    assert result.stdout.strip() == str(len(HOSTILE) + 1), result.stderr[-2000:]
