"""aomc-sky verify RUN: correct runs pass, and every damage is found and named."""

import json
import os
import shutil
from pathlib import Path

import pytest

import aomc_sky as sky
from tests.support.fault_rows import command, row_id
from tests.support.scenes import flip_bit
from tests.support.shared import INPUTS
from tests.support.verified import change_photons

BLOCK = 65_536
ITERATIONS = 2 * BLOCK + 1000
SCENE = INPUTS / "document_example" / "amc.inp"


def run(out, *words, iterations=ITERATIONS, scene=SCENE):
    assert command("run", scene, "--iterations", iterations, "-q", "--out", out, *words) == 0


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    out = tmp_path_factory.mktemp("verify") / "out"
    run(out, "--waveband", 1, "--waveband", 2)
    return out


@pytest.fixture
def out(finished, tmp_path):
    return Path(shutil.copytree(finished, tmp_path / "out"))


class Verified:
    """Exit code and report of one call."""

    def __init__(self, capsys, *words):
        capsys.readouterr()
        self.code = command("verify", *words, "--json")
        text = capsys.readouterr()
        assert text.err == ""
        self.report = json.loads(text.out)
        assert self.report["passed"] == (self.code == 0)
        failed = [check for check in self.report["checks"] if not check["passed"]]
        self.failed = "\n".join(f"{check['name']}: {check.get('detail', '')}" for check in failed)

    def named(self, name):
        return [check for check in self.report["checks"] if check["name"] == name]


def test_a_run_passes(finished, capsys):
    done = Verified(capsys, finished)
    assert done.code == 0
    assert {c["waveband"] for c in done.named("photons")} == {1, 2}
    assert all(f"{ITERATIONS} photons made again, no bit differs" in c["detail"] for c in done.named("photons"))
    for name in ("counts file", "counts", "manifest"):
        assert done.named(name), name
    assert done.report["tests"] == 0


def test_statistics_are_made_when_asked_for(tmp_path, capsys):
    run(tmp_path / "out", "--waveband", 1, "--waveband", 2, scene=INPUTS / "clear_day" / "amc.inp")
    report = Verified(capsys, tmp_path / "out", "--statistics", "--level", "0.01").report
    assert report["tests"] == sum("p_value" in check for check in report["checks"]) > 0
    assert (1 - report["level"]) ** report["tests"] == pytest.approx(0.99)
    (test, _) = [c for c in report["checks"] if c["name"] == "mu^2 x azimuth: chi-square per degree of freedom"]
    assert test["found"] < test["allowed"] == 0.1


def test_the_table(finished, told):
    text = told("verify", finished).out
    assert text.splitlines()[0].split() == ["check", "waveband", "outcome", "what"]  # no test, so no numbers
    assert len(told("verify", finished, "-v").out.splitlines()) > len(text.splitlines())
    assert told("verify", finished, "-q").out == ""


def test_photons_that_are_not_stored_are_not_made(tmp_path, capsys):
    """They would take 819 GiB."""
    run(tmp_path / "out", "--format", "none", iterations=10**18)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"plan.npz", "counts.csv", "manifest.json"}
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert (manifest["total"], manifest["bands"][2]["mean_cosine_photons"]) == (3 * 10**18, None)
    done = Verified(capsys, tmp_path / "out", "--statistics")
    assert done.code == 0, done.failed
    assert done.named("counts")
    assert not done.named("photons")
    assert done.report["notes"] == ["directions were not tested: the run stores no photons"]


@pytest.mark.parametrize(
    "words",
    [
        "--format mcpl", "--format raw --format npy", "--precision float64 --format raw", "--replicates 4",
        "--compat aomc", "--weighting solid-angle --weights",
        "--allocation largest-remainder --order patch --placement centre",
    ],
)  # fmt: skip
def test_every_kind_of_run_passes(tmp_path, capsys, words):
    run(tmp_path / "out", *words.split(), "--waveband", 1, iterations=70_000)
    done = Verified(capsys, tmp_path / "out")
    assert done.code == 0, done.failed


def swap_blocks(photons):
    photons[:BLOCK], photons[BLOCK : 2 * BLOCK] = photons[BLOCK : 2 * BLOCK].copy(), photons[:BLOCK].copy()
    return photons


