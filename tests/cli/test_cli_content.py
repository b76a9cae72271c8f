"""The content hash in a run folder: leaves of the rows, roots in the manifest, damage that resuming repairs."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from aomc_sky.cli.main import main
from aomc_sky.outputs.photons.leaves import leaf_hash, tree_root
from tests.support.scenes import flip_bit, run_bytes, scene_with_circle
from tests.support.shared import REPOSITORY

BLOCK = 65_536
ITERATIONS = BLOCK + 465
SCHEMA = json.loads((REPOSITORY / "src/aomc_sky/outputs/manifest.schema.json").read_text())


@pytest.fixture
def amc(tmp_path: Path) -> Path:
    return scene_with_circle(tmp_path)


def run(amc: Path, out: Path, *words: object) -> int:
    return main(["run", *map(str, (amc, "--iterations", ITERATIONS, "-q", "--out", out, *words))])


def manifest_of(out: Path) -> dict:
    return json.loads((out / "manifest.json").read_text())


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("formats", [("npy",), ("raw", "mcpl", "npy")])
def test_leaves_are_those_of_the_rows(amc, tmp_path, precision, formats):
    words = [word for name in formats for word in ("--format", name)]
    assert run(amc, tmp_path / "out", "--precision", precision, *words) == 0
    manifest = manifest_of(tmp_path / "out")
    jsonschema.validate(manifest, SCHEMA)
    roots = []
    for band in (1, 2, 3):
        columns = [np.load(tmp_path / "out" / f"{kind}-{band:04d}.npy") for kind in ("photons", "positions")]
        wanted = [leaf_hash(*(c[start : start + BLOCK] for c in columns)) for start in range(0, ITERATIONS, BLOCK)]
        leaves = np.load(tmp_path / "out" / f"blocks-{band:04d}.npy")
        assert leaves.dtype == np.uint8
        assert [bytes(leaf) for leaf in leaves] == wanted
        roots.append(tree_root(wanted))
        assert manifest["content"]["bands"][band - 1] == {"waveband": band, "n_blocks": 2, "root": roots[-1].hex()}
        assert f"blocks-{band:04d}.npy" in manifest["files"]
    assert manifest["content"]["root"] == tree_root(roots).hex()
    assert manifest["content"]["block_photons"] == BLOCK


def test_the_root_is_that_of_the_photons_whatever_the_format(amc, tmp_path):
    roots = set()
    for name in ("npy", "raw", "mcpl"):
        assert run(amc, tmp_path / name, "--format", name, "--threads", len(roots) + 1) == 0
        roots.add(manifest_of(tmp_path / name)["content"]["root"])
    assert len(roots) == 1
    assert run(amc, tmp_path / "other", "--seed", 1) == 0
    assert manifest_of(tmp_path / "other")["content"]["root"] not in roots
    assert run(amc, tmp_path / "none", "--format", "none") == 0
    assert manifest_of(tmp_path / "none")["content"] is None
    jsonschema.validate(manifest_of(tmp_path / "none"), SCHEMA)


DAMAGED = ("photons-0002.npy", "positions-0002.npy", "blocks-0002.npy", "photons-0002.raw", "photons.mcpl")


@pytest.mark.parametrize("name", [*DAMAGED, "counts.csv", "plan.npz"])
def test_a_finished_run_with_a_flipped_bit_is_repaired(amc, tmp_path, name):
    """The same command finds the file by its hash, and makes nothing else again."""
    out, words = tmp_path / "out", ("--format", "npy", "--format", "raw", "--format", "mcpl")
    assert run(amc, out, *words) == 0
    whole = run_bytes(out)
    times = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    place = len(whole[name]) - 2 if name != "plan.npz" else 12  # a date of the archive, which changes no number
    flip_bit(out / name, place)
    assert run(amc, out, *words) == 0
    assert run_bytes(out) == whole
    for kept in ("photons-0001.npy", "photons-0003.raw", "blocks-0001.npy"):
        assert (out / kept).stat().st_mtime_ns == times[kept]


@pytest.mark.parametrize("name", [name for name in DAMAGED if "mcpl" not in name])
def test_an_unfinished_run_is_compared_with_its_leaves(amc, tmp_path, name):
    """Without a manifest the leaves find what is damaged; records of MCPL are rounded and have no leaves."""
    out, words = tmp_path / "out", ("--format", "npy", "--format", "raw")
    assert run(amc, out, *words) == 0
    whole = run_bytes(out)
    times = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    (out / "manifest.json").unlink()
    flip_bit(out / name, len(whole[name]) - 2)
    assert run(amc, out, *words) == 0
    assert run_bytes(out) == whole
    for kept in ("photons-0001.npy", "photons-0003.raw", "blocks-0001.npy"):
        assert (out / kept).stat().st_mtime_ns == times[kept]


def test_photons_without_leaves_are_made_again(amc, tmp_path):
    out = tmp_path / "out"
    assert run(amc, out) == 0
    whole = run_bytes(out)
    (out / "manifest.json").unlink()
    (out / "blocks-0002.npy").unlink()
    flip_bit(out / "photons-0002.npy", 1000)
    assert run(amc, out) == 0
    assert run_bytes(out) == whole
