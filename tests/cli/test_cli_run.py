"""``run`` through main(argv): what it writes, prints and refuses, and its replicates."""

import hashlib
import json
import os

import numpy as np
import pytest

import aomc_sky
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.engine.run import JobOptions, run_job
from aomc_sky.plan.plan import Plan
from aomc_sky.source.read.scene import read_scene
from tests.support.fault_rows import command
from tests.support.scenes import copy_scene, manifest_of, run_bytes


def run(*words):
    return command("run", *words)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    amc = copy_scene("document_example", tmp_path_factory.mktemp("scene"))
    words = "--iterations", 100_000, "--format", "npy", "--format", "raw", "-q"
    assert run(amc, *words, "--out", amc.parent / "out") == 0
    return amc.parent / "out"


def test_default_folder_and_its_files(amc, capsys):
    assert run(amc, "--iterations", "2e4", "--seed", 5) == 0
    folder = amc.parent / "aomc-sky-out"
    names = {path.name for path in folder.iterdir()}
    assert names == {"plan.npz", "counts.csv", "manifest.json"} | {f"photons-{b:04d}.npy" for b in (1, 2, 3)}
    shown = capsys.readouterr()
    for word in ("band", "requested", "launched", "residual", "mean cosine", "Ed/Eo", str(folder)):
        assert word in shown.out
    assert shown.err == ""


def test_manifest_keeps_its_schema_its_hashes_and_the_statistics_of_the_photons(finished):
    manifest = manifest_of(finished)
    assert set(manifest["files"]) == {path.name for path in finished.iterdir()} - {"manifest.json"}
    for name, entry in manifest["files"].items():
        assert entry["bytes"] == (finished / name).stat().st_size
    for entry in manifest["inputs"].values():
        assert entry["sha256"] == hashlib.sha256((finished.parent / entry["name"]).read_bytes()).hexdigest()
    assert manifest["plan_sha256"] == Plan.load(finished / "plan.npz").sha256
    source = PhotonSource.from_plan(Plan.load(finished / "plan.npz"))
    for band in manifest["bands"]:
        directions = np.load(finished / f"photons-{band['waveband']:04d}.npy")
        assert np.array_equal(directions, source.photons(band["waveband"] - 1).directions)
        mu = -directions[:, 2].astype(np.float64)
        assert np.isclose(band["mean_cosine_photons"], mu.mean(), rtol=1e-13)
        assert np.isclose(band["ed_over_eo_photons"], 1 / np.mean(1 / mu), rtol=1e-13)
        assert abs(band["mean_cosine_photons"] - band["mean_cosine_exact"]) < 1e-4
        assert band["residual"] == 0
        assert band["launched"] == band["requested"] == 100_000


@pytest.mark.parametrize(
    ("name", "words", "columns"),
    [
        ("clear_day", [], ["ux", "uy", "uz"]),
        ("clear_day", ["--weighting", "solid-angle", "--weights"], ["ux", "uy", "uz", "weight"]),
        ("overcast", [], ["ux", "uy", "uz", "x_m", "y_m"]),
        ("clear_day", ["--precision", "float64"], ["ux", "uy", "uz"]),
    ],
)
def test_raw_says_its_columns(tmp_path, told, name, words, columns):
    """In the summary, in `info` and in the manifest: as many as a record has, in the order of its bytes."""
    amc, out = copy_scene(name, tmp_path), tmp_path / "out"
    words = ("--iterations", 100, "--waveband", 1, "--format", "raw", "--format", "npy", "--out", out, *words)
    said = f"{', '.join(columns)} (float32, little-endian)"
    shown = told("run", amc, *words).out
    assert f"a raw record: {said}" in shown
    assert ("count each photon once, whatever its weight" in shown) == ("weight" in columns)
    raw = np.fromfile(out / "photons-0001.raw", dtype="<f4").reshape(100, len(columns))
    files = [out / f"{file}-0001.npy" for file in ("photons", "positions", "weights")]
    stored = [np.load(path).reshape(100, -1) for path in files if path.exists()]
    np.testing.assert_array_equal(raw, np.hstack(stored).astype(np.float32))
    assert manifest_of(out)["files"]["photons-0001.raw"]["columns"] == columns
    assert f"photons-0001.raw: {raw.nbytes} bytes, records of {said}" in told("info", out).out


def test_json_is_one_object_and_nothing_else(amc, tmp_path, told):
    for _ in range(2):  # made, then found finished
        out = told("run", amc, "--iterations", 100, "--out", tmp_path / "out", "--json").out
        assert out.count("\n") == 1
        shown = json.loads(out)
        assert shown["schema"] == "aomc-sky-manifest/2"
        assert {"seconds", "threads", "machine"} <= shown["run"].keys()
    assert shown["was_finished"] is True
    assert "run" not in json.loads((tmp_path / "out" / "manifest.json").read_text())