def lines_changed(out):
    text = (out / "counts.csv").read_text().splitlines(keepends=True)
    text[4], text[5] = text[5], text[4]
    (out / "counts.csv").write_text("".join(text))


def manifest_damage(change):
    def spoil(out):
        manifest = json.loads((out / "manifest.json").read_text())
        change(manifest)
        (out / "manifest.json").write_text(json.dumps(manifest))

    return spoil


PHOTON = BLOCK + 7
DAMAGES = {
    "a flipped bit": (
        lambda out: flip_bit(out / "photons-0002.npy", 4096 + PHOTON * 12),
        f"photons-0002.npy: 1 of {ITERATIONS} photons differ from the plan, the first is photon {PHOTON}",
    ),
    "a truncated file": (
        lambda out: os.truncate(out / "photons-0001.npy", 4096 + (BLOCK + 5) * 12),
        f"photons-0001.npy: {4096 + (BLOCK + 5) * 12} bytes in place of {4096 + ITERATIONS * 12}",
        f"{ITERATIONS - BLOCK - 5} of {ITERATIONS} photons differ from the plan, the first is photon {BLOCK + 5}",
    ),
    "an extra byte": (
        lambda out: (out / "photons-0001.npy").write_bytes((out / "photons-0001.npy").read_bytes() + b"x"),
        f"photons-0001.npy: {4097 + ITERATIONS * 12} bytes in place of {4096 + ITERATIONS * 12}",
    ),
    "another head": (
        lambda out: flip_bit(out / "photons-0002.npy", 60),
        "photons-0002.npy: the first 4096 bytes are not those of this run",
    ),
    "blocks that changed places": (
        lambda out: change_photons(out, swap_blocks),
        f"photons-0001.npy: {2 * BLOCK} of {ITERATIONS} photons differ from the plan, the first is photon 0",
    ),
    "a missing file": (lambda out: (out / "photons-0001.npy").unlink(), "photons-0001.npy: missing"),
    "lines of counts": (lines_changed, "counts.csv differs from the plan, from line 5"),
    "no counts": (lambda out: (out / "counts.csv").unlink(), "counts.csv is missing"),
    "a mean in the manifest": (
        manifest_damage(lambda manifest: manifest["bands"][0].update(mean_cosine_photons=0.5)),
        "manifest: bands[0].mean_cosine_photons is 0.5, expected 0.",
    ),
    "a number in the manifest": (
        manifest_damage(lambda manifest: manifest["bands"][1].update(launched=7)),
        f"manifest: bands[1].launched is 7, expected {ITERATIONS}",
    ),
    "a name in the manifest": (
        manifest_damage(lambda manifest: manifest["files"].update({"../../victim": {"bytes": 3}})),
        "manifest: files.../../victim is not expected",
    ),
}


@pytest.mark.parametrize("name", DAMAGES, ids=[row_id(49, name.replace(" ", "-")) for name in DAMAGES])
def test_damage_is_found_and_named(out, capsys, name):
    spoil, *texts = DAMAGES[name]
    spoil(out)
    done = Verified(capsys, out)
    assert done.code in ((1, 5) if name.startswith("blocks") else (1,))
    assert [text for text in texts if text not in done.failed] == []


def test_photons_that_a_file_lost_are_counted_although_they_equal_those_before(tmp_path, capsys):
    run(tmp_path, iterations=3 * BLOCK, scene=INPUTS / "beam_only" / "amc.inp")
    os.truncate(tmp_path / "photons-0001.npy", 4096 + 12 * 70_000)
    done = Verified(capsys, tmp_path)
    assert "126608 of 196608 photons differ from the plan, the first is photon 70000" in done.failed


def test_damage_in_every_format(tmp_path, capsys):
    run(tmp_path, "--format", "mcpl", "--format", "raw", iterations=70_000)
    flip_bit(tmp_path / "photons.mcpl", (tmp_path / "photons.mcpl").stat().st_size - 5)
    flip_bit(tmp_path / "photons-0002.raw", 12 * 69_000)
    done = Verified(capsys, tmp_path)
    assert done.code == 1
    first = "photons differ from the plan, the first is photon"
    assert f"photons.mcpl: 1 of 210000 {first} 69999 of waveband 3" in done.failed
    assert f"photons-0002.raw: 1 of 70000 {first} 69000" in done.failed


