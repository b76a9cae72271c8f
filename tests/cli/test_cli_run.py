"""``run`` through main(argv): what it writes, prints and refuses."""

from __future__ import annotations

import csv
import hashlib
import json
from importlib import resources
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from aomc_sky.cli.main import main
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.engine.run import JobOptions, run_job
from aomc_sky.plan.plan import Plan
from aomc_sky.source.read.scene import read_scene
from tests.support.scenes import copy_scene, run_bytes

SCHEMA = json.loads((resources.files("aomc_sky.outputs") / "manifest.schema.json").read_text())


@pytest.fixture
def far_amc(amc: Path) -> Path:
    """The scene with a waveband far outside the sky's wavelengths, which warns."""
    table = amc.parent / "lambbot.inp"
    text = table.read_text()
    assert text.count("555") == 1
    table.write_text(text.replace("555", "520"))
    return amc


def run(*words: object) -> int:
    return main(["run", *map(str, words)])


def test_default_folder_and_its_files(amc, capsys):
    assert run(amc, "--iterations", "2e4", "--seed", 5) == 0
    folder = amc.parent / "aomc-sky-out"
    names = {path.name for path in folder.iterdir()}
    assert names == {"plan.npz", "counts.csv", "manifest.json"} | {f"photons-{b:04d}.npy" for b in (1, 2, 3)}
    shown = capsys.readouterr()
    for word in ("band", "requested", "launched", "residual", "mean cosine", "Ed/Eo", "per second", str(folder)):
        assert word in shown.out
    assert shown.err == ""


def test_a_warning_is_printed_once_and_strict_makes_it_an_error(far_amc, tmp_path, capsys):
    assert run(far_amc, "--iterations", 1000, "--out", tmp_path / "out", "-q") == 0
    shown = capsys.readouterr()
    assert shown.err.count("warning[E310]") == 1
    assert shown.out == ""
    assert run(far_amc, "--iterations", 1000, "--out", tmp_path / "strict", "--strict") == 3
    assert "--strict" in capsys.readouterr().err
    assert not (tmp_path / "strict").exists()


def test_directions_counts_and_plan_agree(amc, tmp_path):
    out = tmp_path / "out"
    assert run(amc, "--iterations", 30_000, "--out", out, "-q") == 0
    source = PhotonSource.from_plan(Plan.load(out / "plan.npz"))
    for band in range(3):
        stored = np.load(out / f"photons-{band + 1:04d}.npy", mmap_mode="r", allow_pickle=False)
        assert stored.dtype == np.float32
        assert np.array_equal(stored, source.photons(band).directions)
        assert stored[:, 2].max() < 0
    with (out / "counts.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for band in range(3):
        band_rows = [row for row in rows if row["waveband"] == str(band + 1)]
        assert sum(int(row["photons"]) for row in band_rows) == 30_000
        assert np.isclose(sum(float(row["mass"]) for row in band_rows), 1.0, rtol=0, atol=1e-12)
        lit = np.flatnonzero(source.mass(band))
        assert [int(row["photons"]) for row in band_rows] == source.counts[band, lit].tolist()
        assert [float(row["expected"]) for row in band_rows] == source.expected(band)[lit].tolist()


def test_manifest_keeps_its_schema_and_hashes(amc, tmp_path):
    out = tmp_path / "out"
    assert run(amc, "--iterations", 1000, "--out", out, "--format", "npy", "--format", "raw", "-q") == 0
    manifest = json.loads((out / "manifest.json").read_text())
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(manifest, SCHEMA)
    assert set(manifest["files"]) == {path.name for path in out.iterdir()} - {"manifest.json"}
    for name, entry in manifest["files"].items():
        assert entry["bytes"] == (out / name).stat().st_size
    for entry in manifest["inputs"].values():
        assert entry["sha256"] == hashlib.sha256((amc.parent / entry["name"]).read_bytes()).hexdigest()
    assert manifest["plan_sha256"] == Plan.load(out / "plan.npz").sha256
    broken = {**manifest, "seed": -1}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(broken, SCHEMA)


def test_statistics_are_those_of_the_photons(amc, tmp_path):
    out = tmp_path / "out"
    assert run(amc, "--iterations", 100_000, "--out", out, "-q") == 0
    for band in json.loads((out / "manifest.json").read_text())["bands"]:
        mu = -np.load(out / f"photons-{band['waveband']:04d}.npy")[:, 2].astype(np.float64)
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
    ],
)
def test_raw_says_its_columns(tmp_path, capsys, name, words, columns):
    """In the summary, in `info` and in the manifest: as many as a record has, in the order of its bytes."""
    amc, out = copy_scene(name, tmp_path), tmp_path / "out"
    assert (
        run(amc, "--iterations", 100, "--waveband", 1, "--format", "raw", "--format", "npy", "--out", out, *words) == 0
    )
    said = f"{', '.join(columns)} (float32, little-endian)"
    assert f"a raw record: {said}" in capsys.readouterr().out
    raw = np.fromfile(out / "photons-0001.raw", dtype="<f4").reshape(100, len(columns))
    parts = {"ux": ("photons", 0), "uy": ("photons", 1), "uz": ("photons", 2), "x_m": ("positions", 0)}
    parts |= {"y_m": ("positions", 1), "weight": ("weights", ...)}
    for k, column in enumerate(columns):
        file, index = parts[column]
        stored = np.load(out / f"{file}-0001.npy")
        np.testing.assert_array_equal(raw[:, k], stored if index is ... else stored[:, index])
    manifest = json.loads((out / "manifest.json").read_text())
    jsonschema.validate(manifest, SCHEMA)
    assert manifest["files"]["photons-0001.raw"]["columns"] == columns
    assert main(["info", str(out)]) == 0
    assert f"photons-0001.raw: {raw.nbytes} bytes, records of {said}" in capsys.readouterr().out


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_raw_holds_the_records_of_npy(amc, tmp_path, precision):
    out = tmp_path / "out"
    words = ("--iterations", 70_000, "--format", "raw", "--format", "npy", "--precision", precision, "--out", out, "-q")
    assert run(amc, *words) == 0
    raw = np.fromfile(out / "photons-0002.raw", dtype="<f4").reshape(-1, 3)
    assert np.array_equal(raw, np.load(out / "photons-0002.npy").astype(np.float32))


