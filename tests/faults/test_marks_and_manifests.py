"""Row 52: marks of shards, manifests and heads of photon files that were changed are not believed; no traceback."""

import hashlib
import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.engine.shards import read_mark
from aomc_sky.outputs.run_folder import RunFolder
from aomc_sky.outputs.shard import Shard
from tests.support.fault_rows import command, row
from tests.support.scenes import copy_scene, run_bytes
from tests.support.shared import DATA

WORDS = ("--iterations", "70000", "--waveband", "1", "-q")
MARK = "shard-1-of-2.done"


@pytest.fixture(scope="module")
def amc(tmp_path_factory):
    return copy_scene("document_example", tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def whole(amc):
    assert command("run", amc, *WORDS, "--out", amc.parent / "whole") == 0
    return amc.parent / "whole"


@pytest.fixture(scope="module")
def made(amc):
    """Shard 1 of 2."""
    assert command("run", amc, *WORDS, "--out", amc.parent / "made", "--shard", "1/2") == 0
    return amc.parent / "made"


@pytest.fixture
def folder(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "out"))


def changed_digit(text):
    """The first digit of the sum of cosines becomes another one, and nothing else."""
    at = text.index('"mu": [') + len('"mu": [')
    return text[:at] + str(int(text[at]) % 9 + 1) + text[at + 1 :]  # no 0, with which no JSON number begins


def with_more(text):
    """Lists of another length, with a hash that fits."""
    mark = json.loads(text)["mark"]
    lists = [key for key, value in mark["bands"][0].items() if isinstance(value, list)]
    for key in lists:
        mark["bands"][0][key].append(1)
    assert lists
    return json.dumps({"mark": mark, "sha256": hashlib.sha256(json.dumps(mark).encode()).hexdigest()})


MARKS = {
    "digit": changed_digit,
    "longer-lists": with_more,
    "copy-of-another": lambda text: text.replace('"shard": 1', '"shard": 2'),
    "of-0.3": lambda text: json.dumps(json.loads(text)["mark"]),
    "long-integer": lambda text: text.replace('"shard": 1', f'"shard": {"1" * 5000}'),
    "nested": lambda text: "[" * 100_000,
    "no-text": lambda text: "\x00" * 300,
}


@row(52, *(f"mark-{name}" for name in MARKS))
def test_a_mark_that_does_not_fit_is_ignored(fault, folder, amc, whole):
    """The shard counts as missing and is made again; the run ends as if it had never had this mark."""
    text = (folder / MARK).read_text()
    changed = MARKS[fault.removeprefix("mark-")](text)
    assert changed != text
    (folder / MARK).write_text(changed)
    assert command("run", amc, *WORDS, "--out", folder, "--shard", "2/2") == 0
    assert not (folder / "manifest.json").exists()
    assert command("run", amc, *WORDS, "--out", folder, "--shard", "1/2") == 0
    assert run_bytes(folder) == run_bytes(whole)


@row(52, "mark-every-byte")
def test_no_changed_byte_of_a_mark_is_believed(fault, folder, amc):
    """Each byte becomes one of two digits or a minus sign, in turn."""
    source = sky.read_scene(amc, iterations=70000, wavebands=[1]).source(0)
    shard = Shard(index=1, count=2)
    assert read_mark(source, RunFolder(folder), shard) is not None
    data = (folder / MARK).read_bytes()
    for k in range(len(data)):
        other = next(one for one in (b"78-"[k % 3 :] + b"78") if one != data[k])
        changed = data[:k] + bytes([other]) + data[k + 1 :]
        (folder / MARK).write_bytes(changed)
        assert read_mark(source, RunFolder(folder), shard) is None, changed


