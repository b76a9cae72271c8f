"""aomc-sky verify RUN: correct runs pass, and every damage is found and named."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.cli.main import main
from tests.support.shared import INPUTS
from tests.support.verified import change_photons, seal, uniform_in_zenith_angle

BLOCK = 65_536
ITERATIONS = 2 * BLOCK + 1000
SCENE = INPUTS / "clear_day" / "amc.inp"


def run(out: Path, *words: object, iterations: int = ITERATIONS, scene: Path = SCENE) -> None:
    assert main(["run", str(scene), "--iterations", str(iterations), "-q", "--out", str(out), *map(str, words)]) == 0


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two wavebands and three blocks each."""
    out = tmp_path_factory.mktemp("verify") / "out"
    run(out, "--waveband", 1, "--waveband", 2)
    return out


@pytest.fixture
def out(finished: Path, tmp_path: Path) -> Path:
    """A copy of it, to be spoilt."""
    return Path(shutil.copytree(finished, tmp_path / "out"))


class Verified:
    """Exit code and report of one call."""

    def __init__(self, capsys: pytest.CaptureFixture[str], *words: object) -> None:
        capsys.readouterr()
        self.code = main(["verify", *map(str, words), "--json", "--picture", "none"])
        text = capsys.readouterr()
        assert text.err == ""
        self.report = json.loads(text.out)
        assert self.report["passed"] == (self.code == 0)

    @property
    def failed(self) -> str:
        """Names and details of the checks that failed."""
        return "\n".join(f"{c['name']}: {c.get('detail', '')}" for c in self.report["checks"] if not c["passed"])

    def named(self, name: str) -> list[dict]:
        return [check for check in self.report["checks"] if check["name"] == name]


def test_a_run_passes(finished, capsys):
    done = Verified(capsys, finished)
    assert done.code == 0
    assert {c["waveband"] for c in done.named("blocks")} == {1, 2}
    assert all("3 blocks agree, 1 of them made again" in c["detail"] for c in done.named("blocks"))
    for name in ("files", "content tree", "counts: each cell within one photon", "photons come from above"):
        assert done.named(name), name
    (test, _) = done.named("mu^2 x azimuth: chi-square per degree of freedom")
    assert test["found"] < test["allowed"] == 0.1


def test_the_level_is_shared_out(finished, capsys):
    report = Verified(capsys, finished, "--level", "0.01").report
    assert report["tests"] == sum("p_value" in check for check in report["checks"]) > 0
    assert (1 - report["level"]) ** report["tests"] == pytest.approx(0.99)


def test_the_table(finished, capsys):
    assert main(["verify", str(finished)]) == 0
    text = capsys.readouterr().out
    assert text.splitlines()[0].split() == ["check", "waveband", "outcome", "found", "allowed", "p-value", "what"]
    assert "all checks passed" in text
    assert main(["verify", str(finished), "-v"]) == 0
    assert len(capsys.readouterr().out.splitlines()) > len(text.splitlines())
    assert main(["verify", str(finished), "-q"]) == 0
    assert capsys.readouterr().out == ""


def test_the_programs_own_counts_pass(tmp_path, capsys):
    run(tmp_path / "out", "--compat", "aomc", scene=INPUTS / "document_example" / "amc.inp", iterations=70_000)
    done = Verified(capsys, tmp_path / "out", "--resample", 1)
    assert done.code == 0, done.failed
    assert done.named("counts: each cell rounded")


@pytest.mark.parametrize(
    "words",
    [
        ("--format", "mcpl"),
        ("--format", "none"),
        ("--format", "raw", "--format", "npy"),
        ("--precision", "float64", "--format", "raw"),
        ("--replicates", "4"),
        ("--placement", "centre"),
        ("--weighting", "solid-angle", "--weights"),
        ("--allocation", "largest-remainder", "--order", "patch"),
    ],
)
def test_every_kind_of_run_passes(tmp_path, capsys, words):
    run(tmp_path / "out", *words, "--waveband", 1, iterations=70_000)
    done = Verified(capsys, tmp_path / "out")
    assert done.code == 0, done.failed


def flip(path: Path, place: int) -> None:
    with open(path, "r+b") as file:
        file.seek(place)
        byte = file.read(1)[0]
        file.seek(place)
        file.write(bytes([byte ^ 4]))