def test_format_none_emits_nothing(amc, tmp_path, capsys):
    out = tmp_path / "out"
    assert run(amc, "--iterations", 10**18, "--format", "none", "--out", out, "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert {path.name for path in out.iterdir()} == {"plan.npz", "counts.csv", "manifest.json"}
    assert shown["total"] == 3 * 10**18
    assert {band["mean_cosine_photons"] for band in shown["bands"]} == {None}
    jsonschema.validate(json.loads((out / "manifest.json").read_text()), SCHEMA)


def test_json_is_one_object_and_nothing_else(amc, tmp_path, capsys):
    for _ in range(2):  # made, then found finished
        assert run(amc, "--iterations", 100, "--out", tmp_path / "out", "--json") == 0
        out = capsys.readouterr().out
        assert out.count("\n") == 1
        shown = json.loads(out)
        assert shown["schema"] == "aomc-sky-manifest/2"
        assert {"seconds", "threads", "machine"} <= shown["run"].keys()
    assert shown["was_finished"] is True
    assert "run" not in json.loads((tmp_path / "out" / "manifest.json").read_text())


def test_a_finished_run_is_not_done_again(amc, tmp_path, capsys):
    out = tmp_path / "out"
    words = (amc, "--iterations", 5000, "--out", out)
    assert run(*words) == 0
    before = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    capsys.readouterr()
    assert run(*words) == 0
    assert "finished before" in capsys.readouterr().out
    assert before == {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    first = run_bytes(out)
    assert run(*words, "--force", "-q") == 0
    assert first == run_bytes(out)
    assert before["manifest.json"] != (out / "manifest.json").stat().st_mtime_ns


@pytest.mark.parametrize("change", [("--seed", 1), ("--iterations", 99), ("--order", "patch"), ("--waveband", 1)])
def test_another_run_is_refused_unless_forced(amc, tmp_path, capsys, change):
    out = tmp_path / "out"
    assert run(amc, "--iterations", 100, "--out", out, "-q") == 0
    before = run_bytes(out)
    assert run(amc, "--iterations", 100, *change, "--out", out, "-q") == 5
    assert "--force" in capsys.readouterr().err
    assert run_bytes(out) == before
    assert run(amc, "--iterations", 100, *change, "--out", out, "-q", "--force") == 0
    assert run_bytes(out)["plan.npz"] != before["plan.npz"]


@pytest.mark.parametrize("formats", [("npy",), ("raw", "npy")])
@pytest.mark.parametrize("lost", ["manifest.json", "photons-0002", "counts.csv"])
def test_resume_gives_the_same_bytes(amc, tmp_path, formats, lost):
    out = tmp_path / "out"
    words = [amc, "--iterations", 70_001, "--out", out, "-q"]
    for name in formats:
        words += ["--format", name]
    assert run(*words) == 0
    whole = run_bytes(out)
    kept = (out / "photons-0001.npy" if "npy" in formats else out / "photons-0001.raw").stat().st_mtime_ns
    (out / "manifest.json").unlink()
    for path in out.glob(f"{lost}*"):
        path.unlink()
    (out / ".aomc-sky-photons-0002.npy.deadbeef").write_bytes(b"half")
    assert run(*words) == 0
    assert run_bytes(out) == whole
    name = "photons-0001.npy" if "npy" in formats else "photons-0001.raw"
    assert (out / name).stat().st_mtime_ns == kept


def test_a_truncated_file_or_manifest_is_made_anew(amc, tmp_path):
    out = tmp_path / "out"
    words = (amc, "--iterations", 5000, "--out", out, "-q")
    assert run(*words) == 0
    whole = run_bytes(out)
    with (out / "photons-0003.npy").open("r+b") as file:
        file.truncate(1000)
    assert run(*words) == 0
    assert run_bytes(out) == whole
    (out / "manifest.json").write_text("{")
    assert run(*words) == 0
    assert run_bytes(out) == whole


def test_positions_come_with_a_footprint(amc, tmp_path):
    from dataclasses import replace

    from aomc_sky.formats.aomc.amc import FootprintCode, read_amc
    from tests.support.scenes import write_amc

    config = replace(read_amc(amc), footprint=FootprintCode.CIRCLE, circle_diameter_m=4.0)
    write_amc(config, amc)
    out = tmp_path / "out"
    assert run(amc, "--iterations", 70_000, "--out", out, "--format", "npy", "--format", "raw", "-q") == 0
    positions = np.load(out / "positions-0001.npy")
    assert positions.shape == (70_000, 2)
    assert 1.99 < np.hypot(*positions.T).max() <= 2.0
    raw = np.fromfile(out / "photons-0001.raw", dtype="<f4").reshape(-1, 5)
    assert np.array_equal(raw[:, 3:], positions)


def test_only_the_wavebands_asked_for(amc, tmp_path):
    assert run(amc, "--iterations", 1000, "--out", tmp_path / "all", "-q") == 0
    assert run(amc, "--iterations", 1000, "--out", tmp_path / "two", "-q", "--waveband", 2) == 0
    assert [p.name for p in (tmp_path / "two").glob("photons-*")] == ["photons-0002.npy"]
    both = [(tmp_path / d / "photons-0002.npy").read_bytes() for d in ("all", "two")]
    assert both[0] == both[1]
    assert [b["waveband"] for b in json.loads((tmp_path / "two/manifest.json").read_text())["bands"]] == [2]


def test_the_engine_tells_its_progress(amc, tmp_path):
    scene = read_scene(amc, iterations=150_000)
    seen = []
    result = run_job(scene.source(), scene, tmp_path / "out", JobOptions(), lambda *a: seen.append(a))
    assert seen[-1] == (450_000, 450_000)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert result.emitted == 450_000


def test_dry_run_writes_nothing(amc, capsys):
    before = sorted(p.name for p in amc.parent.iterdir())
    assert run(amc, "--dry-run") == 0
    out = capsys.readouterr().out
    assert "modelled: " in out
    assert "not modelled: positions" in out
    assert sorted(p.name for p in amc.parent.iterdir()) == before
    assert run(amc, "--dry-run", "--json") == 0
    assert "components" in json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--waveband", "9"], 2),
        (["--format", "mcpl", "--format", "none"], 2),
        (["--sky", "perez"], 2),
        (["--limits", "paper"], 2),
        (["--format", "none", "--format", "npy"], 2),
        (["--out", "-"], 2),
        (["--compat", "aomc", "--allocation", "systematic"], 2),
        (["--compat", "aomc", "--bins", "equal"], 2),
        (["--compat", "aomc", "--order", "shuffled"], 2),
        (["--method", "iid", "--placement", "r2"], 2),
        (["--max-memory", "1k"], 2),
        (["--iterations", "4e18"], 6),
    ],
)
def test_exit_codes(amc, tmp_path, capsys, words, code):
    out = [] if "--out" in words else ["--out", tmp_path / "out"]
    assert run(amc, *words, *out) == code
    shown = capsys.readouterr()
    assert "error" in shown.err
    assert "Traceback" not in shown.err
    assert shown.out == ""
    assert not list((tmp_path).glob("out/photons-*"))


@pytest.mark.parametrize(
    "words",
    [
        ["--seed", "-1"],
        ["--iterations", "0"],
        ["--iterations", "1.5"],
        ["--iterations", "nan"],
        ["--threads", "0"],
        ["--max-memory", "much"],
        ["--order", "none"],
        ["--seed", "18446744073709551616"],
    ],
)
def test_options_out_of_range_are_usage_errors(amc, capsys, words):
    with pytest.raises(SystemExit) as stop:
        run(amc, *words)
    assert stop.value.code == 2
    assert words[0] in capsys.readouterr().err
