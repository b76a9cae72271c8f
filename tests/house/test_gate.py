"""The gate lets no skip pass that it does not list, and its list names legs that there are."""

import re
from types import SimpleNamespace

import pytest

from tests import conftest
from tests.support.shared import REPOSITORY, script

GATE = REPOSITORY / ".ci"
LEGS = set(re.findall(r"^(\w+)\(\) \{", (GATE / "legs").read_text(), re.MULTILINE))
NO_XARRAY = "could not import 'xarray': No module named 'xarray'"
CLANG = "clang not installed"

skips = script(GATE / "skips.py")


def test_the_gate_runs_every_leg_that_it_lists():
    text = (GATE / "run").read_text()
    run = set(re.findall(r"^(?:both|.*\bleg) (\w+) \d", text, re.MULTILINE))
    run |= set(re.findall(r'^both \w+ \d+ "[^"]*" (\w+) \d', text, re.MULTILINE))
    helpers = {"checkout", "readme", "judge_skips", "suite"}
    assert run == LEGS - helpers
    assert {leg for entry in skips.PERMITTED for leg in entry["legs"]} <= run


@pytest.mark.parametrize(
    ("leg", "reason", "missing", "expected"),
    [
        ("tests", NO_XARRAY, "", True),
        ("extras", NO_XARRAY, "", False),
        ("slow_tests", NO_XARRAY, "", False),
        ("tests", "could not import 'aomc_sky.kernels': No module named 'aomc_sky.kernels'", "", False),
        ("tests", "long without the JIT", "", False),
        ("tests", "a reason that nobody listed", "", False),
        ("tests", "got empty parameter set for (case)", "", False),
        ("tests", CLANG, "", False),
        ("tests", CLANG, "gfortran", False),
        ("tests", CLANG, "gfortran clang", True),
        ("tests", "gcc and gfortran not installed", "gfortran", True),
    ],
)
def test_a_skip_passes_only_where_it_is_listed(leg, reason, missing, expected, tmp_path, capsys):
    (tmp_path / "skipped").write_text(f"tests/a/test_b.py::test_c[1]\t{reason}\n")
    assert skips.judge(leg, tmp_path / "skipped", missing.split()) is expected
    said = capsys.readouterr().out
    assert f"skipped    1  tests/a/test_b.py: {reason} [" in said
    assert ("NOT PERMITTED" in said) is not expected


def test_a_leg_whose_skips_were_not_noted_does_not_pass(tmp_path):
    with pytest.raises(FileNotFoundError):
        skips.judge("tests", tmp_path / "skipped", [])


def test_a_file_that_is_skipped_whole_is_run_again_once(tmp_path):
    (tmp_path / "skipped").write_text("a.py\tr\nb.py::t[1]\tr\nb.py::t[2]\tr\na.py\tr\nc.py::u\tr\n")
    assert skips.again(tmp_path / "skipped", ["c.py", "d.py"]) == ["a.py", "b.py::t[1]", "b.py::t[2]", "c.py", "d.py"]


def test_a_skip_is_noted_with_its_reason(tmp_path, monkeypatch):
    monkeypatch.setenv("AOMC_SKY_SKIPPED", str(tmp_path / "skipped"))
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    conftest.pytest_sessionstart()
    assert skips.noted(tmp_path / "skipped") == {}
    for k, (skipped, where) in enumerate([(True, ("b.py", 3, "Skipped: no\ngcc")), (True, "an xfail"), (False, None)]):
        conftest.pytest_runtest_logreport(SimpleNamespace(skipped=skipped, nodeid=f"b.py::t[{k}]", longrepr=where))
    assert list(skips.noted(tmp_path / "skipped").values()) == ["no gcc", "an xfail"]
