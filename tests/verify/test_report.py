"""Reports: the shared level, what passes, and what the table says."""

import json

import numpy as np
import pytest

from aomc_sky.cli.commands.verify import report_text
from aomc_sky.grid import PatchGrid
from aomc_sky.verify.report import Check, Pulls, judged, pool_starts, sidak_level


def a_test(p_value, name="test", waveband=1):
    return Check(name=name, waveband=waveband, passed=True, p_value=p_value)


def test_each_test_gets_its_share_of_the_level_and_only_failures_make_it_foreign():
    report = judged([a_test(1e-4), a_test(0.5), Check(name="exact", passed=True)], family_level=1e-3)
    assert report.level == pytest.approx(1 - (1 - 1e-3) ** 0.5, rel=1e-12)
    assert [check.passed for check in report.checks] == [False, True, True]
    assert not report
    assert judged([a_test(6e-4), a_test(0.5)], family_level=1e-3)
    assert not judged([a_test(float("nan"))], family_level=1e-6)
    assert sidak_level(1e-6, 0) == pytest.approx(1e-6)
    assert not judged([Check(name="blocks", passed=True, is_foreign=True)], family_level=0.1).is_foreign
    assert judged([Check(name="blocks", passed=False, is_foreign=True)], family_level=0.1).is_foreign


def test_maps_are_those_of_wavebands_whose_tests_failed():
    expected, variance = np.array([[25.0, 5.0], [329.0, 0.0]]), np.array([[400.0, 5.0], [1296.0, 0.0]])
    maps = {"zones": PatchGrid.regular(2, 2), "observed": np.full((2, 2), 5.0), "expected": expected}
    pulls = [Pulls(waveband=w, variance=variance, **maps) for w in (1, 2)]
    checks = [a_test(0.0, waveband=2), Check(name="photons come from above", waveband=1, passed=False, allowed=0.0)]
    report = judged(checks, family_level=1e-6, pulls=pulls)
    assert [p.waveband for p in report.failed_pulls] == [2]
    assert pulls[0].worst() == [(1, 1), (1, 0), (0, 0)]
    cells = json.loads(json.dumps(report.as_json(), allow_nan=False))["worst"][0]["cells"]
    assert [cell["pull"] for cell in cells] == [None, -9.0, -1.0]
    text = report_text(report, verbose=False, only_failed=True)
    assert "2 of 2 checks FAILED" in text


def test_wavebands_share_a_line():
    checks = [a_test(p, waveband=w) for w, p in ((1, 0.5), (2, 0.1), (3, 0.9))]
    checks += [Check(name="test", waveband=4, passed=True, detail="too few photons")]
    report = judged(checks, family_level=1e-6)
    (line,) = [x for x in report_text(report, verbose=False, only_failed=False).splitlines() if x[:5] == "test "]
    assert line.split()[:4] == ["test", "4", "bands", "ok"]
    assert "1 had too few photons" in line
    assert len(report_text(report, verbose=True, only_failed=False).splitlines()) == 7


def test_groups_expect_enough():
    assert pool_starts(np.array([5.0, 5, 5, 5, 5]), 10).tolist() == [0, 2]
    assert pool_starts(np.array([1.0, 1]), 10).tolist() == [0]
    assert pool_starts(np.zeros(0), 10).tolist() == []
