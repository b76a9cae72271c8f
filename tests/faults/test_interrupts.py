"""Row 55: Ctrl-C at any moment of the first call that imports numba leaves a process that works."""

import itertools
import os
import signal
import subprocess
import sys
import time

import pytest

from aomc_sky.kernels import jit
from aomc_sky.system import interrupts_held
from tests.support.fault_rows import row

FIRST_CALL = """
import os, signal, sys, threading, time
import numpy as np
import aomc_sky as sky

source = sky.Scene(wavebands=[550.0], n_photons=300_000, components="uniform").source(seed=1)
calls = {
    "photons": lambda: float(source.photons(0).uz.mean(dtype=float)),
    "numba_sampler": lambda: source.numba_sampler(0).sample(5)[0],
    "multinomial": lambda: sky.allocate(np.ones(5), 100, method="multinomial", seed=1).sum(),
}
call = calls[sys.argv[2]]
begins = threading.Event()


def press():
    begins.wait()
    time.sleep(float(sys.argv[1]))
    os.kill(os.getpid(), signal.SIGINT)


threading.Thread(target=press, daemon=True).start()
try:
    begins.set()
    call()
    time.sleep(5)
except KeyboardInterrupt:
    pass
print(call())
"""
MOMENTS = [0.01, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6]
"""Of the call that imports numba. [s]"""


DEFAULT = {("photons", 0.3), ("numba_sampler", 0.2), ("multinomial", 0.25)}
"""Cases of the default suite: in the middle of the import."""


@pytest.mark.parametrize(
    ("name", "moment"),
    [
        pytest.param(*case, id=f"row-55-{case[0]}-after-{case[1]}", marks=[] if case in DEFAULT else pytest.mark.slow)
        for case in itertools.product(("photons", "numba_sampler", "multinomial"), MOMENTS)
    ],
)
def test_the_second_call_works(moment, name):
    words = [sys.executable, "-c", FIRST_CALL, str(moment), name]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    if name == "photons":
        assert float(done.stdout) == pytest.approx(-2 / 3, abs=2e-3)
    elif name == "multinomial":
        assert done.stdout.strip() == "100"


@pytest.fixture
def interruptible():
    """A shell starts what it runs in the background with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@row(55, "held")
def test_an_interrupt_waits_for_the_end_of_the_block(fault, interruptible):
    ended = False
    with pytest.raises(KeyboardInterrupt), interrupts_held():  # noqa: PT012 - what it interrupts is the block
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        ended = True
    assert ended
    with interrupts_held():
        pass


@row(55, "compile")
@pytest.mark.skipif(jit.is_off(), reason="compiles nothing")
def test_an_interrupt_waits_for_the_compiler(fault, interruptible, monkeypatch):
    """llvmlite notes who owns the code after each call of LLVM; an interrupt in between ended in SIGSEGV."""
    ended = []

    def pressed(compiler, function):
        os.kill(os.getpid(), signal.SIGINT)
        ended.append(compile_extra(compiler, function))
        return ended[0]

    numba_private = pytest.importorskip("aomc_sky.kernels.numba_private")
    compile_extra = numba_private.CompilerBase.compile_extra
    monkeypatch.setattr(numba_private.CompilerBase, "compile_extra", pressed)
    function = jit.shared(lambda x: x + 1)
    with pytest.raises(KeyboardInterrupt):
        function(1)
    assert len(ended) == 1


BEFORE_ANYTHING = """
import importlib.abc, os, signal, sys

class Pressed(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "aomc_sky.cli.main":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Pressed())
from {module} import main
main()
"""


def interrupted(program, *words):
    """A program that hears Ctrl-C, which a shell lets its background jobs ignore."""
    hear = lambda: signal.signal(signal.SIGINT, signal.default_int_handler)  # noqa: E731
    words = [sys.executable, "-c", program, *map(str, words)]
    return subprocess.run(words, capture_output=True, text=True, timeout=60, check=False, preexec_fn=hear)


@row(55, "before the package")
def test_the_command_hears_an_interrupt_before_the_package_is_imported(fault):
    """Planted: the package alone, whose import ended in a traceback and a death by the signal."""
    done = interrupted(BEFORE_ANYTHING.format(module="aomc_sky.cli.command"), "--version")
    assert (done.returncode, done.stderr, done.stdout) == (130, "aomc-sky: interrupted\n", "")
    assert "KeyboardInterrupt" in interrupted(BEFORE_ANYTHING.format(module="aomc_sky.cli.main")).stderr


DEAF = """
import os, signal, sys, threading, time
from aomc_sky import system
from aomc_sky.cli import interrupts, main

def deaf(arguments):
    for k in range(int(sys.argv[2])):
        threading.Timer(0.1 + 0.2 * k, os.kill, (os.getpid(), signal.SIGINT)).start()
    block = system.tidying() if len(sys.argv) > 3 else system.interrupts_held()
    with block, system.interrupts_held():
        end = time.monotonic() + 2
        while time.monotonic() < end:
            time.sleep(0.01)
        print("it came back", flush=True)
    return 0

interrupts.GRACE_S = float(sys.argv[1])
from aomc_sky.cli.commands import info
info.info = deaf
sys.exit(main.main(["info", "x"]))
"""


@pytest.mark.parametrize(
    ("grace_s", "presses", "more", "came_back"),
    [(0.3, 1, [], False), (60, 2, [], False), (60, 1, [], True), (0.3, 1, ["tidying"], True)],
    ids=[f"row-55-{name}" for name in ("once", "twice", "in-time", "tidying")],
)
def test_a_command_that_hears_nothing_ends_soon(grace_s, presses, more, came_back):
    """As in numba's compiler; a second Ctrl-C ends it at once, and one that ends processes of its own is left alone."""
    done = interrupted(DEAF, grace_s, presses, *more)
    assert done.returncode == 130
    assert done.stderr == "aomc-sky: interrupted\n"
    assert ("it came back" in done.stdout) == came_back
