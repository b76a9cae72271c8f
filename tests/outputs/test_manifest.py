"""manifest.json: the published schema, and manifests that nobody of us wrote."""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path

import jsonschema
import pytest

from aomc_sky.cli.main import main
from aomc_sky.errors import AomcSkyError
from aomc_sky.outputs.manifest import manifest_bytes, read_manifest
from tests.support.scenes import copy_scene
from tests.support.shared import REPOSITORY

SCHEMA = json.loads((REPOSITORY / "src/aomc_sky/outputs/manifest.schema.json").read_text())


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    amc = copy_scene("document_example", folder)
    words = ["--iterations", "200", "--format", "npy", "--format", "raw", "--replicates", "3", "-q"]
    assert main(["run", str(amc), "--out", str(folder / "out"), *words]) == 0
    return folder / "out"


def test_a_manifest_keeps_its_schema(run):
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    manifest = read_manifest(run / "manifest.json")
    jsonschema.validate(manifest, SCHEMA)
    assert manifest_bytes(manifest) == (run / "manifest.json").read_bytes()
    record = {"numbers": "float32, little-endian", "columns": ["ux", "uy", "uz"]}
    assert manifest["files"] == {
        path.name: {"bytes": path.stat().st_size} | (record if path.suffix == ".raw" else {})
        for path in sorted(run.iterdir())
        if path.name != "manifest.json"
    }


def test_a_source_file_is_a_file_of_the_schema(tmp_path):
    amc = copy_scene("document_example", tmp_path)
    words = ["--iterations", "200", "--format", "source", "-q"]
    assert main(["run", str(amc), "--out", str(tmp_path / "out"), *words]) == 0
    manifest = read_manifest(tmp_path / "out" / "manifest.json")
    assert "source.sky" in manifest["files"]
    jsonschema.validate(manifest, SCHEMA)


def test_all_columns_of_a_raw_file_are_of_the_schema(tmp_path):
    amc = copy_scene("clear_day", tmp_path)
    amc.write_text(amc.read_text().replace("circle[2],rect.[3]  : 1", "circle[2],rect.[3]  : 2"))
    words = ["--iterations", "200", "--polarisation", "0.7", "--weights", "--format", "raw", "--format", "npy", "-q"]
    assert main(["run", str(amc), "--out", str(tmp_path / "out"), *words]) == 0
    manifest = read_manifest(tmp_path / "out" / "manifest.json")
    columns = ["ux", "uy", "uz", "x_m", "y_m", "weight", "q", "u"]
    assert manifest["files"]["photons-0001.raw"]["columns"] == columns
    jsonschema.validate(manifest, SCHEMA)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("schema",), "aomc-sky-manifest/1"),
        (("run",), {}),
        (("bands", 0, "launched"), -1),
        (("bands", 0, "residual"), 0.5),
        (("files", "../victim"), {"bytes": 1}),
        (("files", "photons-0001.npy", "bytes"), "1"),
        (("files", "photons-0001.raw", "columns"), ["energy"]),
        (("options", "formats"), ["../npy"]),
    ],
)
def test_the_schema_refuses_what_is_no_manifest(run, place, value):
    manifest = part = json.loads((run / "manifest.json").read_text())
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(manifest, SCHEMA)


@pytest.mark.parametrize("text", ["", "[]", "{}", "null", "7", '{"schema": "aomc-sky-manifest/2"}', "\xff", "[" * 9**5])
def test_damaged_manifests_name_the_file(tmp_path, text):
    (tmp_path / "manifest.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(AomcSkyError, match="manifest"):
        read_manifest(tmp_path / "manifest.json")


def paths_of(value: object, path: tuple = ()) -> list[tuple]:
    """Every value of a manifest that commands print."""
    if isinstance(value, dict):
        return [path, *(p for key in value for p in paths_of(value[key], (*path, key)))]
    if isinstance(value, list):
        return [path, *(p for k in range(len(value)) for p in paths_of(value[k], (*path, k)))]
    return [path]


VALUES = (None, "x", -1.5, [], {}, {"a": "b"}, True, 10**400)


@pytest.mark.parametrize("turn", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, len(VALUES)))])
def test_no_value_of_another_kind_ends_in_a_traceback(run, turn, capsys):
    whole = json.loads((run / "manifest.json").read_text())
    try:
        for k, path in enumerate(paths_of(whole)[1:]):
            value = VALUES[(k + turn) % len(VALUES)]
            part = manifest = copy.deepcopy(whole)
            for key in path[:-1]:
                part = part[key]
            part[path[-1]] = value
            (run / "manifest.json").write_text(json.dumps(manifest))
            for words in (["info", str(run)], ["verify", str(run), "--resample", "0", "-q"]):
                assert main(words) in (0, 1, 3, 5), (words, path)
    finally:
        (run / "manifest.json").write_bytes(manifest_bytes(whole))
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["link", "folder", "fifo"])
def test_what_is_no_file_is_not_read(run, tmp_path, kind):
    path = tmp_path / "manifest.json"
    if kind == "link":
        path.symlink_to(run / "manifest.json")
    elif kind == "folder":
        path.mkdir()
    else:
        os.mkfifo(path)
    with pytest.raises(AomcSkyError, match="E961"):
        read_manifest(path)
