"""``run --shard`` and ``merge`` through main(argv): what they write, print and refuse."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.processes import start
from tests.support.scenes import copy_scene, flip_bit, run_bytes, scene_with_circle
from tests.support.shared import REPOSITORY

BLOCK = 65_536
ITERATIONS = 2 * BLOCK + 77
SCHEMA, SHARD_SCHEMA = (
    json.loads((REPOSITORY / "src/aomc_sky/outputs" / name).read_text())
    for name in ("manifest.schema.json", "shard_manifest.schema.json")
)


@pytest.fixture(scope="module")
def amc(tmp_path_factory) -> Path:
    return scene_with_circle(tmp_path_factory.mktemp("scene"))


def run(amc: Path, out: Path, *words: object, iterations: int = ITERATIONS) -> int:
    return main(["run", *map(str, (amc, "--iterations", iterations, "--waveband", 2, "-q", "--out", out, *words))])


def merge(*words: object) -> int:
    return main(["merge", *map(str, words)])


@pytest.fixture(scope="module")
def whole(amc, tmp_path_factory) -> dict[str, bytes]:
    out = tmp_path_factory.mktemp("whole")
    assert run(amc, out) == 0
    return run_bytes(out)


@pytest.fixture(scope="module")
def made(amc, tmp_path_factory) -> Path:
    """All three shards in one folder; tests copy it."""
    out = tmp_path_factory.mktemp("made") / "out"
    for k in (3, 1, 2):
        assert run(amc, out, "--shard", f"{k}/3") == 0
    return out


@pytest.fixture
def out(made, tmp_path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "out"))


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def shard_names(k: int, count: int = 3) -> set[str]:
    suffix = f"k{k}-of-{count}"
    kinds = ("photons", "positions", "blocks")
    return {f"{kind}-0002.{suffix}.npy" for kind in kinds} | {f"manifest.{suffix}.json"}


def test_a_shard_holds_its_blocks(made, whole):
    assert names(made) == {"plan.npz"} | shard_names(1) | shard_names(2) | shard_names(3)
    assert (made / "plan.npz").read_bytes() == whole["plan.npz"]
    parts = [np.load(made / f"photons-0002.k{k}-of-3.npy") for k in (1, 2, 3)]
    assert [len(part) for part in parts] == [BLOCK, BLOCK, 77]
    head = len(whole["photons-0002.npy"]) - 12 * ITERATIONS
    assert np.concatenate(parts).tobytes() == whole["photons-0002.npy"][head:]
    manifest = json.loads((made / "manifest.k2-of-3.json").read_text())
    assert manifest["schema"] == "aomc-sky-shard/1"
    assert manifest["shard"] == {"index": 2, "count": 3}
    assert manifest["bands"] == [{"waveband": 2, "first_photon": BLOCK, "n_photons": BLOCK}]
    assert set(manifest["files"]) | {"manifest.k2-of-3.json"} == shard_names(2)


def test_manifests_of_shards_keep_their_schema(made):
    jsonschema.Draft202012Validator.check_schema(SHARD_SCHEMA)
    for k in (1, 2, 3):
        jsonschema.validate(json.loads((made / f"manifest.k{k}-of-3.json").read_text()), SHARD_SCHEMA)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("schema",), "aomc-sky-manifest/1"),
        (("shard", "index"), 0),
        (("shard", "size"), 3),
        (("bands",), []),
        (("bands", 0, "first_photon"), -1),
        (("bands", 0, "launched"), 7),
        (("files", "photons-0002.npy"), {"bytes": 1, "sha256": 64 * "0"}),
        (("files", "photons-0002.k2-of-3.npy", "sha256"), 64 * "g"),
        (("options", "formats"), ["npy", "mcpl"]),
        (("total",), 3),
    ],
)
def test_what_is_no_manifest_of_a_shard(made, place, value):
    manifest = part = json.loads((made / "manifest.k2-of-3.json").read_text())
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(manifest, SHARD_SCHEMA)


def test_both_schemas_begin_alike():
    """What a shard and its run say of the run has one form."""
    head = {*SHARD_SCHEMA["required"]} - {"schema", "options", "shard", "bands", "files", "run"}
    assert head == {"version", "stream", "seed", "plan_sha256", "inputs", "conventions", "components", "notes"}
    for key in head:
        assert SHARD_SCHEMA["properties"][key] == SCHEMA["properties"][key], key
    ours, theirs = (schema["properties"]["options"]["properties"] for schema in (SHARD_SCHEMA, SCHEMA))
    assert {**ours, "formats": theirs["formats"]} == theirs


def test_merge_writes_the_run_beside_its_shards(out, whole, capsys):
    before = {name: (out / name).read_bytes() for name in names(out)}
    assert merge(out) == 0
    shown = capsys.readouterr()
    assert f"{ITERATIONS} photons of 3 shards joined" in shown.out
    assert shown.err == ""
    files = run_bytes(out)
    assert {name: files[name] for name in whole} == whole
    assert {name: files[name] for name in before} == before
    assert set(files) == set(whole) | set(before)
    jsonschema.validate(json.loads((out / "manifest.json").read_text()), SCHEMA)
    assert merge(out) == 0
    assert "joined before" in capsys.readouterr().out


def test_shards_are_removed_when_asked(out, whole, capsys):
    assert merge(out, "--remove-shards", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["removed"] == 12
    assert shown["content"] == json.loads(whole["manifest.json"])["content"]
    assert run_bytes(out) == whole
    assert merge(out, "--remove-shards", "-q") == 0  # again: the run stands, nothing to remove
    assert run_bytes(out) == whole


def test_a_merged_run_is_a_run(amc, out, whole):
    assert merge(out, "-q") == 0
    stamp = (out / "photons-0002.npy").stat().st_mtime_ns
    assert run(amc, out) == 0
    assert (out / "photons-0002.npy").stat().st_mtime_ns == stamp
    assert main(["export", str(out), "--to", "mcpl", "-q"]) == 0


@pytest.mark.parametrize("words", [(), ("--precision", "float64", "--replicates", 3)])
def test_folders_of_their_own_and_more_shards_than_blocks(amc, tmp_path, words):
    assert run(amc, tmp_path / "whole", *words) == 0
    for k in range(1, 6):
        assert run(amc, tmp_path / f"part{k}", "--shard", f"{k}/5", *words) == 0
        manifest = (tmp_path / f"part{k}" / f"manifest.k{k}-of-5.json").read_text()
        jsonschema.validate(json.loads(manifest), SHARD_SCHEMA)
    parts = [tmp_path / f"part{k}" for k in range(5, 0, -1)]
    assert merge(*parts, "-q") == 2
    assert merge(*parts, "--out", tmp_path / "joined", "-q") == 0
    assert run_bytes(tmp_path / "joined") == run_bytes(tmp_path / "whole")


def lengthen(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"x")


def swap(out: Path) -> None:
    for name in ("photons", "positions", "blocks"):
        one, other = (out / f"{name}-0002.k{k}-of-3.npy" for k in (1, 2))
        one.rename(out / "between")
        other.rename(one)
        (out / "between").rename(other)


# damaged photons: tests/faults/test_shard_faults.py
DAMAGES = {
    "last bit": (
        lambda out: flip_bit(out / "positions-0002.k3-of-3.npy", -1),
        "block 2 of waveband 2 (photons 131072 to",
    ),
    "another head": (
        lambda out: flip_bit(out / "positions-0002.k1-of-3.npy", 30),
        "does not begin with the header of 65536 photons",
    ),
    "file gone": (lambda out: (out / "photons-0002.k2-of-3.npy").unlink(), "photons-0002.k2-of-3.npy is missing"),
    "leaves": (
        lambda out: flip_bit(out / "blocks-0002.k1-of-3.npy", -1),
        "blocks-0002.k1-of-3.npy is missing or damaged",
    ),
    "leaves gone": (lambda out: (out / "blocks-0002.k1-of-3.npy").unlink(), "is missing or damaged"),
    "swapped": (swap, "blocks-0002.k2-of-3.npy is missing or damaged"),
    "manifest": (lambda out: (out / "manifest.k2-of-3.json").write_text("{"), "manifest"),
    "manifest of another": (
        lambda out: shutil.copy(out / "manifest.k1-of-3.json", out / "manifest.k2-of-3.json"),
        "is the manifest of shard 1/3",
    ),
    "missing": (lambda out: (out / "manifest.k2-of-3.json").unlink(), "shard 2/3 is missing or unfinished"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage_is_refused_by_name_and_repaired_by_the_same_command(amc, out, tmp_path, capsys, whole, name):
    damage, told = DAMAGES[name]
    damage(out)
    before = names(out)
    assert merge(out, "--out", tmp_path / "joined") == 1
    shown = capsys.readouterr()
    assert told in shown.err
    assert "shard " in shown.err
    assert shown.out == ""
    assert not list((tmp_path / "joined").glob("*"))
    assert merge(out) == 1
    assert names(out) == before
    for k in (1, 2, 3):
        assert run(amc, out, "--shard", f"{k}/3") == 0
    assert merge(out, "--out", tmp_path / "joined", "-q") == 0
    assert run_bytes(tmp_path / "joined") == whole


def test_only_what_is_damaged_is_made_again(amc, out):
    stamps = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    flip_bit(out / "photons-0002.k2-of-3.npy", 1000)
    for k in (1, 2, 3):
        assert run(amc, out, "--shard", f"{k}/3") == 0
    changed = {path.name for path in out.iterdir() if path.stat().st_mtime_ns != stamps[path.name]}
    assert changed <= shard_names(2)
    assert {"photons-0002.k2-of-3.npy", "manifest.k2-of-3.json"} <= changed


def test_a_shard_without_photons_can_be_too_long(amc, tmp_path, capsys):
    for k in range(1, 6):
        assert run(amc, tmp_path, "--shard", f"{k}/5", iterations=100) == 0
    lengthen(tmp_path / "photons-0002.k1-of-5.npy")
    assert merge(tmp_path) == 1
    assert "photons-0002.k1-of-5.npy is 1 bytes too long; it holds no photons" in capsys.readouterr().err


def test_every_damaged_block_is_named(out, capsys):
    flip_bit(out / "photons-0002.k1-of-3.npy", 1000)
    flip_bit(out / "photons-0002.k3-of-3.npy", 1000)
    assert merge(out) == 1
    shown = capsys.readouterr().err
    assert "shard 1/3" in shown
    assert "block 0 of waveband 2" in shown
    assert "shard 3/3" in shown
    assert "block 2 of waveband 2" in shown
    assert "--shard k/K" in shown


def test_divisions_and_doubles_overlap(amc, out, tmp_path, capsys):
    assert run(amc, out, "--shard", "2/4") == 0
    assert merge(out) == 1
    assert "1 to 3 of 3, and 2 of 4" in capsys.readouterr().err
    other = shutil.copytree(out, tmp_path / "other")
    for name in shard_names(2, 4):
        (out / name).unlink()
    for name in shard_names(2, 4) | shard_names(1) | shard_names(3):
        (other / name).unlink()
    assert merge(out, other, "--out", tmp_path / "joined") == 1
    assert "shard 2/3" in (shown := capsys.readouterr().err)
    assert "overlaps" in shown
    assert merge(out, out, "-q") == 0  # one folder named twice is one folder


def test_missing_shards_are_counted(amc, tmp_path, capsys):
    for k in (2, 5, 9):
        assert run(amc, tmp_path / "out", "--shard", f"{k}/10") == 0
    assert merge(tmp_path / "out") == 1
    assert "shards 1, 3 to 4, 6 to 8, 10 of 10 are missing or unfinished" in capsys.readouterr().err
    assert main(["info", str(tmp_path / "out")]) == 0
    assert "finished shards: 2/10, 5/10, 9/10 (3)" in capsys.readouterr().out


@pytest.mark.parametrize("change", [("--seed", 1), ("--placement", "philox")])
def test_another_run_is_refused(amc, out, tmp_path, capsys, change):
    """By `run`, into the folder, forced or not; and by `merge`, as a folder, a manifest or a target."""
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    for force in ((), ("--force",)):
        assert run(amc, out, "--shard", "1/3", *change, *force) == 5
        assert "another run" in capsys.readouterr().err
    other = tmp_path / "other"
    assert run(amc, other, "--shard", "1/3", *change) == 0
    assert merge(out, other, "--out", tmp_path / "joined") == 5
    assert str(other) in capsys.readouterr().err
    assert merge(out, "--out", other) == 5
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    shutil.copy(other / "manifest.k1-of-3.json", out / "manifest.k1-of-3.json")
    assert merge(out) == 5
    assert "shard 1/3" in capsys.readouterr().err


def test_force_makes_one_shard_again(amc, out, whole):
    stamps = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    assert run(amc, out, "--shard", "2/3", "--force") == 0
    changed = {path.name for path in out.iterdir() if path.stat().st_mtime_ns != stamps[path.name]}
    assert changed == shard_names(2)


@pytest.mark.parametrize(
    "words",
    [
        ("--shard", "0/3"),
        ("--shard", "4/3"),
        ("--shard", "1:3"),
        ("--shard", "1/2000000"),
        ("--shard", "1/3", "--format", "mcpl"),
        ("--shard", "1/3", "--format", "none"),
        ("--shard", "1/3", "--format", "npy", "--format", "raw"),
    ],
)
def test_what_is_no_shard_is_a_usage_error(amc, tmp_path, capsys, words):
    assert run(amc, tmp_path / "out", *words) == 2
    assert "shard" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_folders_without_shards(amc, tmp_path, capsys):
    assert merge(tmp_path / "none") == 3
    assert merge(tmp_path) == 3
    assert "plan.npz" in capsys.readouterr().err
    assert run(amc, tmp_path / "out", "--format", "none", iterations=100) == 0
    (tmp_path / "out" / "manifest.json").unlink()
    assert merge(tmp_path / "out") == 1
    assert "no finished shards" in capsys.readouterr().err


def test_what_a_shard_prints(amc, tmp_path, capsys):
    words = ["run", str(amc), "--iterations", "70000", "--shard", "2/3", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "shard 2/3: 196608 photons in 3 wavebands, seed 0" in shown
    assert "waveband 3: photons 0 to 65535" in shown
    assert main([*words, "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["was_finished"] is True
    assert again["shard"] == {"index": 2, "count": 3}


def test_two_merges_at_once(out, whole):
    """Both end well: they write the same bytes, and the last rename holds."""
    both = [start("merge", out, "-q") for _ in range(2)]
    for process in both:
        _, err = process.communicate(timeout=120)
        assert process.returncode == 0, err
    files = run_bytes(out)
    assert {name: files[name] for name in whole} == whole


def test_a_shard_without_photons_says_so_and_no_more(tmp_path, capsys):
    amc = copy_scene("document_example", tmp_path)
    assert main(["run", str(amc), "--iterations", "1000", "--shard", "3/7", "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "no photons (more shards than blocks)" in said
    assert "hashes" not in said  # there is nothing that could agree
