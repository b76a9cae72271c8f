"""Row 46: plans changed by hand: refused by their hash; and with a new hash, where no index leaves its array."""

import contextlib
import dataclasses
import io
import multiprocessing
import os
import resource
import shutil
import subprocess
import sys
import warnings
import zipfile

import numpy as np
import pytest

from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import AomcSkyError, InputFileError
from aomc_sky.plan.plan import Plan, from_members
from tests.support.damaged_plans import DAMAGED_FILES, KINDS, damages, plan_of
from tests.support.fault_rows import command, row
from tests.support.shared import REPOSITORY

N_RANDOM = 300
MOST_PHOTONS = 10**6
MOST_BYTES = 2**33
"""Of address space: a plan that unpacks to gigabytes, or an array of 10^15, ends in MemoryError."""

MOST_CPU_S = 15
"""Of a child, many times what it takes: what goes on for ever is killed by the system, and the test says so."""


_FORK = multiprocessing.get_context("fork")


def in_child(work, most_s=MOST_CPU_S):
    """What `work` returns in a process with little memory and time."""
    receiver, sender = _FORK.Pipe(duplex=False)

    def run():
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
        resource.setrlimit(resource.RLIMIT_CPU, (most_s, most_s))
        sender.send(work())

    child = _FORK.Process(target=run)
    child.start()
    sender.close()
    try:
        return receiver.recv()
    except EOFError:
        child.join()
        return [f"the child ended with {child.exitcode}"]
    finally:
        receiver.close()
        child.join()


