"""Row 49: folders that were changed and sealed anew. What the plan gives, verify compares; the rest it names."""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import pytest

from aomc_sky.source.read.scene import read_scene
from tests.faults.test_plan_faults import in_child, row_id, said
from tests.support.fault_rows import command
from tests.support.forged_runs import PLAN_FORGERIES, forged_runs, hidden_forgeries, reseal, run_of_a_forged_plan
from tests.support.scenes import copy_scene

PHOTONS = 400


def row_49(*names: str) -> pytest.MarkDecorator:
    """A test of row 49; its argument ``fault`` is the name of the case."""
    return pytest.mark.parametrize("fault", names, ids=[row_id(49, name) for name in names])


@pytest.fixture(scope="module")
def scene(tmp_path_factory: Any) -> Path:
    """A small scene of three wavebands."""
    return copy_scene("document_example", tmp_path_factory.mktemp("scene")).parent


@pytest.fixture(scope="module")
def run(scene: Path) -> Path:
    """A finished run of it."""
    assert command("run", scene, "--iterations", PHOTONS, "--out", scene / "good", "-q") == 0
    return scene / "good"


def verdict(folder: Path, *words: object) -> tuple[int, str]:
    """Exit code and words of verify, every photon made again."""
    return said("verify", folder, "--resample", 1, "--threads", 1, "-q", *words)


@row_49("resealed-folders")
def test_verify_sees_what_the_plan_betrays(fault: str, run: Path, tmp_path: Path) -> None:
    forgeries = forged_runs(run)
    assert len({forged.name for forged in forgeries}) == len(forgeries) >= 60

    def work() -> list[str]:
        wrong = []
        for forged in forgeries:
            folder = shutil.copytree(run, tmp_path / "forged")
            forged.forge(folder)
            try:
                code, text = verdict(folder)
            except BaseException as error:
                code, text = -1, repr(error)
            if code not in (1, 3, 5) or "Traceback" in text or not text:
                wrong.append(f"{forged.name}: {code}, {text[:300]}")
            shutil.rmtree(folder)
        return wrong

    assert in_child(work, 600) == []


@row_49("sealing-alone-changes-nothing")
def test_a_folder_sealed_anew_without_a_change_passes(fault: str, run: Path, scene: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(run, tmp_path / "sealed")
    reseal(folder)
    assert verdict(folder) == (0, "")
    assert verdict(folder, "--scene", scene / "amc.inp", "--iterations", PHOTONS) == (0, "")


@row_49("what-only-the-scene-betrays")
def test_what_a_plan_cannot_know_is_named_and_the_scene_betrays_it(
    fault: str, run: Path, scene: Path, tmp_path: Path
) -> None:
    for forged in hidden_forgeries():
        folder = shutil.copytree(run, tmp_path / forged.name)
        forged.forge(folder)
        code, text = said("verify", folder, "--threads", 1)
        assert (code, "not vouched for:" in text) == (0, True), (forged.name, text)
        code, text = verdict(folder, "--scene", scene / "amc.inp", "--iterations", PHOTONS)
        assert code == 1, (forged.name, text)
        assert "scene: manifest" in text, forged.name


@row_49("a-plan-of-no-scene")
def test_a_run_of_a_plan_that_no_scene_gives(fault: str, scene: Path, tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read = read_scene(scene / "amc.inp", iterations=PHOTONS)
    for what in PLAN_FORGERIES:
        run_of_a_forged_plan(what, read.source(), read, tmp_path / what)
        assert verdict(tmp_path / what)[0] == 0, what  # all that there is agrees
        code, text = verdict(tmp_path / what, "--scene", scene / "amc.inp", "--iterations", PHOTONS)
        if what == "seed":
            assert code == 0  # another seed is another run of the same scene: nobody can know which one was meant
            continue
        assert code == 5, (what, text)
        assert "scene: plan" in text


@row_49("blocks-drawn-at-random")
def test_the_blocks_are_drawn_and_told(fault: str, run: Path) -> None:
    def report(*words: object) -> dict[str, Any]:
        code, text = said("verify", run, "--json", "--threads", 1, *words)
        assert code == 0
        return json.loads(text)  # type: ignore[no-any-return]

    first, second, third = report(), report(), report("--seed", 7)
    assert first["block_seed"] != second["block_seed"]
    assert third["block_seed"] == 7
    assert report("--resample", 0)["block_seed"] is None
    assert [check.get("p_value") for check in first["checks"]] == [check.get("p_value") for check in second["checks"]]
    assert "times, speed and machine" in first["not_vouched_for"]
    assert f"--seed {7}" in said("verify", run, "--seed", 7, "--threads", 1)[1]
