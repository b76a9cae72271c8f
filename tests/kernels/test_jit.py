"""What the decorators of the kernels promise, and who loads numba; their cache: tests/faults/test_machine_faults.py."""

import ast
import re

import numba
import pytest

from tests.support.processes import in_environment, with_numba
from tests.support.shared import INPUTS, REPOSITORY

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")


_WITHOUT_BLAS = """
import sys
import numpy as np
import aomc_sky.emission.kernels.emit
assert not [name for name in sys.modules if name.startswith("scipy.linalg")]
import numba
@numba.njit
def product(a, b):
    return a @ b
assert (product(2.0 * np.eye(3), np.ones((3, 3))) == 2.0).all()
"""


def test_kernels_load_no_blas_and_leave_it_to_those_who_multiply_matrices():
    in_environment(_WITHOUT_BLAS)


PRIVATE = sorted(
    f"{node.module}:{alias.name}"
    for node in ast.walk(ast.parse((REPOSITORY / "src/aomc_sky/kernels/numba_private.py").read_text()))
    if isinstance(node, ast.ImportFrom) and node.module.startswith("numba.")
    for alias in node.names
)
"""Every private name of numba that speeds the kernels up."""

OPTIONS = ("_nrt", "no_cpython_wrapper", "no_cfunc_wrapper", "forceinline")

HIDE_NAME = """
import builtins
found = builtins.__import__
def without(name, globals=None, locals=None, fromlist=(), level=0):
    ours = (globals or {{}}).get("__name__", "").startswith("aomc_sky.")
    if ours and name == "{module}" and "{name}" in (fromlist or ()):
        raise ImportError("cannot import name '{name}'")
    return found(name, globals, locals, fromlist, level)
builtins.__import__ = without
"""
HIDE_OPTION = "import numba.core.cpu as cpu; cpu.CPUTargetOptions.{name} = None\n"
OTHER_CACHE = """
import numba.core.caching as caching
caching.FunctionCache.__init__ = lambda self, function, more: None
"""
HIDDEN = {
    **{name: HIDE_NAME.format(**dict(zip(("module", "name"), name.split(":"), strict=True))) for name in PRIVATE},
    **{name: HIDE_OPTION.format(name=name) for name in OPTIONS},
    "another signature": OTHER_CACHE,
}
TOLD = """
import warnings
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    from aomc_sky.kernels import jit
told = [str(w.message) for w in caught if issubclass(w.category, RuntimeWarning)]
print(len(told), all("compiles its kernels anew" in text for text in told), jit._private is None)
"""
SUMS = """
import numpy as np
from aomc_sky.emission.kernels.batches import block_sums
print(block_sums(np.array([-0.5, -1.0], np.float32)))
"""
PHOTONS = """
import hashlib, warnings
warnings.simplefilter("ignore")
import aomc_sky as sky
from aomc_sky.kernels import backend
source = sky.read_scene("{scene}", iterations=8_000_000).source(5, order="patch")
batches = source.batches(0, 1_000_000)
digest = hashlib.sha256()
for batch in batches:
    digest.update(batch.directions.tobytes())
print(digest.hexdigest(), backend.use_kernels(0))
"""


ONE_OF_A_KIND = (PRIVATE[0], "_nrt", "another signature")
"""Whatever is hidden, the kernels are compiled by the same plain `njit`."""


@pytest.mark.parametrize(
    "hidden", [name if name in ONE_OF_A_KIND else pytest.param(name, marks=pytest.mark.slow) for name in HIDDEN]
)
def test_a_numba_without_a_private_name_compiles_plainly_with_one_warning(hidden, tmp_path):
    is_compiled = hidden in ONE_OF_A_KIND
    said = with_numba(HIDDEN[hidden] + TOLD + SUMS * is_compiled, NUMBA_CACHE_DIR=str(tmp_path))
    assert said.splitlines() == ["1 True True", *["(1.5, 3.0)"] * is_compiled]
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


@pytest.mark.slow
@pytest.mark.parametrize("hidden", ONE_OF_A_KIND)
def test_eight_million_photons_without_a_private_name(hidden, expected_photons):
    """Those beyond the threshold come from kernels."""
    program = HIDDEN[hidden] + PHOTONS.format(scene=INPUTS / "overcast")
    assert with_numba(program).strip() == expected_photons


@pytest.fixture(scope="module")
def expected_photons():
    said = with_numba(PHOTONS.format(scene=INPUTS / "overcast")).strip()
    assert said.endswith("True")
    return said


HOST = """
import aomc_sky as sky
source = sky.read_scene("{scene}", iterations=1000).source(5)
try:
    source.numba_sampler(0)
except sky.AomcSkyError as error:
    print(error)
"""


HIDDEN_FROM_HOSTS = {
    "add_dynamic_addr": "import numba.core.base as base; del base.BaseContext.add_dynamic_addr\n",
    "ExternalFunctionPointer": HIDE_NAME.format(module="numba.core.types", name="ExternalFunctionPointer"),
}


@pytest.mark.parametrize("name", HIDDEN_FROM_HOSTS)
def test_a_host_without_a_private_name_ends_with_one_sentence(name):
    said = with_numba(HIDDEN_FROM_HOSTS[name] + HOST.format(scene=INPUTS / "overcast")).strip()
    assert re.fullmatch(rf"hosts need a name .*{name}.*; take photons in batches, or install numba \S+", said)


_VARIANTS = """
from aomc_sky.kernels.jit import inner, kernel

def variant(step):
    def loop(x):
        for _ in range(3):
{lines}
        return x
    return inner(loop)

one, two = variant(1.0), variant(2.0)

@kernel
def first(x):
    return one(x) + one(2.0 * x)

@kernel
def second(x):
    return two(x) + two(2.0 * x)
"""


def test_variants_of_one_text_cached_by_two_processes_keep_apart(tmp_path):
    """Too long to be inlined, they are found by name: with numba's own numbers one takes the place of the other."""
    lines = "\n".join(f"            x = x * 0.5 + step / (x + {k}.0)" for k in range(1, 60))
    (tmp_path / "variants.py").write_text(_VARIANTS.format(lines=lines))

    def printed(*kernels):
        calls = ", ".join(f"variants.{name}(1.0)" for name in kernels)
        where = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
        return with_numba(f"import variants; print({calls})", **where).split()

    alone = printed("first") + printed("second")
    assert alone[0] != alone[1]
    assert printed("first", "second") == alone


PROGRAM = """
import sys
from aomc_sky.kernels import backend
assert not backend.use_kernels(1) and "numba" not in sys.modules
assert backend.use_kernels(backend.PLAIN_PHOTONS) and "numba" in sys.modules
"""


def test_the_thread_that_takes_the_kernels_loads_numba_for_all():
    in_environment(PROGRAM)
