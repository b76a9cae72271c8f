"""A slice below `skies/` can be deleted: scenes without it give the same bytes, others name what is missing."""

import json
import os
import shutil
import subprocess
import sys
from functools import cache

import pytest

from tests.support.shared import INPUTS, REPOSITORY

pytestmark = pytest.mark.slow

WITHOUT = {"lobes": ("lobes",), "atmosphere": ("atmosphere",), "both": ("lobes", "atmosphere")}
"""Copies of the package -> the slices that they lack."""

N = "2e4"

_WORK = """
import contextlib, hashlib, io, json, sys
from pathlib import Path
import aomc_sky
from aomc_sky.cli.main import main

scene, out, *works = sys.argv[1:]

def command(*words):
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = main([*words])
    assert code == 0, (words, code, said.getvalue())

def digests(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(Path(folder).iterdir())}

def plain():
    command("run", scene, "--iterations", ITERATIONS, "--out", f"{out}/plain", "-q")
    return digests(f"{out}/plain")

def compiled():
    from aomc_sky.kernels import backend
    backend.PLAIN_PHOTONS = 0  # as if the job were large
    command("run", scene, "--iterations", ITERATIONS, "--out", f"{out}/compiled", "-q")
    assert "numba" in sys.modules
    return digests(f"{out}/compiled")

def looks():
    command("validate", scene)
    command("verify", f"{out}/plain", "-q")
    command("plot", scene, "--out", f"{out}/scene.svg", "-q")
    command("plot", f"{out}/plain", "--out", f"{out}/run.svg", "-q")
    return [Path(out, name).stat().st_size > 0 for name in ("scene.svg", "run.svg")]

def host():
    import numpy as np
    source = aomc_sky.read_scene(scene, iterations=int(float(ITERATIONS))).source(1)
    sampler = source.numba_sampler(0)
    photons = np.zeros((3, sampler.n), source.dtype)
    assert sampler.fill(0, photons) == sampler.n
    return [hashlib.sha256(data).hexdigest() for data in (photons.tobytes(), source.to_bytes())]

package_folder = Path(aomc_sky.__file__).parent
print(json.dumps({"package": str(package_folder), **{work: globals()[work]() for work in works}}))
""".replace("ITERATIONS", repr(N))


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The folder of a copy of the package, by its name in `WITHOUT`, or "whole"."""

    @cache
    def copy(name):
        folder = tmp_path_factory.mktemp(name)
        shutil.copytree(REPOSITORY / "src/aomc_sky", folder / "aomc_sky", ignore=shutil.ignore_patterns("__pycache__"))
        for missing in WITHOUT.get(name, ()):
            shutil.rmtree(folder / "aomc_sky" / "skies" / missing)
        return folder

    yield copy
    copy.cache_clear()


def python(package, *words):
    command = [sys.executable, *words]
    environment = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(package / "cache")}
    return subprocess.run(command, cwd=package, env=environment, capture_output=True, text=True, check=False)


def work(package, scene, *works):
    out = package / scene / "-".join(works)
    out.mkdir(parents=True)
    done = python(package, "-c", _WORK, str(INPUTS / scene), str(out), *works)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert found.pop("package") == str(package / "aomc_sky")  # not the one that is installed
    return found


@pytest.mark.parametrize(
    ("name", "scene", "works"),
    [
        ("both", "clear_day", "plain looks compiled host"),
        ("both", "perez_sky", "plain looks compiled host"),
        ("atmosphere", "night_sky", "plain compiled host"),
        ("lobes", "atmosphere_sky", "plain"),
    ],
)
def test_scenes_that_need_no_slice_give_the_same_bytes(package, name, scene, works):
    for library in {"both": ["matplotlib"], "atmosphere": ["h5py"]}.get(name, []):
        pytest.importorskip(library)
    assert work(package(name), scene, *works.split()) == work(package("whole"), scene, *works.split())


@pytest.mark.parametrize("command", ["run", "validate", "plot", "info"])
@pytest.mark.parametrize(("name", "scene"), [("lobes", "night_sky"), ("atmosphere", "atmosphere_sky")])
def test_a_scene_names_the_slice_that_is_missing(package, tmp_path, command, name, scene):
    out = {"run": ["--out", str(tmp_path / "out")], "plot": ["--out", str(tmp_path / "sky.svg")]}.get(command, [])
    done = python(package(name), "-m", "aomc_sky", command, str(INPUTS / scene), *out)
    assert done.returncode != 0
    assert f"No module named 'aomc_sky.skies.{name}'" in done.stderr + done.stdout
    assert list(tmp_path.iterdir()) == []