def test_a_finished_run_is_not_done_again(amc, tmp_path, told):
    out = tmp_path / "out"
    words = (amc, "--iterations", 5000, "--out", out)
    assert run(*words) == 0
    before = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    assert "finished before" in told("run", *words).out
    assert before == {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    first = run_bytes(out)
    assert run(*words, "--force", "-q") == 0
    assert first == run_bytes(out)
    assert before["manifest.json"] != (out / "manifest.json").stat().st_mtime_ns


LOST = {
    "manifest": lambda out: (out / "manifest.json").unlink(),
    "photons": lambda out: [path.unlink() for path in out.glob("photons-0002*")],
    "counts": lambda out: (out / "counts.csv").unlink(),
    "end of photons": lambda out: [os.truncate(path, 1000) for path in out.glob("photons-0003*")],
    "text of the manifest": lambda out: (out / "manifest.json").write_text("{"),
}


@pytest.mark.parametrize("lost", LOST)
def test_resume_gives_the_same_bytes(amc, tmp_path, lost):
    """What is whole stays, what a killed run left goes."""
    out = tmp_path / "out"
    words = [amc, "--iterations", 70_001, "--out", out, "-q", "--format", "raw", "--format", "npy"]
    assert run(*words) == 0
    whole, kept = run_bytes(out), (out / "photons-0001.npy").stat().st_mtime_ns
    LOST[lost](out)
    (out / ".aomc-sky-photons-0002.npy.deadbeef").write_bytes(b"half")
    assert run(*words) == 0
    assert run_bytes(out) == whole
    assert (out / "photons-0001.npy").stat().st_mtime_ns == kept


def test_only_the_wavebands_asked_for(amc, tmp_path):
    assert run(amc, "--iterations", 1000, "--out", tmp_path / "all", "-q") == 0
    assert run(amc, "--iterations", 1000, "--out", tmp_path / "two", "-q", "--waveband", 2) == 0
    assert [p.name for p in (tmp_path / "two").glob("photons-*")] == ["photons-0002.npy"]
    both = [(tmp_path / d / "photons-0002.npy").read_bytes() for d in ("all", "two")]
    assert both[0] == both[1]
    assert [b["waveband"] for b in json.loads((tmp_path / "two/manifest.json").read_text())["bands"]] == [2]


def test_the_engine_tells_its_progress(amc, tmp_path):
    """And removes what a process that is killed meanwhile leaves."""
    scene, out, seen = read_scene(amc, iterations=150_000), tmp_path / "out", []

    def tell(*numbers):
        seen.append(numbers)
        (out / ".aomc-sky-shard-1-of-2.done.0123abcd").write_bytes(b"half")

    result = run_job(scene.source(), scene, out, JobOptions(), tell)
    assert seen[-1] == (450_000, 450_000)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert result.emitted == 450_000
    assert not list(out.glob(".aomc-sky-*"))


def test_standard_errors_of_replicates(amc, tmp_path, told):
    """In the table, in `info` and in the manifest; a finished run keeps them, and has none without photons."""
    out = tmp_path / "out"
    words = ("run", amc, "--iterations", 160_003, "--replicates", 16, "--out", out)
    for shown in (told(*words).out, told("info", out).out, told(*words).out):
        assert "standard errors from 16 replicates" in shown
    source = PhotonSource.from_plan(Plan.load(out / "plan.npz"))
    for band in manifest_of(out)["bands"]:
        uz = np.load(out / f"photons-{band['waveband']:04d}.npy")[:, 2].astype(np.float64)
        ranges = [source.replicate_range(band["waveband"] - 1, r) for r in range(16)]
        for name, values in (("mean_cosine", -uz), ("eo", -1 / uz)):
            means = np.array([values[start:stop].mean() for start, stop in ranges])
            assert np.isclose(band[f"{name}_standard_error"], means.std(ddof=1) / 4, rtol=1e-3)
        ratio = band["eo_standard_error"] * band["ed_over_eo_photons"] ** 2
        assert np.isclose(band["ed_over_eo_standard_error"], ratio, rtol=1e-12)
        assert (band["ed_photons"], band["ed_standard_error"], band["eo_variance_is_finite"]) == (1.0, 0.0, False)
    assert "no standard errors" in told(*words[:-1], tmp_path / "none", "--format", "none").out
    equal = told(*words[:-1], tmp_path / "equal", "--allocation", "largest-remainder").out
    assert "bias is not in these errors" in equal


def test_how_a_table_was_read_waits_for_v(amc, tmp_path, told):
    """The manifest does not depend on -v, and `info`, which is asked about the file, says it always."""
    remark, words = "note: skydist.inp read with listed values in equal bins; AOMC", ("run", amc, "--iterations", 1000)
    short, long = (told(*words, "--out", tmp_path / name, *more).out for name, more in (("0", ()), ("1", ["-v"])))
    assert (remark in short, "1 more note with -v\n" in short) == (False, True)
    assert (remark in long, "more note" in long) == (True, False)
    assert run_bytes(tmp_path / "0") == run_bytes(tmp_path / "1")
    assert remark in told("info", amc).out


def test_notes_of_an_older_version_are_not_compared(amc, tmp_path):
    """It says the same in other words; planted: another note of this version."""
    out = tmp_path / "out"
    assert run(amc, "--iterations", 1000, "--out", out, "-q") == 0
    plan = Plan.load(out / "plan.npz").to_bytes()  # as 0.4 wrote it, without digests of the scene
    (out / "plan.npz").write_bytes(plan)
    manifest = manifest_of(out)
    manifest["files"]["plan.npz"]["bytes"] = len(plan)
    for version, code in (("0.3.0", 0), (aomc_sky.__version__, 1)):
        changed = {**manifest, "version": version, "notes": ["another note", *manifest["notes"]]}
        (out / "manifest.json").write_text(json.dumps(changed, indent=1) + "\n")
        assert command("verify", out, "--scene", amc, "--iterations", 1000, "-q") == code