@row(52, "mark-copied")
def test_a_mark_under_the_name_of_another_shard(fault, amc, tmp_path):
    """Shards of equal numbers of photons: a copied mark does not stand for photons that nobody made."""
    words, out = ("--iterations", str(4 * 65536), "--waveband", "1", "-q"), tmp_path / "out"
    assert command("run", amc, *words, "--out", out, "--shard", "1/4") == 0
    shutil.copy(out / "shard-1-of-4.done", out / "shard-2-of-4.done")
    for k in (3, 4):
        assert command("run", amc, *words, "--out", out, "--shard", f"{k}/4") == 0
    assert not (out / "manifest.json").exists()
    assert command("run", amc, *words, "--out", out, "--shard", "2/4") == 0
    assert command("verify", out, "-q") == 0


@row(52, "manifest-with-a-long-integer", "manifest-of-nan", "manifest-of-lists", "manifest-with-numbers-as-names")
def test_a_manifest_that_no_version_wrote(fault, whole, amc, tmp_path, told):
    """Each command names the file, or makes the run again; none ends in a traceback."""
    out = Path(shutil.copytree(whole, tmp_path / "out"))
    before = (out / "manifest.json").read_text()
    manifest = json.loads(before)
    if fault == "manifest-with-a-long-integer":
        manifest["bands"][0]["requested_photons"] = 0
        text = json.dumps(manifest).replace('"requested_photons": 0', f'"requested_photons": {"9" * 401}')
    elif fault == "manifest-of-nan":
        manifest["inputs"]["amc"]["sha256"] = math.nan
        text = json.dumps(manifest)
    elif fault == "manifest-of-lists":
        text = json.dumps({key: [[]] for key in manifest})
    else:
        text = json.dumps({**manifest, "files": {"7": 7}})
    assert json.loads(before) != json.loads(text.replace("9" * 401, "0"))
    for words, code in ((("info", out), 3), (("verify", out), 3)):
        (out / "manifest.json").write_text(text)
        said = told(*words, code=code).err
        assert "manifest.json" in said
        assert any(f"error[{code}]" in said for code in ("E100", "E961", "E962"))
    assert command("run", amc, *WORDS, "--out", out) == 0
    assert run_bytes(out) == run_bytes(whole)


CHANGES = {
    "mean-cosine": lambda of: of["bands"][0].update(mean_cosine_exact=of["bands"][0]["mean_cosine_exact"] + 1e-6),
    "seed": lambda of: of.update(seed=1),
    "conventions": lambda of: of["conventions"].update(azimuth="0 is north"),
}


@row(52, *(f"finished-{name}" for name in CHANGES), "counts-changed", "counts-of-arrays")
def test_a_finished_folder_that_does_not_follow_from_the_plan_is_made_again(fault, whole, amc, tmp_path):
    out = Path(shutil.copytree(whole, tmp_path / "out"))
    if fault.startswith("finished-"):
        manifest = json.loads((out / "manifest.json").read_text())
        CHANGES[fault.removeprefix("finished-")](manifest)
        (out / "manifest.json").write_text(json.dumps(manifest))
    elif fault == "counts-changed":
        text = (out / "counts.csv").read_text()
        (out / "counts.csv").write_text(text[:-2] + str((int(text[-2]) + 1) % 10) + "\n")
    else:
        (out / "counts.npz").write_bytes(b"of another program")
    assert command("run", amc, *WORDS, "--out", out) == 0
    assert run_bytes(out) == run_bytes(whole)


@row(52, "head-without-its-brace", "head-cut", "head-of-zeros", "head-of-brackets")
def test_the_head_of_a_numpy_file(fault, amc, tmp_path, told):
    path = tmp_path / "photons.npy"
    data = (DATA / "damaged" / "bad_head.npy").read_bytes()
    if fault != "head-without-its-brace":
        np.save(path, np.zeros((3, 3), np.float32))
        data = path.read_bytes()
        middle = {"head-cut": b"", "head-of-zeros": bytes(118), "head-of-brackets": b"{" * 118}[fault]
        data = data[:10] + middle + (data[128:] if middle else b"")
    path.write_bytes(data)
    assert f"{path}: error[E902]" in told("verify", "--scene", amc, path, "--waveband", "1", code=3).err
