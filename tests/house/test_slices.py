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

WORK = """
import hashlib, json, sys
from pathlib import Path
import numpy as np
import aomc_sky as sky
from aomc_sky.cli.main import main
from aomc_sky.kernels import backend

scene, out, *ways = sys.argv[1:]
assert main(["validate", scene]) == 0
for way in ways:
    backend.PLAIN_PHOTONS = 0 if way == "compiled" else backend.PLAIN_PHOTONS
    run = f"{out}/{way}"
    assert main(["run", scene, "--iterations", "2e4", "--out", run, "-q"]) == main(["verify", run, "-q"]) == 0
    assert main(["plot", run, "--out", f"{out}/{way}.svg", "-q"]) == 0
    source = sky.PhotonSource(sky.Plan.load(f"{run}/plan.npz"))
    (Path(out) / f"{way}.sky").write_bytes(source.to_bytes())
if "compiled" in ways:
    assert "numba" in sys.modules
    sampler = source.numba_sampler(0)
    photons = np.zeros((3, sampler.n), source.dtype)
    assert sampler.fill(0, photons) == sampler.n
    photons.tofile(f"{out}/host.bin")
files = [path for path in sorted(Path(out).rglob("*")) if path.is_file()]
print(sky.__file__)
print(json.dumps({str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}))
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The folder of a copy of the package that lacks some slices."""

    @cache
    def copy(*missing):
        folder = tmp_path_factory.mktemp("package")
        shutil.copytree(REPOSITORY / "src/aomc_sky", folder / "aomc_sky", ignore=shutil.ignore_patterns("__pycache__"))
        for name in missing:
            shutil.rmtree(folder / "aomc_sky" / "skies" / name)
        return folder

    yield copy
    copy.cache_clear()


def python(package, *words):
    environment = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(package / "cache")}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=package, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("missing", "scene", "ways"),
    [
        (("lobes", "atmosphere"), "clear_day", ("plain", "compiled")),
        (("lobes", "atmosphere"), "perez_sky", ("plain", "compiled")),
        (("atmosphere",), "night_sky", ("plain", "compiled")),
        (("lobes",), "atmosphere_sky", ("plain",)),
    ],
)
def test_scenes_that_need_no_slice_give_the_same_bytes(package, missing, scene, ways, tmp_path):
    for library in ("matplotlib", *(["h5py"] if scene == "night_sky" else [])):
        pytest.importorskip(library)
    found = []
    for k, folder in enumerate((package(*missing), package())):
        out = tmp_path / str(k)
        out.mkdir()
        done = python(folder, "-c", WORK, INPUTS / scene, out, *ways)
        assert done.returncode == 0, done.stderr
        *_, path, digests = done.stdout.splitlines()
        assert path.startswith(str(folder))  # not the one that is installed
        found.append(json.loads(digests))
    assert found[0] == found[1]


@pytest.mark.parametrize("command", ["run", "validate", "plot", "info"])
@pytest.mark.parametrize(("name", "scene"), [("lobes", "night_sky"), ("atmosphere", "atmosphere_sky")])
def test_a_scene_names_the_slice_that_is_missing(package, tmp_path, command, name, scene):
    out = {"run": ["--out", tmp_path / "out"], "plot": ["--out", tmp_path / "sky.svg"]}.get(command, [])
    done = python(package(name), "-m", "aomc_sky", command, INPUTS / scene, *out)
    assert done.returncode != 0
    assert f"No module named 'aomc_sky.skies.{name}'" in done.stderr + done.stdout
    assert list(tmp_path.iterdir()) == []
