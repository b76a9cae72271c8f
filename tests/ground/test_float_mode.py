"""A host that flushes small numbers to zero gets the plans and photons of everybody else; other rounding is refused.

Each mode is set by the C library in a process of its own, before the package is imported.
"""

import json
import platform
import subprocess
import sys

import pytest

from aomc_sky.errors import HostError
from aomc_sky.float_mode import default_mode, require_default
from tests.support.processes import in_environment
from tests.support.shared import INPUTS

# numbers of fenv.h
ROUNDING = {
    "x86_64": {"nearest": 0, "down": 0x400, "up": 0x800, "zero": 0xC00},
    "aarch64": {"nearest": 0, "up": 0x400000, "down": 0x800000, "zero": 0xC00000},
}.get(platform.machine(), {"nearest": 0})
FLUSH = "flush" if platform.machine() == "x86_64" and sys.platform == "linux" else None
OTHERS = [name for name in ROUNDING if name != "nearest"]

_HOST = """
import ctypes, hashlib, json, struct, sys, threading, warnings
libm = ctypes.CDLL(None)

def mode():
    state = ctypes.create_string_buffer(512)
    libm.fegetenv(state)
    return libm.fegetround(), int.from_bytes(state.raw[28:32], "little") & 0x8040

def set_mode(name, rounding):
    if name == "flush":
        state = ctypes.create_string_buffer(512)
        libm.fegetenv(state)
        word = int.from_bytes(state.raw[28:32], "little") | 0x8040
        changed = ctypes.create_string_buffer(state.raw[:28] + word.to_bytes(4, "little") + state.raw[32:], 512)
        libm.fesetenv(changed)
    else:
        assert libm.fesetround(rounding) == 0

name, rounding, scenes = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
set_mode(name, rounding)
before = mode()
import aomc_sky as sky
sky.read_scene
import numpy
warnings.simplefilter("ignore")
found = {}

def look(key, scene):
    source = scene.source(3)
    digest = hashlib.sha256()
    for band in range(source.n_bands):
        batch = source.photons(band)
        for part in source.batches(band, 999):
            digest.update(part.ux.tobytes() + part.uz.tobytes())
        digest.update(batch.ux.tobytes() + batch.uy.tobytes() + batch.uz.tobytes())
    found[key] = [source.plan.sha256, digest.hexdigest(), repr(source.exact_moments(0))]

for path in scenes:
    look(path, sky.read_scene(path, iterations=5000))
perez = sky.PerezSky(sun_zenith_rad=0.7, dni=700.0, dhi=130.0)
look("python", sky.Scene(wavebands=numpy.array([500.0]), n_photons=3000, components=(perez,)))
tiny = struct.unpack("<3d", struct.pack("<3q", 1, 2, 3))  # 5e-324, 1e-323, 1.5e-323
found["subnormal"] = sky.allocate(tiny, 600).tolist()
if name != "flush":
    thread = threading.Thread(target=look, args=("thread", sky.read_scene(scenes[0], iterations=5000)))
    thread.start()
    thread.join()
try:
    sky.read_scene(scenes[0], iterations=5000).source(3).numba_sampler(0)
    found["sampler"] = "given"
except sky.AomcSkyError as error:
    found["sampler"] = str(error)
assert mode() == before, "the host finds another mode than its own"
print(json.dumps(found))
"""


def found_under(mode):
    scenes = [str(INPUTS / name / "amc.inp") for name in ("document_example", "perez_sky", "sun_and_sky")]
    return json.loads(in_environment(_HOST, mode, ROUNDING.get(mode, 0), *scenes))


@pytest.fixture(scope="module")
def usual():
    return found_under("nearest")


needs_flush = pytest.mark.skipif(FLUSH is None, reason="set aside on Linux on x86-64 alone")


@needs_flush
def test_plans_and_photons_are_the_same_where_small_numbers_are_flushed(usual):
    found = found_under(FLUSH)
    assert usual.pop("sampler", "given") == "given"
    assert "works in the floating-point mode of its host" in found.pop("sampler")
    assert found == {key: usual[key] for key in found}
    assert found["subnormal"] == [100, 200, 300]


@needs_flush
def test_without_the_guard_flushing_makes_other_counts(usual):
    """The planted defect: the same host, with the guard taken out."""
    change = "import aomc_sky.float_mode as guard\nguard.is_default = lambda: True\nimport aomc_sky as sky"
    program = _HOST.replace("import aomc_sky as sky", change)
    command = [sys.executable, "-c", program, FLUSH, "0", str(INPUTS / "document_example" / "amc.inp")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode != 0 or json.loads(done.stdout)["subnormal"] != usual["subnormal"]


_REFUSED = """
import ctypes, sys
import aomc_sky as sky
from aomc_sky.cli.main import main
path, out, *modes = sys.argv[1:]
scene = sky.read_scene(path, iterations=3000)
calls = scene.source, lambda: sky.read_scene(path), lambda: sky.allocate([1.0, 2.0], 3)
for mode in map(int, modes):
    assert ctypes.CDLL(None).fesetround(mode) == 0
    for call in calls:
        try:
            call()
        except sky.AomcSkyError as error:
            print(error)
    print(main(["run", path, "--out", out]))
"""


@pytest.mark.skipif(not OTHERS, reason="their numbers are known on two processors")
def test_another_rounding_is_refused_with_one_sentence(tmp_path):
    scene = str(INPUTS / "document_example" / "amc.inp")
    modes = [str(ROUNDING[mode]) for mode in OTHERS]
    command = [sys.executable, "-c", _REFUSED, scene, str(tmp_path / "out"), *modes]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    sentence = "this thread does not round to nearest; call fesetround(FE_TONEAREST) before aomc-sky"
    assert done.stdout.splitlines() == [*[sentence] * 3, "6"] * len(OTHERS)
    assert done.stderr.count(sentence) == len(OTHERS)
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_flushing_that_cannot_be_set_aside_is_refused(monkeypatch):
    monkeypatch.setattr("aomc_sky.float_mode.is_default", lambda: False)
    monkeypatch.setattr("aomc_sky.float_mode.has_linux_sse_state", lambda: False)
    with pytest.raises(HostError, match="flushes small numbers to zero") as caught, default_mode():
        pass
    assert caught.value.exit_code == 6
    with pytest.raises(HostError, match="a host works in"):
        require_default("a host")
