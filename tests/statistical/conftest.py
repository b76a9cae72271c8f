"""The shared level of the statistical tests; see tests/support/plan.py."""

from collections import Counter
from pathlib import Path

import pytest

from tests.statistical.declared import DECLARED, PLAN

HERE = Path(__file__).resolve().parent


@pytest.fixture
def plan(request):
    """The plan, bound to the running test: it must compare exactly the p-values it declares."""
    per_case = DECLARED[request.path.stem][request.node.originalname][1]
    bound = PLAN.bind(f"{request.path.stem}::{request.node.originalname}")
    yield bound
    report = getattr(request.node, "_outcome", None)
    if report is not None and report.passed:
        assert bound.compared == per_case, f"{bound.name} declares {per_case} p-values, compared {bound.compared}"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if call.when == "call":
        item._outcome = report
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Declared tests and existing tests must agree, file by file, unless single tests were asked for."""
    found = {stem: Counter() for stem in DECLARED}
    files = set()
    for item in items:
        if item.path.parent == HERE:
            files.add(item.path.stem)
            if "plan" in getattr(item, "fixturenames", ()):
                found.setdefault(item.path.stem, Counter())[item.originalname] += 1
    if any("::" in argument for argument in config.args):
        return
    for stem in files:
        declared = {name: cases for name, (cases, _) in DECLARED.get(stem, {}).items()}
        if dict(found.get(stem, {})) != declared:
            raise pytest.UsageError(
                f"tests/statistical/declared.py: {stem} declares {declared}, has {dict(found[stem])}"
            )


@pytest.fixture
def plan_only():
    """The plan for tests that only plant defects and compare no p-value of ours."""
    return PLAN