def said_by(*words):
    """Exit code and text of a command; what it raises is our bug."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        code = command(*words)
    return code, out.getvalue()


def refused(name, codes, load, *given):
    """What is wrong where a plan is loaded that must be refused with one of these codes, and its member named."""
    try:
        load(*given)
    except InputFileError as error:
        is_said = error.problems[0].code in codes and (load == Plan.load or error.problems[0].field)
        return [] if is_said else [f"{name}: {error}"]
    except Exception as error:
        return [f"{name}: {load.__name__} raised {error!r}"]
    return [f"{name}: {load.__name__} took it"]


def by_command(run, k, name, codes):
    """What is wrong with the answer of one of the commands that read a plan."""
    export = run.parent / "export"
    words = [("info", run), ("verify", run), ("export", run, "--to", "npy", "--out", export)][k % 3]
    code, text = said_by(*words)
    is_right = code == 3 and any(f"error[{one}]" in text for one in codes) and "Traceback" not in text
    return [] if is_right and not export.exists() else [f"{name}: {words[0]} said {code}, {text[:200]}"]


def test_a_second_perez_sky_is_refused():
    """No kernel looks for it; a plan can come from a program, too."""
    plan = plan_of("perez")
    (perez,) = plan.components
    again = dataclasses.replace(perez, name="again", mass=0 * perez.mass, strength=0 * perez.strength)
    options = {**plan.options, "components": ["perez", "again"], "azimuth_first_index": [0, 0]}
    cumulative = np.hstack([plan.cumulative, np.repeat(plan.cumulative[:, -1:], perez.n_cells, axis=1)])
    with pytest.raises(InputFileError, match=r"E954\]: law: found 2 components of law PEREZ"):
        dataclasses.replace(plan, components=(perez, again), cumulative=cumulative, options=options)


@row(46, "a-byte-of-any-member")
def test_a_changed_member_does_not_fit_the_hash(fault, small_run, tmp_path):
    """Every member of the file, changed in its last byte, and the hash as it was."""
    path = tmp_path / "plan.npz"
    with zipfile.ZipFile(small_run / "plan.npz") as stored:
        members = {name: stored.read(name) for name in stored.namelist()}
    for changed in [name for name, data in members.items() if len(data) > 128]:  # an empty array has no byte to change
        with zipfile.ZipFile(path, "w") as file:
            for name, data in members.items():
                file.writestr(name, data[:-1] + bytes([data[-1] ^ 1]) if name == changed else data)
        assert refused(changed, ("E951", "E955"), Plan.load, path) == []


@row(46, "damaged-plans", "files-that-are-no-plan")
def test_every_command_refuses_a_damaged_plan(fault, small_run, tmp_path):
    """Each command a third of them, and the members of each by themselves.

    The code and the member are those of the table; what the damage of one does to another may be named instead.
    """
    copy = shutil.copytree(small_run, tmp_path / "run")
    (copy / "plan.npz").unlink()

    def damaged():
        for k, damage in enumerate(damages()):
            codes = damage.codes.split()
            wrong = refused(damage.name, codes, from_members, *damage.members())
            with contextlib.suppress(TypeError, ValueError, KeyError):  # what cannot be written is no file
                (copy / "plan.npz").write_bytes(damage.file())
                wrong += by_command(copy, k, damage.name, codes)
            yield wrong

    def no_plan():
        codes = ("E951", "E955", "E961", "E100")  # or the folder says it; and no file at all is no run
        for name, write in DAMAGED_FILES.items():
            write(copy / "plan.npz")
            yield refused(name, codes, Plan.load, copy / "plan.npz")
            yield [line for k in range(3) for line in by_command(copy, k, name, codes)]
            path = copy / "plan.npz"
            path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)

    assert len(damages()) >= 240
    work = damaged if fault == "damaged-plans" else no_plan
    assert in_child(lambda: [line for wrong in work() for line in wrong], 10 * MOST_CPU_S) == []


def random_value(generator, value, dtype):
    """Another value of an array: a neighbour, an end of its type, nonsense."""
    if dtype.kind == "f":
        with np.errstate(all="ignore"):
            near = value * (1 + 1e-15), value + 1e-9, 2 * value, -value
            choices = [*near, 0.0, 1.0, 5e-324, 1e308, -1e308, np.nan, np.inf]
        return generator.choice(np.array([*choices, generator.normal()]))
    ends = np.iinfo(dtype)
    choices = [0, 1, int(value) + 1, int(value) - 1, int(value) ^ (1 << int(generator.integers(8))), ends.max, ends.min]
    return dtype.type(min(max(choices[int(generator.integers(len(choices)))], int(ends.min)), int(ends.max)))


def random_damage(generator, kind):
    """Members and options with one value of one array changed at random; not of the tables of Perez and lobes."""
    plan = plan_of(kind)
    members = {name: array.copy() for name, array in plan.members().items()}
    names = sorted(n for n, array in members.items() if array.size and not n.startswith(("bounds_", "shared_")))
    name = names[int(generator.integers(len(names)))]
    at = int(generator.integers(members[name].size))
    flat = members[name].reshape(-1)
    flat[at] = random_value(generator, flat[at], flat.dtype)
    return f"{kind}: {name}[{at}]", (members, plan.options)


def judged_photons(what, damaged, fill):
    """What is wrong with the photons of a plan, and whether it was taken: photons of patches that are there."""
    try:
        source = PhotonSource(from_members(*damaged))
    except AomcSkyError:
        return "", False
    for lane in range(source.n_bands * source.replicates):
        n = source._emitter.n_photons(lane)
        if n > MOST_PHOTONS:
            continue
        kinds = {"ux": source.dtype, "uy": source.dtype, "uz": source.dtype, "patch": np.int32, "x": source.dtype}
        arrays = {name: np.full(n, 99, kind) for name, kind in {**kinds, "y": source.dtype}.items()}
        if n:
            getattr(source._emitter, fill)(lane, 0, arrays)
        patches = arrays["patch"]
        if n and not (patches.min() >= 0 and patches.max() < source.plan.n_cells):
            return f"{what}: patches {patches.min()} to {patches.max()}", True
    return "", True


def photons_of_random_plans(n, seed, fill):
    """What is wrong with the photons of n random plans; of each kind some must be taken and some not."""
    warnings.simplefilter("ignore")  # of numbers that are no directions, and of words, which wrap on purpose
    generator = np.random.default_rng(seed)
    wrong, seen = [], set()
    for k in range(n):
        kind = KINDS[k % len(KINDS)]
        what, damaged = random_damage(generator, kind)
        try:
            problem, taken = judged_photons(what, damaged, fill)
        except Exception as error:
            problem, taken = f"{what}: {error!r}", True
        wrong += [problem] if problem else []
        seen.add((kind, taken))
    return wrong + [f"{kind} never {taken}" for kind in KINDS for taken in (True, False) if (kind, taken) not in seen]


@row(46, "plans-changed-at-random")
def test_a_plan_with_another_value_gives_good_photons_or_none(fault):
    assert in_child(lambda: photons_of_random_plans(N_RANDOM, 11, "fill_plain"), 4 * MOST_CPU_S) == []


@pytest.mark.slow
@row(46, "plans-changed-at-random-by-the-kernels")
def test_the_kernels_give_good_photons_or_none(fault):
    assert in_child(lambda: photons_of_random_plans(30 * N_RANDOM, 12, "fill_compiled"), 20 * MOST_CPU_S) == []


PROBE = """
from tests.faults.test_plan_faults import KINDS, photons_of_random_plans
from aomc_sky.kernels.jit import is_off
assert is_off()
print(*photons_of_random_plans(14 * len(KINDS), 13, "fill_compiled"), sep="\\n")
"""


@pytest.mark.slow
@row(46, "no-index-leaves-its-array")
def test_no_kernel_looks_outside_an_array(fault):
    """The kernels as Python: numpy raises IndexError where machine code would read what stands behind an array."""
    words = [sys.executable, "-c", PROBE]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        words, cwd=REPOSITORY, env=environment, capture_output=True, text=True, timeout=1800, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip() == ""
