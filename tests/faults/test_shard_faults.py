"""Rows 42 and 43 of the matrix: shards that are damaged, exchanged, of another run, or written twice at once."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.fault_rows import command, row, row_id
from tests.support.processes import start
from tests.support.scenes import run_bytes
from tests.support.shards import make_shards, shard_file, shard_words


@pytest.fixture
def out(shards, tmp_path) -> Path:
    """A copy of the good shards, to be damaged."""
    return Path(shutil.copytree(shards, tmp_path / "out"))


def flip(path: Path, place: float = 0.5) -> None:
    data = bytearray(path.read_bytes())
    data[int(place * len(data))] ^= 1
    path.write_bytes(data)


def flipped(out: Path) -> None:
    flip(shard_file(out, "photons", 2, 2))


def flipped_in_the_last_block(out: Path) -> None:
    flip(shard_file(out, "photons", 3, 3), 0.9999)


def cut(out: Path) -> None:
    path = shard_file(out, "photons", 2, 2)
    path.write_bytes(path.read_bytes()[:-5])


def extra_byte(out: Path) -> None:
    with shard_file(out, "photons", 2, 2).open("ab") as file:
        file.write(b"x")


def exchanged(out: Path) -> None:
    first, second, spare = shard_file(out, "photons", 2, 1), shard_file(out, "photons", 2, 2), out / "spare"
    first.rename(spare)
    second.rename(first)
    spare.rename(second)


def of_another_band(out: Path) -> None:
    shutil.copy(shard_file(out, "photons", 1, 2), shard_file(out, "photons", 2, 2))


def zeros(out: Path) -> None:
    """As a disk gives them back whose blocks were never written."""
    path = shard_file(out, "photons", 2, 2)
    data = path.read_bytes()
    path.write_bytes(data[:128] + bytes(len(data) - 128))


DAMAGES = {
    # damage: (what merge names, what verify names)
    flipped: ("shard 2/3 in {out}: block 1 of waveband 2", "photons-0002.k2-of-3.npy, block 1"),
    flipped_in_the_last_block: ("shard 3/3 in {out}: block 3 of waveband 3", "photons-0003.k3-of-3.npy, block 3"),
    cut: ("photons-0002.k2-of-3.npy is cut after 786555 of 786560 bytes", "photons-0002.k2-of-3.npy: truncated"),
    extra_byte: ("photons-0002.k2-of-3.npy is 1 bytes too long", "photons-0002.k2-of-3.npy: too long"),
    exchanged: ("shard 2/3 in {out}: block 1 of waveband 2", "block 1: holds block 0 of waveband 2"),
    of_another_band: ("shard 2/3 in {out}: block 1 of waveband 2", "block 1: holds block 1 of waveband 1"),
    zeros: ("shard 2/3 in {out}: block 1 of waveband 2", "photons-0002.k2-of-3.npy, block 1"),
}


@pytest.mark.parametrize("damage", DAMAGES, ids=[row_id(42, one.__name__.replace("_", "-")) for one in DAMAGES])
def test_fault(damage, out, whole, capsys):
    """verify and merge name the shard and the block; the shard's own command makes it good, and nothing else."""
    damage(out)
    merged, verified = DAMAGES[damage]
    assert command("verify", out, "-q", "--resample", 0) == 1
    assert verified in (said := capsys.readouterr()).out + said.err
    assert command("merge", out, "-q") == 1
    said = capsys.readouterr().err
    assert merged.format(out=out) in said
    assert "run each of these shards again (--shard k/K)" in said
    assert not (out / "manifest.json").exists()
    assert not list(out.glob("photons-000[123].npy"))
    scene = whole.parent / "document_example"
    for k in (1, 2, 3):
        assert command(*shard_words(scene, out, k)) == 0
    assert command("merge", out, "-q", "--remove-shards") == 0
    assert run_bytes(out) == run_bytes(whole)