def swap_blocks(photons):
    photons[:BLOCK], photons[BLOCK : 2 * BLOCK] = photons[BLOCK : 2 * BLOCK].copy(), photons[:BLOCK].copy()
    return photons


def cut_off(path: Path, n_bytes: int) -> None:
    path.write_bytes(path.read_bytes()[:n_bytes])


PHOTON = BLOCK + 7
DAMAGES = {
    "a flipped bit": (
        lambda out: flip(out / "photons-0002.npy", 128 + PHOTON * 12),
        "photons-0002.npy: its SHA-256 is not the one in the manifest",
        f"photons-0002.npy, block 1: 1 of 65536 photons differ from the plan, photon {PHOTON} is",
    ),
    "a truncated file": (
        lambda out: cut_off(out / "photons-0001.npy", 128 + (BLOCK + 5) * 12),
        "photons-0001.npy: truncated",
        "photons-0001.npy ends in block 1; blocks 1 to 2 are not complete",
    ),
    "an extra byte": (
        lambda out: (out / "photons-0001.npy").write_bytes((out / "photons-0001.npy").read_bytes() + b"x"),
        "photons-0001.npy: too long",
        "photons-0001.npy has 1 bytes after its last block",
    ),
    "blocks that changed places": (
        lambda out: change_photons(out, swap_blocks),
        "block 0: holds block 1 of waveband 1",
        "block 1: holds block 0 of waveband 1",
    ),
    "a damaged leaf": (
        lambda out: flip(out / "blocks-0001.npy", 128 + 32 * 2 + 5),
        "blocks-0001.npy: its SHA-256 is not the one in the manifest",
        "block 2: its leaf is damaged, its photons are not",
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage_is_found_and_named(out, capsys, name):
    spoil, *texts = DAMAGES[name]
    spoil(out)
    done = Verified(capsys, out, "--resample", 0)
    assert done.code == 1
    for text in texts:
        assert text in done.failed
    if name == "a damaged leaf":
        assert done.named("leaves")[0]["waveband"] == 1


def test_a_missing_file(out, capsys):
    (out / "photons-0001.npy").unlink()
    done = Verified(capsys, out)
    assert done.code == 1
    assert "photons-0001.npy: missing" in done.failed
    assert "waveband 1 were not tested" in done.report["notes"][0]


def test_photons_of_another_seed(out, tmp_path, capsys):
    run(tmp_path / "other", "--seed", 2, "--waveband", 1)
    shutil.copy(tmp_path / "other" / "photons-0001.npy", out)
    done = Verified(capsys, out)
    assert done.code == 5
    assert "every block belongs to another run (another scene, seed or options)" in done.failed


@pytest.mark.parametrize("name", ["plan.npz", "manifest.json"])
def test_a_plan_or_manifest_of_another_seed(out, tmp_path, capsys, name):
    run(tmp_path / "other", "--seed", 2, "--waveband", 1)
    shutil.copy(tmp_path / "other" / name, out)
    assert main(["verify", str(out)]) == 5
    assert "belongs to another run (another scene, seed or options)" in capsys.readouterr().err


def test_a_hidden_change_of_one_photon_changes_the_means(out, capsys):
    def turn_one(photons):
        photons[2 * BLOCK + 3] = photons[2 * BLOCK + 4]
        return photons

    change_photons(out, turn_one)
    seal(out)
    done = Verified(capsys, out, "--resample", 0)
    assert done.code == 1
    assert done.failed.startswith("manifest: bands[0].mean_cosine_photons is ")


def test_a_hidden_change_is_found_by_making_photons_again(out, capsys):
    def swap_two(photons):
        photons[[2 * BLOCK + 3, 2 * BLOCK + 4]] = photons[[2 * BLOCK + 4, 2 * BLOCK + 3]]
        return photons

    change_photons(out, swap_two)
    seal(out)
    assert Verified(capsys, out, "--resample", 0).code == 0
    done = Verified(capsys, out, "--resample", 1)
    assert done.code == 1
    assert f"block 2: 2 of 1000 photons differ from the plan, photon {2 * BLOCK + 3}" in done.failed


def test_the_choice_of_blocks_is_keyed(out, capsys):
    change_photons(out, lambda photons: np.roll(photons, 1, axis=0) if len(photons) else photons)
    seal(out)
    found = [Verified(capsys, out, "--seed", seed).named("blocks")[0]["detail"] for seed in (0, 0, 1)]
    assert found[0] == found[1]
    assert all("every block that was made again (1) belongs to another run" in text for text in found)


@pytest.mark.slow
def test_one_percent_uniform_in_zenith_angle_is_caught(tmp_path, capsys):
    """The figure of the issue: 2e6 photons, hashes made to agree, no block made again."""
    run(tmp_path / "out", "--waveband", 1, iterations=2_000_000)
    assert Verified(capsys, tmp_path / "out", "--resample", 0).code == 0
    change_photons(tmp_path / "out", lambda photons: uniform_in_zenith_angle(photons, 0.01))
    seal(tmp_path / "out")
    done = Verified(capsys, tmp_path / "out", "--resample", 0)
    assert done.code == 1
    assert "mu^2: chi-square per degree of freedom" in done.failed


def test_an_unfinished_run(out, capsys):
    (out / "manifest.json").unlink()
    done = Verified(capsys, out)
    assert done.code == 1
    assert "which the same run command finishes" in done.failed


def test_damaged_plans_and_manifests(out, capsys):
    (out / "manifest.json").write_text("{")
    assert main(["verify", str(out)]) == 3
    (out / "plan.npz").write_bytes(b"PK")
    assert main(["verify", str(out)]) == 3
    assert main(["verify", str(out / "nowhere")]) == 3
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (("--method", "iid"), "--scene AMC_INP"),
        (("--frame", "down"), "--scene AMC_INP"),
        (("--waveband", "3"), "waveband 3 is not in this run"),
    ],
)
def test_usage_errors(finished, capsys, words, what):
    assert main(["verify", str(finished), *words]) == 2
    assert what in capsys.readouterr().err