OTHER_RUN = "belongs to another run (another scene, seed or options)"
FALSIFIED = (
    lambda m: m["inputs"]["amc"].update(sha256=64 * "0"),
    lambda m: m["inputs"].update(difcol={"name": "difcol.inp", "sha256": 64 * "1"}),
    lambda m: m["options"]["scene"].update({min(m["options"]["scene"]): "x"}),
    lambda m: m["options"]["scene"].update(wind=5),
    lambda m: m["notes"].append("all is well"),
    lambda m: m.update(version="9.9.9"),
)


@pytest.fixture(scope="module")
def noted(tmp_path_factory):
    """A run with notes, and no photons."""
    out = tmp_path_factory.mktemp("verify") / "out"
    run(out, "--format", "none", iterations=1000, scene=INPUTS / "perez_sky")
    return out


def test_a_falsified_manifest_is_found(noted, tmp_path, told):
    """What follows from the scene and not from the plan has digests in plan.npz; planted: a plan of 0.4."""
    out = Path(shutil.copytree(noted, tmp_path / "out"))
    for falsify in FALSIFIED:
        shutil.copy(noted / "manifest.json", out)
        manifest_damage(falsify)(out)
        assert "is not what plan.npz states" in " ".join(told("verify", out, code=1).out.split())
    plan = sky.Plan.load(out / "plan.npz").to_bytes()
    (out / "plan.npz").write_bytes(plan)
    manifest_damage(lambda m: m["files"]["plan.npz"].update(bytes=len(plan)))(out)
    said = " ".join(told("verify", out).out.split())
    assert "not checked, for this plan.npz does not state them: inputs, options.scene, notes and version" in said


def test_what_a_plan_states_has_a_digest_of_its_own(noted, tmp_path, told):
    out = Path(shutil.copytree(noted, tmp_path / "out"))
    data = (out / "plan.npz").read_bytes()
    at = data.rindex(b'"version"') + 15
    (out / "plan.npz").write_bytes(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
    said = " ".join(told("verify", out, code=1).out.split())
    assert "states of its scene what does not fit its digest" in said


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    """The run of another seed."""
    folder = tmp_path_factory.mktemp("verify") / "other"
    run(folder, "--seed", 2, "--waveband", 1)
    return folder


OTHERS = {"plan.npz": OTHER_RUN, "manifest.json": OTHER_RUN}
OTHERS |= {"photons-0001.npy": "photons differ from the plan, the first is photon 0"}


@pytest.mark.parametrize("name", OTHERS)
def test_a_file_of_another_seed(out, other, told, name):
    shutil.copy(other / name, out)
    said = told("verify", out, code=5)
    assert OTHERS[name] in " ".join((said.out + said.err).split())


def test_a_part_of_the_photons(out, capsys):
    """A bit in one of three blocks: a part that holds the block sees it, and one seed draws one part."""
    flip_bit(out / "photons-0001.npy", 4096 + 12 * (2 * BLOCK + 3))
    found = [Verified(capsys, out, "--resample", "0.3", "--seed", seed) for seed in (*range(4), *range(4))]
    codes = [done.code for done in found]
    assert codes[:4] == codes[4:]
    assert set(codes) == {0, 1}
    assert "of 1000 photons differ" in next(done.failed for done in found if done.code)
    assert found[3].report["notes"] == ["blocks to make again were drawn with --seed 3"]
    assert Verified(capsys, out, "--resample", "0").code == 0


def test_the_scene_makes_the_plan_again(out, capsys):
    scene, iterations = ("--scene", SCENE, "--resample", "0"), ("--iterations", ITERATIONS)
    done = Verified(capsys, out, *scene, *iterations)
    assert done.code == 0, done.failed
    assert done.named("scene: plan")
    manifest_damage(lambda manifest: manifest["inputs"]["amc"].update(sha256=64 * "0"))(out)
    for words, code, said in (
        (iterations, 1, "scene: manifest: other contents of amc"),
        ((), 5, "for a run made with --iterations, give it here too"),
    ):
        done = Verified(capsys, out, *scene, *words)
        assert done.code == code
        assert said in done.failed


def test_an_unfinished_run(out, capsys):
    (out / "manifest.json").unlink()
    done = Verified(capsys, out)
    assert done.code == 1
    assert "which the same run command finishes" in done.failed
