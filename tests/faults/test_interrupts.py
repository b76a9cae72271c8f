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
