"""manifest.json: the published schema, and manifests that nobody of us wrote."""

import copy
import json

import jsonschema
import pytest

from aomc_sky.cli.main import main
from aomc_sky.outputs.manifest import manifest_bytes
from tests.support.scenes import copy_scene
from tests.support.shared import REPOSITORY

SCHEMA = json.loads((REPOSITORY / "src/aomc_sky/outputs/manifest.schema.json").read_text())


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    amc = copy_scene("document_example", folder)
    words = ["--iterations", "200", "--format", "npy", "--format", "raw", "--replicates", "3", "-q"]
    assert main(["run", str(amc), "--out", str(folder / "out"), *words]) == 0
    return folder / "out"


def changed(manifest, place, value):
    part = manifest = copy.deepcopy(manifest)
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    return manifest


def test_the_schema_refuses_what_is_no_manifest(run):
    whole = json.loads((run / "manifest.json").read_text())
    for place, value in (
        (("schema",), "aomc-sky-manifest/1"),
        (("run",), {}),
        (("bands", 0, "launched"), -1),
        (("bands", 0, "residual"), 0.5),
        (("files", "../victim"), {"bytes": 1}),
        (("files", "photons-0001.npy", "bytes"), "1"),
        (("files", "photons-0001.raw", "columns"), ["energy"]),
        (("options", "formats"), ["../npy"]),
    ):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(changed(whole, place, value), SCHEMA)


def paths_of(value, path=()):
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
            manifest = changed(whole, path, VALUES[(k + turn) % len(VALUES)])
            (run / "manifest.json").write_text(json.dumps(manifest))
            for words in (["info", str(run)], ["verify", str(run), "--resample", "0", "-q"]):
                assert main(words) in (0, 1, 3, 5), (words, path)
    finally:
        (run / "manifest.json").write_bytes(manifest_bytes(whole))
    assert "Traceback" not in capsys.readouterr().err