@row(42, "damaged-and-a-folder-of-its-own")
def test_a_refused_merge_leaves_nothing(fault, out, tmp_path, capsys):
    """No folder that was not there; one that was keeps what it held."""
    flipped(out)
    assert command("merge", out, "--out", tmp_path / "new" / "whole", "-q") == 1
    assert not (tmp_path / "new").exists()
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "notes.txt").write_text("mine")
    assert command("merge", out, "--out", tmp_path / "old", "-q") == 1
    assert [path.name for path in (tmp_path / "old").iterdir()] == ["notes.txt"]
    assert "block 1 of waveband 2" in capsys.readouterr().err


@row(42, "of-another-seed", "of-another-scene")
def test_a_foreign_shard(fault, out, tmp_path, capsys):
    change = ["--seed", 9] if fault.endswith("seed") else ["--waveband", 1, "--waveband", 2]
    other = make_shards(tmp_path / "other", *change, shards=[2])
    for path in other.glob("*.k2-of-3*"):
        shutil.copy(path, out)
    for words in (("verify", out, "-q"), ("merge", out, "-q")):
        assert command(*words) == 5
        said = capsys.readouterr().err
        assert "belongs to another run (another scene, seed or options) than" in said
        assert "k2-of-3" in said or "shard 2/3" in said
    assert not (out / "manifest.json").exists()


@row(42, "missing")
def test_a_missing_shard(fault, out, capsys):
    for path in out.glob("*.k2-of-3*"):
        path.unlink()
    assert command("merge", out, "-q") == 1
    assert "shard 2/3 is missing or unfinished; run it with --shard 2/3" in capsys.readouterr().err


@row(42, "photons-of-a-whole-run")
def test_a_damaged_whole_run(fault, whole, tmp_path, capsys):
    run = Path(shutil.copytree(whole, tmp_path / "run"))
    assert command("verify", run, "-q") == 0
    change_a_photon(run)
    capsys.readouterr()
    assert command("verify", run, "-q", "--resample", 0) == 1
    said = capsys.readouterr()
    assert "photons-0002.npy, block 2" in said.out + said.err


def change_a_photon(run: Path) -> None:
    """The last bit of one number, which no test of directions sees."""
    photons = np.load(run / "photons-0002.npy", mmap_mode="r+")
    photons.view(np.uint32)[150_000, 1] ^= 1
    photons.flush()


@row(42, "photons-that-the-manifest-vouches-for")
def test_a_damage_that_the_manifest_vouches_for(fault, whole, tmp_path, capsys):
    """Whoever hashes a file anew does not hide what is in it: its blocks have leaves."""
    run = Path(shutil.copytree(whole, tmp_path / "run"))
    change_a_photon(run)
    manifest = json.loads((run / "manifest.json").read_text())
    digest = hashlib.sha256((run / "photons-0002.npy").read_bytes()).hexdigest()
    manifest["files"]["photons-0002.npy"]["sha256"] = digest
    (run / "manifest.json").write_text(json.dumps(manifest))
    assert command("verify", run, "-q", "--resample", 0) == 1
    said = capsys.readouterr()
    assert "photons-0002.npy, block 2" in said.out + said.err


@row(42, "counts-of-a-whole-run")
def test_damaged_counts(fault, whole, tmp_path, capsys):
    """A file without leaves, which only its hash in the manifest looks after."""
    run = Path(shutil.copytree(whole, tmp_path / "run"))
    flip(run / "counts.csv")
    assert command("verify", run, "-q", "--resample", 0) == 1
    said = capsys.readouterr()
    assert "counts.csv: its SHA-256 is not the one in the manifest" in said.out + said.err


@row(43, "one-shard-by-two-processes")
def test_two_processes_on_one_shard(fault, whole, tmp_path):
    """Both end well, and the files are those that one of them makes alone."""
    out, scene = tmp_path / "out", whole.parent / "document_example"
    both = [start(*shard_words(scene, out, 2)) for _ in range(2)]
    for process in both:
        _, err = process.communicate(timeout=120)
        assert process.returncode == 0, err
    alone = make_shards(tmp_path / "alone", shards=[2])
    assert shard_bytes(out) == shard_bytes(alone)


def shard_bytes(folder: Path) -> dict[str, bytes]:
    """Bytes of all files; of the manifests, what does not tell of time."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    for name in files:
        if name.startswith("manifest"):
            manifest = json.loads(files[name])
            del manifest["run"]
            files[name] = json.dumps(manifest).encode()
    return files