@pytest.mark.parametrize("words", [("--resample", "1.5"), ("--level", "0"), ("--level", "x")])
def test_numbers_outside_their_range(finished, words):
    with pytest.raises(SystemExit) as error:
        main(["verify", str(finished), *words])
    assert error.value.code == 2


@pytest.fixture(scope="module")
def sharded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of one waveband in four shards of one block each."""
    out = tmp_path_factory.mktemp("shards") / "out"
    for k in range(1, 5):
        run(out, "--shard", f"{k}/4", "--waveband", 1, iterations=4 * BLOCK)
    return out


def test_shards_pass(sharded, capsys):
    done = Verified(capsys, sharded, "--resample", 1)
    assert done.code == 0, done.failed
    assert len(done.named("blocks")) == 4
    assert done.named("mu^2: chi-square per degree of freedom")


@pytest.fixture
def shards(sharded: Path, tmp_path: Path) -> Path:
    """A copy of them, to be spoilt."""
    return Path(shutil.copytree(sharded, tmp_path / "shards"))


def test_a_missing_shard(shards, capsys):
    (shards / "manifest.k2-of-4.json").unlink()
    done = Verified(capsys, shards)
    assert done.code == 1
    assert "shards: missing: 2/4" in done.failed


def test_a_swapped_shard(shards, capsys):
    shutil.copy(shards / "photons-0001.k3-of-4.npy", shards / "photons-0001.k2-of-4.npy")
    done = Verified(capsys, shards)
    assert done.code == 1
    assert "photons-0001.k2-of-4.npy, block 1: holds block 2 of waveband 1" in done.failed


def test_a_shard_of_another_seed(shards, tmp_path, capsys):
    run(tmp_path / "other", "--shard", "2/4", "--waveband", 1, "--seed", 5, iterations=4 * BLOCK)
    for name in ("photons-0001.k2-of-4.npy", "blocks-0001.k2-of-4.npy"):
        shutil.copy(tmp_path / "other" / name, shards)
    done = Verified(capsys, shards)
    assert done.code == 5
    assert "photons-0001.k2-of-4.npy: every block belongs to another run" in done.failed
    shutil.copy(tmp_path / "other" / "manifest.k2-of-4.json", shards)
    assert main(["verify", str(shards)]) == 5
    assert "manifest.k2-of-4.json belongs to another run" in capsys.readouterr().err
