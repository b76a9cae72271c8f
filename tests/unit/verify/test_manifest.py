"""Every value of a manifest changed by one character: `verify` names the key."""

from __future__ import annotations

import copy
import json
import re
from dataclasses import replace

import pytest

from aomc_sky.cli.main import main
from aomc_sky.engine.stored_run import open_run
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.manifest import rest_sha256
from aomc_sky.outputs.photons.leaves import StoredPhotons
from aomc_sky.outputs.statistics import PhotonSums
from aomc_sky.verify.stored.manifest import manifest_check
from aomc_sky.verify.stored.parts import open_parts
from tests.support.shared import INPUTS

SCENE = INPUTS / "document_example" / "amc.inp"


def made(folder, *words):
    assert main(["run", str(SCENE), "--iterations", "1000", "-q", "--out", str(folder), *words]) == 0
    return open_parts(RunFolder(folder), open_run(folder).source)[0]


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    """A run of two of the three wavebands with weights and replicates, so that no value of its bands is null."""
    out = tmp_path_factory.mktemp("manifest") / "out"
    return made(
        out, "--waveband", "1", "--waveband", "3", "--weighting", "solid-angle", "--weights", "--replicates", "3"
    )


@pytest.fixture(scope="module")
def shard(tmp_path_factory):
    return made(tmp_path_factory.mktemp("manifest") / "shard", "--shard", "1/2")


@pytest.fixture(scope="module")
def sums(part):
    """Sums over the photons, as a verification reads them."""
    found = {}
    for band in part.bands:
        found[band] = PhotonSums(part.source.replicates)
        for span in part.spans(band):
            with StoredPhotons(part.folder, part.row_writers[0], band) as stored:
                found[band].add(stored.block(span).sums)
    return found


def leaves(value, path=()):
    """Paths of all values."""
    if isinstance(value, dict | list) and value:
        for key, below in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(below, (*path, key))
    else:
        yield path


def named(path):
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)[1:]


def changed(value):
    """The value with one character changed, and another value where it has none."""
    if value is None or isinstance(value, bool | dict | list):
        return {None: 0, False: True, True: False}.get(value) if not isinstance(value, dict | list) else None
    if isinstance(value, str):
        return value[:-1] + ("0" if value[-1:] != "0" else "1")
    text = repr(value)
    digit = re.search(r"[0-9]", text).start()
    return json.loads(text[:digit] + str(int(text[digit]) % 9 + 1) + text[digit + 1 :])


def spoilt(part, path, *, sealed):
    """The part with one value changed, and with the hash made to agree again."""
    manifest = copy.deepcopy(part.manifest)
    *above, last = path
    place = manifest
    for key in above:
        place = place[key]
    assert changed(place[last]) != place[last]
    place[last] = changed(place[last])
    if sealed:
        manifest["run"]["rest_sha256"] = rest_sha256({k: v for k, v in manifest.items() if k != "run"})
    return replace(part, manifest=manifest)


UNKNOWN = ("version", "inputs", "notes", ("options", "scene"))
"""What no plan knows."""


def is_known(path):
    is_of_files = path[0] == "files" and path[-1] in ("bytes", "sha256")  # compared with the files themselves
    return path[0] not in UNKNOWN and path[:2] not in UNKNOWN and not is_of_files


def outside_run(part):
    return [path for path in leaves(part.manifest) if path[0] not in ("run", "schema") and path[-1] != "formats"]


def test_a_manifest_passes(part, shard, sums):
    for check in (manifest_check(part, sums), manifest_check(part, {}), manifest_check(shard, {})):
        assert check.passed, check.detail


def test_every_value_is_covered_by_the_hash(part, shard, sums):
    for of_part, of_sums in ((part, sums), (shard, {})):
        paths = [path for path in outside_run(of_part) if path[:2] != ("options", "formats")]
        assert len(paths) > 40
        for path in paths:
            assert not manifest_check(spoilt(of_part, path, sealed=False), of_sums).passed, path


def test_every_value_that_the_plan_knows_is_compared(part, shard, sums):
    """Also where somebody made the hash agree again: the key is named."""
    for of_part, of_sums in ((part, sums), (shard, {})):
        paths = [p for p in outside_run(of_part) if is_known(p) and p[:2] != ("options", "formats")]
        assert len(paths) > 25
        for path in paths:
            check = manifest_check(spoilt(of_part, path, sealed=True), of_sums)
            assert not check.passed, path
            assert named(path) in check.detail or len(check.detail) > 200, (path, check.detail)


def test_the_hash_itself(part, sums):
    check = manifest_check(spoilt(part, ("run", "rest_sha256"), sealed=False), sums)
    assert not check.passed
    assert "run.rest_sha256 is" in check.detail


def test_the_rest_of_the_record_is_free(part, sums):
    manifest = part.manifest | {"run": {"machine": "another"}}
    assert manifest_check(replace(part, manifest=manifest), sums).passed  # of a version before the hash


@pytest.mark.parametrize(
    ("key", "value", "what"),
    [
        ("version", "one", "which is not a version"),
        ("version", None, "which is not a version"),
        ("inputs", [], "is not an object"),
        ("inputs", {"amc": {"name": "amc.inp"}}, "is not a name and a SHA-256"),
        ("inputs", {"amc": {"name": "amc.inp", "sha256": "0g" * 32}}, "which is not a SHA-256"),
        ("inputs", {"amc": {"name": "../amc.inp", "sha256": "00" * 32}}, "which is not a file name"),
        ("notes", [1], "is not a list of texts"),
        ("total", True, "total is True"),
        ("extra", 1, "extra is not expected"),
    ],
)
def test_forms(part, sums, key, value, what):
    manifest = part.manifest | {key: value}
    manifest["run"] = {}
    check = manifest_check(replace(part, manifest=manifest), sums)
    assert not check.passed
    assert what in check.detail


def test_a_number_in_its_last_digit_may_differ(part, sums):
    """Another processor may round another way; photons never differ."""
    manifest = copy.deepcopy(part.manifest)
    manifest["bands"][0]["mean_cosine_exact"] *= 1 + 4e-16
    manifest["run"] = {}
    assert manifest_check(replace(part, manifest=manifest), sums).passed
    manifest["bands"][0]["mean_cosine_exact"] *= 1 + 1e-11
    assert not manifest_check(replace(part, manifest=manifest), sums).passed


def test_the_command_names_the_key(part, capsys):
    path = part.folder.path / "manifest.json"
    text = path.read_text()
    try:
        path.write_text(
            text.replace('"north up', '"south up') if '"north up' in text else text.replace("y north", "y south")
        )
        assert main(["verify", str(part.folder.path), "--json"]) == 1
        (check,) = (c for c in json.loads(capsys.readouterr().out)["checks"] if c["name"] == "manifest")
        assert check["detail"].startswith("conventions.frame is 'x east, y south")
    finally:
        path.write_text(text)
